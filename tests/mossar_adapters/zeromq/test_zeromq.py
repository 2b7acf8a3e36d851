import json
import socket
import time

import msgspec
import numpy as np
import pytest
import zmq
import zmq.auth

from mossar_adapters.address import parse_url
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.source import Meta
from mossar_adapters.zeromq.decoder import ZmqMessage
from mossar_adapters.zeromq.sink import ZmqFrameSink, ZmqSink
from mossar_adapters.zeromq.source import ZmqSource
from mossar_stream import (
    ActivityEvent,
    Frames,
    KeyFrameEvent,
    MossarError,
    MoveEvent,
    SegmentEvent,
    Skeleton,
    StreamEvent,
    to_json,
)

SKELETON = Skeleton(("hips", "head"), (-1, 0))


def frames(count, performer="p1", confidence=False):
    positions = np.random.default_rng(3).normal(size=(count, 2, 3)).astype(np.float32)
    positions[count // 2, 1] = np.nan
    shares = np.full((count, 2), 0.5, np.float32) if confidence else None
    return Frames(positions, np.arange(count) / 2000, shares, performer)


def url_of(sink, query=""):
    return parse_url(sink.endpoint.replace("tcp://", "zmq://") + query)


@pytest.fixture
def subscriber():
    context = zmq.Context()
    sockets = []

    def connect(endpoint, topic=b"", keys=(), server=None):
        socket = context.socket(zmq.SUB)
        if server is not None:
            socket.curve_publickey, socket.curve_secretkey = keys
            socket.curve_serverkey = server
        socket.setsockopt(zmq.SUBSCRIBE, topic)
        socket.setsockopt(zmq.RCVTIMEO, 5000)
        socket.setsockopt(zmq.LINGER, 0)
        socket.connect(endpoint)
        sockets.append(socket)
        return socket

    yield connect
    for opened in sockets:
        opened.close()
    context.term()


@pytest.mark.parametrize("encoding", ["msgpack", "json"])
@pytest.mark.parametrize("confidence", [False, True])
def test_frames_arrive_bit_for_bit(hear, encoding, confidence):
    sink = ZmqFrameSink(parse_url(f"zmq+bind://127.0.0.1:0?encoding={encoding}"))
    source = ZmqSource(url_of(sink))
    sent = frames(50, confidence=confidence)

    def send():
        sink.announce(Meta("p1", SKELETON, 2000.0))
        sink.send_frames(sent)

    heard = hear(source, send)
    sink.close()
    assert np.array_equal(heard.positions(), sent.positions, equal_nan=True)
    assert np.array_equal(heard.times(), sent.times)
    assert heard.metas[0].skeleton == SKELETON
    if confidence:
        assert np.array_equal(np.concatenate([f.confidence for f in heard.frames()]), sent.confidence)


def test_two_thousand_frames_a_second_arrive_without_loss(hear):
    sink = ZmqFrameSink(parse_url("zmq+bind://127.0.0.1:0"))
    source = ZmqSource(url_of(sink))
    sent = frames(2000)

    def send():
        sink.announce(Meta("p1", SKELETON))
        started = time.monotonic()
        for i in range(0, 2000, 20):
            time.sleep(max(0.0, started + i / 2000 - time.monotonic()))
            piece = slice(i, i + 20)
            sink.send_frames(Frames(sent.positions[piece], sent.times[piece]))

    heard = hear(source, send)
    sink.close()
    assert heard.count() == 2000
    assert source.counters.gaps == 0


def test_the_source_may_bind_and_the_sender_connect(hear):
    source = ZmqSource(parse_url("zmq+bind://127.0.0.1:0"))
    sink = ZmqFrameSink(url_of(source))

    def send():
        sink.announce(Meta("p1", SKELETON))
        sink.send_frames(frames(10))

    heard = hear(source, send)
    sink.close()
    assert heard.count() == 10


def test_local_sockets_carry_frames(hear, tmp_path):
    path = tmp_path / "pose"
    sink = ZmqFrameSink(parse_url(f"zmq+bind+ipc://{path}"))
    source = ZmqSource(parse_url(f"ipc://{path}"))

    def send():
        sink.announce(Meta("p1", SKELETON))
        sink.send_frames(frames(10))

    heard = hear(source, send)
    sink.close()
    assert heard.count() == 10


def test_events_go_out_in_two_parts_with_the_topic_of_their_performer(subscriber, made):
    sink = ZmqSink(parse_url("zmq+bind://127.0.0.1:0"))
    sink.announce(Meta("p1", SKELETON, 60.0, settings={"level": "motion"}, run="a1"))
    late = subscriber(sink.endpoint, b"mossar.")
    time.sleep(0.3)
    sink.send([StreamEvent(performer="p1", event="started", take=0), made(KeyFrameEvent)])
    received = [late.recv_multipart() for _ in range(3)]
    sink.close()
    assert [topic for topic, _ in received] == [
        b"mossar.meta.p1.",
        b"mossar.stream.p1.",
        b"mossar.key_frame.p1.",
    ]
    meta, stream, key_frame = (msgspec.msgpack.decode(data) for _, data in received)
    assert meta["names"] == ["hips", "head"]
    assert meta["settings"] == {"level": "motion"}
    assert meta["run"] == "a1"
    assert meta["unit"] == "m"
    assert stream == {
        "type": "stream",
        "v": 1,
        "performer": "p1",
        "event": "started",
        "take": 0,
        "reason": "",
    }
    assert key_frame == msgspec.to_builtins(made(KeyFrameEvent))


def test_json_is_sent_on_request(subscriber, made):
    sink = ZmqSink(parse_url("zmq+bind://127.0.0.1:0?encoding=json"))
    listener = subscriber(sink.endpoint, b"mossar.key_frame.")
    time.sleep(0.3)
    sink.send([made(KeyFrameEvent)])
    _, data = listener.recv_multipart()
    sink.close()
    assert json.loads(data)["id"] == "p1/0/7"


def test_the_topic_of_p1_does_not_match_p10(subscriber):
    sink = ZmqSink(parse_url("zmq+bind://127.0.0.1:0"))
    listener = subscriber(sink.endpoint, b"mossar.stream.p1.")
    time.sleep(0.3)
    for name in ("p10", "p1"):
        sink.send([StreamEvent(performer=name, event="started", take=0)])
    topic, _ = listener.recv_multipart()
    sink.close()
    assert topic == b"mossar.stream.p1."


def test_json_of_strangers_is_read_in_one_part_or_two(hear):
    source = ZmqSource(parse_url("zmq+bind://127.0.0.1:0?fps=30"), ReadOptions(fps=30.0))
    context = zmq.Context()
    stranger = context.socket(zmq.PUB)
    stranger.connect(source.endpoint)

    def send():
        time.sleep(0.3)
        for i in range(6):
            text = json.dumps({"type": "frame", "xyz": [[0, 1, i], [0, 2, None], None]}).encode()
            stranger.send_multipart([text] if i % 2 else [b"pose", text])
        stranger.send_multipart([b"a", b"b", b"c"])
        stranger.send(b"no json")
        stranger.send_multipart([b"x", b"\xc1\xff"])
        stranger.send(json.dumps({"type": "frame", "xyz": [[0, 1]]}).encode())
        stranger.send(json.dumps({"type": "frame", "xyz": [[0, 1, 2]]}).encode())
        stranger.send(json.dumps({"type": "key_frame"}).encode())

    heard = hear(source, send)
    stranger.close(0)
    context.term()
    assert heard.positions().shape == (6, 3, 3)
    assert heard.times() == pytest.approx(np.arange(6) / 30)
    assert np.isnan(heard.positions()[:, 1:]).any(axis=2).all()
    assert source.counters.malformed == 5
    assert source.counters.ignored == 1
    assert "does not fit the skeleton" in source.explain()


def test_missing_numbers_are_counted_as_gaps(hear):
    source = ZmqSource(parse_url("zmq+bind://127.0.0.1:0"))
    context = zmq.Context()
    stranger = context.socket(zmq.PUB)
    stranger.connect(source.endpoint)

    def send():
        time.sleep(0.3)
        for seq in (0, 1, 2, 5, 6, 0, 1):
            stranger.send(json.dumps({"type": "frame", "seq": seq, "t": seq, "xyz": [[0, 1, 2]]}).encode())

    heard = hear(source, send)
    stranger.close(0)
    context.term()
    assert heard.count() == 7
    assert source.counters.gaps == 2


def test_a_sender_may_go_and_come_back(hear):
    sink = ZmqFrameSink(parse_url("zmq+bind://127.0.0.1:0"))
    source = ZmqSource(url_of(sink))
    again = []

    def send():
        sink.announce(Meta("p1", SKELETON))
        sink.send_frames(frames(5))
        time.sleep(0.1)
        sink.close()
        again.append(ZmqFrameSink(parse_url(sink.endpoint.replace("tcp://", "zmq+bind://"))))
        again[0].announce(Meta("p1", SKELETON))
        again[0].send_frames(frames(5))

    heard = hear(source, send)
    again[0].close()
    assert heard.count() == 10


def test_who_subscribes_late_is_told_where_everybody_stands(subscriber):
    sink = ZmqSink(parse_url("zmq+bind://127.0.0.1:0"))
    sink.send([StreamEvent(performer="p1", event="started", take=2, run="a1")])
    late = subscriber(sink.endpoint)
    time.sleep(0.3)
    sink.send([])
    topic, data = late.recv_multipart()
    sink.close()
    state = msgspec.msgpack.decode(data)
    assert topic == b"mossar.state.p1."
    assert (state["type"], state["take"], state["present"], state["run"]) == ("state", 2, True, "a1")


def test_a_subscriber_that_never_reads_does_not_stop_the_others(subscriber, made):
    sink = ZmqSink(parse_url("zmq+bind://127.0.0.1:0"))
    lazy = subscriber(sink.endpoint)
    lazy.setsockopt(zmq.RCVHWM, 10)
    time.sleep(0.3)
    started = time.monotonic()
    for _ in range(300):
        sink.send([made(KeyFrameEvent)] * 200)
    assert time.monotonic() - started < 5
    quick = subscriber(sink.endpoint, b"mossar.stream.")
    time.sleep(0.3)
    sink.send([StreamEvent(performer="p1", event="ended", take=0)])
    assert quick.recv_multipart()[0] == b"mossar.stream.p1."
    started = time.monotonic()
    sink.close()
    assert time.monotonic() - started < 1.5


def test_who_connects_and_says_nothing_is_hung_up_on(monkeypatch):
    monkeypatch.setattr("mossar_adapters.zeromq.endpoint.HANDSHAKE_MS", 200)
    sink = ZmqSink(parse_url("zmq+bind://127.0.0.1:0"))
    port = int(sink.endpoint.rpartition(":")[2])
    with socket.create_connection(("127.0.0.1", port), timeout=5) as idle:
        while idle.recv(100):  # the greeting, then the end
            pass
    sink.close()


def test_curve_keys_keep_strangers_out(hear, tmp_path, subscriber):
    for name in ("server", "client"):
        zmq.auth.create_certificates(tmp_path, name)
    sink = ZmqFrameSink(parse_url(f"zmq+bind://127.0.0.1:0?key={tmp_path}/server.key_secret"))
    query = f"?key={tmp_path}/client.key_secret&server_key={tmp_path}/server.key"
    source = ZmqSource(url_of(sink, query))
    stranger = subscriber(sink.endpoint)
    stranger.setsockopt(zmq.RCVTIMEO, 200)

    def send():
        sink.announce(Meta("p1", SKELETON))
        sink.send_frames(frames(10))

    heard = hear(source, send)
    assert heard.count() == 10
    with pytest.raises(zmq.Again):
        stranger.recv()
    sink.close()


def test_with_a_list_of_clients_the_servers_key_alone_opens_nothing(tmp_path, subscriber):
    (tmp_path / "known").mkdir()
    for name in ("server", "guest", "stranger"):
        zmq.auth.create_certificates(tmp_path, name)
    (tmp_path / "guest.key").rename(tmp_path / "known" / "guest.key")
    keys = f"?key={tmp_path}/server.key_secret&clients={tmp_path}/known"
    sink = ZmqFrameSink(parse_url(f"zmq+bind://127.0.0.1:0{keys}"))
    server, _ = zmq.auth.load_certificate(tmp_path / "server.key")
    guest, stranger = (
        subscriber(
            sink.endpoint, keys=zmq.auth.load_certificate(tmp_path / f"{name}.key_secret"), server=server
        )
        for name in ("guest", "stranger")
    )
    stranger.setsockopt(zmq.RCVTIMEO, 500)
    sink.announce(Meta("p1", SKELETON))
    deadline = time.monotonic() + 10
    while not guest.poll(50) and time.monotonic() < deadline:
        sink.send_frames(frames(1))
    assert guest.recv_multipart()[0].endswith(b".p1.")
    with pytest.raises(zmq.Again):
        stranger.recv()
    sink.close()


@pytest.mark.parametrize(
    ("query", "message"),
    [
        ("clients=nowhere", "goes with key="),
        ("key={}/server.key_secret&clients={}/empty", "is no folder with public keys"),
        ("key={}/server.key_secret&clients={}", "a key cannot be read"),
    ],
)
def test_an_impossible_list_of_clients_is_explained(tmp_path, query, message):
    zmq.auth.create_certificates(tmp_path, "server")
    (tmp_path / "broken.key").write_text("no key")
    with pytest.raises(MossarError, match=message):
        ZmqSink(parse_url("zmq+bind://127.0.0.1:0?" + query.format(tmp_path, tmp_path)))


def test_silence_is_explained():
    source = ZmqSource(parse_url("zmq://127.0.0.1:9"))
    assert "connecting to tcp://127.0.0.1:9; no message came yet" in source.explain()
    source.close()
    source.close()


def test_a_receiver_that_is_too_slow_is_noticed_and_the_others_get_everything(monkeypatch, caplog):
    monkeypatch.setattr("mossar_adapters.zeromq.sink.QUEUE", 100)
    sink = ZmqSink(parse_url("zmq+bind://127.0.0.1:0"))
    event = StreamEvent(performer="p1", event="started", take=0, reason="x" * 2000)
    with zmq.Context() as context, context.socket(zmq.SUB) as slow, context.socket(zmq.SUB) as good:
        for subscriber, room in ((slow, 10), (good, 0)):
            subscriber.setsockopt(zmq.LINGER, 0)
            subscriber.setsockopt(zmq.RCVHWM, room)
            subscriber.setsockopt(zmq.SUBSCRIBE, b"")
            subscriber.connect(sink.endpoint)
        time.sleep(0.3)
        received = 0
        for _ in range(400):
            sink.send([event] * 20)
            for _ in range(20):  # it keeps up
                assert good.poll(5000)
                good.recv_multipart()
                received += 1
    sink.close()
    assert received == 8000
    assert sink.dropped > 0
    assert len([message for message in caplog.messages if "a receiver is too slow" in message]) == 1


def test_explaining_silence_does_not_say_of_a_good_sender_that_it_sent_no_frame():
    decoder_of = ZmqSource(parse_url("zmq+bind://127.0.0.1:0"))
    frame = b'{"type": "frame", "t": 0.5, "xyz": [[0, 1, 0]]}'
    decoder_of.decoder.receive(ZmqMessage((b'{"type": "stats"}',), 0.0))
    assert decoder_of.explain().endswith("none was a frame map (type: frame)")
    decoder_of.decoder.receive(ZmqMessage((frame,), 0.0))
    assert "none was a frame map" not in decoder_of.explain()
    decoder_of.close()


def test_limbs_have_topics_of_their_own_and_moves_theirs(subscriber, told):
    sink = ZmqSink(parse_url("zmq+bind://127.0.0.1:0?encoding=json"))
    topics = [
        b"mossar.key_frame.",
        b"mossar.limb.key_frame.",
        b"mossar.limb.segment.",
        b"mossar.activity.",
        b"mossar.move.",
    ]
    heard = [subscriber(sink.endpoint, topic) for topic in topics]
    time.sleep(0.3)
    sink.send(told)
    limbs = [event for event in told if getattr(event, "channel", "body") != "body"]
    wanted = [
        [e for e in told if isinstance(e, KeyFrameEvent) and e.channel == "body"],
        [e for e in limbs if isinstance(e, KeyFrameEvent)],
        [e for e in limbs if isinstance(e, SegmentEvent)],
        [e for e in told if isinstance(e, ActivityEvent)],
        [e for e in told if isinstance(e, MoveEvent)],
    ]
    for receiver, topic, events in zip(heard, topics, wanted, strict=True):
        for event in events:
            assert receiver.recv_multipart() == [topic + b"p1.", to_json(event)]
        assert not receiver.poll(50)
    sink.close()
