"""Frames become samples at a constant rate: per coordinate the middle one of three frames of a sample.

Joints are taken relative to the root; the root keeps its own path, since squats and jumps move it most. Of three
frames the mean without the least and the most is their median, so a joint that leaps for one frame does not count.
"""

import math

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.repetitions.state import FRAMES, HOME, RATE, SAMPLES

ROUNDING, EARLY = 3e-3, 1e-4  # frames; s: of timestamps as exact as those since 1970
SHORTEST_BONE = 0.03  # m; what is shorter says nothing of how a limb is held


@kernel
def next_wanted(origin, time):
    """Return from when on the next frame is taken after one that was: `FRAMES` in a sample, evenly spread.

    Args:
        origin: s, of the take.
        time: Of the frame, s.
    """
    return origin + (math.floor((time - origin) * (RATE * FRAMES) + ROUNDING) + 1) / (RATE * FRAMES) - EARLY


@inline_kernel
def take_frame(header, samples, position, time):
    """Take one frame of a take in, if it is wanted; no look is due before it.

    Args:
        header: `HEADER` record.
        samples: `Kept`.
        position: (J, 3) float32, m, NaN where missing.
        time: s.
    """
    sample = int((time - header.origin) * RATE + 1e-6)
    while header.open < sample:
        close_sample(header, samples)
    header.latest = time
    if time >= header.wanted:
        header.wanted = next_wanted(header.origin, time)
        take_pose(header, samples, position)


@kernel
def take_pose(header, samples, positions):
    """Add a frame to the open sample; what is missing stays where it was.

    Args:
        header: `HEADER` record.
        samples: `Kept`.
        positions: (J, 3) float32, m, NaN where missing.
    """
    r = header.root
    pose = samples.pose
    fresh = header.frames == 0
    x, y, z = positions[r, 0], positions[r, 1], positions[r, 2]
    if header.unseen > 0:
        _appear(header, samples, positions)
    for j in range(header.joints):
        k = 3 * j
        a, b, c = positions[j, 0] - x, positions[j, 1] - y, positions[j, 2] - z
        pose[k] = pose[k] if np.isnan(a) else a
        pose[k + 1] = pose[k + 1] if np.isnan(b) else b
        pose[k + 2] = pose[k + 2] if np.isnan(c) else c
    if header.travels == 1:
        k = 3 * r
        pose[k] = pose[k] if np.isnan(x) else x
        pose[k + 1] = pose[k + 1] if np.isnan(y) else y
        pose[k + 2] = pose[k + 2] if np.isnan(z) else z
    sums, least, most = samples.sums, samples.least, samples.most
    for k in range(pose.size):
        value = pose[k]
        sums[k] = value if fresh else sums[k] + value
        least[k] = value if fresh or value < least[k] else least[k]
        most[k] = value if fresh or value > most[k] else most[k]
    header.frames += 1


@kernel
def _appear(header, samples, positions):
    """Let coordinates that are seen for the first time have been there all along."""
    n = np.float32(header.frames)
    for j in range(header.joints):
        for c in range(3):
            k = 3 * j + c
            own = j == header.root and header.travels == 1
            value = positions[j, c] if own else positions[j, c] - positions[header.root, c]
            if np.isnan(value) or not np.isnan(samples.pose[k]):
                continue
            header.unseen -= 1
            for i in range(SAMPLES):
                samples.by_sample[i, k] = value
            samples.home[k] = value
            samples.sums[k] = n * value
            samples.least[k] = samples.most[k] = value


@kernel
def close_sample(header, samples):
    """Put the open sample into the ring; without frames it repeats the latest pose."""
    place = header.open % SAMPLES
    n = header.frames
    for k in range(samples.pose.size):
        value = samples.pose[k]
        if n > 2:
            value = (samples.sums[k] - samples.least[k] - samples.most[k]) / np.float32(n - 2)
        elif n > 0:
            value = samples.sums[k] / np.float32(n)
        if np.isnan(value):
            value = np.float32(0.0)
        samples.by_sample[place, k] = value
        if header.open < HOME:
            samples.home[k] += (value - samples.home[k]) / np.float32(header.open + 1)
    samples.straight[place] = _straightness(header, samples.by_sample[place])
    header.frames = 0
    header.open += 1


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
