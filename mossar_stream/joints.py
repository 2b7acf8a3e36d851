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
DERIVATIVE_CUTOFF = np.float64(1.0)  # Hz, of the speeds in the One-Euro filter


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
    if h.complete == 1:
        if time - h.time <= h.max_gap and _step_complete(h, good, step, frame, time):
            return lane_sum(step)
        for j in range(h.joints):
            seen[j] = h.time
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
def lane_sum(values):
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
    h.complete = 1
    cx = cy = cz = 0.0
    counted = 0
    for j in range(joints):
        lasted = time - seen[j]
        there = _is_position(frame[j])
        x = frame[j, 0] - good[0, j]
        y = frame[j, 1] - good[1, j]
        z = frame[j, 2] - good[2, j]
        reach = h.max_speed * lasted
        if there and lasted <= gap and x * x + y * y + z * z > reach * reach:
            h.outliers += 1
            there = False
        # In step: 1 moved, 0 held, -1 left out; the paths follow when the centre is known.
        step[j] = -1.0 if lasted > gap else (1.0 if there else 0.0)
        if step[j] > 0.0 and (h.center < 0 or j == h.center):
            cx += x
            cy += y
            cz += z
        counted += 1 if step[j] >= 0.0 else 0
        if not there:
            h.complete = 0
            h.held += 1 if lasted <= gap else 0
    if h.center < 0 and counted > 0:
        cx /= counted
        cy /= counted
        cz /= counted
    lost = counted == 0 or (h.center >= 0 and step[h.center] < 0.0)
    return _partial_sum(h, seen, good, step, frame, time, cx, cy, cz, lost)


@compiled
def _partial_sum(h, seen, good, step, frame, time, cx, cy, cz, lost):
    """Turn the marks in `step` into paths, keep the joints that are there, and return the scaled sum."""
    moving = 0
    for j in range(h.joints):
        mark = step[j]
        x = y = z = 0.0
        back = mark < 0.0 and _is_position(frame[j])
        if mark > 0.0:
            x, y, z = frame[j, 0] - good[0, j], frame[j, 1] - good[1, j], frame[j, 2] - good[2, j]
        if mark > 0.0 or back:
            seen[j] = time
            good[0, j], good[1, j], good[2, j] = frame[j, 0], frame[j, 1], frame[j, 2]
        step[j] = 0.0
        if mark >= 0.0 and j != h.center and not lost:
            moving += 1
            x, y, z = x - cx, y - cy, z - cz
            step[j] = np.sqrt(x * x + y * y + z * z)
    return lane_sum(step) * h.moving_joints / moving if moving > 0 else 0.0


@compiled
def filter_joints(h, good, filtered, step, dt):
    """Pass the joints through a One-Euro filter and set the steps from the filtered positions.

    Casiez, Roussel and Vogel (2012): a low-pass filter whose cut-off rises with the speed of the joint, so that
    it is smooth at rest and quick in motion.

    Args:
        h: Header of the row.
        good: (3, lanes) m, the joints.
        filtered: (6, lanes) m and m/s, filtered positions and derivatives.
        step: (lanes,) m, set to each joint's path since the last frame.
        dt: s since the last frame; 0 or less at the start of a take.

    Returns:
        Path summed over the joints, m.
    """
    for j in range(h.joints):
        speed = 0.0
        for axis in range(3):
            if dt <= 0.0:
                filtered[axis, j] = good[axis, j]
                filtered[3 + axis, j] = 0.0
                continue
            slope = (good[axis, j] - filtered[axis, j]) / dt
            filtered[3 + axis, j] += _smoothing(DERIVATIVE_CUTOFF, dt) * (slope - filtered[3 + axis, j])
            speed += filtered[3 + axis, j] ** 2
        step[j] = _smoothing(h.one_euro_cutoff + h.one_euro_beta * np.sqrt(speed), dt) if dt > 0.0 else 0.0
    return _filtered_sum(h, good, filtered, step)


@compiled
def _smoothing(cutoff, dt):
    """Weight of a new sample for a cut-off frequency in Hz."""
    rate = 2.0 * np.pi * cutoff * dt
    return rate / (rate + 1.0)


@compiled
def _filtered_sum(h, good, filtered, step):
    """Move the filtered positions by the weights in `step`, and turn these into paths."""
    cx = cy = cz = 0.0
    for j in range(h.joints):
        if h.center < 0 or j == h.center:
            cx += step[j] * (good[0, j] - filtered[0, j])
            cy += step[j] * (good[1, j] - filtered[1, j])
            cz += step[j] * (good[2, j] - filtered[2, j])
    share = 1.0 / h.joints if h.center < 0 else 1.0
    for j in range(h.joints):
        x = step[j] * (good[0, j] - filtered[0, j])
        y = step[j] * (good[1, j] - filtered[1, j])
        z = step[j] * (good[2, j] - filtered[2, j])
        filtered[0, j] += x
        filtered[1, j] += y
        filtered[2, j] += z
        x, y, z = x - cx * share, y - cy * share, z - cz * share
        step[j] = np.sqrt(x * x + y * y + z * z)
    return lane_sum(step)


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
