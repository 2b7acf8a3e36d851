"""Frames over a WebSocket that listens: from programs and pages, within limits."""

import json
import threading
import time

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from mossar_adapters.source import Departure
from mossar_adapters.urls import open_sink, open_source
from mossar_adapters.websocket_source import MAX_MESSAGE
from mossar_stream import MossarError

META = {"type": "meta", "performer": "ann", "names": ["hips", "hand"], "parents": [-1, 0], "root": 0}


def frame(k, performer="ann", **more):
    return json.dumps(
        {
            "type": "frame",
            "performer": performer,
            "seq": k,
            "t": k / 30,
            "xyz": [[0, 1, 0], [k / 10, 1, 0]],
            **more,
        }
    )


@pytest.fixture
def source():
    opened = open_source("ws+bind://127.0.0.1:0")
    yield opened
    opened.close()


def test_frames_of_a_program_arrive(source, hear):
    def send():
        with connect(f"ws://127.0.0.1:{source.port}") as client:
            client.send(json.dumps(META))
            for k in range(20):
                client.send(frame(k, conf=[1.0, 0.5]))
            time.sleep(0.3)

    heard = hear(source, send)
    assert heard.metas[0].skeleton.names == ("hips", "hand")
    assert np.allclose(heard.times("ann"), np.arange(20) / 30)
    assert heard.positions("ann").shape == (20, 2, 3)
    assert [item.reason for item in heard.items if isinstance(item, Departure)] == ["disconnected"]


def test_a_frame_of_33_joints_fits_and_one_of_a_thousand(source, hear):
    def send():
        with connect(f"ws://127.0.0.1:{source.port}") as client:
            for joints in (33, 1000):
                xyz = np.random.default_rng(1).normal(size=(joints, 3)).round(6).tolist()
                client.send(json.dumps({"type": "frame", "performer": f"of{joints}", "t": 0.0, "xyz": xyz}))
            time.sleep(0.3)

    heard = hear(source, send)
    assert heard.positions("of33").shape == (1, 33, 3)
    assert heard.positions("of1000").shape == (1, 1000, 3)


def test_what_is_malformed_is_counted_and_the_next_frame_counts(source, hear):
    def send():
        with connect(f"ws://127.0.0.1:{source.port}") as client:
            for bad in ("no json", '{"type": "frame", "xyz": 3}', "[]", '{"type": "stats"}', b"\xff\x00"):
                client.send(bad)
            client.send(frame(0))
            time.sleep(0.3)

    heard = hear(source, send)
    assert heard.count("ann") == 1
    assert source.counters.malformed >= 3
    assert source.counters.received == 6


def test_a_message_that_is_too_long_ends_its_connection_alone(source, hear):
    def send():
        with (
            connect(f"ws://127.0.0.1:{source.port}") as flood,
            connect(f"ws://127.0.0.1:{source.port}") as client,
        ):
            flood.send("x" * (MAX_MESSAGE + 1))
            with pytest.raises(ConnectionClosed):
                flood.recv(5)
            client.send(frame(0))
            time.sleep(0.3)

    assert hear(source, send).count("ann") == 1


def test_pages_of_other_sites_are_refused(source):
    with pytest.raises(InvalidStatus):
        connect(f"ws://127.0.0.1:{source.port}", origin="https://evil.example")
    with connect(f"ws://127.0.0.1:{source.port}", origin="http://127.0.0.1:8000"):
        pass


def test_a_page_that_is_named_may_connect():
    source = open_source("ws+bind://127.0.0.1:0?origin=https://game.example")
    try:
        with connect(f"ws://127.0.0.1:{source.port}", origin="https://game.example"):
            pass
        with pytest.raises(InvalidStatus):
            connect(f"ws://127.0.0.1:{source.port}", origin="http://127.0.0.1:8000")
    finally:
        source.close()


