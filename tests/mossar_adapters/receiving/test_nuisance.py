from mossar_adapters.address import parse_url
from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.osc.encode import encode
from mossar_adapters.osc.source import OscSource
from mossar_adapters.receiving.nuisance import PATIENCE, Nuisances
from mossar_stream.frames import Frames

GOOD = encode("/mossar/frame", "sidb", "p1", 1, 0.5, bytes(24))


def test_a_sender_of_rubbish_is_read_now_and_then_and_heard_when_it_mends_its_ways():
    source = OscSource(parse_url("osc://127.0.0.1:0"))
    for _ in range(10 * PATIENCE):
        source.take(Datagram(b"rubbish", "10.0.0.7", 9000, 0.0))
    assert source.counters.malformed == source.counters.received == 10 * PATIENCE
    for _ in range(100):
        source.take(Datagram(GOOD, "10.0.0.7", 9000, 0.0))
    frames = sum(len(item) for item in source.collected() if isinstance(item, Frames))
    source.close()
    assert frames > 60


def test_others_are_heard_meanwhile():
    source = OscSource(parse_url("osc://127.0.0.1:0"))
    for k in range(2 * PATIENCE):
        source.take(Datagram(b"rubbish", "10.0.0.7", 9000, 0.0))
        source.take(Datagram(GOOD, "10.0.0.8", 9000, k / 60))
    frames = sum(len(item) for item in source.collected() if isinstance(item, Frames))
    source.close()
    assert frames == 2 * PATIENCE


def test_no_more_than_so_many_are_remembered():
    nuisances = Nuisances()
    for k in range(5000):
        nuisances.judge(("10.0.0.7", k), sound=False)
    assert len(nuisances._rubbish) == 1024
