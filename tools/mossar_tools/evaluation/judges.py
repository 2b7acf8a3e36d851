"""Judges: one ground truth from the cuts that several people set (paper 4.1, Fig. 10).

The density is a sum of Gaussian kernels over all cuts, as a share of the judges: it is 1 where all judges set a cut at
the same moment. The truth lies at its maxima; maxima below a floor are ignored.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_tools.evaluation.matching import Cut

BANDWIDTH = 0.25  # s, standard deviation of the kernel; ours, the paper names none
DENSITY_FLOOR = 0.3  # share of the judges; ours
STEPS = 20  # of the density per bandwidth
REACH = 8  # bandwidths beyond which the kernel is zero


def truth_from_judges(
    judgements: Sequence[Sequence[float]], bandwidth: float = BANDWIDTH, floor: float = DENSITY_FLOOR
) -> list[Cut]:
    """Return the cuts on which the judges agree.

    Each judgement belongs to the maximum between the same two minima of the density. A cut reaches from the earliest to
    the latest of its judgements.

    Args:
        judgements: Cuts of each judge, s.
        bandwidth: Standard deviation of the kernel, s.
        floor: Density below which a maximum is ignored, as a share of the judges.
    """
    everything = np.sort(np.concatenate([np.asarray(one, np.float64) for one in (*judgements, [])]))
    if not len(everything):
        return []
    grid = np.arange(everything[0] - bandwidth, everything[-1] + 2 * bandwidth, bandwidth / STEPS)
    return _at_maxima(grid, density(grid, everything, bandwidth) / len(judgements), everything, floor)


def density(at: NDArray[np.float64], cuts: NDArray[np.float64], bandwidth: float) -> NDArray[np.float64]:
    """Return the sum of Gaussians of height 1 around `cuts` (s) at the times `at` (s, increasing)."""
    total = np.zeros(len(at))
    for cut in cuts:
        near = slice(*np.searchsorted(at, (cut - REACH * bandwidth, cut + REACH * bandwidth)))
        total[near] += np.exp(-0.5 * ((at[near] - cut) / bandwidth) ** 2)
    return total


def _at_maxima(
    grid: NDArray[np.float64], curve: NDArray[np.float64], judgements: NDArray[np.float64], floor: float
) -> list[Cut]:
    """Return the cuts at the maxima of a density that reach the floor."""
    rising = np.diff(curve) > 0
    peaks = np.flatnonzero(rising[:-1] & ~rising[1:]) + 1
    valleys = np.flatnonzero(~rising[:-1] & rising[1:]) + 1
    borders = [-np.inf, *grid[valleys], np.inf]
    cuts = []
    for peak, low, high in zip(peaks, borders[:-1], borders[1:], strict=True):
        own = judgements[(judgements >= low) & (judgements < high)]
        if curve[peak] >= floor and len(own):
            middle = _top(grid, curve, int(peak))
            cuts.append(Cut(min(float(own[0]), middle), middle, max(float(own[-1]), middle)))
    return cuts


def _top(grid: NDArray[np.float64], curve: NDArray[np.float64], peak: int) -> float:
    """Return the place of the maximum of the parabola through a peak and its neighbours."""
    before, here, after = curve[peak - 1 : peak + 2]
    bend = before - 2 * here + after
    shift = 0.5 * (before - after) / bend if bend < 0 else 0.0
    return float(grid[peak] + shift * (grid[1] - grid[0]))
