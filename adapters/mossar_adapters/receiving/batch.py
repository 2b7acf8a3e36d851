"""Single frames of many performers, collected into metas and chunks."""

from collections import OrderedDict

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.receiving.steady import Steady
from mossar_adapters.source import Left, Meta
from mossar_stream.errors import FrameError
from mossar_stream.frames import Frames
from mossar_stream.skeleton import Skeleton

MAX_PERFORMERS = 256  # known at a time; the one unheard for longest is forgotten
FARTHEST = 1e6  # m; whatever is farther away is damage, and would overflow sums of squares in float32


class _Line(msgspec.Struct):
    """One performer's frames that wait to be taken."""

    meta: Meta | None = None
    count: int = 0  # frames so far, for times at a given rate
    steady: Steady = msgspec.field(default_factory=Steady)  # for times without one
    positions: list[NDArray[np.float32]] = msgspec.field(default_factory=list)
    confidence: list[NDArray[np.float32]] = msgspec.field(default_factory=list)
    times: list[float] = msgspec.field(default_factory=list)


class Batch:
    """Collects what arrived since the reader last looked, and hands it out in order for each performer.

    Args:
        fps: Rate in Hz: frames without a time of their own get frame number / fps instead of their arrival, steadied.
    """

    def __init__(self, fps: float | None = None) -> None:
        self.fps = fps
        self._lines: OrderedDict[str, _Line] = OrderedDict()
        self._ready: list[Meta | Frames | Left] = []

    def announce(self, meta: Meta) -> None:
        """Take note of a performer; nothing happens if it is the same as before."""
        line = self._line(meta.performer)
        if line.meta == meta:
            return
        self._finish(meta.performer, line)
        line.meta = meta
        self._ready.append(meta)

    def skeleton(self, performer: str) -> Skeleton | None:
        """Return the skeleton announced for a performer."""
        line = self._lines.get(performer)
        return None if line is None or line.meta is None else line.meta.skeleton

    def add(
        self,
        performer: str,
        positions: NDArray[np.float32],
        *,
        arrival: float,
        time: float | None = None,
        confidence: NDArray[np.float32] | None = None,
    ) -> None:
        """Add one frame of an announced performer.

        Args:
            performer: Name.
            positions: (J, 3) float32, metres.
            arrival: When it came, s.
            time: The sender's time, s.
            confidence: (J,) or None.

        Raises:
            FrameError: If it does not fit the performer's skeleton, or the time is none.
        """
        line = self._line(performer)
        if line.meta is None or len(positions) != len(line.meta.skeleton):
            expected = "none was announced" if line.meta is None else f"it has {len(line.meta.skeleton)}"
            raise FrameError(f"a frame with {len(positions)} joints does not fit the skeleton: {expected}")
        if time is not None and not abs(time) < 1e15:
            raise FrameError(f"t = {time} is no time")
        if line.times and (confidence is None) != (not line.confidence):
            self._finish(performer, line)
        if time is None:
            time = line.steady.time(arrival) if self.fps is None else line.count / self.fps
        line.count += 1
        line.times.append(time)
        line.positions.append(positions)
        if confidence is not None:
            line.confidence.append(confidence)

    def leave(self, performer: str, reason: str) -> None:
        """Note that a performer has left; nothing happens if it was never announced.

        Args:
            performer: Name.
            reason: What the sender says.
        """
        line = self._lines.get(performer)
        if line is not None:
            self._finish(performer, line)
            self._ready.append(Left(performer, reason))

    def take(self) -> list[Meta | Frames | Left]:
        """Return everything collected since the last call."""
        for performer, line in self._lines.items():
            if line.times:
                self._finish(performer, line)
        ready, self._ready = self._ready, []
        return ready

    def _line(self, performer: str) -> _Line:
        line = self._lines.get(performer)
        if line is None:
            line = self._lines[performer] = _Line()
            if len(self._lines) > MAX_PERFORMERS:
                self._finish(*self._lines.popitem(last=False))
        else:
            self._lines.move_to_end(performer)
        return line

    def _finish(self, performer: str, line: _Line) -> None:
        if not line.times:
            return
        positions = np.array(line.positions)
        if not float(np.abs(positions).max()) < FARTHEST:  # most frames are whole: one look is enough
            with np.errstate(invalid="ignore"):
                positions[~(np.abs(positions) < FARTHEST).all(axis=2)] = np.nan
        confidence = np.array(line.confidence) if line.confidence else None
        self._ready.append(Frames(positions, np.array(line.times), confidence, performer))
        line.positions, line.confidence, line.times = [], [], []
