"""Timing: where repetitions begin and end, and how long they take, from the cycles that are counted."""

from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np

from mossar_stream.repetitions.state import RATE

# Between cycles, whose median is the period: one that was missed does not count, and four, for where samples fall makes
# those of fast movements longer and shorter in turn.
INTERVALS = 4


class Cycle(NamedTuple):
    """A `CYCLE` record; see there."""

    start: int
    far: int
    end: int
    out: float
    back: float
    amplitude: float
    number: int  # in its bout
    joint: int
    straighter: float
    resting: float
    turned: int

    @property
    def middle(self) -> float:
        """Where it is in the middle between passing half way out and half way back, samples from the take's start."""
        return (self.out + self.back + 1) / 2


class Timeline:
    """Some of the cycles that are remembered, and their neighbours.

    Args:
        cycles: (n,) `CYCLE` records, from the one before the first that is asked for on, as far as there are any.
        first: Place of the first one.
    """

    def __init__(self, cycles: np.ndarray, first: int = 0) -> None:
        self._cycles = [Cycle._make(cycle) for cycle in cycles.tolist()]
        self._first = first

    @classmethod
    def since(cls, cycles: np.ndarray, place: int) -> Self:
        """Return what is needed to know of the cycles from one on.

        Args:
            cycles: (n,) `CYCLE` records, all that are remembered.
            place: Of the first cycle that is asked for.
        """
        first = max(place - INTERVALS - 1, 0)
        return cls(cycles[first:], first)

    def __getitem__(self, place: int) -> Cycle:
        return self._cycles[place - self._first]

    def period(self, place: int) -> float | None:
        """Return the duration of a cycle, s, the median of the last ones of its bout; None for the first.

        While there are too few before it, those after it count, too.
        """
        begin = end = place
        begin -= min(self[place].number - 1, INTERVALS, place)
        if begin == end:
            return None
        beyond = min(begin + INTERVALS, self._first + len(self._cycles) - 1)
        while end < beyond and self[end + 1].number > 1:
            end += 1
        places = [
            cycle.out + cycle.back for cycle in self._cycles[begin - self._first : end + 1 - self._first]
        ]
        passed = sorted([after - before for before, after in pairwise(places)])
        median = (passed[(len(passed) - 1) // 2] + passed[len(passed) // 2]) / 2
        return max(median / 2 / RATE, 1 / RATE)

    def begin_of(self, place: int) -> float:
        """Return where a repetition begins, samples; in a bout between passing half way back and half way out again."""
        cycle = self[place]
        before = self[place - 1] if place > 0 else None
        follows = before is not None and cycle.number > 1 and before.turned == cycle.turned
        if before is not None and follows:
            return before.middle if cycle.turned else (before.back + cycle.out + 1) / 2
        begin = 2 * cycle.start - cycle.far if cycle.turned else max(cycle.start, 2 * cycle.out - cycle.far)
        return max(begin, 0 if before is None else self._own_end(before)) + 0.5

    def end_of(self, place: int) -> float:
        """Return where a repetition ends, samples."""
        cycle, next_place = self[place], place + 1
        if not cycle.turned and next_place < self._first + len(self._cycles):
            after = self[next_place]
            if after.number > 1 and not after.turned:
                return self.begin_of(next_place)
        return self._own_end(cycle) + 0.5

    @staticmethod
    def _own_end(cycle: Cycle) -> float:
        """Return where a repetition ends that nothing follows, half a sample early."""
        # Where it rests the extreme is anywhere: movements end as long after half way as they began before it.
        return cycle.middle - 0.5 if cycle.turned else min(cycle.end, 2 * cycle.back - cycle.far)
