"""Localising: where the joints are relative to the centre (paper 3.1.1), low-pass filtered where the measure asks for it.

Where the sensor is noisy, the velocity is that of the filtered poses. It is needed before the frame's features are
set: the splitter tells on which side of a candidate the features of the frame before lie.
"""

import numpy as np

from mossar_stream.algorithm.pose_history import measure_speeds
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
    STEP,
    STEP_BEFORE,
    WORK,
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
    center = center_of(plan, joints.state, body)
    for first in range(0, plan.padded_joints, PAGE):
        page = page_of(body, first)
        _filter(page, center, (kept, moved), POSE_X)
        _keep_paths(page)


@kernel
def speed_to_come(joints, history, weights, time):
    """Return the sum of the squared speeds of the joints, (m/s)², in the filtered pose that the frame will have.

    Args:
        joints: Joints.
        history: PoseHistory.
        weights: `kept` and `moved` of `localise`.
        time: s, of the frame.
    """
    plan, body = joints.plan, joints.body
    center = center_of(plan, joints.state, body)
    for first in range(0, plan.padded_joints, PAGE):
        # The lines of smoothed displacements: there are none where poses are filtered.
        _filter(page_of(body, first), center, weights, SMOOTH_X)
    return measure_speeds(history, body, time, SMOOTH_X, WORK)


@inline_kernel
def _filter(page, center, weights, to):
    """Write the filtered pose, given the one of the frame before, to three lines of a page."""
    cx, cy, cz = center
    kept, moved = weights
    new = ONE - kept
    for j in range(PAGE):
        live, step = new * page[j + LIVE], moved * page[j + LIVE]
        x = kept * page[j + POSE_X] + (page[j + X] - cx) * live + page[j + MOVED_X] * step
        y = kept * page[j + POSE_Y] + (page[j + Y] - cy) * live + page[j + MOVED_Y] * step
        z = kept * page[j + POSE_Z] + (page[j + Z] - cz) * live + page[j + MOVED_Z] * step
        page[j + to], page[j + to + PAGE], page[j + to + 2 * PAGE] = x, y, z


@inline_kernel
def _keep_paths(page):
    for j in range(PAGE):
        page[j + STEP_BEFORE] = page[j + STEP]
