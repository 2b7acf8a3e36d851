"""Sampling: frames in, the directions of bones out, at a fixed rate whatever the sensor's.

Samples lie on a grid of `PERIOD`, between two frames by interpolation, so that alignments count time, not frames.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.moves.facing import facing_of, heading, turned_back

LATE = 1.0  # s, frames that are so late are repeated or out of order
MAX_STEP = 0.25  # s, a longer time without frames breaks what is being made
FACING_TIME = 1.0  # s, time constant with which the facing follows
SMALLEST = np.float32(1e-6)  # m, of a bone
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
def localise(known, bank, positions):
    """Write a frame as points relative to the centre, y upwards; return whether all were there.

    A missing point stays where it was.
    """
    pose, before, points, started = known.poses[1], known.poses[0], bank.points, known.state[0].frames > 0
    axis, sign = bank.head[0].axis, np.float32(bank.head[0].sign)
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
            if axis == 0:
                px, py, pz = pz, px, py
            elif axis == 2:
                px, py, pz = py, pz, px
            pose[k, 0], pose[k, 1], pose[k, 2] = sign * px, sign * py, pz
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
    """Write the directions of bones between the last two frames, as of a body that faces the same way all the time.

    Args:
        known: `Memory`; the later frame is `poses[1]`.
        bank: `Bank`.
        share: Of the way from the earlier to the later frame, 0..1.
        seconds: Since the last sample, s.
    """
    state, poses, directions, bones = known.state[0], known.poses, known.directions, bank.bones
    later = np.float32(share)
    earlier = np.float32(1.0) - later
    cosine, sine = _facing(state, bank.head[0], poses[1], seconds)
    for b in range(bones.size):
        begin, end = bones[b].begin, bones[b].end
        x = later * (poses[1, end, 0] - poses[1, begin, 0]) + earlier * (
            poses[0, end, 0] - poses[0, begin, 0]
        )
        y = later * (poses[1, end, 1] - poses[1, begin, 1]) + earlier * (
            poses[0, end, 1] - poses[0, begin, 1]
        )
        z = later * (poses[1, end, 2] - poses[1, begin, 2]) + earlier * (
            poses[0, end, 2] - poses[0, begin, 2]
        )
        length = np.sqrt(x * x + y * y + z * z)
        scale = np.float32(1.0) / max(length, SMALLEST)
        x, z = turned_back(x, z, cosine, sine)
        directions[b, 0] = scale * x
        directions[b, 1] = scale * y
        directions[b, 2] = scale * z


@inline_kernel
def _facing(state, head, pose, seconds):
    """Let the facing follow; return the cosine and the sine of the heading."""
    if head.left < 0:
        return np.float32(1.0), np.float32(0.0)
    x, z = facing_of(pose, (head.left, head.right, head.left_shoulder, head.right_shoulder))
    share = 1.0 if state.samples == 0 else 1.0 - np.exp(-seconds / FACING_TIME)
    state.facing[0] += share * (x - state.facing[0])
    state.facing[1] += share * (z - state.facing[1])
    cosine, sine = heading(state.facing[0], state.facing[1])
    return np.float32(cosine), np.float32(sine)
