"""Cycles between turning points, and which of them are alike.

A cycle goes from one extreme to the other and back. Its description is the posture at the three extremes and where it
passes a quarter, half and three quarters of the way, out and back: pauses and pace do not matter. Cycles count in runs
of neighbours whose descriptions agree; the agreement of all pairs of a run must add up to enough.
"""

import math

import numpy as np

from mossar_stream.jit.decorators import kernel
from mossar_stream.repetitions.sampling import STAMP_ROUNDING
from mossar_stream.repetitions.state import COMPONENTS, POSTURES, ring_place

SHORTEST_CYCLE = 4  # samples, of a cycle
LONGEST_RATIO = 2.0  # of the durations of neighbours
LEAST_AMPLITUDE_RATIO = 0.6
LEAST_AGREEMENT = 0.26  # of two neighbours
ENOUGH_AGREEMENT = 0.79  # of a run's pairs together
STRONG = 0.93  # one such pair makes clear that this is a repeated movement,
SAME_POSTURE = 0.3  # of the way between the extremes, by which postures differ that are the same
LONGEST_STOP = 0.5  # cycles, within what goes on
MUCH = 1.5  # or as much of a run's pairs together


@kernel
def cycles_between(turns, found, direction, first, cycles):
    """Write the cycles that begin and end at extremes of one direction.

    Args:
        turns: See `turning_points`.
        found: How many there are.
        direction: 1 to begin at maxima, -1 at minima.
        first: Whether the window's first sample is the take's: otherwise an extreme there is only where it was cut.
        cycles: (3, SAMPLES), out: start, far extreme, end.

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
def describe(samples, component, cycles, i, shapes):
    """Write the postures by which a cycle is compared.

    Args:
        samples: `Samples`.
        component: The one whose turning points these are.
        cycles: (3, SAMPLES) start, far extreme, end.
        i: Which cycle.
        shapes: (n, POSTURES, COMPONENTS) float32, whose i-th is written.
    """
    smooth = samples.smooth
    start, far, end = cycles[0, i], cycles[1, i], cycles[2, i]
    for k in range(COMPONENTS):
        shapes[i, 0, k], shapes[i, 1, k], shapes[i, 2, k] = smooth[k, start], smooth[k, far], smooth[k, end]
    begin, top = smooth[component, start], smooth[component, far]
    sign = np.float32(1.0) if top > begin else np.float32(-1.0)
    there = start
    for q in range(3):
        goal = begin + np.float32(0.25 * (q + 1)) * (top - begin)
        while there < far and (smooth[component, there + 1] - goal) * sign < 0:
            there += 1
        _write_between(smooth, component, (there, min(there + 1, far)), goal, shapes, (i, 3 + 2 * q))
    begin, back = smooth[component, end], end
    sign = np.float32(1.0) if top > begin else np.float32(-1.0)
    for q in range(3):
        goal = begin + np.float32(0.25 * (q + 1)) * (top - begin)
        while back > far and (smooth[component, back - 1] - goal) * sign < 0:
            back -= 1
        _write_between(smooth, component, (back, max(back - 1, far)), goal, shapes, (i, 4 + 2 * q))


@kernel
def _write_between(smooth, component, between, goal, shapes, place):
    """Write the posture where a component has a value between two neighbours."""
    one, other = between
    i, q = place
    rest = np.float32(0.0)
    if one != other:
        rest = (goal - smooth[component, one]) / (smooth[component, other] - smooth[component, one])
    for k in range(COMPONENTS):
        shapes[i, q, k] = smooth[k, one] + rest * (smooth[k, other] - smooth[k, one])


@kernel
def agreement(described, i, j):
    """Return how alike two descriptions are: 1 the same, 0 no more than by chance.

    With a and b the descriptions and m their mean, this is 1 - |a - b|² / (|a - m|² + |b - m|²).
    """
    shapes, totals = described.shapes, described.totals
    product, means = np.float32(0.0), np.float32(0.0)
    for q in range(POSTURES):
        for k in range(COMPONENTS):
            product += shapes[i, q, k] * shapes[j, q, k]
    for k in range(COMPONENTS):
        means += (totals[i, k] + totals[j, k]) ** 2
    squares = totals[i, COMPONENTS] + totals[j, COMPONENTS]
    spread = max(squares - means / np.float32(2 * POSTURES), np.float32(1e-9))
    return 1.0 - float((squares - np.float32(2.0) * product) / spread)


@kernel
def _pair(scores, cycles, i):
    """Return whether durations and amplitudes of a cycle and the next are near enough."""
    one = cycles[2, i] - cycles[0, i]
    other = cycles[2, i + 1] - cycles[0, i + 1]
    if max(one, other) > LONGEST_RATIO * min(one, other):
        return False
    if min(one, other) < SHORTEST_CYCLE:
        return False
    a = abs(scores[cycles[1, i]] - 0.5 * (scores[cycles[0, i]] + scores[cycles[2, i]]))
    b = abs(scores[cycles[1, i + 1]] - 0.5 * (scores[cycles[0, i + 1]] + scores[cycles[2, i + 1]]))
    return min(a, b) >= LEAST_AMPLITUDE_RATIO * max(a, b)


@kernel
def describe_all(samples, component, cycles, count, described):
    """Describe cycles.

    Args:
        samples: `Samples`.
        component: The one whose turning points these are.
        cycles: (3, SAMPLES).
        count: How many there are.
        described: `SCRATCH` record, out.
    """
    shapes, totals = described.shapes, described.totals
    for i in range(count):
        describe(samples, component, cycles, i, shapes)
        totals[i] = np.float32(0.0)
        for q in range(POSTURES):
            for k in range(COMPONENTS):
                value = shapes[i, q, k]
                totals[i, k] += value
                totals[i, COMPONENTS] += value * value
        if i > 0:
            described.alike[i - 1] = agreement(described, i - 1, i)


@kernel
def alternation(cycles, count, described):
    """Return how much better cycles agree with the next but one than with the next: those are halves of cycles."""
    alike = described.alike
    better, triples = 0.0, 0
    for i in range(count - 2):
        if cycles[2, i] == cycles[0, i + 1] and cycles[2, i + 1] == cycles[0, i + 2]:
            better += agreement(described, i, i + 2) - 0.5 * (alike[i] + alike[i + 1])
            triples += 1
    return better / triples if triples > 1 else 0.0


@kernel
def copy_cycles(cycles, count, goal):
    """Copy the first `count` cycles of one (3, SAMPLES) to another."""
    for k in range(3):
        for i in range(count):
            goal[k, i] = cycles[k, i]


@kernel
def join_pairs(scores, cycles, count, first, joined):
    """Write cycles joined two by two from one of them on; return how many there are."""
    made, i = 0, first
    while i + 1 < count:
        if cycles[2, i] != cycles[0, i + 1]:
            i += 1
            continue
        start, one, other = cycles[0, i], cycles[1, i], cycles[1, i + 1]
        joined[0, made], joined[2, made] = start, cycles[2, i + 1]
        farther = abs(scores[one] - scores[start]) >= abs(scores[other] - scores[start])
        joined[1, made] = one if farther else other
        made += 1
        i += 2
    return made


@kernel
def keep_alike(scores, cycles, count, alike):
    """Keep the cycles of runs that agree enough.

    Args:
        scores: Of the component whose turning points these are.
        cycles: (3, SAMPLES), in and out.
        count: How many there are.
        alike: Agreement of each with the next.

    Returns:
        How many are left, the samples that they cover, weighted by their agreement, and whether it is clear that
        a movement repeats.
    """
    kept, covered, i, clear = 0, 0.0, np.int64(0), False
    while i < count:
        j, agreed, strongest = i, 0.0, 0.0
        while j + 1 < count and _pair(scores, cycles, j):
            if alike[j] < LEAST_AGREEMENT:
                break
            agreed += alike[j]
            strongest = max(strongest, alike[j])
            j += 1
        if j > i and agreed >= ENOUGH_AGREEMENT:
            clear |= strongest >= STRONG or agreed >= MUCH
            covered += agreed / (j - i) * (cycles[2, j] - cycles[0, i])
            for q in range(i, j + 1):
                for k in range(3):
                    cycles[k, kept] = cycles[k, q]
                kept += 1
        i = j + 1
    return kept, covered, clear


@kernel
def duration(cycles, count):
    """Return how many samples cycles last together."""
    total = 0
    for i in range(count):
        total += cycles[2, i] - cycles[0, i]
    return total


@kernel
def recurring(scores, cycles, count):
    """Return the correlation of the posture with that one mean cycle later, from -1 to 1, between first and last cycle."""
    lag = int(duration(cycles, count) / count + 0.5)
    begin, n = cycles[0, 0], cycles[2, count - 1] - cycles[0, 0] - lag
    if n < 2:
        return 0.0
    product, one, other = 0.0, 1e-18, 1e-18
    for k in range(COMPONENTS):
        row = scores[k]
        u = v = uu = vv = uv = np.float32(0.0)
        for i in range(begin, begin + n):
            a, b = row[i], row[i + lag]
            u += a
            v += b
            uu += a * a
            vv += b * b
            uv += a * b
        product += float(uv - u * v / np.float32(n))
        one += float(uu - u * u / np.float32(n))
        other += float(vv - v * v / np.float32(n))
    return product / math.sqrt(one * other)


@kernel
def goes_on(header, n, smooth, cycle, step, last):
    """Return how much of a cycle is shown beyond its end (step 1), or before its begin (-1), and up to which sample.

    Args:
        header: `HEADER` record.
        n: Samples in the window.
        smooth: (COMPONENTS, n) scores.
        cycle: (3,) start, far extreme, end.
        step: 1 or -1.
        last: Sample beyond which it is not looked for.
    """
    start, far, end = cycle[0], cycle[1], cycle[2]
    here, there, goal = (end, start, end) if step == 1 else (start, end, start)
    begun = there
    most, lasted = (
        SAME_POSTURE * distance(smooth, start, far),
        header.at[ring_place(header, n, end)] - header.left[ring_place(header, n, start)],
    )
    while here != last and there != goal:
        one, other = (here, here + 1) if step == 1 else (here - 1, here)
        if (
            header.at[ring_place(header, n, other)] - header.left[ring_place(header, n, one)]
            > LONGEST_STOP * lasted + STAMP_ROUNDING
        ):
            break
        best, least = there, np.inf
        for q in range(3):
            place = there + q * step
            if (goal - place) * step < 0:
                break
            apart = distance(smooth, here + step, place)
            if apart < least:
                best, least = place, apart
        if least > most:
            break
        here, there = here + step, best
    return abs(there - begun) / (end - start), here


@kernel
def distance(smooth, i, j):
    """Return how far two samples of the window are apart, m over all joints."""
    total = np.float32(0.0)
    for k in range(COMPONENTS):
        total += (smooth[k, i] - smooth[k, j]) ** 2
    return math.sqrt(total)


@kernel
def dwelling_of(header, n, scores, start, far, end):
    """Return how long a cycle is in the quarter where it begins, and in that of its other extreme, s."""
    begin, top = scores[start], scores[far]
    sign = np.float32(1.0) if top > begin else np.float32(-1.0)
    near = sign * (begin + np.float32(0.25) * (top - begin))
    away = sign * (begin + np.float32(0.75) * (top - begin))
    dwelling, distant = 0.0, 0.0
    for q in range(start, end):
        lasted = header.at[ring_place(header, n, q + 1)] - header.at[ring_place(header, n, q)]
        dwelling += lasted if sign * scores[q] < near else 0.0
        distant += lasted if sign * scores[q] > away else 0.0
    return dwelling, distant


@kernel
def rest_pose_nearness(samples, cycles, count):
    """Return how much nearer to the rest pose cycles begin than at their other extreme, from -1 to 1."""
    begin, far = 0.0, 0.0
    for i in range(count):
        near, distant = rest_pose_distances(samples, cycles[0, i], cycles[1, i])
        begin, far = begin + near, far + distant
    return (far - begin) / max(begin + far, 1e-9)


@kernel
def rest_pose_distances(samples, start, far):
    """Return how far from the rest pose two samples are, m over all joints."""
    one = other = np.float32(0.0)
    for k in range(COMPONENTS):
        one += (samples.smooth[k, start] - samples.rest_pose_scores[k]) ** 2
        other += (samples.smooth[k, far] - samples.rest_pose_scores[k]) ** 2
    return np.sqrt(one), np.sqrt(other)
