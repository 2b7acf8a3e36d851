"""Pose history: poses of the last seconds, thinned to about 30 Hz.

Speeds are taken over a tenth of a second, from these poses; and a key frame that moves to a likelier place takes
the poses between with it. Poses are kept as 16-bit multiples of 1/8192 m relative to the centre.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.simd import page_product
from mossar_stream.memory.joint_pages import (
    LIVE,
    LOG_SPEED,
    PAGE,
    PAGE_SIZE,
    POSE_X,
    mark_absent,
    page_of,
    place,
)

RATE = 30.0  # Hz
SPACING = 0.8 / RATE  # s; poses are kept at least this far apart
SPEED_WINDOW = 0.1  # s, over which speeds are taken
QUANTUM, PER_QUANTUM = np.float32(1.0 / 8192.0), np.float32(8192.0)  # m
FIRST_JOINT = np.int64(0)
NEWEST = np.int64(0)  # no kept pose is later than this one
MOST_QUANTA = np.float32(32767.0)
REST_SPEED = np.float32(0.1)  # m/s, added before the logarithm, so that rest is log 0.1
MARGIN = 1e-4  # s, for the rounding of timestamps
LOG_2 = np.float32(0.6931471805599453)
EXPONENT_SHIFT, ROOT_HALF = np.int32(23), np.int32(0x3F3504F3)  # of a float32; the bits of √½
ONE, TWO = np.float32(1.0), np.float32(2.0)
ODD = tuple(np.float32(1.0 / n) for n in (3, 5, 7))  # of the series of log((1 + z)/(1 - z))

MARK = np.dtype([("time", "f8"), ("frame", "i8"), ("weight", "f8")])  # s, number, s that the pose stands for
HISTORY = np.dtype(
    [
        ("head", "i8"),  # next place
        ("filled", "i8"),  # poses kept
        ("debt", "f8"),  # s, since the last pose that was kept
    ],
)


class PoseHistory(NamedTuple):
    """Poses of the last seconds, as the functions below need them: a ring."""

    state: np.void  # HISTORY
    marks: NDArray[np.void]  # (history_size,) MARK
    poses: NDArray[np.int16]  # (history_size, 3, padded_joints) 1/8192 m
    body: NDArray[np.float32]  # see joint_pages.py


def history_size(seconds: float) -> int:
    """Return how many poses cover `seconds`, with the speed window before them."""
    return int((seconds + SPEED_WINDOW + 2 * SPACING) / SPACING) + 4


@kernel
def start_history(state):
    """Begin without a pose."""
    state.head = 0
    state.filled = 0
    state.debt = 0.0


@inline_kernel
def keep_pose(history, body, frame, time, weight):
    """Keep the pose of the last used frame if one is due, and return the time it stands for.

    Args:
        history: PoseHistory.
        body: See joint_pages.py.
        frame: Number of the frame.
        time: s.
        weight: s since the frame before.

    Returns:
        s; 0 for a pose that is not kept, or the first one.
    """
    state, marks = history.state, history.marks
    state.debt += weight
    here = state.head
    last = here - 1 if here > 0 else len(marks) - 1
    if state.filled > 0 and time - marks[last].time < SPACING - MARGIN:
        return 0.0
    marks[here].time = time
    marks[here].frame = frame
    marks[here].weight = state.debt
    for first in range(0, history.poses.shape[2], PAGE):
        for axis in range(3):
            begin = first // PAGE * PAGE_SIZE + POSE_X + axis * PAGE
            _quantise(body[begin : begin + PAGE], history.poses[here, axis, first : first + PAGE])
    stood_for = state.debt
    state.debt = 0.0
    state.head = here + 1 if here + 1 < len(marks) else 0
    state.filled = min(state.filled + 1, len(marks))
    return stood_for


@inline_kernel
def _quantise(values, target):
    for j in range(len(target)):
        target[j] = np.int16(min(max(np.rint(values[j] * PER_QUANTUM), -MOST_QUANTA), MOST_QUANTA))


@inline_kernel
def follow_speeds(history, body, time, offset):
    """Set the log speeds of the joints in the body.

    Args:
        history: PoseHistory.
        body: See joint_pages.py.
        time: s, of this frame.
        offset: m/s, added before the logarithm.

    Returns:
        Sum of the squared speeds, (m/s)².
    """
    squares = measure_speeds(history, body, time, POSE_X, LOG_SPEED)
    joints = history.poses.shape[2]
    for first in range(0, joints, PAGE):
        page = page_of(body, first)
        _log_speeds(page[LOG_SPEED : LOG_SPEED + min(PAGE, joints - first)], offset)
        _leave_out(page)
    return squares


@inline_kernel
def measure_speeds(history, body, time, pose, speed):
    """Set the joints' speeds, m/s, in the body, and return the sum of their squares, (m/s)².

    Args:
        history: PoseHistory.
        body: See joint_pages.py.
        time: s, of this frame.
        pose: First of the three lines of a page where the pose stands.
        speed: Line where the speeds are to stand.
    """
    poses = history.poses
    past = _past_place(history, time, NEWEST)
    rate = _rate(history.marks, past, time)
    squares = 0.0
    for first in range(0, poses.shape[2], PAGE):
        page = page_of(body, first)
        target = page[speed : speed + min(PAGE, poses.shape[2] - first)]
        _speeds(_axes(page[pose:]), poses[past], first, rate, target)
        squares += page_product(page, speed, speed)
    return squares


@inline_kernel
def _leave_out(page):
    """Let the log speed be 0 where no joint counts."""
    for j in range(PAGE):
        page[j + LOG_SPEED] *= page[j + LIVE]


@inline_kernel
def _axes(pose):
    return pose, pose[PAGE:], pose[2 * PAGE :]


@inline_kernel
def _past_place(history, time, newest):
    """Return the place of the pose from which a speed is taken: that of about a tenth of a second ago, or -1.

    Args:
        history: PoseHistory.
        time: s, of the pose whose speeds are asked for.
        newest: How many kept poses are later than this one; 0 on the live end.
    """
    state, marks = history.state, history.marks
    past = -1
    for back in range(newest + 1, state.filled + 1):
        past = state.head - back
        past += len(marks) if past < 0 else 0
        if marks[past].time <= time - SPEED_WINDOW + MARGIN:
            break
    return past


@inline_kernel
def _rate(marks, past, time):
    """Return what turns a way since a kept pose into a speed, 1/s; 0 where there is none."""
    span = time - marks[past].time if past >= 0 else 0.0
    return np.float32(1.0 / span if span > MARGIN else 0.0)


@inline_kernel
def _speeds(axes, past, first, rate, speeds):
    """Set `speeds` to the joints' speeds, m/s."""
    x, y, z = axes
    a, b, c = past[0, first:], past[1, first:], past[2, first:]
    for j in range(len(speeds)):
        u = x[j] - np.float32(a[j]) * QUANTUM
        v = y[j] - np.float32(b[j]) * QUANTUM
        w = z[j] - np.float32(c[j]) * QUANTUM
        speeds[j] = np.sqrt(u * u + v * v + w * w) * rate


