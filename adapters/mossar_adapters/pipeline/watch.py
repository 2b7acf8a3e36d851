"""Watch: notices on the wall clock that frames have stopped, and that they are back."""

import math
from typing import Literal

STALL = 0.3  # s without frames

Finding = Literal["stalled", "ended"]


class Watch:
    """Keeps the time of the last frames of a performer of a live source.

    Example:
        >>> watch = Watch()
        >>> watch.heard(now=0.0), watch.check(0.2, 1.0), watch.check(0.4, 1.0), watch.check(0.5, 1.0)
        (False, [], ['stalled'], [])
        >>> watch.check(1.1, 1.0), watch.heard(now=2.0)
        (['ended'], True)
    """

    def __init__(self) -> None:
        self._at = math.inf  # monotonic s of the last frames; infinite while nothing is watched
        self._stalled = False
        self._ended = False

    def heard(self, now: float, came: float | None = None) -> bool:
        """Note frames; return whether they had stalled.

        Frames that arrived before the stall, and waited to be completed, change nothing.

        Args:
            now: Monotonic s.
            came: When they arrived, monotonic s; None: now.
        """
        if self._stalled and came is not None and came - self._at <= STALL:
            return False
        resumed = self._stalled
        self._at, self._stalled, self._ended = now, False, False
        return resumed

    def leave(self) -> None:
        """Stop watching: the performer has left, or the source has ended."""
        self._at, self._stalled, self._ended = math.inf, False, False

    def check(self, until: float, max_pause: float) -> list[Finding]:
        """Return the findings since the last call: that frames stopped, and that the take is over.

        Args:
            until: Time up to which the source has been read, monotonic s: frames in a queue have come in time.
            max_pause: Time without frames after which the take ends, s.
        """
        found: list[Finding] = []
        quiet = until - self._at
        if quiet > STALL and not self._stalled:
            self._stalled = True
            found.append("stalled")
        if self._stalled and not self._ended and quiet > max_pause:
            self._ended = True
            found.append("ended")
        return found
