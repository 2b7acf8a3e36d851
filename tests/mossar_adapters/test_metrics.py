import contextlib
import urllib.request

import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.metrics import Metrics
from mossar_adapters.pipeline import Pipeline
from mossar_stream.errors import MossarError


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
