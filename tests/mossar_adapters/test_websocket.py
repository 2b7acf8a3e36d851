import contextlib
import json
import socket
import threading
import time
from pathlib import Path

import msgspec
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from mossar_adapters.address import parse_url
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_sink
from mossar_adapters.websocket import QUEUE, WebSocketSink
from mossar_stream import ActivityEvent, MossarError, RepetitionEvent, Skeleton, StreamEvent

META = Meta("p1", Skeleton(("hips", "head"), (-1, 0)), 60.0)


def started(take=0):
    return StreamEvent(performer="p1", event="started", take=take)


@pytest.fixture
def sink():
    opened = open_sink("ws://127.0.0.1:0")
    yield opened
    opened.close()


def test_clients_get_metas_first_and_then_every_event(sink):
    sink.announce(META)
    with connect(f"ws://127.0.0.1:{sink.port}") as client:
        assert json.loads(client.recv(5))["names"] == ["hips", "head"]
        sink.send([started(k) for k in range(5)])
        assert [json.loads(client.recv(5))["take"] for _ in range(5)] == [0, 1, 2, 3, 4]


def test_a_client_that_joins_late_gets_the_state_of_everybody(sink, made):
    sink.announce(msgspec.structs.replace(META, settings={"level": "cluster"}))
    counted = made(RepetitionEvent, take=1, count=3, total=7)
    moved = ActivityEvent(
        performer="p1",
        id="p1/activity/1/1",
        take=1,
        state="moving",
        start=1.0,
        previous=None,
        limb=None,
        decided_time=1.1,
    )
    sink.send([msgspec.structs.replace(started(1), run="a1"), moved, counted])
    with connect(f"ws://127.0.0.1:{sink.port}") as client:
        assert json.loads(client.recv(5))["type"] == "meta"
        state = json.loads(client.recv(5))
        expected = {"type": "state", "v": 1, "performer": "p1", "run": "a1", "take": 1, "level": "cluster"}
        assert {name: state[name] for name in expected} == expected
        assert (state["present"], state["repetitions"]) == (True, {"body": 7})
        assert state["activity"] == {"body": "moving"}
        sink.send([StreamEvent(performer="p1", event="ended", take=1)])
        assert json.loads(client.recv(5))["event"] == "ended"
    with connect(f"ws://127.0.0.1:{sink.port}") as client:
        assert [json.loads(client.recv(5)).get("present") for _ in range(2)] == [None, False]


def test_clients_may_come_and_go(sink):
    sink.announce(META)
    for _ in range(3):
        with connect(f"ws://127.0.0.1:{sink.port}") as client:
            client.recv(5)
            client.send("anything")
    deadline = time.monotonic() + 5
    while sink.clients and time.monotonic() < deadline:
        sink.send([started()])
        time.sleep(0.01)
    assert sink.clients == 0