@inline_kernel
def _log_speeds(speeds, offset):
    """Turn speeds into log(speed + offset)."""
    for j in range(len(speeds)):
        speeds[j] += offset
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
def mark_at(history, time):
    """Return the place of the kept pose that lies nearest to a time, the later of two; -1 if none was kept."""
    state, marks = history.state, history.marks
    best, least = np.int64(-1), np.inf
    for back in range(state.filled):
        here = place_back(history, back)
        distance = abs(marks[here].time - time)
        if distance < least - MARGIN:
            best, least = here, distance
    return best


@inline_kernel
def place_back(history, back):
    """Return the place of the pose that was kept `back` poses before the newest."""
    here = history.state.head - 1 - back
    return here + len(history.marks) if here < 0 else here


@kernel
def load_pose(history, pose, back):
    """Set `pose` to a kept one, with its log speeds; x is NaN where a joint does not count.

    Args:
        history: PoseHistory.
        pose: (4, padded_joints), set.
        back: Which one, counted from the newest, 0.
    """
    here = place_back(history, back)
    for axis in range(3):
        for j in range(pose.shape[1]):
            pose[axis, j] = np.float32(history.poses[here, axis, j]) * QUANTUM
    time = history.marks[here].time
    past = _past_place(history, time, back + 1)
    rate = _rate(history.marks, past, time)
    _speeds((pose[0], pose[1], pose[2]), history.poses[past], FIRST_JOINT, rate, pose[3])
    _log_speeds(pose[3], REST_SPEED)
    mark_absent(history.body, pose)


@kernel
def keep_all_along(history, j):
    """Let a joint have been where it is now in all poses that are kept."""
    k = place(j)
    for axis in range(3):
        here = history.body[k + POSE_X + axis * PAGE : k + POSE_X + axis * PAGE + 1]
        for back in range(history.state.filled):
            _quantise(here, history.poses[place_back(history, back), axis, j : j + 1])
