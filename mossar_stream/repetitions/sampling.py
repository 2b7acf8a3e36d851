"""Poses become samples where the movement has gone on: a sample differs from the one before by a share of the movement.

So a cycle has as many samples however long it takes, and a rest has one. Joints are taken relative to the root; the
root keeps its own path, since squats and jumps move it most. Of three frames in a row each coordinate's median counts,
so a joint that leaps for one frame does not.
"""

import math

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.joint_pages import FARTHEST
from mossar_stream.repetitions.state import (
    ANALYSIS_INTERVAL,
    LEAST_REACH,
    MOST_QUANTA,
    RATE,
    REST_POSE_FRAMES,
    SAMPLES,
    SMALLEST_QUANTUM,
    STRIDE,
)

ROUNDING, STAMP_ROUNDING = 3e-3, 1e-4  # frames; s: of timestamps as exact as those since 1970
SHORTEST_BONE = 0.03  # m; what is shorter says nothing of how a limb is held
LEAST_STEP = 0.02  # of the size of the body, rms over joints, between samples
STAYS = 0.1  # of the square of a step, within which a pose is still that of the sample
MEDIAN = 0.45  # variance of the median of three, of theirs
STEP_ABOVE_NOISE = 3.0  # times the square by which noise alone makes two samples differ
FOLLOWS = 0.2  # of what three poses say of the noise
TURNS_BACK = 1.5  # times the square of the way, by which the square of the bend is larger in noise (3) and not in motion
RETURNED = 0.25  # of the square of how far it went, within which a pose has come back
RETURNS = 3  # after which the step is made smaller,
SHARE_OF_SMALL = 0.1  # to this share of that square
LONGEST_REST = 30.0  # s; what was done before a longer one is not compared with what comes


@kernel
def next_wanted(origin, time):
    """Return from when on the next frame is looked at after one that was: at `RATE`.

    Args:
        origin: s, of the take.
        time: Of the frame, s.
    """
    return origin + (math.floor((time - origin) * RATE + ROUNDING) + 1) / RATE - STAMP_ROUNDING


@inline_kernel
def take_frame(header, samples, position, time):
    """Process one frame of a take, if it is wanted; no analysis is due before it.

    Args:
        header: `HEADER` record.
        samples: `StoredSamples`.
        position: (J, 3) float32, m, NaN where missing.
        time: s.
    """
    header.latest = time
    if time >= header.wanted:
        header.wanted = next_wanted(header.origin, time)
        take_pose(header, samples, position, time)


@kernel
def take_pose(header, samples, positions, time):
    """Look at a frame; what is missing, or too far off to be true, stays where it was.

    Args:
        header: `HEADER` record.
        samples: `StoredSamples`.
        positions: (J, 3) float32, m, NaN where missing.
        time: s.
    """
    r = header.root
    pose = samples.pose
    x, y, z = _place(positions[r, 0]), _place(positions[r, 1]), _place(positions[r, 2])
    if header.unseen > 0:
        _appear(header, samples, positions)
    for j in range(header.joints):
        k = 3 * j
        a, b, c = _place(positions[j, 0]) - x, _place(positions[j, 1]) - y, _place(positions[j, 2]) - z
        pose[k] = pose[k] if np.isnan(a) else a
        pose[k + 1] = pose[k + 1] if np.isnan(b) else b
        pose[k + 2] = pose[k + 2] if np.isnan(c) else c
    if header.travels == 1:
        k = 3 * r
        pose[k] = pose[k] if np.isnan(x) else x
        pose[k + 1] = pose[k + 1] if np.isnan(y) else y
        pose[k + 2] = pose[k + 2] if np.isnan(z) else z
    since = time - header.origin
    if header.frames == 0:
        for k in range(pose.size):
            samples.before[k] = samples.older[k] = pose[k]
        header.middle = since
        header.size = _size(header, samples.pose)
        header.quantum = max(
            SMALLEST_QUANTUM, LEAST_REACH * math.sqrt(header.size / header.joints) / MOST_QUANTA
        )
        header.per_quantum = np.float32(1.0) / header.quantum
        append_sample(header, samples, samples.before)
    else:
        _follow(header, samples)
    header.middle = since
    header.frames += 1
    if header.frames <= REST_POSE_FRAMES:
        share = np.float32(1.0 / header.frames)
        for k in range(pose.size):
            samples.rest_pose[k] += (
                np.float32(0.0) if np.isnan(pose[k]) else share * (pose[k] - samples.rest_pose[k])
            )


@inline_kernel
def _place(coordinate):
    """Return a coordinate, m; NaN for one that is no position: its square would leave nothing else of a pose."""
    return coordinate if abs(coordinate) <= FARTHEST else np.float32(np.nan)


