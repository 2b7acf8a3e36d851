"""One-Euro filter: smooths each joint before its path is measured, for sources with jitter.

Casiez, Roussel and Vogel (2012): a low-pass filter whose cut-off rises with the speed of the joint, so that it is
smooth at rest and quick in motion.
"""

import numpy as np

from mossar_stream.jit.decorators import kernel
from mossar_stream.memory.joint_pages import (
    GOOD_X,
    LIVE,
    MOVED_X,
    MOVED_Y,
    MOVED_Z,
    STEP,
    X,
    Y,
    Z,
    line_sum,
    place,
)

DERIVATIVE_CUTOFF = np.float64(1.0)  # Hz, of the speeds


@kernel
def filter_joints(plan, body, filtered, dt):
    """Pass the joints through the filter and set displacements and steps from the filtered positions.

    Args:
        plan: PLAN.
        body: Where the joints are, which the filter moves; displacements and their lengths are set.
        filtered: (6, padded_joints) m and m/s, filtered positions and derivatives.
        dt: s since the last frame; 0 or less at the start of a take.

    Returns:
        Path summed over the joints, m.
    """
    for j in range(plan.joints):
        speed = 0.0
        for axis in range(3):
            now = np.float64(body[place(j) + axis * Y])
            if dt <= 0.0:
                filtered[axis, j] = now
                filtered[3 + axis, j] = 0.0
                continue
            slope = (now - filtered[axis, j]) / dt
            filtered[3 + axis, j] += _smoothing(DERIVATIVE_CUTOFF, dt) * (slope - filtered[3 + axis, j])
            speed += filtered[3 + axis, j] ** 2
        body[place(j) + STEP] = (
            _smoothing(plan.one_euro_cutoff + plan.one_euro_beta * np.sqrt(speed), dt) if dt > 0.0 else 0.0
        )
    return _filtered_sum(plan, body, filtered)


@kernel
def _smoothing(cutoff, dt):
    """Weight of a new sample for a cut-off frequency in Hz."""
    rate = 2.0 * np.pi * cutoff * dt
    return rate / (rate + 1.0)


@kernel
def _step_of(body, filtered, j):
    """Return how far the filter moves a joint."""
    k = place(j)
    weight = body[k + STEP]
    return (
        weight * (body[k + X] - filtered[0, j]),
        weight * (body[k + Y] - filtered[1, j]),
        weight * (body[k + Z] - filtered[2, j]),
    )


@kernel
def _filtered_sum(plan, body, filtered):
    """Move the filtered positions by the weights in STEP, and turn these into paths."""
    cx = cy = cz = live = 0.0
    for j in range(plan.joints):
        if (plan.center < 0 or j == plan.center) and body[place(j) + LIVE] > 0.0:
            x, y, z = _step_of(body, filtered, j)
            cx, cy, cz, live = cx + x, cy + y, cz + z, live + 1.0
    share = 1.0 / max(live, 1.0)
    for j in range(plan.joints):
        x, y, z = _step_of(body, filtered, j)
        filtered[0, j] += x
        filtered[1, j] += y
        filtered[2, j] += z
        k = place(j)
        body[k + X], body[k + Y], body[k + Z] = filtered[0, j], filtered[1, j], filtered[2, j]
        x, y, z = x - cx * share, y - cy * share, z - cz * share
        if body[k + LIVE] == 0.0:
            x = y = z = 0.0
        body[k + MOVED_X], body[k + MOVED_Y], body[k + MOVED_Z] = x, y, z
        body[k + STEP] = np.sqrt(x * x + y * y + z * z)
    return line_sum(body, STEP)


@kernel
def begin_filter(body, filtered, j):
    """Let the filter begin anew for a joint, where it is."""
    k = place(j)
    for axis in range(3):
        filtered[axis, j] = body[k + X + axis * Y] = body[k + GOOD_X + axis * Y]
        filtered[3 + axis, j] = 0.0
