"""What the tests of the pipeline share: sources that follow a script, and a sink that keeps everything."""

import threading
import time
from collections.abc import Iterator, Sequence
from types import SimpleNamespace

import numpy as np
import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.source import Meta, Recording
from mossar_stream import Event, Frames, Skeleton, StreamEvent

SKELETON = Skeleton(("hip", "hand"), (-1, 0))


@pytest.fixture(autouse=True)
def same_run(monkeypatch):
    """Call all runs the same, so that their events can be compared."""
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline.new_run_id", lambda: "a1")


class Script:
    """A source that delivers what it is told to, and waits where it is told to."""

    def __init__(self, items: Sequence[object], *, live: bool = False, name: str = "script") -> None:
        self.name = name
        self.live = live
        self._items = items
        self._closed = threading.Event()

    def items(self) -> Iterator[Meta | Frames | None]:
        for item in self._items:
            if isinstance(item, float):
                until = time.monotonic() + item
                while (left := until - time.monotonic()) > 0:
                    if self._closed.wait(min(left, 0.1)):
                        return
                    yield None
            elif isinstance(item, Exception):
                raise item
            else:
                yield item

    def close(self) -> None:
        self._closed.set()


class Collected:
    """A sink that keeps what it gets."""

    def __init__(self, name: str = "collected") -> None:
        self.name = name
        self.dropped = 0
        self.metas: list[Meta] = []
        self.events: list[Event] = []
        self.closed = False

    def announce(self, meta: Meta) -> None:
        self.metas.append(meta)

    def send(self, events: Sequence[Event]) -> None:
        self.events += events

    def close(self) -> None:
        self.closed = True

    def of(self, kind: type) -> list[Event]:
        return [event for event in self.events if isinstance(event, kind)]


def wave(first: int = 0, count: int = 60, performer: str = "p1", fps: float = 30.0) -> Frames:
    """Frames of a hand that swings, numbered from `first`."""
    times = np.arange(first, first + count) / fps
    positions = np.zeros((count, 2, 3), np.float32)
    positions[:, 1, 0] = np.sin(2 * np.pi * times) * (np.sin(times) > 0)
    return Frames(positions, times, performer=performer)


def meta(performer: str = "p1") -> Meta:
    return Meta(performer, SKELETON, 30.0)


def demo(seconds=6.0, **options):
    return DemoSource(seconds=seconds, speed="max", **options)


def changes(sink):
    return [(event.performer, event.event, event.reason) for event in sink.of(StreamEvent)]


def recording(name="take.msk", chunk=30, count=240):
    frames = wave(0, count)

    def chunks():
        for i in range(0, count, chunk):
            yield Frames(frames.positions[i : i + chunk], frames.times[i : i + chunk])

    return Recording(name, SKELETON, 30.0, chunks, (), count)


@pytest.fixture(scope="session")
def stage():
    """Return the parts by name."""
    return SimpleNamespace(
        Script=Script,
        Collected=Collected,
        SKELETON=SKELETON,
        wave=wave,
        meta=meta,
        demo=demo,
        changes=changes,
        recording=recording,
    )
