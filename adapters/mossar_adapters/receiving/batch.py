"""Batching: poses of many performers, announced, timed and put together into chunks.

The last step from a wire to the pipeline, and the same for all wires. It decides on the skeleton of a performer, the
time of a frame, and the frames of a chunk.
"""

import logging
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.joint_sets import by_count
from mossar_adapters.live import Counters
from mossar_adapters.newest import Newest
from mossar_adapters.receiving.clocks import Clocks
from mossar_adapters.receiving.pose import Pose, check_time, differ
from mossar_adapters.receiving.recent import Recent
from mossar_adapters.receiving.sender_clocks import SenderClock, Verdict
from mossar_adapters.receiving.senders import MAX_SENDERS
from mossar_adapters.receiving.steady import Steady
from mossar_adapters.source import Departure, Meta
from mossar_stream import FrameError, Frames, Skeleton, narrow

MAX_PERFORMERS = 256  # known at a time
FARTHEST = 1e5  # m; a coordinate beyond this is damage, as in the core

_log = logging.getLogger("mossar.source")


class _Line(msgspec.Struct):
    """One performer's frames that wait to be taken."""

    meta: Meta | None = None
    sender: str | None = None  # whose clock its times are on: that of its first frame
    arrival: float | None = None  # of the latest frame, s
    count: int = 0  # frames so far, for times at a given rate
    steady: Steady = msgspec.field(default_factory=Steady)  # for times without one
    clock: SenderClock[Pose] | None = None  # for times with one
    positions: list[NDArray[np.float64] | NDArray[np.float32]] = msgspec.field(default_factory=list)
    confidence: list[NDArray[np.float64] | NDArray[np.float32]] = msgspec.field(default_factory=list)
    times: list[float] = msgspec.field(default_factory=list)


