"""Trail: poses of the last seconds, thinned to about 30 Hz.

Speeds are taken over a tenth of a second, from the trail; and a key frame that moves to a likelier place takes
the poses between with it. Poses are kept as 16-bit multiples of 1/8192 m relative to the centre.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.joint_pages import LOG_SPEED, PAGE, PAGE_SIZE, POSE_X, page_of

RATE = 30.0  # Hz
SPACING = 0.8 / RATE  # s; poses are kept at least this far apart
SPEED_WINDOW = 0.1  # s
QUANTUM, PER_QUANTUM = np.float32(1.0 / 8192.0), np.float32(8192.0)  # m
FIRST = np.int64(0)  # joint
NEWEST = np.int64(0)  # no kept pose is later than this one
MOST = np.float32(32767.0)
SPEED_OFFSET = np.float32(0.1)  # m/s, added before the logarithm, so that rest is log 0.1
MARGIN = 1e-4  # s, for the rounding of timestamps
LOG_2 = np.float32(0.6931471805599453)
EXPONENT_SHIFT, ROOT_HALF = np.int32(23), np.int32(0x3F3504F3)  # of a float32; the bits of √½
ONE, TWO = np.float32(1.0), np.float32(2.0)
ODD = tuple(np.float32(1.0 / n) for n in (3, 5, 7))  # of the series of log((1 + z)/(1 - z))


def trail_size(seconds: float) -> int:
    """Return how many poses cover `seconds`, with the speed window before them."""
    return int((seconds + SPEED_WINDOW + 2 * SPACING) / SPACING) + 4


@inline_kernel
def keep_pose(h, body, marks, trail, weight):
    """Keep the pose of the last used frame if the trail is due for one, and return the time it stands for.

    Args:
        h: Header of the row.
        body: See joint_pages.py.
        marks: (trail,) MARK.
        trail: (trail, 3, lanes) 1/8192 m.
        weight: s since the frame before.

    Returns:
        s; 0 for a pose that is not kept, or the first one.
    """
    h.trail_debt += weight
    here = h.trail_head
    last = here - 1 if here > 0 else h.trail_size - 1
    if h.trail_filled > 0 and h.time - marks[last].time < SPACING:
        return 0.0
    marks[here].time = h.time
    marks[here].frame = h.used_frame
    marks[here].weight = h.trail_debt
    for first in range(0, h.lanes, PAGE):
        for axis in range(3):
            begin = first // PAGE * PAGE_SIZE + POSE_X + axis * PAGE
            _quantise(body[begin : begin + PAGE], trail[here, axis, first : first + PAGE])
    stood_for = h.trail_debt
    h.trail_debt = 0.0
    h.trail_head = here + 1 if here + 1 < h.trail_size else 0
    h.trail_filled = min(h.trail_filled + 1, h.trail_size)
    return stood_for


@inline_kernel
def _quantise(values, target):
    for j in range(len(target)):
        target[j] = np.int16(min(max(np.rint(values[j] * PER_QUANTUM), -MOST), MOST))


@inline_kernel
def follow_speeds(h, body, marks, trail, time):
    """Set the log speeds of the joints in the body.

    Args:
        h: Header of the row.
        body: See joint_pages.py.
        marks: (trail,) MARK.
        trail: (trail, 3, lanes) 1/8192 m.
        time: s, of this frame.
    """
    past = _past_place(h, marks, time, NEWEST)
    rate = _rate(marks, past, time)
    for first in range(0, h.lanes, PAGE):
        page = page_of(body, first)
        pose = page[POSE_X:]
        target = page[LOG_SPEED : LOG_SPEED + min(PAGE, h.lanes - first)]
        _log_speeds(pose, pose[PAGE:], pose[2 * PAGE :], trail[past], first, rate, target)


@inline_kernel
def _past_place(h, marks, time, newest):
    """Return the place in the trail of the pose from which a speed is taken: about a tenth of a second ago, or -1.

    Args:
        h: Header of the row.
        marks: (trail,) MARK.
        time: s, of the pose whose speeds are asked for.
        newest: How many kept poses are later than this one; 0 on the live end.
    """
    past = -1
    for back in range(newest + 1, h.trail_filled + 1):
        past = h.trail_head - back
        past += h.trail_size if past < 0 else 0
        if marks[past].time <= time - SPEED_WINDOW + MARGIN:
            break
    return past


@inline_kernel
def _rate(marks, past, time):
    """Return what turns a way since a kept pose into a speed, 1/s; 0 where there is none."""
    span = time - marks[past].time if past >= 0 else 0.0
    return np.float32(1.0 / span if span > MARGIN else 0.0)


@inline_kernel
def _log_speeds(x, y, z, past, first, rate, speeds):
    """Set `speeds` to log(speed + 0.1 m/s)."""
    a, b, c = past[0, first:], past[1, first:], past[2, first:]
    for j in range(len(speeds)):
        u = x[j] - np.float32(a[j]) * QUANTUM
        v = y[j] - np.float32(b[j]) * QUANTUM
        w = z[j] - np.float32(c[j]) * QUANTUM
        speeds[j] = np.sqrt(u * u + v * v + w * w) * rate + SPEED_OFFSET
    logarithm(speeds)


@inline_kernel
def logarithm(values):
    """Replace positive numbers by their natural logarithms, to 3e-7; unlike np.log this vectorises."""
    for i in range(len(values)):
        bits = np.float32(values[i]).view(np.int32)
        # From √½ to √2, where the series needs few terms.
        exponent = np.int32(np.int32(bits - ROOT_HALF) >> EXPONENT_SHIFT)
        mantissa = np.int32(bits - np.int32(exponent << EXPONENT_SHIFT)).view(np.float32)
        z = (mantissa - ONE) / (mantissa + ONE)
        q = z * z
        odd = ODD[0] + q * (ODD[1] + q * ODD[2])
        values[i] = np.float32(exponent) * LOG_2 + TWO * z * (ONE + q * odd)


@inline_kernel
def place_back(h, back):
    """Return the place in the trail of the pose that was kept `back` poses before the newest."""
    here = h.trail_head - 1 - back
    return here + h.trail_size if here < 0 else here


@kernel
def load_pose(h, marks, trail, pose, place):
    """Set `pose` to a kept one, with its log speeds; `place` counts back from the newest, 0."""
    here = place_back(h, place)
    for axis in range(3):
        for j in range(h.lanes):
            pose[axis, j] = np.float32(trail[here, axis, j]) * QUANTUM
    time = marks[here].time
    past = _past_place(h, marks, time, place + 1)
    _log_speeds(pose[0], pose[1], pose[2], trail[past], FIRST, _rate(marks, past, time), pose[3])
