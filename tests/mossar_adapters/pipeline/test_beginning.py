"""What waited while the program started is not the present; a sender's last frame resumes nothing."""

import socket
import time

import numpy as np

from mossar_adapters.address import parse_url
from mossar_adapters.demo import DemoSource
from mossar_adapters.osc.encode import encode
from mossar_adapters.osc.source import OscSource
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.pipeline.beginning import OLD, Beginning
from mossar_adapters.pipeline.inbox import Arrival
from mossar_adapters.source import Meta
from mossar_stream import Frames, Settings, Skeleton, StatsEvent, StreamEvent

META = Meta("p1", Skeleton(("hip", "hand"), (-1, 0)), 30.0)


def frames(first, count):
    return Frames(np.zeros((count, 2, 3), np.float32), np.arange(first, first + count) / 30)


class Live:
    """A live source whose first frames arrived some time ago."""

    name, live = "live", True

    def __init__(self, ages):
        self._ages = ages
        self._came = 0.0

    def came(self, _):
        return self._came

    def items(self):
        yield META
        for number, age in enumerate(self._ages):
            self._came = time.monotonic() - age
            yield frames(10 * number, 10)

    def close(self):
        pass


class Kept:
    name = "kept"
    dropped = 0

    def __init__(self):
        self.events = []

    def announce(self, meta):
        pass

    def send(self, events):
        self.events += events

    def close(self):
        pass


def test_old_frames_at_the_start_are_dropped_counted_and_logged_once(caplog):
    sink = Kept()
    pipeline = Pipeline([Live([9.0, 5.0, 0.1, 7.0])], [sink], Settings())
    outcome = pipeline.run()
    assert outcome.frames == 20  # those that came late in the run are late, and not of the start
    assert pipeline.upkeep.stats_of(pipeline, "p1").queue_dropped == 20
    said = [message for message in caplog.messages if "older than" in message]
    assert said == ["live: 20 frames were older than 1 s at the start and were dropped"]
    assert not any(isinstance(event, StatsEvent) for event in sink.events)


def test_what_waits_in_the_queue_grows_old_too():
    beginning = Beginning(Live([]))
    now = time.monotonic()
    assert beginning.is_old(Arrival(0, frames(0, 3), now - OLD - 1), 3)
    assert not beginning.is_old(Arrival(0, frames(3, 3), now), 3)
    assert not beginning.is_old(Arrival(0, frames(6, 3), now - 9), 3)
    assert beginning.dropped == 3


def test_recordings_and_performers_of_our_own_wait_for_the_program():
    beginning = Beginning(DemoSource(speed=1.0))
    assert not beginning.is_old(Arrival(0, frames(0, 3), time.monotonic() - 60), 3)


def bone(name, number):
    return encode("/VMC/Ext/Bone/Pos", "sfffffff", name, 0.0, 1.0, 0.01 * number, 0.0, 0.0, 0.0, 1.0)


def test_the_last_frame_of_a_sender_whose_marks_come_first_resumes_nothing():
    source = OscSource(parse_url("osc://127.0.0.1:0?profile=vmc"))
    sink = Kept()
    pipeline = Pipeline([source], [sink], Settings(max_pause=0.6))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for number in range(30):
            for message in (
                encode("/VMC/Ext/OK", "i", 1),
                encode("/VMC/Ext/T", "f", number / 30),
                *(bone(name, number) for name in ("Hips", "Spine", "Head", "LeftHand", "RightHand")),
            ):
                sender.sendto(message, ("127.0.0.1", source.port))

    def look():
        if any(isinstance(event, StreamEvent) and event.event == "ended" for event in sink.events):
            pipeline.stop()

    pipeline._tick = look
    pipeline.run()
    changes = [event.event for event in sink.events if isinstance(event, StreamEvent)]
    assert changes == ["started", "stalled", "ended"]
    assert pipeline.outcome.frames == 30
