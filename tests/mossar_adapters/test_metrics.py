import contextlib
import socket
import threading
import time
import urllib.request

import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.metrics import MAX_CLIENTS, Metrics
from mossar_adapters.pipeline import Pipeline
from mossar_stream import MossarError


@pytest.fixture
def pipeline():
    done = Pipeline([DemoSource(1, performers=2, seconds=3, speed="max")], [])
    done.run()
    return done


def asked(url):
    with urllib.request.urlopen(url, timeout=5) as answer:
        return answer.read().decode()


def test_prometheus_gets_counters_delays_and_what_the_process_holds(pipeline):
    with contextlib.closing(Metrics(pipeline, 0)) as served:
        text = asked(served.url)
    assert 'mossar_frames_total{performer="p1"} 180.0' in text
    assert 'mossar_frames_total{performer="p2"} 180.0' in text
    assert 'mossar_malformed_total{source="demo:"} 0.0' in text
    assert "mossar_outputs_failed 0.0" in text
    assert "process_resident_memory_bytes" in text


def test_it_is_served_to_this_computer_only_unless_asked_otherwise(pipeline):
    with contextlib.closing(Metrics(pipeline, 0)) as served:
        assert served.url.startswith("http://127.0.0.1:")


def test_a_port_in_use_is_said_in_one_line(pipeline):
    with contextlib.closing(Metrics(pipeline, 0)) as served:
        port = int(served.url.rpartition(":")[2].partition("/")[0])
        with pytest.raises(MossarError, match=f"--metrics 127.0.0.1:{port}: the port is in use"):
            Metrics(pipeline, port)


def test_connections_that_only_stay_exhaust_nothing_and_others_are_answered(pipeline, monkeypatch):
    monkeypatch.setattr("mossar_adapters.metrics.PATIENCE", 30.0)
    threads = threading.active_count()
    with contextlib.closing(Metrics(pipeline, 0)) as served, contextlib.ExitStack() as idle:
        place = ("127.0.0.1", int(served.url.rpartition(":")[2].partition("/")[0]))
        for _ in range(200):
            client = idle.enter_context(socket.create_connection(place, timeout=5))
            client.sendall(b"GET /metrics HTTP/1.1\r\n")
        assert "mossar_frames_total" in asked(served.url)
        assert threading.active_count() - threads <= MAX_CLIENTS + 4


def test_a_client_that_says_nothing_is_cut_off(pipeline, monkeypatch, capfd):
    monkeypatch.setattr("mossar_adapters.metrics.PATIENCE", 0.1)
    with contextlib.closing(Metrics(pipeline, 0)) as served:
        place = ("127.0.0.1", int(served.url.rpartition(":")[2].partition("/")[0]))
        with socket.create_connection(place, timeout=5) as client:
            began = time.monotonic()
            assert client.recv(100) == b""
            assert time.monotonic() - began < 3
    assert capfd.readouterr().err == ""
