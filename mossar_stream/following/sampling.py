"""Sampling: frames in, the directions of bones out, at a fixed rate whatever the sensor's.

Samples lie on a grid of `PERIOD`, between two frames by interpolation, so that alignments count time, not frames.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel

LATE = 1.0  # s, frames that are so late are repeated or out of order
MAX_STEP = 0.25  # s, a longer time without frames breaks what is being made
FACING_TIME = 1.0  # s, over which the line of the hips is averaged
FARTHEST = np.float32(1e6)  # m
EARLY = 1e-6  # s by which a frame may come before the sample that is due


@inline_kernel
def is_in_order(state, time):
    """Tell whether a frame is to be processed; late ones are not, time that was set back begins anew."""
    if not np.isfinite(time):
        return False
    return state.frames == 0 or not -LATE <= time - state.time <= 0.0


@inline_kernel
def goes_on(state, time):
    """Tell whether a frame follows the one before without a gap."""
    return state.frames > 0 and 0.0 < time - state.time <= MAX_STEP


@inline_kernel
def localise(pose, before, points, positions, started):
    """Write a frame as points relative to the centre; a missing one stays where it was. Return whether all were there."""
    whole = True
    x = y = z = np.float32(0.0)
    for k in range(points.size):
        a, b = points[k].one, points[k].other
        if a < 0:
            px, py, pz = _mean(positions)
        else:
            px = np.float32(0.5) * (positions[a, 0] + positions[b, 0])
            py = np.float32(0.5) * (positions[a, 1] + positions[b, 1])
            pz = np.float32(0.5) * (positions[a, 2] + positions[b, 2])
        if k == 0:
            x, y, z = px, py, pz
        px, py, pz = px - x, py - y, pz - z
        if abs(px) + abs(py) + abs(pz) < FARTHEST:
            pose[k, 0], pose[k, 1], pose[k, 2] = px, py, pz
            continue
        whole = False
        for d in range(3):
            pose[k, d] = before[k, d] if started else np.float32(0.0)
    return whole


@inline_kernel
def _mean(positions):
    x = y = z = np.float32(0.0)
    count = 0
    for j in range(positions.shape[0]):
        if not np.isnan(positions[j, 0] + positions[j, 1] + positions[j, 2]):
            x += positions[j, 0]
            y += positions[j, 1]
            z += positions[j, 2]
            count += 1
    share = np.float32(1.0) / np.float32(count)
    return x * share, y * share, z * share


@kernel
def take_sample(known, bank, share, seconds):
    """Write the directions of bones between the last two frames.

    Args:
        known: `Memory`; the later frame is `poses[1]`.
        bank: `Bank`.
        share: Of the way from the earlier to the later frame, 0..1.
        seconds: Since the last sample, s.
    """
    head, state, poses, directions = bank.head[0], known.state[0], known.poses, known.directions
    axis, sign, later = head.axis, np.float32(head.sign), np.float32(share)
    first, last = (axis + 2) % 3, (axis + 1) % 3
    earlier = np.float32(1.0) - later
    cosine, sine = _facing(state, head, poses, seconds)
    bones = bank.bones
    for b in range(bones.size):
        begin, end = bones[b].begin, bones[b].end
        x = sign * (
            later * (poses[1, end, first] - poses[1, begin, first])
            + earlier * (poses[0, end, first] - poses[0, begin, first])
        )
        y = sign * (
            later * (poses[1, end, axis] - poses[1, begin, axis])
            + earlier * (poses[0, end, axis] - poses[0, begin, axis])
        )
        z = later * (poses[1, end, last] - poses[1, begin, last]) + earlier * (
            poses[0, end, last] - poses[0, begin, last]
        )
        length = np.sqrt(x * x + y * y + z * z)
        scale = np.float32(1.0) / max(length, np.float32(1e-6))
        directions[0, b] = scale * (cosine * x + sine * z)
        directions[1, b] = scale * y
        directions[2, b] = scale * (cosine * z - sine * x)


@inline_kernel
def _facing(state, head, poses, seconds):
    """Let the line of the hips follow; return the cosine and the sine of the turn that lays it along the first axis."""
    if head.left < 0:
        return np.float32(1.0), np.float32(0.0)
    first, last = (head.axis + 2) % 3, (head.axis + 1) % 3
    share = 1.0 if state.samples == 0 else min(1.0, seconds / FACING_TIME)
    x = head.sign * (poses[1, head.left, first] - poses[1, head.right, first])
    z = np.float64(poses[1, head.left, last] - poses[1, head.right, last])
    state.across[0] += share * (x - state.across[0])
    state.across[1] += share * (z - state.across[1])
    width = np.sqrt(state.across[0] ** 2 + state.across[1] ** 2)
    if width < 1e-6:
        return np.float32(1.0), np.float32(0.0)
    return np.float32(state.across[0] / width), np.float32(state.across[1] / width)