@kernel
def _follow(header, samples):
    """Let noise and samples follow the newest pose."""
    pose, before, older = samples.pose, samples.before, samples.older
    last = samples.last
    bend = way = moved = np.float32(0.0)
    for k in range(pose.size):
        a, b, c = older[k], before[k], pose[k]
        low, high = min(a, b), max(a, b)
        middle = max(low, min(high, c))
        older[k] = middle
        turn, went = (a - b) + (c - b), c - a
        apart = middle - last[k]
        bend += np.float32(0.0) if np.isnan(turn) else turn * turn
        way += np.float32(0.0) if np.isnan(went) else went * went
        moved += np.float32(0.0) if np.isnan(apart) else apart * apart
    if header.frames > 1:
        noise = float(bend) / 6.0
        if noise < header.noise or bend > TURNS_BACK * way:
            header.noise += FOLLOWS * (noise - header.noise)
    least = LEAST_STEP**2 * header.size
    still = STEP_ABOVE_NOISE * 2.0 * MEDIAN * header.noise
    step = max(header.step, least)
    if moved > still + step:
        append_sample(header, samples, older)
        header.wander, header.returns = 0.0, 0
    else:
        if moved <= still + STAYS * step:
            header.left[(header.open - 1) % SAMPLES] = header.middle
        _wander(header, moved - still, least)
    for k in range(pose.size):
        older[k] = before[k]
        before[k] = pose[k]


@kernel
def _wander(header, square, least):
    """Make the step smaller if the pose goes out and back again and again, without a step.

    Args:
        header: `HEADER` record.
        square: m², how far it is from the last sample.
        least: m², the smallest step.
    """
    if square > header.wander:
        header.wander = square
    elif header.wander > 4.0 * least and square < RETURNED * header.wander:
        header.returns += 1
        if header.returns == RETURNS:
            header.step = SHARE_OF_SMALL * header.wander
            header.fine = header.open - 1
            header.returns = 0
        header.wander = 0.0


@kernel
def _size(header, pose):
    """Return the square of how far joints are from their centre, added up, m²."""
    total, n = 0.0, pose.size // 3
    for c in range(3):
        mean, squares, seen = 0.0, 0.0, 0
        for j in range(n):
            value = np.float32(0.0) if j == header.root else pose[3 * j + c]
            if not np.isnan(value):
                mean += float(value)
                squares += float(value) ** 2
                seen += 1
        if seen > 0:
            total += (squares - mean * mean / seen) * n / seen
    return total


@kernel
def append_sample(header, samples, pose):
    """Put a pose into the ring, at the time of the middle frame."""
    place = header.open % SAMPLES
    if (
        header.open > 0
        and header.middle - header.left[(header.open - 1) % SAMPLES] > LONGEST_REST + STAMP_ROUNDING
    ):
        header.first = header.open - 1
    for k in range(pose.size):
        samples.last[k] = np.float32(0.0) if np.isnan(pose[k]) else pose[k]
        samples.ring[k, place] = _in_quanta(header, samples.last[k])
    for c in range(3):
        samples.root[c, place] = samples.last[3 * header.root + c]
    header.at[place] = header.left[place] = header.middle
    samples.straight[place] = _straightness(header, samples.last)
    header.open += 1
    if header.open >= header.analysed + STRIDE:
        header.due = header.latest
    else:
        header.due = min(header.due, header.latest + ANALYSIS_INTERVAL - STAMP_ROUNDING)


@inline_kernel
def _in_quanta(header, coordinate):
    """Return a coordinate, m, as the nearest multiple of the quantum, the largest one at most."""
    return np.int16(min(max(np.rint(coordinate * header.per_quantum), -MOST_QUANTA), MOST_QUANTA))


@kernel
def _appear(header, samples, positions):
    """Let coordinates that are seen for the first time have been there all along."""
    for j in range(header.joints):
        for c in range(3):
            k = 3 * j + c
            own = j == header.root and header.travels == 1
            value = _place(positions[j, c])
            value -= np.float32(0.0) if own else _place(positions[header.root, c])
            if np.isnan(value) or not np.isnan(samples.pose[k]):
                continue
            header.unseen -= 1
            for i in range(SAMPLES):
                samples.ring[k, i] = _in_quanta(header, value)
                if j == header.root:
                    samples.root[c, i] = value
            samples.rest_pose[k] = samples.last[k] = samples.before[k] = samples.older[k] = value


@kernel
def _straightness(header, pose):
    """Return how straight and upright limbs are, 0 to 2, mean.

    That is the distance of the ends of two bones, and how far one is above the other, over the sum of their lengths.
    """
    total, count = 0.0, 0
    for k in range(header.chains):
        one = _distance(header, pose, header.chain[k, 0], header.chain[k, 1])
        other = _distance(header, pose, header.chain[k, 1], header.chain[k, 2])
        if min(one, other) >= SHORTEST_BONE:
            ends = _distance(header, pose, header.chain[k, 0], header.chain[k, 2])
            above = abs(_height(header, pose, header.chain[k, 0]) - _height(header, pose, header.chain[k, 2]))
            total += (ends + above) / (one + other)
            count += 1
    return total / count if count > 0 else 0.0


@kernel
def _height(header, pose, i):
    """Return how far a joint is above the root, m; y is up."""
    return 0.0 if i == header.root else float(pose[3 * i + 1])


@kernel
def _distance(header, pose, i, j):
    total = 0.0
    for c in range(3):
        a = 0.0 if i == header.root else float(pose[3 * i + c])
        b = 0.0 if j == header.root else float(pose[3 * j + c])
        total += (a - b) ** 2
    return math.sqrt(total)
