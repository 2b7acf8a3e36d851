"""Truth: the expected events, computed from the sent frames.

The rules of the interface are followed here a second time, frame by frame and without the pipeline: repeated and
late frames are dropped but numbered, a step of the clock beyond `max_pause` begins a new take. The remaining frames go
to segmenters of our own, in stretches; the pipeline must emit exactly the same bytes for every event.
"""

import threading
from collections import deque
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from checks.soak.strangers import is_of_a_stranger
from mossar_adapters.pipeline.upkeep import STOPPED
from mossar_stream import Event, Segmenter, Settings, Skeleton, StatsEvent, StreamEvent, to_json

_RECENT = 60_000  # events that receivers may still hear; half a minute of them
_SHOWN = 5  # differences that are kept


class _Performer(msgspec.Struct):
    segmenter: Segmenter
    time: float | None = None  # of the latest frame used in the open take, s
    number: int = 0  # of the next frame in the take


class Truth:
    """Knows the events to come, and compares. Any thread may call any method.

    Args:
        skeleton: Of all performers.
        settings: Of the pipeline.
    """

    def __init__(self, skeleton: Skeleton, settings: Settings) -> None:
        self.equal = 0  # events that came out as they must
        self.wrong = 0
        self.differences: list[str] = []
        self._skeleton, self._settings = skeleton, settings
        self._performers: dict[str, _Performer] = {}
        self._expected: dict[str, deque[bytes]] = {}
        self._recent = np.zeros(_RECENT, np.int64)  # hashes of the latest events, ring buffer
        self._count = 0  # of events put into it
        self._lock = threading.Lock()

    def follow(self, name: str, positions: NDArray[np.float32], times: NDArray[np.float64]) -> None:
        """Note frames that are about to be sent."""
        who = self._performers.get(name)
        if who is None:
            who = self._performers[name] = _Performer(Segmenter(self._skeleton, self._settings, name))
        begin = 0  # of the stretch of frames that follow each other
        for i, time in enumerate(times.tolist()):
            step = 0.0 if who.time is None else time - who.time
            if abs(step) > self._settings.max_pause:
                self._push(name, who, positions[begin:i], times[begin:i])
                self._expect(name, who.segmenter.end_take("gap" if step > 0 else "clock stepped back"))
                begin, who.number = i, 0
            elif who.time is not None and step <= 0:
                self._push(name, who, positions[begin:i], times[begin:i])
                begin, who.number = i + 1, who.number + 1
                continue
            who.time = time
        self._push(name, who, positions[begin:], times[begin:])

    def leave(self, name: str) -> None:
        """Note that a performer has gone for longer than `max_pause`."""
        who = self._performers[name]
        self._expect(name, who.segmenter.end_take("gap"))
        who.time, who.number = None, 0

    def check(self, events: Sequence[Event]) -> None:
        """Compare emitted events."""
        for event in events:
            if is_clock(event) or is_of_a_stranger(event):
                continue
            found, expected = _comparable(event), b"nothing"
            with self._lock:
                waiting = self._expected.get(event.performer)
                expected = waiting.popleft() if waiting else expected
            if found == expected:
                self.equal += 1
            else:
                self.differ(f"expected {expected.decode()}, found {found.decode()}")

    def knows(self, event: Event) -> bool:
        """Return whether an event that comes late, or again, is one of those that were expected."""
        with self._lock:
            return (
                is_clock(event)
                or is_of_a_stranger(event)
                or bool((self._recent == hash(_comparable(event))).any())
            )

    def differ(self, difference: str) -> None:
        """Note a difference."""
        self.wrong += 1
        if len(self.differences) < _SHOWN:
            self.differences.append(difference)

    @property
    def missing(self) -> int:
        """Number of events that have not come out yet."""
        with self._lock:
            return sum(map(len, self._expected.values()))

    def _push(
        self, name: str, who: _Performer, positions: NDArray[np.float32], times: NDArray[np.float64]
    ) -> None:
        if len(times):
            self._expect(name, who.segmenter.push(positions, times, first_frame=who.number))
            who.number += len(times)

    def _expect(self, name: str, events: Sequence[Event]) -> None:
        written = [_comparable(event) for event in events]
        with self._lock:
            self._expected.setdefault(name, deque()).extend(written)
            for line in written:
                self._recent[self._count % _RECENT] = hash(line)
                self._count += 1


def _comparable(event: Event) -> bytes:
    """Return an event as a segmenter emits it: without the run, and a take that ended with the frames as a gap."""
    if isinstance(event, StreamEvent):
        reason = "gap" if event.reason == STOPPED else event.reason
        event = msgspec.structs.replace(event, run=None, reason=reason)
    return to_json(event)


def is_clock(event: Event) -> bool:
    """Return whether an event depends on the machine and not on the motion."""
    if isinstance(event, StatsEvent):
        return True
    return isinstance(event, StreamEvent) and event.event in {"stalled", "resumed"}
