import json
import time

import numpy as np
import pylsl
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.lsl import LslSink, LslSource
from mossar_stream import StreamEvent, to_json


def outlet(name, labels, unit):
    info = pylsl.StreamInfo(name, "MoCap", len(labels), 100.0, "float32", f"test-{name}")
    channels = info.desc().append_child("channels")
    for label in labels:
        channel = channels.append_child("channel")
        channel.append_child_value("label", label)
        channel.append_child_value("unit", unit)
    return pylsl.StreamOutlet(info)


def test_labelled_channels_become_joints_in_metres_with_lsls_times(hear):
    stream = outlet("mossar-test-in", ["hips_x", "hips_y", "hips_z", "head_x", "head_y", "head_z"], "mm")
    source = LslSource(parse_url("lsl:?name=mossar-test-in"), ReadOptions())
    times = []

    def send():
        assert stream.wait_for_consumers(15)
        time.sleep(0.3)
        for k in range(50):
            times.append(pylsl.local_clock())
            stream.push_sample([0, 1000, k, 0, 1700, k], times[-1])
            time.sleep(0.002)

    heard = hear(source, send, quiet=5)
    skeleton = heard.metas[0].skeleton
    assert skeleton.names == ("hips", "head")
    assert skeleton.root == 0
    assert heard.metas[0].fps == 100.0
    assert heard.positions()[:, 0] == pytest.approx(np.array([(0, 1, k / 1000) for k in range(50)]))
    assert heard.times() == pytest.approx(np.array(times), abs=0.002)
    assert "reading the LSL stream 'mossar-test-in'; 50 samples" in source.explain()


def test_samples_of_a_clock_in_whole_seconds_are_timed_by_arrival(hear, caplog):
    stream = outlet("mossar-test-coarse", ["hips_x", "hips_y", "hips_z"], "m")
    source = LslSource(parse_url("lsl:?name=mossar-test-coarse"), ReadOptions())

    def send():
        assert stream.wait_for_consumers(15)
        time.sleep(0.3)
        for k in range(80):
            stream.push_sample([0, 1 + k / 100, 0], float(int(pylsl.local_clock())))
            time.sleep(0.01)

    heard = hear(source, send, quiet=5)
    times = heard.times()
    assert heard.positions()[:, 0, 1] == pytest.approx([1 + k / 100 for k in range(80)])
    assert np.diff(times).min() > 0
    assert 0.5 < times[-1] - times[0] < 5.0
    assert source.counters.retimed >= 75
    assert "frames get the times of their arrival" in caplog.text


def test_a_stream_that_is_not_there_is_looked_for_and_named():
    source = LslSource(parse_url("lsl:?name=nobody-sends-this"))
    items = source.items()
    assert next(items) is None
    assert "no LSL stream called 'nobody-sends-this'" in source.explain()
    source.close()
    assert list(items) == []


def test_events_leave_as_json_markers():
    sink = LslSink(parse_url("lsl:?name=mossar-test-out"))
    found = pylsl.resolve_byprop("name", "mossar-test-out", 1, 10)
    inlet = pylsl.StreamInlet(found[0])
    inlet.open_stream(10)
    assert found[0].type() == "Markers"
    sink.send([StreamEvent(performer="p1", event="started", take=0)])
    sample, _ = inlet.pull_sample(5)
    sink.close()
    sink.close()
    inlet.close_stream()
    assert json.loads(sample[0])["event"] == "started"


def test_limbs_and_moves_leave_as_markers_too_in_their_order(told):
    sink = LslSink(parse_url("lsl:?name=mossar-test-limbs"))
    inlet = pylsl.StreamInlet(pylsl.resolve_byprop("name", "mossar-test-limbs", 1, 10)[0])
    inlet.open_stream(10)
    sink.send(told)
    found = [inlet.pull_sample(5)[0][0] for _ in told]
    sink.close()
    inlet.close_stream()
    assert found == [to_json(event).decode() for event in told]
