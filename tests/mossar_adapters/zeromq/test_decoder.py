"""The ZeroMQ decoder by itself."""

import numpy as np
import pytest

from mossar_adapters.maps.codec import to_json, to_msgpack
from mossar_adapters.maps.frame_maps import FrameMap, MetaMap
from mossar_adapters.source import Meta
from mossar_adapters.zeromq.decoder import ZmqDecoder, ZmqMessage
from mossar_stream import Frames

META = MetaMap(("hip", "head"), parents=(-1, 0))
MAPS = [META, *(FrameMap(seq=k, t=k / 50, xyz=np.full(6, k, "<f4").tobytes()) for k in range(6))]


def messages(encode, topic=True):
    return [ZmqMessage((b"mossar.frame.p1.",) * topic + (encode(found),), 0.0) for found in MAPS]


@pytest.mark.parametrize("sent", [messages(to_msgpack), messages(to_json), messages(to_json, topic=False)])
@pytest.mark.parametrize("size", [1, 3, 7])
def test_msgpack_and_json_give_the_same_frames_however_they_are_handed_over(sent, size):
    decoder = ZmqDecoder()
    found = [item for i in range(0, len(sent), size) for item in decoder.receive(*sent[i : i + size])]
    frames = [item for item in found if isinstance(item, Frames)]
    assert [item.skeleton.names for item in found if isinstance(item, Meta)] == [("hip", "head")]
    assert np.concatenate([f.times for f in frames]).tolist() == [k / 50 for k in range(6)]
    assert np.concatenate([f.positions for f in frames])[:, 1, 2].tolist() == list(range(6))
    assert (decoder.frames, decoder.counters.malformed, decoder.counters.gaps) == (6, 0, 0)


def test_events_that_pass_by_are_left_alone_and_damage_is_counted():
    decoder = ZmqDecoder()
    event = ZmqMessage((b"mossar.stream.p1.", b'{"type": "stream"}'), 0.0)
    assert decoder.receive(event, ZmqMessage((b"a", b"b", b"c"), 0.0), ZmqMessage((b"t", b"\xc1"), 0.0)) == []
    assert (decoder.counters.received, decoder.counters.ignored, decoder.counters.malformed) == (3, 1, 2)
