from mossar_adapters.address import parse_url
from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.osc.decoder import OscDecoder
from mossar_adapters.osc.encode import encode
from mossar_adapters.receiving.admission import PATIENCE, Nuisances
from mossar_stream import Frames

GOOD = encode("/mossar/frame", "sidb", "p1", 1, 0.5, bytes(24))


def decoder():
    return OscDecoder(parse_url("osc://127.0.0.1:0"))


def frames_of(items):
    return sum(len(item) for item in items if isinstance(item, Frames))


def test_a_sender_of_rubbish_is_read_now_and_then_and_heard_when_it_mends_its_ways():
    osc = decoder()
    osc.receive(*(Datagram(b"rubbish", "10.0.0.7", 9000, 0.0) for _ in range(10 * PATIENCE)))
    assert osc.counters.malformed == osc.counters.received == 10 * PATIENCE
    found = osc.receive(*(Datagram(GOOD, "10.0.0.7", 9000, 0.0) for _ in range(100)))
    assert frames_of(found) > 60


def test_others_are_heard_meanwhile():
    osc, frames = decoder(), 0
    for k in range(2 * PATIENCE):
        frames += frames_of(osc.receive(Datagram(b"rubbish", "10.0.0.7", 9000, 0.0)))
        frames += frames_of(osc.receive(Datagram(GOOD, "10.0.0.8", 9000, k / 60)))
    assert frames == 2 * PATIENCE


def test_no_more_than_so_many_are_remembered():
    nuisances = Nuisances()
    for k in range(5000):
        nuisances.judge(("10.0.0.7", k), sound=False)
    assert len(nuisances._rubbish) == 1024
