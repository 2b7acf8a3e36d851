"""Odd times: every frame seems to begin a take, because its time is not in seconds."""

import numpy as np

from mossar_stream import Frames

_ENOUGH = 3  # takes of one frame in a row
_UNITS = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}
_RATES = (5.0, 250.0)  # Hz of senders of poses


class OddTimes:
    """Watches the steps from frame to frame of one performer.

    Example:
        >>> odd = OddTimes()
        >>> frames = Frames(np.zeros((5, 1, 3), np.float32), np.arange(5) * 33.3)
        >>> odd.finding(frames, 1.0)[:57], odd.finding(frames, 1.0)
        ('each frame is a take of its own: times step by 33.3 s; in', None)
    """

    def __init__(self) -> None:
        self._latest: float | None = None  # s, of the last frame
        self._alone = 0  # frames in a row that came more than a pause after the one before
        self._is_logged = False

    def finding(self, frames: Frames, max_pause: float) -> str | None:
        """Return, once, the fault of the times, None if they have none.

        Args:
            frames: Of the performer.
            max_pause: Longest step in time within a take, s.
        """
        latest, self._latest = self._latest, float(frames.times[-1])
        if self._is_logged:
            return None
        times = frames.times if latest is None else np.concatenate(([latest], frames.times))
        steps = np.diff(times)
        wide = steps > max_pause
        if not wide.any():
            self._alone = 0
            return None
        narrow = np.flatnonzero(~wide)
        self._alone = len(steps) - 1 - int(narrow[-1]) if len(narrow) else self._alone + len(steps)
        if self._alone < _ENOUGH:
            return None
        self._is_logged = True
        return _in_words(float(steps[-1]))


def _in_words(step: float) -> str:
    for unit, factor in _UNITS.items():
        if _RATES[0] <= factor / step <= _RATES[1]:
            hint = f"in {unit} that would be {factor / step:.3g} frames a second; send seconds"
            break
    else:
        hint = "times are in seconds, and a step beyond max_pause ends a take"
    return f"each frame is a take of its own: times step by {step:.4g} s; {hint}"
