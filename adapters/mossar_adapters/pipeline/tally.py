"""Tally: a performer's counts at earlier looks, so that the next look sees the difference."""

import math
from typing import NamedTuple

_JUST_NOW = 0.5  # s, in which too few frames come for a rate
_SHORTEST = 1e-9  # s that there must be for a rate; a clock of nonsense may have less


class _Mark(NamedTuple):
    """Counts at one look: frames, the time of the stream that passed (s), and the time of the look (monotonic s)."""

    frames: int
    length: float
    at: float


class Counts(NamedTuple):
    """Frames of a performer, those without a tracked joint, and those dropped because of their times."""

    frames: int = 0
    unseen: int = 0
    out_of_order: int = 0

    def since(self, before: "Counts") -> "Counts":
        """Return the difference from earlier counts."""
        return Counts(*(now - then for now, then in zip(self, before, strict=True)))


_FIRST = _Mark(1, 0.0, -math.inf)


class Tally:
    """Remembers the counts of one performer.

    Example:
        >>> tally = Tally()
        >>> tally.rate(frames=121, length=2.0, now=10.0), tally.rate(frames=151, length=2.5, now=11.0)
        (60.0, 60.0)
        >>> tally.since_last(Counts(100, 2)), tally.since_last(Counts(130, 32))
        (Counts(frames=100, unseen=2, out_of_order=0), Counts(frames=30, unseen=30, out_of_order=0))
    """

    def __init__(self) -> None:
        self.empty_is_logged = False  # that frames come without a tracked joint
        self.dropped_is_logged = False  # that most frames are dropped
        self._counts = Counts()
        self._last = self._before = _FIRST  # at the last stats, and at those before

    def since_last(self, counts: Counts) -> Counts:
        """Return the counts since the last call."""
        new, self._counts = counts.since(self._counts), counts
        return new

    def rate(self, frames: int, length: float, now: float) -> float:
        """Return the rate since the last stats, Hz, or since those before if the last ones were sent just now.

        Args:
            frames: Of the performer so far.
            length: How much time of its stream has passed, s.
            now: Monotonic s.
        """
        last = self._last
        if now - last.at < _JUST_NOW:
            last = self._before
        else:
            self._before, self._last = last, _Mark(frames, length, now)
        passed = length - last.length
        return (frames - last.frames) / passed if passed > _SHORTEST else 0.0
