"""Cycles: whether the performer repeats a movement, and which key frame ends each repetition.

The period is that of YIN (de Cheveigne and Kawahara 2002) on poses instead of sound: d(l) is the mean squared
distance of the poses of the last moments from those l earlier, normalised by its mean over the shorter lags; the
period is at its first deep local minimum. Ten poses a second serve.

While there is a period, every candidate of Algorithm 2 gets a verdict when it is `JUDGED_AFTER` old, or decided: it
ends a repetition if, of all candidates within half a period around it, it is the slowest, nearest to the pose in which
the performer dwells, and best in step with the last one. What it is compared with is fixed, so that the verdict is the
same whatever the window of Algorithm 3 holds.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.scales import extent
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.joint_pages import PAGE, PAGE_SIZE, POSE_X, place

SPACING = 0.1  # s between the poses
MARGIN = 1e-4  # s, for the rounding of timestamps
LAGS = 61  # longest lag, poses
PLACES = 64  # for LAGS + 1 poses, padded so that loops over them vectorise
SHORTEST_LAG = 4  # a repetition is not shorter
LONGEST_WINDOW, SHORTEST_WINDOW = 45, 10  # poses; three quarters of the lag between them
DEEP, CERTAIN = 0.6, 0.25  # normalised distance at the period, to stay in cycles and to enter them
# s², times the squared noise of a speed over 0.1 s: squared distance of poses that are the same but for noise, and the
# mean of what lies beyond without which nothing moved.
NOISE_APART, LEAST_APART = 0.013, 0.005
STILL = 0.05  # mean squared distance, in A², below which nothing is repeated
CANDIDATES = 32  # remembered
JUDGED_AFTER = 1.5 - 1e-6  # s; a little less, for the rounding of timestamps
NEAREST = 0.6  # periods between two repetitions' ends
SLOWNESS, SLOWNESS_OFFSET = 1.5, 0.1  # weight of the log speed, and the share of V added to the speed
FREE, ENDS, WITHIN = np.arange(3)  # verdicts: no cycle, end of a repetition, inside one

CYCLES = np.dtype(
    [
        ("poses", "i8"),  # taken so far
        ("next_time", "f8"),  # s, of the next one
        ("inside", "i8"),  # whether the performer repeats a movement
        ("period", "f8"),  # s
        ("last_time", "f8"),  # s, end of the last repetition
        ("candidates", "i8"),  # noted so far
        ("judged", "i8"),  # of them
    ],
)
NOTE = np.dtype([("time", "f8"), ("cost", "f8")])  # s; how unlike the end of a repetition a candidate is


class Cycles(NamedTuple):
    """What is needed to find cycles, as the functions below need it."""

    state: np.void  # CYCLES
    poses: NDArray[np.float32]  # (3, joints, PLACES) m, ring of LAGS + 1 poses
    distances: NDArray[np.float32]  # (LONGEST_WINDOW, LAGS + 1) m², of the last poses from those before, ring
    sums: NDArray[np.float64]  # (PLACES,) m², scratch
    notes: NDArray[np.void]  # (CANDIDATES,) NOTE, ring


@kernel
def start_cycles(state, time):
    """Begin a take."""
    state.poses = 0
    state.next_time = time
    state.inside = 0
    state.period = 0.0
    state.last_time = -np.inf
    state.candidates = 0
    state.judged = 0


@inline_kernel
def follow_cycles(cycles, scales, body, joints, time, noise):
    """Take the pose of a frame in if one is due, and look for a period.

    Args:
        cycles: Cycles.
        scales: SCALES.
        body: See joint_pages.py.
        joints: How many can move relative to the centre.
        time: s, of the frame.
        noise: m/s, what the sensor's noise adds to the speed u (facts.py).
    """
    state = cycles.state
    if time < state.next_time - MARGIN:
        return
    state.next_time = max(state.next_time + SPACING, time)
    _take_pose(cycles, body, joints, NOISE_APART * noise * noise)
    _find_period(cycles, STILL * extent(scales) ** 2, LEAST_APART * noise * noise)


@kernel
def _take_pose(cycles, body, joints, noise):
    """Keep a pose, and its squared distances from those before, less what noise adds to them, m²."""
    state, sums = cycles.state, cycles.sums
    here = state.poses % (LAGS + 1)
    sums[:] = 0.0
    for axis in range(3):
        for j in range(cycles.poses.shape[1]):
            value = body[j // PAGE * PAGE_SIZE + j % PAGE + POSE_X + axis * PAGE]
            kept = cycles.poses[axis, j]
            kept[here] = value
            _add_squares(sums, kept, value)
    line = cycles.distances[state.poses % LONGEST_WINDOW]
    line[0] = 0.0
    for lag in range(1, LAGS + 1):
        apart = sums[(state.poses - lag) % (LAGS + 1)] / joints - noise if state.poses >= lag else 0.0
        line[lag] = max(apart, 0.0)
    state.poses += 1


@kernel
def keep_in_cycles(cycles, body, j):
    """Let a joint have been where it is now in all poses that are kept."""
    for axis in range(len(cycles.poses)):  # none without evidence
        cycles.poses[axis, j] = body[place(j) + POSE_X + axis * PAGE]


@inline_kernel
def _add_squares(sums, kept, value):
    """Add to the squared distance from each kept pose what one coordinate gives: all of them side by side."""
    for i in range(PLACES):
        step = value - kept[i]
        sums[i] += step * step


@kernel
def _find_period(cycles, still, least):
    """Set whether the performer is in a cycle, and its period.

    Args:
        cycles: Cycles.
        still: m², mean squared distance at all lags below which nothing is repeated.
        least: m², that at the shorter lags below which there is no period.
    """
    state = cycles.state
    _sum_distances(cycles)
    total = 0.0
    last = value = depth = 1.0
    period = 0.0
    for lag in range(1, LAGS + 1):
        mean, known = _mean_distance(cycles, lag)
        total += mean
        later = (mean * lag / total if total > lag * least else 1.0) if known else 2.0
        # `value` belongs to the lag before, `last` to the one before that.
        is_minimum = value < DEEP and value <= last and value < later
        if period == 0.0 and lag - 1 >= SHORTEST_LAG and is_minimum:
            bend = last - 2.0 * value + later
            shift = 0.5 * (last - later) / bend if bend > 1e-12 else 0.0
            period, depth = (lag - 1 + shift) * SPACING, value
        last, value = value, later
    found = period > 0.0 and total / LAGS > still
    if not found:
        state.inside = 0
        return
    state.period = period
    if depth < CERTAIN:
        state.inside = 1


@inline_kernel
def _sum_distances(cycles):
    """Set `sums` to the sum, at each lag, of the distances of the last poses: as many as `_window` says."""
    poses, sums = cycles.state.poses, cycles.sums
    for lag in range(LAGS + 1):
        sums[lag] = 0.0
    for back in range(1, min(LONGEST_WINDOW, poses) + 1):
        shortest = (4 * back + 2) // 3 if back > SHORTEST_WINDOW else 1
        line = cycles.distances[(poses - back) % LONGEST_WINDOW, shortest : min(LAGS, poses - back) + 1]
        _add_line(sums[shortest:], line)


@inline_kernel
def _add_line(sums, line):
    for i in range(len(line)):
        sums[i] += line[i]


@inline_kernel
def _window(lag):
    """Return over how many poses the distances at a lag are averaged."""
    return max(3 * lag // 4, SHORTEST_WINDOW)


@inline_kernel
def _mean_distance(cycles, lag):
    """Return the mean squared distance at a lag, and whether there were poses enough to know it."""
    window = _window(lag)
    there = max(0, min(window, cycles.state.poses - lag))
    return cycles.sums[lag] / max(there, 1), there == window


@inline_kernel
def note_candidate(cycles, time, home, speed):
    """Remember a candidate that Algorithm 2 accepted.

    Args:
        cycles: Cycles.
        time: s, of the candidate.
        home: Distance from the pose in which the performer dwells, in A.
        speed: In V.
    """
    note = cycles.notes[cycles.state.candidates % CANDIDATES]
    note.time = time
    note.cost = home + SLOWNESS * np.log(speed + SLOWNESS_OFFSET)
    cycles.state.candidates += 1


@inline_kernel
def due_verdict(cycles, delay):
    """Return when the next candidate must be judged, s; inf if none waits."""
    state = cycles.state
    if state.judged == state.candidates:
        return np.inf
    return cycles.notes[state.judged % CANDIDATES].time + delay


@kernel
def judge(cycles):
    """Return the verdict on the oldest candidate that has none."""
    state = cycles.state
    number = state.judged
    state.judged += 1
    if state.inside == 0 or state.candidates - number > CANDIDATES:
        return FREE
    note = cycles.notes[number % CANDIDATES]
    best, least = number, np.inf
    for other in range(max(0, state.candidates - CANDIDATES), state.candidates):
        candidate = cycles.notes[other % CANDIDATES]
        if abs(candidate.time - note.time) > 0.5 * state.period:
            continue
        cost = candidate.cost + _out_of_step(state, candidate.time)
        if cost < least:
            best, least = other, cost
    if best != number or note.time - state.last_time < NEAREST * state.period:
        return WITHIN
    state.last_time = note.time
    return ENDS


@inline_kernel
def _out_of_step(state, time):
    """Return how far a time is from whole periods after the last repetition: 0, to 1 from a half on."""
    if not state.last_time > -np.inf:
        return 0.0
    periods = (time - state.last_time) / state.period
    return min(1.0, 2.0 * abs(periods - np.rint(periods)))


@inline_kernel
def forget_newest(cycles):
    """Forget the newest candidate, which was taken back."""
    state = cycles.state
    state.candidates -= 1
    state.judged = min(state.judged, state.candidates)
