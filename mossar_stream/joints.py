"""Joints of one frame: who is there, how far each moved relative to the body centre.

Localisation is step 1 of the paper's preprocessing (3.1.1): positions relative to the body centre, so that the
place where the performer stands does not matter. Displacements of localised joints are differences of
displacements, which is what is computed here.

Live joints come and go. A joint that is missing, or faster than `max_speed`, is held where it was for `max_gap`
seconds; after that it is left out until it is back, without a displacement across the gap.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.compiled import compiled

FARTHEST = 1e5  # m; a coordinate beyond this is no position


@compiled
def step_joints(h, seen, good, step, frame, time):
    """Take one frame's joints in and set each joint's path relative to the centre.

    Args:
        h: Header of the row.
        seen: (lanes,) s, when each joint was last there.
        good: (3, lanes) m, where it was then.
        step: (lanes,) m, set to each joint's path since the last frame.
        frame: (J, 3) float32 m, NaN where missing.
        time: s, later than the last frame's.

    Returns:
        Path summed over the joints, scaled up for those left out, m.
    """
    if h.complete == 1 and _step_complete(h, good, step, frame, time):
        return _lane_sum(step)
    if h.complete == 1:
        seen[: h.joints] = h.time
    return _step_partial(h, seen, good, step, frame, time)


@compiled
def first_joints(h, seen, good, step, frame, time):
    """Take the first frame of a take in: no joint has moved yet."""
    h.complete = 1
    for j in range(h.joints):
        step[j] = 0.0
        if _is_position(frame[j]):
            seen[j] = time
            for axis in range(3):
                good[axis, j] = frame[j, axis]
        else:
            seen[j] = -np.inf
            h.complete = 0


@compiled
def _step_complete(h, good, step, frame, time):
    """Step when every joint was there in the last frame; False, with nothing kept, if one is not there now."""
    joints = h.joints
    reach = h.max_speed * (time - h.time)
    reach *= reach
    cx, cy, cz = _center_step(h, good, frame)
    unfit = 0
    for j in range(joints):
        ax = np.float64(frame[j, 0]) - good[0, j]
        ay = np.float64(frame[j, 1]) - good[1, j]
        az = np.float64(frame[j, 2]) - good[2, j]
        # NaN fails the comparison, too.
        unfit += 0 if ax * ax + ay * ay + az * az <= reach else 1
        ax -= cx
        ay -= cy
        az -= cz
        step[j] = np.sqrt(ax * ax + ay * ay + az * az)
    if unfit > 0:
        return False
    for j in range(joints):
        good[0, j] = frame[j, 0]
        good[1, j] = frame[j, 1]
        good[2, j] = frame[j, 2]
    return True


@compiled
def _center_step(h, good, frame):
    """Displacement of the centre when all joints are there."""
    if h.center >= 0:
        c = h.center
        return frame[c, 0] - good[0, c], frame[c, 1] - good[1, c], frame[c, 2] - good[2, c]
    x = y = z = 0.0
    for j in range(h.joints):
        x += frame[j, 0] - good[0, j]
        y += frame[j, 1] - good[1, j]
        z += frame[j, 2] - good[2, j]
    return x / h.joints, y / h.joints, z / h.joints


@compiled
def _lane_sum(values):
    """Sum in eight lanes: a fixed order that vectorises without fastmath."""
    a = b = c = d = e = f = g = k = 0.0
    for i in range(0, len(values), 8):
        a += values[i]
        b += values[i + 1]
        c += values[i + 2]
        d += values[i + 3]
        e += values[i + 4]
        f += values[i + 5]
        g += values[i + 6]
        k += values[i + 7]
    return ((a + e) + (c + g)) + ((b + f) + (d + k))


@compiled
def _is_position(joint):
    return abs(joint[0]) <= FARTHEST and abs(joint[1]) <= FARTHEST and abs(joint[2]) <= FARTHEST


@compiled
def _step_partial(h, seen, good, step, frame, time):
    """Step joint by joint, when one is missing, is back, or is too fast."""
    joints, gap = h.joints, h.max_gap
    moved = np.empty((3, joints))
    valid = np.zeros(joints, np.bool_)
    h.complete = 1
    for j in range(joints):
        was_there = h.time - seen[j] <= gap
        there = _is_position(frame[j])
        far = 0.0
        for axis in range(3):
            moved[axis, j] = frame[j, axis] - good[axis, j] if there and was_there else 0.0
            far += moved[axis, j] * moved[axis, j]
        if there and was_there and far > (h.max_speed * (time - seen[j])) ** 2:
            h.outliers += 1
            there = False
        if there:
            valid[j] = was_there
            seen[j] = time
            for axis in range(3):
                good[axis, j] = frame[j, axis]
            continue
        h.complete = 0
        for axis in range(3):
            moved[axis, j] = 0.0
        if was_there and time - seen[j] <= gap:
            valid[j] = True
            h.held += 1
    return _partial_sum(h, step, moved, valid)


@compiled
def _partial_sum(h, step, moved, valid):
    """Set the steps of the joints that count, and return their sum scaled to all joints."""
    joints = h.joints
    center = np.zeros(3)
    count = 0
    for j in range(joints):
        step[j] = 0.0
        count += 1 if valid[j] else 0
    if count == 0 or (h.center >= 0 and not valid[h.center]):
        return 0.0
    for axis in range(3):
        if h.center >= 0:
            center[axis] = moved[axis, h.center]
        else:
            for j in range(joints):
                center[axis] += moved[axis, j] / count if valid[j] else 0.0
    moving = 0
    for j in range(joints):
        if valid[j] and j != h.center:
            moving += 1
            x, y, z = moved[0, j] - center[0], moved[1, j] - center[1], moved[2, j] - center[2]
            step[j] = np.sqrt(x * x + y * y + z * z)
    return _lane_sum(step) * h.moving_joints / moving if moving > 0 else 0.0


@compiled
def filter_joints(h, seen, good, filtered, step, dt):
    """Pass the joints through a One-Euro filter and set the steps from the filtered positions.

    Casiez, Roussel and Vogel (2012): a low-pass filter whose cut-off rises with the speed of the joint, so that
    it is smooth at rest and quick in motion.

    Args:
        filtered: (6, lanes) m and m/s, position and its filtered derivative.
        dt: s since the last frame; 0 or less at the start of a take.

    Returns:
        Path summed over the joints, m.
    """
    before = filtered[:3].copy()
    for j in range(h.joints):
        if dt <= 0.0 or seen[j] - h.start_time <= 0.0:
            for axis in range(3):
                filtered[axis, j] = good[axis, j]
                filtered[3 + axis, j] = 0.0
            continue
        alpha = _smoothing(1.0, dt)
        speed = 0.0
        for axis in range(3):
            slope = (good[axis, j] - filtered[axis, j]) / dt
            filtered[3 + axis, j] += alpha * (slope - filtered[3 + axis, j])
            speed += filtered[3 + axis, j] ** 2
        alpha = _smoothing(h.one_euro_cutoff + h.one_euro_beta * np.sqrt(speed), dt)
        for axis in range(3):
            filtered[axis, j] += alpha * (good[axis, j] - filtered[axis, j])
    return _filtered_sum(h, filtered, before, step)


@compiled
def _smoothing(cutoff, dt):
    """Weight of a new sample for a cut-off frequency in Hz."""
    rate = 2.0 * np.pi * cutoff * dt
    return rate / (rate + 1.0)


@compiled
def _filtered_sum(h, filtered, before, step):
    center = np.zeros(3)
    for axis in range(3):
        if h.center >= 0:
            center[axis] = filtered[axis, h.center] - before[axis, h.center]
        else:
            for j in range(h.joints):
                center[axis] += (filtered[axis, j] - before[axis, j]) / h.joints
    for j in range(h.joints):
        far = 0.0
        for axis in range(3):
            far += (filtered[axis, j] - before[axis, j] - center[axis]) ** 2
        step[j] = np.sqrt(far)
    return _lane_sum(step)


def localise(positions: NDArray[np.float64], root: int) -> NDArray[np.float64]:
    """Return positions relative to the body centre (paper 3.1.1, localisation).

    Args:
        positions: (n, J, 3) m.
        root: Index of the root, -1 for the centroid.

    Returns:
        (n, J, 3) m.
    """
    center = positions[:, root : root + 1] if root >= 0 else positions.mean(axis=1, keepdims=True)
    return positions - center
