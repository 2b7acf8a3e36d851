"""Trail: poses of the last seconds, thinned to about 30 Hz.

Speeds are taken over a tenth of a second, from the trail; and a key frame that moves to a likelier place takes
the poses between with it. Poses are kept as 16-bit multiples of 1/8192 m relative to the centre.
"""

import numpy as np

from mossar_stream.compiled import compiled

RATE = 30.0  # Hz
SPACING = 0.8 / RATE  # s; poses are kept at least this far apart
SPEED_WINDOW = 0.1  # s
QUANTUM = 1.0 / 8192.0  # m
MOST = 32767.0
SPEED_OFFSET = 0.1  # m/s, added before the logarithm, so that rest is log 0.1
MARGIN = 1e-4  # s, for the rounding of timestamps
LOG_2 = 0.6931471805599453
EXPONENT_SHIFT, EXPONENT_BIAS = np.int64(52), np.int64(1023)  # of a float64
MANTISSA, ONE = np.int64(0x000FFFFFFFFFFFFF), np.int64(0x3FF0000000000000)


def trail_size(seconds: float) -> int:
    """Return how many poses cover `seconds`, with the speed window before them."""
    return int((seconds + SPEED_WINDOW + 2 * SPACING) / SPACING) + 4


@compiled
def keep_pose(h, marks, trail, pose, weight):
    """Keep the pose of the last used frame if the trail is due for one.

    Args:
        h: Header of the row.
        marks: (trail,) MARK.
        trail: (trail, 3, lanes) 1/8192 m.
        pose: (4, lanes) m relative to the centre.
        weight: s since the frame before.
    """
    h.trail_debt += weight
    here = h.trail_head
    last = here - 1 if here > 0 else h.trail_size - 1
    if h.trail_filled > 0 and h.time - marks[last].time < SPACING:
        return
    marks[here].time = h.time
    marks[here].frame = h.used_frame
    marks[here].weight = h.trail_debt
    for axis in range(3):
        for j in range(h.lanes):
            trail[here, axis, j] = np.int16(min(max(np.rint(pose[axis, j] / QUANTUM), -MOST), MOST))
    h.trail_debt = 0.0
    h.trail_head = here + 1 if here + 1 < h.trail_size else 0
    h.trail_filled = min(h.trail_filled + 1, h.trail_size)


@compiled
def set_log_speeds(h, marks, trail, pose, speeds, time, newest):
    """Set `speeds` to log(speed + 0.1 m/s), the speed being the way since about a tenth of a second ago.

    Args:
        h: Header of the row.
        marks: (trail,) MARK.
        trail: (trail, 3, lanes) 1/8192 m.
        pose: (4, lanes) m, the positions now.
        speeds: (lanes,), which may be a part of `pose`.
        time: s, of the pose.
        newest: How many kept poses are later than this one; 0 on the live end.
    """
    past = -1
    for back in range(newest + 1, h.trail_filled + 1):
        past = h.trail_head - back
        past += h.trail_size if past < 0 else 0
        if marks[past].time <= time - SPEED_WINDOW + MARGIN:
            break
    span = time - marks[past].time if past >= 0 else 0.0
    per_second = 1.0 / span if span > MARGIN else 0.0
    for j in range(h.lanes):
        x = pose[0, j] - trail[past, 0, j] * QUANTUM
        y = pose[1, j] - trail[past, 1, j] * QUANTUM
        z = pose[2, j] - trail[past, 2, j] * QUANTUM
        speeds[j] = np.sqrt(x * x + y * y + z * z) * per_second + SPEED_OFFSET
    logarithm(speeds)


@compiled
def logarithm(values):
    """Replace positive numbers by their natural logarithms, to 1e-10; unlike np.log this vectorises."""
    for i in range(len(values)):
        bits = np.float64(values[i]).view(np.int64)
        exponent = (bits >> EXPONENT_SHIFT) - EXPONENT_BIAS
        mantissa = np.int64((bits & MANTISSA) | ONE).view(np.float64)
        z = (mantissa - 1.0) / (mantissa + 1.0)
        q = z * z
        odd = 1.0 / 11.0 + q * (1.0 / 13.0 + q * (1.0 / 15.0 + q / 17.0))
        odd = 1.0 / 5.0 + q * (1.0 / 7.0 + q * (1.0 / 9.0 + q * odd))
        values[i] = exponent * LOG_2 + 2.0 * z * (1.0 + q * (1.0 / 3.0 + q * odd))


@compiled
def load_pose(h, marks, trail, pose, place):
    """Set `pose` to a kept one, with its log speeds; `place` counts back from the newest, 0."""
    here = (h.trail_head - 1 - place) % h.trail_size
    for axis in range(3):
        for j in range(h.lanes):
            pose[axis, j] = trail[here, axis, j] * QUANTUM
    set_log_speeds(h, marks, trail, pose, pose[3], marks[here].time, place + 1)
