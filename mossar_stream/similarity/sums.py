"""Sums: of the positions and the log speeds of a segment's frames, and of their squares, for measures that compare variances.

Frames come one by one, and their features wait in the body, in single precision, until `flush_sums` adds them to a
summary. The parameters of such a measure have `start`, where the sums begin in a summary, and `dimensions`, their
number before their squares. `positions` and `speeds` are the numbers of each kind: 3 or 1 for each padded joint, or 0.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import kernel
from mossar_stream.memory.joint_pages import (
    LOG_SPEED,
    PADDING,
    PAGE,
    POSE_X,
    POSE_Y,
    POSE_Z,
    SQUARE_SPEED,
    SQUARE_X,
    SQUARE_Y,
    SQUARE_Z,
    STEP_BEFORE,
    SUM_PATH,
    SUM_SPEED,
    SUM_X,
    SUM_Y,
    SUM_Z,
    page_of,
)
from mossar_stream.similarity.summary import DURATION, FRAMES, MOVING_FRAMES, PATH

LOG_OF_2 = np.log(2.0)


def slot_size(params: NDArray[np.void]) -> int:
    """Return the length of a summary that ends with such sums, float64 numbers."""
    return -(-int(params["start"][0] + 2 * params["dimensions"][0]) // PADDING) * PADDING


@kernel
def add_features(summary, frame):
    """Add a frame to a summary; its positions, speeds and paths wait in the body for `flush_sums`.

    Args:
        summary: Of the segment so far.
        frame: `SummaryFrame`.
    """
    summary[FRAMES] += 1.0
    summary[MOVING_FRAMES] += frame.moving
    summary[DURATION] += frame.weight
    for first in range(0, frame.pose.shape[1], PAGE):
        _gather(page_of(frame.body, first), np.float32(frame.weight))


@kernel
def _gather(page, weight):
    """Add the features of a page's joints to the sums that wait."""
    for j in range(PAGE):
        x, y, z, speed = page[j + POSE_X], page[j + POSE_Y], page[j + POSE_Z], page[j + LOG_SPEED]
        page[j + SUM_X] += weight * x
        page[j + SUM_Y] += weight * y
        page[j + SUM_Z] += weight * z
        page[j + SUM_SPEED] += weight * speed
        page[j + SQUARE_X] += weight * x * x
        page[j + SQUARE_Y] += weight * y * y
        page[j + SQUARE_Z] += weight * z * z
        page[j + SQUARE_SPEED] += weight * speed * speed
        page[j + SUM_PATH] += page[j + STEP_BEFORE]


@kernel
def flush_sums(params, summary, body, padded_joints):
    """Add the sums that wait to a summary, and empty them."""
    for first in range(0, padded_joints, PAGE):
        page, count = page_of(body, first), min(PAGE, padded_joints - first)
        add_all(summary[PATH + first : PATH + first + count], page[SUM_PATH : SUM_PATH + PAGE])
        at = params.start + first
        for axis in range(4):
            if (axis < 3 and params.positions > 0) or (axis == 3 and params.speeds > 0):
                begin = SUM_X + axis * PAGE
                add_all(summary[at : at + count], page[begin : begin + PAGE])
                begin = SQUARE_X + axis * PAGE
                squares = at + params.dimensions
                add_all(summary[squares : squares + count], page[begin : begin + PAGE])
                at += padded_joints
        sums = page[SUM_X : SUM_PATH + PAGE]
        for i in range(len(sums)):
            sums[i] = 0.0


@kernel
def add_all(sums, others):
    """Add numbers to as many sums."""
    for j in range(len(sums)):
        sums[j] += others[j]


@kernel
def add_pose_sums(params, summary, pose, weight):
    """Add a pose alone, or take it out: to the duration and the sums, not to frames and paths.

    Args:
        params: Of the measure.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1); x is NaN where a joint does not count.
        weight: s that the pose stands for; negative to take it out.
    """
    summary[DURATION] += weight
    padded_joints = pose.shape[1]
    # Loops over slices: an index with an offset would be tested for its sign and not vectorise.
    sums = summary[params.start : params.start + params.dimensions]
    squares = summary[params.start + params.dimensions : params.start + 2 * params.dimensions]
    at = 0
    for axis in range(4):
        if (axis < 3 and params.positions > 0) or (axis == 3 and params.speeds > 0):
            own, square = sums[at : at + padded_joints], squares[at : at + padded_joints]
            _add_values(own, square, pose[axis], pose[0], weight)
            at += padded_joints


@kernel
def _add_values(sums, squares, values, counted, weight):
    for j in range(len(values)):
        value = values[j] if abs(counted[j]) < np.inf else np.float32(0.0)
        weighted = weight * value
        sums[j] += weighted
        squares[j] += weighted * value


@kernel
def add_resting_joint(params, summary, pose, j):
    """Let a joint have rest where it is for as long as a summary lasts.

    Args:
        params: Of the measure.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1).
        j: Which joint.
    """
    at = params.start
    for axis in range(4):
        if (axis < 3 and params.positions > 0) or (axis == 3 and params.speeds > 0):
            set_constant(params, summary, at + j, pose[axis, j])
            at += pose.shape[1]


@kernel
def set_constant(params, summary, d, value):
    """Let a dimension have had one value all along."""
    weighted = summary[DURATION] * value
    summary[d] = weighted
    summary[d + params.dimensions] = weighted * value
