"""What came while the program was not ready is discarded, and how much is logged."""

import json
import socket
import time

import msgspec
import numpy as np
import pytest
import zmq
from websockets.sync.client import connect

from mossar_adapters.address import parse_url
from mossar_adapters.maps.frame_maps import FrameMap, MetaMap
from mossar_adapters.osc.encode import encode
from mossar_adapters.osc.source import OscSource
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.source import Meta
from mossar_adapters.websocket_source import WebSocketSource
from mossar_adapters.zeromq.source import ZmqSource
from mossar_stream import Frames

BLOB = np.zeros((2, 3), ">f4").tobytes()


def send_over_osc(source, first, count):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(encode("/mossar/meta", "sss", "p1", "hips", "head"), ("127.0.0.1", source.port))
        for k in range(first, first + count):
            frame = encode("/mossar/frame", "sidb", "p1", k, k / 50, BLOB)
            sender.sendto(frame, ("127.0.0.1", source.port))


def send_over_zmq(publisher, first, count):
    meta = MetaMap(("hips", "head"), parents=(-1, 0))
    publisher.send_multipart([b"mossar.meta.p1.", msgspec.msgpack.encode(meta)])
    for k in range(first, first + count):
        frame = FrameMap(seq=k, t=k / 50, shape=(2, 3), xyz=bytes(24))
        publisher.send_multipart([b"mossar.frame.p1.", msgspec.msgpack.encode(frame)])


def send_over_websocket(client, first, count):
    client.send(
        json.dumps({"type": "meta", "performer": "p1", "names": ["hips", "head"], "parents": [-1, 0]})
    )
    for k in range(first, first + count):
        xyz = [[0, 0, 0], [0, 0, 0]]
        client.send(json.dumps({"type": "frame", "performer": "p1", "seq": k, "t": k / 50, "xyz": xyz}))


@pytest.fixture(params=["osc", "zmq", "ws"])
def waiting(request):
    """A source in which 100 frames of two seconds wait, and what sends it more."""
    if request.param == "osc":
        source = OscSource(parse_url("osc://127.0.0.1:0?profile=mossar"))
        send_over_osc(source, 0, 100)
        yield source, lambda: send_over_osc(source, 100, 10)
        source.close()
        return
    if request.param == "ws":
        source = WebSocketSource(parse_url("ws+bind://127.0.0.1:0"))
        with connect(f"ws://127.0.0.1:{source.port}") as client:
            send_over_websocket(client, 0, 100)
            yield source, lambda: send_over_websocket(client, 100, 10)
        source.close()
        return
    with zmq.Context() as context, context.socket(zmq.PUB) as publisher:
        publisher.setsockopt(zmq.LINGER, 0)
        port = publisher.bind_to_random_port("tcp://127.0.0.1")
        source = ZmqSource(parse_url(f"zmq://127.0.0.1:{port}"))
        time.sleep(0.3)
        send_over_zmq(publisher, 0, 100)
        yield source, lambda: send_over_zmq(publisher, 100, 10)
        source.close()


def read(source, send_more):
    """Return the metas and the times of the frames that come, the second half sent once the first was read."""
    time.sleep(0.2)
    metas, times = 0, []
    for item in source.items():
        if isinstance(item, Meta):
            metas += 1
        elif isinstance(item, Frames):
            times += item.times.tolist()
        elif send_more is not None:
            send_more()
            send_more = None
        else:
            break
    return metas, times


def test_old_frames_are_discarded_and_the_performer_is_known_all_the_same(waiting, caplog):
    caplog.set_level("INFO")
    source, send_more = waiting
    time.sleep(0.2)
    source.skip_waiting()
    metas, times = read(source, send_more)
    assert metas >= 1
    assert times == pytest.approx(np.arange(100, 110) / 50)
    said = [message for message in caplog.messages if "discarded" in message]
    assert len(said) == 1
    assert "100 frames (2.0 s)" in said[0]


def test_discarded_frames_are_in_the_stats(waiting):
    source, send_more = waiting
    time.sleep(0.2)
    source.skip_waiting()
    send_more()
    pipeline = Pipeline([source], [])
    pipeline._tick = lambda: pipeline.stop() if pipeline.outcome.frames == 10 else None
    pipeline.run()
    assert pipeline.upkeep.stats_of(pipeline, "p1").queue_dropped == 100


def test_frames_that_waited_for_minutes_are_discarded_all(monkeypatch, caplog):
    caplog.set_level("INFO")
    monkeypatch.setattr("mossar_adapters.osc.datagrams._OLDEST", 0.1)
    monkeypatch.setattr("mossar_adapters.osc.datagrams.DRAIN", 10)
    source = OscSource(parse_url("osc://127.0.0.1:0?profile=mossar"))
    time.sleep(0.3)  # Linux begins to stamp datagrams a bit after it was asked to
    send_over_osc(source, 0, 100)
    time.sleep(0.4)
    source.skip_waiting()
    _, times = read(source, lambda: send_over_osc(source, 100, 10))
    source.close()
    assert times == pytest.approx(np.arange(100, 110) / 50)
    assert "100 frames (2.0 s)" in caplog.text


def test_nothing_is_discarded_unasked(waiting, caplog):
    caplog.set_level("INFO")
    source, send_more = waiting
    _, times = read(source, send_more)
    assert times == pytest.approx(np.arange(110) / 50)
    assert not caplog.messages