def test_a_port_in_use_is_said_in_one_line(source):
    with pytest.raises(MossarError, match=f"port {source.port} is in use"):
        open_source(f"ws+bind://127.0.0.1:{source.port}")


def test_it_says_that_nobody_has_connected(source):
    assert "no client has connected yet" in source.explain()


def test_it_ends_soon_when_it_is_closed(source):
    reader = threading.Thread(target=lambda: list(source.items()))
    reader.start()
    source.close()
    reader.join(2)
    assert not reader.is_alive()


def test_a_plain_ws_url_is_no_source():
    with pytest.raises(MossarError, match="cannot be read from"):
        open_source("ws://127.0.0.1:8765")


def test_ws_bind_takes_no_events():
    with pytest.raises(MossarError, match="takes no events"):
        open_sink("ws+bind://127.0.0.1:0")


@pytest.mark.parametrize("ahead", [-60.0, 0.5, 30.0])
def test_two_pages_with_clocks_of_their_own_are_on_one(hear, ahead):
    opened = open_source("ws+bind://127.0.0.1:0", people=2)

    def send():
        with (
            connect(f"ws://127.0.0.1:{opened.port}") as one,
            connect(f"ws://127.0.0.1:{opened.port}") as other,
        ):
            for k in range(30):
                one.send(frame(k, "ann", t=100 + k / 30))
                other.send(frame(k, "bob", t=100 + ahead + k / 30, xyz=[[3, 1, 0], [3 + k / 10, 1, 0]]))
                time.sleep(1 / 30)
            time.sleep(0.3)

    heard = hear(opened, send)
    opened.close()
    assert np.allclose(heard.times("p1"), 100 + np.arange(30) / 30)
    assert np.allclose(np.diff(heard.times("p2")), 1 / 30)
    assert np.abs(heard.times("p2") - heard.times("p1")).max() < 0.2


def test_two_connections_of_one_name_are_two_performers_each_with_its_clock(source, hear):
    def send():
        with (
            connect(f"ws://127.0.0.1:{source.port}") as one,
            connect(f"ws://127.0.0.1:{source.port}") as other,
        ):
            for k in range(20):
                one.send(frame(k + 9000, performer="p1"))
                other.send(frame(k, performer="p1"))
                time.sleep(0.005)
            time.sleep(0.3)

    heard = hear(source, send)
    found = sorted([heard.times("p1"), heard.times("p2")], key=lambda times: times[0] % 1000)
    for times in found:
        assert np.allclose(np.diff(times), 1 / 30)
    assert heard.count("p1") == heard.count("p2") == 20
    assert not [meta for meta in heard.metas if meta.performer not in {"p1", "p2"}]


def test_a_stranger_neither_ends_nor_locks_the_take_of_another(source, hear):
    def send():
        with connect(f"ws://127.0.0.1:{source.port}") as good:
            good.send(json.dumps(META))
            good.send(frame(0))
            time.sleep(0.1)
            with connect(f"ws://127.0.0.1:{source.port}") as stranger:
                stranger.send(json.dumps({**META, "names": ["only"], "parents": [-1]}))
                time.sleep(0.1)
            for k in range(1, 10):
                good.send(frame(k))
            time.sleep(0.3)

    heard = hear(source, send)
    assert heard.count("ann") == 10
    assert [item.performer for item in heard.items if isinstance(item, Departure)] == ["ann_2", "ann"]
    assert source.counters.malformed == 0


def test_a_client_that_floods_with_names_delays_and_drops_nobody_else(source, hear):
    def send():
        with (
            connect(f"ws://127.0.0.1:{source.port}") as flood,
            connect(f"ws://127.0.0.1:{source.port}") as good,
        ):
            for k in range(3000):
                flood.send(frame(0, performer=f"x{k}"))
                if k % 100 == 0:
                    good.send(frame(k))
            time.sleep(0.5)

    heard = hear(source, send)
    assert heard.count("ann") == 30
    assert len({meta.performer for meta in heard.metas}) < 200