def test_a_client_that_never_reads_loses_messages_and_stops_nobody(sink):
    sink.announce(META)
    lazy = socket.create_connection(("127.0.0.1", sink.port))
    lazy.sendall(
        b"GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    with connect(f"ws://127.0.0.1:{sink.port}", close_timeout=0.1) as client:
        client.recv(5)
        received = []
        reader = threading.Thread(target=lambda: received.extend(client.recv(10) for _ in range(200)))
        reader.start()
        reason = "x" * 20_000
        for k in range(200):
            sink.send([StreamEvent(performer="p1", event="reset", take=k, reason=reason)])
            time.sleep(0.001)
        reader.join(10)
        assert len(received) == 200
        for k in range(QUEUE + 500):
            sink.send([StreamEvent(performer="p1", event="reset", take=k, reason=reason)])
        deadline = time.monotonic() + 5
        while sink.dropped == 0 and time.monotonic() < deadline:
            time.sleep(0.01)
    assert sink.dropped > 0
    lazy.close()


def test_pages_from_elsewhere_are_refused_where_origins_are_named():
    sink = WebSocketSink(parse_url("ws://127.0.0.1:0?origin=https://game.example"))
    with connect(f"ws://127.0.0.1:{sink.port}", origin="https://game.example"):
        pass
    with pytest.raises(InvalidStatus):
        connect(f"ws://127.0.0.1:{sink.port}", origin="https://evil.example")
    sink.close()


LOCAL = ["http://localhost:8000", "http://127.0.0.1", "https://[::1]:8443", "null", None]
FOREIGN = [
    "https://evil.example",
    "http://localhost.evil.example",
    "http://127.0.0.1.evil.example",
    "file://x",
]


def test_by_default_pages_of_this_computer_and_programs_are_served_and_no_others(sink):
    for origin in LOCAL:
        with connect(f"ws://127.0.0.1:{sink.port}", origin=origin):
            pass
    for origin in FOREIGN:
        with pytest.raises(InvalidStatus, match="403"):
            connect(f"ws://127.0.0.1:{sink.port}", origin=origin)


def test_every_page_is_served_where_the_user_says_so():
    sink = WebSocketSink(parse_url("ws://127.0.0.1:0?origin=*"))
    with connect(f"ws://127.0.0.1:{sink.port}", origin="https://evil.example"):
        pass
    sink.close()


def test_the_last_events_are_delivered_on_closing(sink):
    with connect(f"ws://127.0.0.1:{sink.port}") as client:
        time.sleep(0.1)
        sink.send([started(k) for k in range(100)])
        sink.close()
        assert [json.loads(client.recv(5))["take"] for _ in range(100)] == list(range(100))
        with pytest.raises(ConnectionClosed):
            client.recv(5)


def test_a_client_that_never_says_goodbye_is_told_that_it_is_over(sink):
    asked = "GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    asked += "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
    with socket.create_connection(("127.0.0.1", sink.port)) as client:
        client.sendall(asked.encode())
        client.settimeout(5)
        assert client.recv(4096).startswith(b"HTTP/1.1 101")
        sink.close()
        last = client.recv(4096)  # the server's goodbye, which nobody answers
        assert last
        while last:
            last = client.recv(4096)


def test_a_port_in_use_is_named(sink):
    with pytest.raises(MossarError, match=f"port {sink.port} is in use"):
        open_sink(f"ws://127.0.0.1:{sink.port}")


def test_closing_twice_and_sending_afterwards_do_no_harm(sink):
    sink.close()
    sink.close()
    sink.send([started()])
    assert sink.dropped == 1


@pytest.mark.parametrize(
    "greeting", [b"", b"GET / HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"]
)
def test_a_client_that_never_asks_for_a_websocket_does_not_keep_the_sink_open(sink, greeting):
    with socket.create_connection(("127.0.0.1", sink.port)) as silent:
        silent.sendall(greeting)
        time.sleep(0.1)
        began = time.monotonic()
        sink.close()
        assert time.monotonic() - began < 1.0


def descriptors_of(port):
    """Return how many connections to a port this process holds at the server's end."""
    rows = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    return sum(int(row[1].split(":")[1], 16) == port and row[3] == "01" for row in rows)


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="connections are counted in /proc")
def test_connections_that_only_stay_exhaust_nothing_and_others_are_served(sink):
    with contextlib.ExitStack() as idle:
        for _ in range(300):
            idle.enter_context(socket.create_connection(("127.0.0.1", sink.port), timeout=5))
        with connect(f"ws://127.0.0.1:{sink.port}") as client:
            sink.announce(META)
            assert json.loads(client.recv(5))["type"] == "meta"
        deadline = time.monotonic() + 5
        while descriptors_of(sink.port) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert descriptors_of(sink.port) == 0


@pytest.mark.parametrize("greeting", [b"", b"rubbish\r\n\r\n", b"GET / HTTP/1.1\r\nX: " + b"x" * 9000])
def test_who_speaks_something_else_fills_no_log(sink, caplog, greeting):
    with socket.create_connection(("127.0.0.1", sink.port)) as stranger:
        stranger.sendall(greeting)
        stranger.shutdown(socket.SHUT_WR)
        while stranger.recv(1000):
            pass
    sink.close()
    assert caplog.records == []