class Batch:
    """Collects arrivals since the reader's last look, and hands them out in order for each performer.

    Args:
        fps: Rate in Hz: frames without a time of their own get frame number / fps instead of their arrival, steadied.
            So do those of a sender whose clock does not run.
        counters: They count frames that get another time than the sender's.
        note: Receives notes on a sender's clock, a line each; without it, they are logged.
        piped: Whether times of arrival may be meaningless, as those of a file that is read through a pipe.
    """

    def __init__(
        self,
        fps: float | None = None,
        counters: Counters | None = None,
        note: Callable[[str], None] | None = None,
        *,
        piped: bool = False,
    ) -> None:
        self.fps = fps
        self._counters = counters or Counters()
        self._note = note or _logged
        self._piped = piped
        self._lines: Recent[_Line] = Recent(MAX_PERFORMERS, "performers")
        self._ready: list[Meta | Frames | Departure] = []
        self._clocks = Clocks()
        self._verdicts: Newest[str, Verdict] = Newest(MAX_SENDERS)  # on the clock of each sender
        self._described: dict[int, Meta] = {}  # the latest meta that a sender gave, by its number of joints
        self._now = float("-inf")  # the latest arrival, s

    @property
    def pending(self) -> bool:
        """Whether frames are held back until it is clear whether their sender's clock runs."""
        return any(line.clock is not None and line.clock.holds for line in self._lines.values())

    def put(self, item: Meta | Pose | Departure) -> None:
        """Take one thing that a decoder found.

        A meta that is the same as before, and the departure of an unknown performer, change nothing. A performer
        without a meta has the skeleton that was described last for another one with as many joints.

        Raises:
            FrameError: If a pose does not fit the performer's skeleton, its time is none, or the performer is new
                and there is no room for it.
        """
        if isinstance(item, Pose):
            self._add(item)
        elif isinstance(item, Meta):
            self._announce(item)
        else:
            self._leave(item)

    def take(self, now: float | None = None) -> list[Meta | Frames | Departure]:
        """Return everything collected since the last call.

        Args:
            now: s, on the clock of the arrivals: frames held back after which nothing came go on, too; infinity for all.
        """
        for performer, line in self._lines.items():
            if now is not None:
                self._settle(line, now)
            if line.times:
                self._finish(performer, line)
        ready, self._ready = self._ready, []
        return ready

    def came(self, performer: str) -> float | None:
        """Return the arrival of a performer's latest frame, s on the clock of arrivals; None if there is none."""
        line = self._lines.get(performer)
        return None if line is None else line.arrival

    def forget(self, sender: str) -> None:
        """Forget the clock of a sender that is gone for good."""
        self._clocks.forget(sender)
        self._verdicts.pop(sender, None)

    def _assumed(self, pose: Pose) -> Meta:
        """Return the assumed meta of a performer whose skeleton was not described."""
        other = self._described.get(len(pose.positions))
        if other is not None:
            return msgspec.structs.replace(other, performer=pose.performer)
        return Meta(pose.performer, _unnamed(len(pose.positions)), self.fps, assumed=True)

    def _announce(self, meta: Meta) -> None:
        if not meta.assumed:
            self._described[len(meta.skeleton)] = meta
        line = self._line(meta.performer)
        if line.meta != meta:
            self._settle(line)
            self._finish(meta.performer, line)
            self._ready.append(meta)
        line.meta = meta

    def _leave(self, left: Departure) -> None:
        line = self._lines.get(left.performer)
        if line is not None:
            self._settle(line)
            self._finish(left.performer, line)
            line.sender = line.clock = None  # the next one with this name has a clock of its own
            self._ready.append(left)

    def _add(self, pose: Pose) -> None:
        check_time(pose.time)
        self._now = max(self._now, pose.arrival)
        line = self._line(pose.performer)
        line.arrival = pose.arrival
        meta = line.meta
        if pose.skeleton is not None and (meta is None or meta.skeleton is not pose.skeleton):
            self._announce(Meta(pose.performer, pose.skeleton, self.fps, pose.unit))
        elif meta is None:
            self._announce(self._assumed(pose))
        elif len(pose.positions) != len(meta.skeleton):
            raise FrameError(
                f"a frame with {len(pose.positions)} joints does not fit the skeleton: it has {len(meta.skeleton)}"
            )
        line.count += 1
        if line.sender is None:
            # A program may send each message from another port: its performer stays on one clock.
            line.sender = pose.sender
        if pose.time is None and (line.clock is None or line.clock.verdict.ahead is None):
            self._settle(line)
            if self.fps is not None:
                self._append(line, pose, (line.count - 1) / self.fps)
            else:
                if line.count == 1:
                    line.steady = self._steady_of(pose)
                self._append(line, pose, self._shared(line, pose, line.steady.time(pose.arrival)))
        else:
            line.clock = line.clock or self._clock(line.sender)
            self._append_timed(line, line.clock, line.clock.put(pose, pose.time or 0.0, pose.arrival))

    def _steady_of(self, pose: Pose) -> Steady:
        """Return the line for the times of a new performer: that of another one of the same sender, else a new one.

        Trackers give new ids to people that they lose: the times of a person go on as if the id were the same.
        """
        for other in self._lines.values():
            if other.count > 1 and other.sender == pose.sender and other.steady.follows(pose.arrival):
                return other.steady.copy()
        return Steady()

    def _append_timed(self, line: _Line, clock: SenderClock[Pose], timed: list[tuple[Pose, float]]) -> None:
        """Add frames with their times by their sender's clock, or in its place, s."""
        for pose, time in timed:
            self._append(line, pose, self._shared(line, pose, time))
        self._counters.retimed += clock.changed
        clock.changed = 0

    def _append(self, line: _Line, pose: Pose, time: float) -> None:
        if line.times and (pose.confidence is None) != (not line.confidence):
            self._finish(pose.performer, line)
        line.times.append(time)
        line.positions.append(pose.positions)
        if pose.confidence is not None:
            line.confidence.append(pose.confidence)

    def _shared(self, line: _Line, pose: Pose, time: float) -> float:
        """Return a time on the clock that all senders share, s."""
        return self._clocks.time(line.sender or "", time, pose.arrival)

    def _clock(self, sender: str) -> SenderClock[Pose]:
        verdict = self._verdicts.get(sender)
        if verdict is None:
            verdict = self._verdicts[sender] = Verdict()
        return SenderClock(verdict, _differ, self._note, rate=self.fps, piped=self._piped)

    def _settle(self, line: _Line, now: float = float("inf")) -> None:
        """Let frames go that are held back, if nothing more came until `now`, s."""
        if line.clock is not None and line.clock.holds:
            self._append_timed(line, line.clock, line.clock.settle(now))

    def _line(self, performer: str) -> _Line:
        line = self._lines.hear(performer, self._now)
        if line is not None:
            return line
        forgotten = self._lines.make_room(performer, self._now)
        if forgotten is not None:
            self._settle(forgotten[1])
            self._finish(*forgotten)
        return self._lines.add(performer, _Line(), self._now)

    def _finish(self, performer: str, line: _Line) -> None:
        if not line.times:
            return
        confidence = None
        if line.confidence:
            confidence = np.clip(np.nan_to_num(np.array(line.confidence)), 0.0, 1.0).astype(np.float32)
        self._ready.append(Frames(_sane(line.positions), np.array(line.times), confidence, performer))
        line.positions, line.confidence, line.times = [], [], []


def _logged(note: str) -> None:
    _log.warning("%s", note)


def _differ(one: Pose, other: Pose) -> bool:
    return differ(one.positions, other.positions)


def _sane(poses: list[NDArray[np.float64] | NDArray[np.float32]]) -> NDArray[Any]:
    """Return poses as (n, J, 3), without damaged coordinates."""
    positions: NDArray[Any] = np.array(poses)
    if not float(np.abs(positions).max()) < FARTHEST:  # most frames are whole: one look is enough
        with np.errstate(invalid="ignore"):
            positions[~(np.abs(positions) < FARTHEST).all(axis=2)] = np.nan
    return narrow(positions)


def _unnamed(joints: int) -> Skeleton:
    """Return a skeleton for a sender that never described it."""
    return by_count(joints) or Skeleton(tuple(f"joint{i}" for i in range(joints)), root=-1)
