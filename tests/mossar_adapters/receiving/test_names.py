from mossar_adapters.maps.codec import to_json
from mossar_adapters.maps.frame_maps import FrameMap
from mossar_adapters.receiving.names import distinct_name
from mossar_adapters.receiving.senders import Senders
from mossar_adapters.source import Meta
from mossar_adapters.zeromq.decoder import ZmqDecoder, ZmqMessage

LONG = "performer-of-the-second-act-" * 4


def test_two_whose_names_differ_at_the_end_are_two():
    names = {distinct_name(LONG + who) for who in ("ann", "bob")}
    assert len(names) == 2
    assert all(len(name) == 64 for name in names)
    assert {distinct_name(name) for name in names} == names
    assert Senders().name("", LONG + "ann") != Senders().name("", LONG + "bob")


def test_they_are_two_over_a_wire_as_well():
    decoder = ZmqDecoder()
    maps = [FrameMap(performer=LONG + who, t=0.0, xyz=[[0.0, 1.0, 0.0]]) for who in ("ann", "bob")]
    found = decoder.receive(*(ZmqMessage((to_json(one),), 0.0) for one in maps))
    assert len({item.performer for item in found if isinstance(item, Meta)}) == 2
