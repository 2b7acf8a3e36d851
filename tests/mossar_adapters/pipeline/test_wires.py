"""Frames that came over a wire are segmented as if they had not."""

import threading

import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.replaying import Replay
from mossar_adapters.urls import open_frame_sink, open_source
from mossar_stream.events import KeyFrameEvent

SECONDS = 4.0
RATE = 60
WIRES = {  # what the sender writes, what the receiver is told
    "zmq": ("zmq", ""),
    "mossar": ("osc://127.0.0.1:{port}", ""),
    "vmc": ("osc://127.0.0.1:{port}?profile=vmc", ""),
    "osceleton": ("osc://127.0.0.1:{port}?profile=osceleton", "?unit=m&fps=60"),
    "kinectv2": ("osc://127.0.0.1:{port}?profile=kinectv2", "?fps=60"),
    "nimate": ("osc://127.0.0.1:{port}?profile=nimate", "?unit=m&fps=60"),
    "flat": ("osc://127.0.0.1:{port}?profile=flat", "?unit=m&fps=60&joints=demo"),
}


def events_of(stage, source, seconds=SECONDS):
    """Segment a source; events of the wall clock are left out."""
    sink = stage.Collected()
    Pipeline([source], [sink], seconds=seconds).run()
    wall = {"stalled", "resumed"}
    return [event for event in sink.events if getattr(event, "event", "") not in wall]


@pytest.fixture
def over(stage, tmp_path):
    """Replay a recording over a wire and return the events at the other end."""

    def run(wire, played, speed, seconds=SECONDS, query=None):
        sent_to, options = WIRES[wire]
        options = options if query is None else query
        if wire == "zmq":
            source = open_source(f"zmq+bind+ipc://{tmp_path}/pose{options}")
            sink = open_frame_sink(f"ipc://{tmp_path}/pose?wait=5")
        else:
            source = open_source(f"osc://127.0.0.1:0{options}")
            sink = open_frame_sink(sent_to.format(port=source.port))
        sender = threading.Thread(target=lambda: list(Replay(played(speed), [sink]).run()))
        sender.start()
        found = events_of(stage, source, seconds)
        sender.join()
        sink.close()
        return found

    return run


def performance(speed):
    return DemoSource(seconds=SECONDS + 0.5, speed=speed)


def confirmed(events):
    return [e.frame for e in events if isinstance(e, KeyFrameEvent) and e.status == "confirmed"]


@pytest.mark.parametrize("wire", ["zmq", "mossar"])
def test_protocols_that_carry_everything_give_the_very_events(stage, over, wire):
    assert over(wire, performance, 8.0) == events_of(stage, performance("max"))
