"""Localising: where the joints are relative to the centre (paper 3.1.1), low-pass filtered where evidence decides.

Where the sensor is noisy, the velocity is that of the filtered poses. It is needed before the frame's features are
set: the splitter tells on which side of a candidate the features of the frame before lie.
"""

import numpy as np

from mossar_stream.algorithm.pose_history import squared_speeds
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.joint_pages import (
    LIVE,
    MOVED_X,
    MOVED_Y,
    MOVED_Z,
    PAGE,
    POSE_X,
    POSE_Y,
    POSE_Z,
    SMOOTH_X,
    SMOOTH_Y,
    SMOOTH_Z,
    STEP,
    STEP_BEFORE,
    X,
    Y,
    Z,
    center_of,
    page_of,
)

ONE = np.float32(1.0)


@inline_kernel
def localise(joints, kept, moved):
    """Set the positions relative to the centre; joints that do not count lie in it.

    Args:
        joints: Joints.
        kept: What is left of the low-pass filtered pose; 0 is no filter.
        moved: Weight of the newest displacement in the filtered pose.
    """
    plan, body = joints.plan, joints.body
    cx, cy, cz = center_of(plan, joints.state, body)
    for first in range(0, plan.padded_joints, PAGE):
        page = page_of(body, first)
        _shift(page, cx, cy, cz, (kept, moved))
        _keep_paths(page)


@inline_kernel
def _shift(page, cx, cy, cz, weights):
    kept, moved = weights
    new = ONE - kept
    for j in range(PAGE):
        live, step = new * page[j + LIVE], moved * page[j + LIVE]
        page[j + POSE_X] = kept * page[j + POSE_X] + (page[j + X] - cx) * live + page[j + MOVED_X] * step
        page[j + POSE_Y] = kept * page[j + POSE_Y] + (page[j + Y] - cy) * live + page[j + MOVED_Y] * step
        page[j + POSE_Z] = kept * page[j + POSE_Z] + (page[j + Z] - cz) * live + page[j + MOVED_Z] * step


@inline_kernel
def _keep_paths(page):
    for j in range(PAGE):
        page[j + STEP_BEFORE] = page[j + STEP]


@kernel
def speed_to_come(joints, history, weights, time, window):
    """Return the sum of the squared speeds of the joints, (m/s)², in the filtered pose that the frame will have.

    Args:
        joints: Joints.
        history: PoseHistory.
        weights: `kept` and `moved` of `localise`.
        time: s, of the frame.
        window: s, over which the speeds are taken.
    """
    plan, body = joints.plan, joints.body
    cx, cy, cz = center_of(plan, joints.state, body)
    for first in range(0, plan.padded_joints, PAGE):
        _foresee(page_of(body, first), cx, cy, cz, weights)
    return squared_speeds(history, body, time, window)


@inline_kernel
def _foresee(page, cx, cy, cz, weights):
    """Write the pose that `_shift` will set where smoothed displacements are kept otherwise."""
    kept, moved = weights
    new = ONE - kept
    for j in range(PAGE):
        live, step = new * page[j + LIVE], moved * page[j + LIVE]
        page[j + SMOOTH_X] = kept * page[j + POSE_X] + (page[j + X] - cx) * live + page[j + MOVED_X] * step
        page[j + SMOOTH_Y] = kept * page[j + POSE_Y] + (page[j + Y] - cy) * live + page[j + MOVED_Y] * step
        page[j + SMOOTH_Z] = kept * page[j + POSE_Z] + (page[j + Z] - cz) * live + page[j + MOVED_Z] * step
