"""Turning points of one component, with hysteresis: what moves back by less than a share of the range is no turn."""

import numpy as np

from mossar_stream.jit.decorators import kernel
from mossar_stream.repetitions.state import BINS, SAMPLES

HYSTERESIS = 0.37  # of the range from the 10th to the 90th percentile
SWING_REACHED = 0.7  # of the last swing, after which the extreme that is being made counts as reached


@kernel
def swing_range(scores, n, counts):
    """Return the range from the 10th to the 90th percentile, from a histogram; 0 if a number is infinite.

    What is no number is left out: snapshots from outside may hold it, and a histogram has no place for it.

    Args:
        scores: (n,) float32.
        n: Samples.
        counts: (BINS,), out.
    """
    low = high = scores[0]
    for i in range(n):
        low = min(low, scores[i])
        high = max(high, scores[i])
    if not 0.0 < high - low < np.inf:
        return np.float32(0.0)
    counts[:] = 0
    width = (high - low) / np.float32(BINS)
    for i in range(n):
        place = (scores[i] - low) / width
        if not np.isnan(place):
            counts[min(int(place), BINS - 1)] += 1
    below, passed = 0, counts[0]
    while passed <= 0.1 * n and below < BINS - 1:
        below += 1
        passed += counts[below]
    above, passed = 0, counts[BINS - 1]
    while passed <= 0.1 * n and above < BINS - 1:
        above += 1
        passed += counts[BINS - 1 - above]
    return width * np.float32(max(BINS - above - below - 1, 0))


@kernel
def turning_points(scores, n, least, turns):
    """Find where a component turns back by more than `least`.

    Args:
        scores: (n,) float32.
        n: Samples.
        least: Hysteresis, in the unit of the scores.
        turns: (2, SAMPLES), out: sample and direction (1 a maximum, -1 a minimum).

    Returns:
        How many there are.
    """
    found, direction, low, high = 0, 0, 0, 0
    lowest = highest = scores[0]
    for i in range(n):
        score = scores[i]
        if score > highest:
            high, highest = i, score
        if score < lowest:
            low, lowest = i, score
        if direction >= 0 and highest - score > least:
            turns[0, found], turns[1, found] = high, 1
            found, direction, low, lowest = found + 1, -1, i, score
        elif direction <= 0 and score - lowest > least:
            turns[0, found], turns[1, found] = low, -1
            found, direction, high, highest = found + 1, 1, i, score
    return _with_the_last(scores, turns, found, high if direction > 0 else low)


@kernel
def _with_the_last(scores, turns, found, latest):
    """Add the extreme that is being made if it is nearly as far as the swing before."""
    if found < 2 or found >= SAMPLES:
        return found
    last, before = turns[0, found - 1], turns[0, found - 2]
    if abs(scores[latest] - scores[last]) <= SWING_REACHED * abs(scores[last] - scores[before]):
        return found
    turns[0, found], turns[1, found] = latest, -turns[1, found - 1]
    return found + 1
