"""Frames that came over a wire are segmented as if they had not."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.receiving.selection import SelectedSource
from mossar_adapters.replay.replaying import Replay
from mossar_adapters.urls import open_frame_sink, open_source
from mossar_stream import KeyFrameEvent, Settings

SECONDS = 5.0  # of each performance that are segmented; a little more is sent
RATE = "fps=60"
# For the receiver, where its default would not do.
PROFILES = {
    "osceleton": f"unit=m&{RATE}",
    "kinectv2": RATE,
    "nimate": f"unit=m&{RATE}",
    "flat": f"profile=flat&unit=m&{RATE}",
}


class Wire:
    """Both ends of a wire: a source, and what sends a performance to it."""

    def __init__(self, kind, folder):
        if kind == "zmq":
            self.source = open_source(f"zmq+bind+ipc://{folder}/pose")
            self._sink = open_frame_sink(f"ipc://{folder}/pose?wait=5")
        else:
            self.source = open_source(f"osc://127.0.0.1:0?{PROFILES.get(kind, '')}")
            self._sink = open_frame_sink(f"osc://127.0.0.1:{self.source.port}?profile={kind}")

    def send(self, performance):
        for _ in Replay(performance, [self._sink]).run():
            pass
        self._sink.close()


def performance(speed="max", seconds=SECONDS, **options):
    return DemoSource(seconds=seconds + 0.5, speed=speed, **options)


@pytest.fixture
def segmented(stage):
    """Segment sources while something is sent; leave out what the wall clock says."""

    def run(*sources, send=lambda: None, settings=None, seconds=SECONDS):
        sink = stage.Collected()
        # A busy machine makes pauses that are no gaps.
        pipeline = Pipeline(sources, [sink], settings or Settings(max_pause=60.0), seconds=seconds)
        # Should a frame be lost the end is not reached, and the comparison shows it.
        sender = threading.Thread(target=lambda: (send(), time.sleep(1), pipeline.stop()), daemon=True)
        if any(source.live for source in sources):
            sender.start()
        pipeline.run()
        return [event for event in sink.events if getattr(event, "event", "") not in {"stalled", "resumed"}]

    return run


def confirmed(events, performer="p1"):
    return [
        (e.frame, e.kind)
        for e in events
        if isinstance(e, KeyFrameEvent) and (e.performer, e.status) == (performer, "confirmed")
    ]


@pytest.mark.parametrize("kind", ["zmq", "mossar"])
def test_wires_that_carry_everything_give_the_very_events(segmented, tmp_path, kind):
    wire = Wire(kind, tmp_path)
    found = segmented(wire.source, send=lambda: wire.send(performance(8.0)))
    assert found == segmented(performance())


@pytest.mark.parametrize("kind", ["vmc", "osceleton", "kinectv2", "nimate", "flat"])
def test_other_wires_give_the_same_confirmed_key_frames(segmented, tmp_path, kind):
    # Arrays without names have no known root.
    settings = Settings(center="centroid" if kind == "flat" else "root")
    wire = Wire(kind, tmp_path)
    found = segmented(wire.source, send=lambda: wire.send(performance(8.0)), settings=settings)
    assert confirmed(found) == confirmed(segmented(performance(), settings=settings))
    assert len(confirmed(found)) > 5


def test_wires_that_carry_times_give_the_same_key_frames_at_real_speed(segmented, tmp_path):
    wires = [Wire(kind, tmp_path) for kind in ("zmq", "mossar", "vmc")]

    sent = [(wire, performance(1.0, 5.0, seed=10)) for wire in wires]
    found = segmented(*(wire.source for wire in wires), send=lambda: send_together(sent), seconds=5.0)
    direct = confirmed(segmented(performance(seconds=5.0, seed=10), seconds=5.0))
    assert len(direct) > 3
    assert [confirmed(found, name) for name in ("p1", "p2", "p3")] == [direct] * 3


def send_together(sent):
    """Send performances at the same time, each over its wire."""
    senders = [threading.Thread(target=wire.send, args=(one,)) for wire, one in sent]
    for sender in senders:
        sender.start()
    for sender in senders:
        sender.join()


def one_of_ten(name, speed="max", seconds=SECONDS):
    return SelectedSource(performance(speed, seconds, performers=10), ReadOptions(performer=name))


def test_ten_performers_in_one_osc_stream_give_exactly_the_events_of_ten_runs(segmented, tmp_path):
    wire = Wire("mossar", tmp_path)
    together = segmented(
        wire.source, send=lambda: wire.send(performance(4.0, 4.0, performers=10)), seconds=4.0
    )
    for name in (f"p{k}" for k in range(1, 11)):
        alone = segmented(one_of_ten(name, "max", 4.0), seconds=4.0)
        assert [event for event in together if event.performer == name] == alone
    assert len(confirmed(together)) > 3


def test_ten_users_of_osceleton_give_exactly_the_events_of_ten_streams(segmented, tmp_path):
    wire = Wire("osceleton", tmp_path)
    together = segmented(
        wire.source, send=lambda: wire.send(performance(4.0, 4.0, performers=10)), seconds=4.0
    )

    def run(name):
        wire, sent = Wire("osceleton", tmp_path), one_of_ten(name, 4.0, 4.0)
        return segmented(wire.source, send=lambda: wire.send(sent), seconds=4.0)

    names = [f"p{k}" for k in range(1, 11)]
    with ThreadPoolExecutor(len(names)) as runs:  # each a run of its own, at the same time
        for name, alone in zip(names, runs.map(run, names), strict=True):
            assert [event for event in together if event.performer == name] == alone
            assert confirmed(alone, name)
