"""Stream time: the time for which a performer was seen, and whether it has reached the wanted end."""

import bisect
import math

from mossar_adapters.replay.interleaving import part
from mossar_stream import Frames

_LONGEST = 3600.0  # s from one frame to the next; more is a clock that was set


class StreamTime:
    """The time of one performer, on its source's clock.

    Example:
        >>> import numpy as np
        >>> time = StreamTime()
        >>> frames = Frames(np.zeros((3, 1, 3), np.float32), np.array([5.0, 5.5, 6.0]))
        >>> len(time.within(frames, seconds=1.0)), time.is_over
        (2, True)
    """

    def __init__(self) -> None:
        self.last: float | None = None  # time of the last frame, s; None before the first
        self.length = 0.0  # time that passed, without jumps of the clock, s; less than the wanted time
        self.is_over = False  # whether the end is reached
        # Whether the performer has left, or its frames have stopped: its end is not awaited.
        self.is_absent = False
        self._latest = 0.0  # latest time since the clock was last set back, s

    def within(self, frames: Frames, seconds: float = math.inf, max_pause: float = math.inf) -> Frames:
        """Return those frames that come before the end.

        Time passes from the latest frame to a later one. It does not pass where a clock is set, back or far ahead, and
        where a frame comes out of order.

        Args:
            frames: Of the performer.
            seconds: How much of its time is wanted, s.
            max_pause: A clock is set back if the time falls by more than this, s.
        """
        times = frames.times.tolist()
        passed, latest = self.length, times[0] if self.last is None else self._latest
        self.is_absent, self.last = False, times[-1]
        lengths = []  # s, until each frame
        for time in times:
            if latest < time <= latest + _LONGEST:
                passed += time - latest
            if time > latest or latest - time > max_pause:
                latest = time
            lengths.append(passed)
        self._latest = latest
        if self.is_over:
            return part(frames, 0, 0)
        kept = len(lengths)
        if passed >= seconds:
            self.is_over = True
            kept = bisect.bisect_left(lengths, seconds)
        if kept:
            self.length = lengths[kept - 1]
        return frames if kept == len(lengths) else part(frames, 0, kept)
