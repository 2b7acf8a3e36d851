"""Batching: poses of many performers, announced, timed and put together into chunks.

The last step from a wire to the pipeline, and the same for all wires. Here it is decided which skeleton a performer
has, which time a frame gets, and what goes on together.
"""

from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.joint_sets import by_count
from mossar_adapters.receiving.clocks import Clocks
from mossar_adapters.receiving.pose import Pose, check_time
from mossar_adapters.receiving.recent import Recent
from mossar_adapters.receiving.steady import Steady
from mossar_adapters.source import Departure, Meta
from mossar_stream import FrameError, Frames, Skeleton, narrow

MAX_PERFORMERS = 256  # known at a time
FARTHEST = 1e5  # m; whatever is farther away is damage: as for the core


class _Line(msgspec.Struct):
    """One performer's frames that wait to be taken."""

    meta: Meta | None = None
    sender: str | None = None  # whose clock its times are on: that of its first frame
    count: int = 0  # frames so far, for times at a given rate
    steady: Steady = msgspec.field(default_factory=Steady)  # for times without one
    positions: list[NDArray[np.float64] | NDArray[np.float32]] = msgspec.field(default_factory=list)
    confidence: list[NDArray[np.float64] | NDArray[np.float32]] = msgspec.field(default_factory=list)
    times: list[float] = msgspec.field(default_factory=list)


class Batch:
    """Collects what arrived since the reader last looked, and hands it out in order for each performer.

    Args:
        fps: Rate in Hz: frames without a time of their own get frame number / fps instead of their arrival, steadied.
    """

    def __init__(self, fps: float | None = None) -> None:
        self.fps = fps
        self._lines: Recent[_Line] = Recent(MAX_PERFORMERS, "performers")
        self._ready: list[Meta | Frames | Departure] = []
        self._clocks = Clocks()
        self._described: dict[int, Meta] = {}  # the latest meta that a sender gave, by its number of joints
        self._now = float("-inf")  # the latest arrival, s

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

    def take(self) -> list[Meta | Frames | Departure]:
        """Return everything collected since the last call."""
        for performer, line in self._lines.items():
            if line.times:
                self._finish(performer, line)
        ready, self._ready = self._ready, []
        return ready

    def forget(self, sender: str) -> None:
        """Forget the clock of a sender that is gone for good."""
        self._clocks.forget(sender)

    def _assumed(self, pose: Pose) -> Meta:
        """Return what is taken for granted of a performer whose skeleton was not described."""
        other = self._described.get(len(pose.positions))
        if other is not None:
            return msgspec.structs.replace(other, performer=pose.performer)
        return Meta(pose.performer, _unnamed(len(pose.positions)), self.fps, assumed=True)

    def _announce(self, meta: Meta) -> None:
        if not meta.assumed:
            self._described[len(meta.skeleton)] = meta
        line = self._line(meta.performer)
        if line.meta != meta:
            self._finish(meta.performer, line)
            self._ready.append(meta)
        line.meta = meta

    def _leave(self, left: Departure) -> None:
        line = self._lines.get(left.performer)
        if line is not None:
            self._finish(left.performer, line)
            line.sender = None  # the next one with this name has a clock of its own
            self._ready.append(left)

    def _add(self, pose: Pose) -> None:
        check_time(pose.time)
        self._now = max(self._now, pose.arrival)
        line = self._line(pose.performer)
        meta = line.meta
        if pose.skeleton is not None and (meta is None or meta.skeleton is not pose.skeleton):
            self._announce(Meta(pose.performer, pose.skeleton, self.fps, pose.unit))
        elif meta is None:
            self._announce(self._assumed(pose))
        elif len(pose.positions) != len(meta.skeleton):
            raise FrameError(
                f"a frame with {len(pose.positions)} joints does not fit the skeleton: it has {len(meta.skeleton)}"
            )
        if line.times and (pose.confidence is None) != (not line.confidence):
            self._finish(pose.performer, line)
        line.times.append(self._time(line, pose))
        line.positions.append(pose.positions)
        if pose.confidence is not None:
            line.confidence.append(pose.confidence)

    def _time(self, line: _Line, pose: Pose) -> float:
        line.count += 1
        time = pose.time
        if time is None:
            if self.fps is not None:
                return (line.count - 1) / self.fps
            time = line.steady.time(pose.arrival)
        if line.sender is None:
            # A program may send each message from another port: its performer stays on one clock.
            line.sender = pose.sender
        return self._clocks.time(line.sender, time, pose.arrival)

    def _line(self, performer: str) -> _Line:
        line = self._lines.hear(performer, self._now)
        if line is not None:
            return line
        forgotten = self._lines.make_room(performer, self._now)
        if forgotten is not None:
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


def _sane(poses: list[NDArray[np.float64] | NDArray[np.float32]]) -> NDArray[Any]:
    """Return poses as (n, J, 3), without what is damage."""
    positions: NDArray[Any] = np.array(poses)
    if not float(np.abs(positions).max()) < FARTHEST:  # most frames are whole: one look is enough
        with np.errstate(invalid="ignore"):
            positions[~(np.abs(positions) < FARTHEST).all(axis=2)] = np.nan
    return narrow(positions)


def _unnamed(joints: int) -> Skeleton:
    """Return a skeleton for a sender that never described it."""
    return by_count(joints) or Skeleton(tuple(f"joint{i}" for i in range(joints)), root=-1)
