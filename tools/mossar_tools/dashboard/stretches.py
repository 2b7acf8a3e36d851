"""Stretches: the segments between kept key frames, coloured by the state of most of their frames."""

import itertools

import numpy as np
from numpy.typing import NDArray

from mossar_tools.marks import Stretch


def stretches_between(
    cuts: list[float], times: NDArray[np.float64], moving: NDArray[np.bool_]
) -> list[Stretch]:
    """Return the segments that cuts make of the time seen.

    Args:
        cuts: Times of the kept key frames, s, in order.
        times: (n,) s, of samples of the curve, in order.
        moving: (n,) whether each is in a moving period.

    Example:
        >>> [s.state for s in stretches_between([1.0], np.array([0.0, 0.5, 1.5, 2.0]), np.array([0, 0, 1, 1], bool))]
        ['resting', 'moving']
    """
    if not len(times):
        return []
    edges = [float(times[0]), *(c for c in cuts if times[0] < c < times[-1]), float(times[-1])]
    places = np.searchsorted(times, edges)
    places[-1] = len(times)
    total = np.concatenate([[0], np.cumsum(moving)])
    return [
        Stretch(edges[i], edges[i + 1], "moving" if 2 * (total[b] - total[a]) > b - a else "resting")
        for i, (a, b) in enumerate(itertools.pairwise(places))
        if edges[i + 1] > edges[i]
    ]
