"""CURVE: keys on both sides, and nothing for those who have none."""

import time

import pytest
import zmq
import zmq.auth

from mossar_adapters.address import parse_url
from mossar_adapters.control.zeromq import ZmqControl
from mossar_adapters.zeromq.sink import ZmqSink
from mossar_adapters.zeromq.source import ZmqSource
from mossar_stream import MossarError, StreamEvent

pytestmark = pytest.mark.skipif(not zmq.has("curve"), reason="this ZeroMQ was built without CURVE")


@pytest.fixture
def keys(tmp_path):
    """Key files by name: (public, secret)."""
    return {name: zmq.auth.create_certificates(tmp_path, name) for name in ("server", "client", "stranger")}


def heard(source, sink, seconds=2.0):
    """Return what a source hears of a sink within a while."""
    end = time.monotonic() + seconds
    while source.counters.received == 0 and time.monotonic() < end:
        sink.send([StreamEvent(performer="p1", event="started", take=0)])
        source.decoder.receive(*source._waiting())
        time.sleep(0.02)
    return source.counters.received


def port(endpoint):
    return endpoint.rpartition(":")[2]


def test_who_knows_the_keys_hears_events(keys):
    sink = ZmqSink(parse_url(f"zmq+bind://127.0.0.1:0?key={keys['server'][1]}"))
    url = f"zmq://127.0.0.1:{port(sink.endpoint)}?key={keys['client'][1]}&server_key={keys['server'][0]}"
    source = ZmqSource(parse_url(url))
    assert heard(source, sink) > 0
    source.close()
    sink.close()


def test_who_does_not_know_the_keys_hears_nothing(keys):
    sink = ZmqSink(parse_url(f"zmq+bind://127.0.0.1:0?key={keys['server'][1]}"))
    wrong = f"?key={keys['client'][1]}&server_key={keys['stranger'][0]}"
    for options in ("", wrong):
        source = ZmqSource(parse_url(f"zmq://127.0.0.1:{port(sink.endpoint)}{options}"))
        assert heard(source, sink, 0.5) == 0
        source.close()
    sink.close()


def test_control_can_be_locked_too(keys):
    control = ZmqControl(parse_url(f"zmq+bind://127.0.0.1:0?key={keys['server'][1]}"), lambda _: b"{}")
    with zmq.Context() as context, context.socket(zmq.REQ) as asking:
        asking.linger = 0
        asking.curve_publickey, asking.curve_secretkey = zmq.auth.load_certificate(keys["client"][1])
        asking.curve_serverkey = zmq.auth.load_certificate(keys["server"][0])[0]
        asking.connect(control.endpoint)
        asking.send(b"{}")
        assert asking.poll(5000)
        assert asking.recv() == b"{}"
        with context.socket(zmq.REQ) as stranger:
            stranger.linger = 0
            stranger.connect(control.endpoint)
            stranger.send(b"{}")
            assert not stranger.poll(500)
    control.close()


def test_a_file_without_keys_is_one_clear_line(tmp_path):
    path = tmp_path / "nothing.key"
    path.write_text("hello")
    with pytest.raises(MossarError, match="is no readable CURVE key file"):
        ZmqSink(parse_url(f"zmq+bind://127.0.0.1:0?key={path}"))


def test_control_refuses_options_it_does_not_have():
    with pytest.raises(MossarError, match="there is no option 'kye'"):
        ZmqControl(parse_url("zmq+bind://127.0.0.1:0?kye=a"), lambda _: b"")
