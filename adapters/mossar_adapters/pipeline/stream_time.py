"""Stream time: from when to when each performer was seen, and whether all have reached the end that was asked for."""

import bisect
import math

from mossar_adapters.replay.interleaving import part
from mossar_stream import Frames

_LONGEST = 3600.0  # s from one frame to the next; what is more is a clock that was set


class StreamTime:
    """The time of each performer, on its source's clock.

    Args:
        seconds: How much of each performer's time is wanted; None for all.

    Example:
        >>> import numpy as np
        >>> time = StreamTime(seconds=1.0)
        >>> frames = Frames(np.zeros((3, 1, 3), np.float32), np.array([5.0, 5.5, 6.0]))
        >>> len(time.within(frames)), time.over()
        (2, True)
    """

    def __init__(self, seconds: float | None = None) -> None:
        self.spans: dict[str, tuple[float, float]] = {}  # first and last time of each performer, s
        self.lengths: dict[
            str, float
        ] = {}  # time that passed for each performer, whatever its clock did, s; less than `seconds`
        self._latest: dict[
            str, float
        ] = {}  # latest time of each performer since its clock was last set back, s
        self._seconds = seconds
        self._over: set[str] = set()  # performers who have reached the end
        self._absent: set[str] = set()  # performers who have left, or whose frames have stopped

    def within(self, frames: Frames, max_pause: float = math.inf) -> Frames:
        """Return those frames that come before the end of their performer's time.

        Time passes from the latest frame to a later one. It does not pass where a clock is set, back or far ahead, and
        where a frame comes out of order.

        Args:
            frames: Of one performer.
            max_pause: A clock is set back if the time falls by more than this, s.
        """
        name, times = frames.performer, frames.times
        first = float(times[0])
        self._absent.discard(name)
        self.spans[name] = (self.spans.get(name, (first, first))[0], float(times[-1]))
        passed, latest = self.lengths.get(name, 0.0), self._latest.get(name, first)
        lengths = []  # s, until each frame
        for time in times.tolist():
            if latest < time <= latest + _LONGEST:
                passed += time - latest
            if time > latest or latest - time > max_pause:
                latest = time
            lengths.append(passed)
        self._latest[name] = latest
        if name in self._over:
            return part(frames, 0, 0)
        kept = len(lengths)
        if self._seconds is not None and passed >= self._seconds:
            self._over.add(name)
            kept = bisect.bisect_left(lengths, self._seconds)
        if kept:
            self.lengths[name] = lengths[kept - 1]
        return frames if kept == len(lengths) else part(frames, 0, kept)

    def absent(self, name: str) -> None:
        """Take note that a performer has left, or that its frames have stopped: its end is not awaited."""
        self._absent.add(name)

    def over(self) -> bool:
        """Return whether every present performer has reached the end, and there is one."""
        if self._seconds is None:
            return False
        return bool(self._over) and self._over | self._absent >= self.spans.keys()

    def forget(self, kept: set[str]) -> None:
        """Forget all others."""
        for table in (self.spans, self.lengths, self._latest):
            for name in table.keys() - kept:
                del table[name]
        self._absent &= kept
        self._over &= kept
