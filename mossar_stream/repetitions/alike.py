"""Cycles between turning points, and which of them are alike.

A cycle goes from one extreme to the other and back. Its description is the posture at the three extremes and where it
passes a quarter, half and three quarters of the way, out and back: pauses and pace do not matter. Cycles count in runs
of neighbours whose descriptions agree; the agreement of all pairs of a run must add up to enough.
"""

import numpy as np

from mossar_stream.jit.decorators import kernel
from mossar_stream.repetitions.state import COMPONENTS

POSTURES = 9
LONGEST_RATIO = 2.5  # of the durations of neighbours
LEAST_AMPLITUDE_RATIO = 0.4
LEAST_AGREEMENT = 0.3  # of two neighbours
ENOUGH = 0.6  # of a run's pairs together
STRONG = 0.9  # one such pair makes clear that this is a repeated movement,
MUCH = 1.8  # or as much of a run's pairs together


@kernel
def cycles_between(turns, found, direction, first, cycles):
    """Write the cycles that begin and end at extremes of one direction.

    Args:
        turns: See `turning_points`.
        found: How many there are.
        direction: 1 to begin at maxima, -1 at minima.
        first: Whether the window's first sample is the take's: otherwise an extreme there is only where it was cut.
        cycles: (3, SAMPLES) int64, out: start, far extreme, end.

    Returns:
        How many there are.
    """
    at = 0
    if found > 0 and not first and turns[0, 0] == 0:
        at = 1
    if at < found and turns[1, at] != direction:
        at += 1
    count = 0
    while at + 2 < found:
        for k in range(3):
            cycles[k, count] = turns[0, at + k]
        count += 1
        at += 2
    return count


@kernel
def crossing(scores, start, end, share):
    """Return where a component passes a share of the way between two samples, between samples."""
    goal = scores[start] + np.float32(share) * (scores[end] - scores[start])
    sign = np.float32(1.0) if scores[end] > scores[start] else np.float32(-1.0)
    step = 1 if end > start else -1
    i = start
    while i != end and (scores[i + step] - goal) * sign < 0:
        i += step
    if i == end:
        return float(end)
    return i + step * float((goal - scores[i]) / (scores[i + step] - scores[i]))


@kernel
def describe(samples, component, cycle, out):
    """Write the postures by which a cycle is compared.

    Args:
        samples: `Samples`.
        component: The one whose turning points these are.
        cycle: (3,) start, far extreme, end.
        out: (POSTURES, COMPONENTS) float32.
    """
    scores = samples.scores[component]
    start, far, end = cycle[0], cycle[1], cycle[2]
    for k in range(COMPONENTS):
        row = samples.scores[k]
        out[0, k], out[1, k], out[2, k] = row[start], row[far], row[end]
    for q in range(3):
        share = 0.25 * (q + 1)
        there = crossing(scores, start, far, share)
        back = crossing(scores, end, far, share)
        for k in range(COMPONENTS):
            out[3 + 2 * q, k] = _between(samples.scores[k], there)
            out[4 + 2 * q, k] = _between(samples.scores[k], back)


@kernel
def _between(row, place):
    i = int(place)
    rest = np.float32(place - i)
    return row[i] if rest == 0 else row[i] * (1 - rest) + row[i + 1] * rest


@kernel
def agreement(one, other):
    """Return how alike two descriptions are: 1 the same, 0 no more than by chance."""
    apart, spread = np.float32(0.0), np.float32(1e-9)
    for k in range(COMPONENTS):
        mean = np.float32(0.0)
        for i in range(POSTURES):
            mean += one[i, k] + other[i, k]
        mean /= np.float32(2 * POSTURES)
        for i in range(POSTURES):
            apart += (one[i, k] - other[i, k]) ** 2
            spread += (one[i, k] - mean) ** 2 + (other[i, k] - mean) ** 2
    return 1.0 - float(apart / spread)


@kernel
def _pair(scores, cycles, i):
    """Return whether durations and amplitudes of a cycle and the next are near enough."""
    one = cycles[2, i] - cycles[0, i]
    other = cycles[2, i + 1] - cycles[0, i + 1]
    if max(one, other) > LONGEST_RATIO * min(one, other):
        return False
    a = abs(scores[cycles[1, i]] - 0.5 * (scores[cycles[0, i]] + scores[cycles[2, i]]))
    b = abs(scores[cycles[1, i + 1]] - 0.5 * (scores[cycles[0, i + 1]] + scores[cycles[2, i + 1]]))
    return min(a, b) >= LEAST_AMPLITUDE_RATIO * max(a, b)


@kernel
def keep_alike(samples, component, cycles, count):
    """Keep the cycles of runs that agree enough.

    Returns:
        How many are left, the samples that they cover, weighted by their agreement, and whether it is clear that
        a movement repeats.
    """
    kept, covered, i, clear = 0, 0.0, 0, False
    scores = samples.scores[component]
    one = np.empty((POSTURES, COMPONENTS), np.float32)
    other = np.empty((POSTURES, COMPONENTS), np.float32)
    while i < count:
        describe(samples, component, cycles[:, i], one)
        j, agreed, strongest = i, 0.0, 0.0
        while j + 1 < count and _pair(scores, cycles, j):
            describe(samples, component, cycles[:, j + 1], other)
            alike = agreement(one, other)
            if alike < LEAST_AGREEMENT:
                break
            agreed += alike
            strongest = max(strongest, alike)
            one[:] = other
            j += 1
        if j > i and agreed >= ENOUGH:
            clear |= strongest >= STRONG or agreed >= MUCH
            covered += agreed / (j - i) * (cycles[2, j] - cycles[0, i])
            for q in range(i, j + 1):
                for k in range(3):
                    cycles[k, kept] = cycles[k, q]
                kept += 1
        i = j + 1
    return kept, covered, clear


@kernel
def dwelling(scores, n, cycles, count):
    """Return how much longer cycles dwell where they begin than at their other extreme, from -1 to 1."""
    home, far = 0, 0
    for i in range(count):
        start, top = scores[cycles[0, i]], scores[cycles[1, i]]
        for q in range(cycles[0, i], cycles[2, i]):
            share = (scores[q] - start) / (top - start)
            home += share < 0.25
            far += share > 0.75
    return (home - far) / max(home + far, 1)
