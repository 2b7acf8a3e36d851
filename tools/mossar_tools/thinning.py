"""Thinning: a choice of marks, so that none covers another and the omitted ones are counted."""

import bisect
import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_stream import SegmentState
from mossar_tools.marks import Mark, Stretch

Floats = NDArray[np.float64]


def strongest_apart(keys: Sequence[Mark], gap: float, taken: Sequence[float] = ()) -> list[Mark]:
    """Return the strongest key frames that lie at least `gap` apart, in order of time.

    Args:
        keys: In any order.
        gap: s between two of them.
        taken: Times that they keep the same distance from, s, in ascending order.

    Example:
        >>> keys = [Mark("", time, i, "minimum", 0.1, 1 + i % 2, True) for i, time in enumerate((0.0, 0.1, 0.9))]
        >>> [key.time for key in strongest_apart(keys, 0.5)]
        [0.1, 0.9]
    """
    places = list(taken)
    chosen: list[Mark] = []
    for key in sorted(keys, key=lambda key: -(key.strength or 0.0)):
        at = bisect.bisect(places, key.time)
        near = places[max(0, at - 1) : at + 1]
        if all(abs(key.time - place) >= gap for place in near):
            places.insert(at, key.time)
            chosen.append(key)
    return sorted(chosen, key=lambda key: key.time)


def extremes(times: Floats, values: Floats, most: int) -> tuple[Floats, Floats, Floats]:
    """Return times, lowest and highest values of at most `most` stretches of a curve; the curve if it is short.

    Args:
        times: (n,) s.
        values: (n,), NaN where unknown.
        most: Stretches.
    """
    if len(times) <= most:
        return times, values, values
    edges = np.linspace(0, len(times), most + 1).astype(np.intp)[:-1]
    low = np.fmin.reduceat(values, edges)
    return times[edges], low, np.fmax.reduceat(values, edges)


def runs(parts: Sequence[Stretch], most: int) -> Sequence[Stretch]:
    """Return segments; if there are more than `most`, stretches with the state of the largest part of each.

    Args:
        parts: In ascending order; they do not overlap.
        most: Largest number of distinguishable segments.
    """
    if len(parts) <= most:
        return parts
    starts, ends = np.array([(part.start, part.end) for part in parts]).T
    # A mark a column: the moving share of it, from the sum of moving time up to its edges.
    edges = np.linspace(starts[0], ends[-1], 4 * most + 1)
    moving = np.array([part.state == "moving" for part in parts])
    spans = np.where(moving, ends - starts, 0.0)
    knots = np.stack([starts, ends], axis=1).ravel()
    totals = np.stack([np.cumsum(spans) - spans, np.cumsum(spans)], axis=1).ravel()
    share = np.diff(np.interp(edges, knots, totals)) / np.diff(edges)
    kinds: list[SegmentState] = ["moving" if part > 0.5 else "resting" for part in share]
    firsts = [0, *(i for i in range(1, len(kinds)) if kinds[i] != kinds[i - 1]), len(kinds)]
    return [Stretch(float(edges[a]), float(edges[b]), kinds[a]) for a, b in itertools.pairwise(firsts)]
