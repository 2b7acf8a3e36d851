"""Arrival: joints that are there for the first time in a take, or again.

Absent joints must not count. A joint therefore counts from here on as if it had rest where it is now, relative
to the centre, since the take began: in the means of the pose, in the poses that are kept, and in the summaries of the
segments. So neither its coming nor where it was before makes segments unlike.

One that was left out, and is back elsewhere, did not move there in this moment. To filters and speeds it has rested
where it is now; the summaries of the segments keep where it was.
"""

from mossar_stream.algorithm.joints import count_moving, counts
from mossar_stream.algorithm.one_euro import begin_filter
from mossar_stream.algorithm.open_segment import flush_waiting
from mossar_stream.algorithm.pose_history import keep_all_along
from mossar_stream.jit.decorators import kernel
from mossar_stream.memory.joint_pages import (
    LIVE,
    LOG_SPEED,
    MEAN_X,
    PAGE,
    POSE_X,
    REST_X,
    WORK,
    X,
    center_of,
    flatten,
    place,
)
from mossar_stream.similarity.protocol import add_joint, close
from mossar_stream.similarity.summary import DURATION


@kernel
def add_newcomers(joints, segment, history, filtered, rest):
    """Let the joints count that are there for the first time, before the features of the frame are set.

    Args:
        joints: Joints.
        segment: OpenSegment.
        history: PoseHistory.
        filtered: (6, filtered_joints) m and m/s, see one_euro.py.
        rest: Log speed of a performer at rest.
    """
    plan, body = joints.plan, joints.body
    joints.state.arrived = 0
    flush_waiting(segment)
    _let_count(joints, filtered)
    center = center_of(plan, joints.state, body)
    for j in range(plan.joints):
        if body[place(j) + WORK] > 0.0:
            _set_features(body, place(j), center, rest)
            keep_all_along(history, j)
    flatten(body, segment.pose)
    for slot in range(len(segment.summaries)):
        summary = segment.summaries[slot]
        for j in range(plan.joints):
            if body[place(j) + WORK] > 0.0:
                add_joint(segment.params, summary, segment.pose, plan.joints, j)
        if summary[DURATION] > 0.0:
            close(segment.params, summary)


@kernel
def resume(joints, history, filtered):
    """Let the joints that are back rest where they are, before anything is filtered.

    Args:
        joints: Joints; WORK is 1 for those that are back.
        history: PoseHistory.
        filtered: (6, filtered_joints) m and m/s, see one_euro.py.
    """
    plan, body = joints.plan, joints.body
    joints.state.returned = 0
    all_moved = plan.center >= 0 and body[place(plan.center) + WORK] > 0.0
    center = center_of(plan, joints.state, body)
    for j in range(plan.joints):
        k = place(j)
        if body[k + WORK] > 0.0 and plan.filtered_joints > 0:
            begin_filter(body, filtered, j)
        if plan.is_filtered == 1 and body[k + LIVE] > 0.0 and (all_moved or body[k + WORK] > 0.0):
            for axis in range(3):
                body[k + POSE_X + axis * PAGE] = body[k + X + axis * PAGE] - center[axis]
            keep_all_along(history, j)


@kernel
def _let_count(joints, filtered):
    """Let those who arrive count, which WORK says of each joint from here on; the centroid stays where it was."""
    plan, body, state = joints.plan, joints.body, joints.state
    x, y, z = center_of(plan, state, body)
    anybody = 0.0
    for j in range(plan.joints):
        k = place(j)
        anybody += body[k + LIVE]
        arrives = body[k + LIVE] == 0.0 and counts(joints, j)
        body[k + WORK] = 1.0 if arrives else 0.0
        if arrives and plan.filtered_joints > 0:
            begin_filter(body, filtered, j)
    for j in range(plan.joints):
        body[place(j) + LIVE] += body[place(j) + WORK]
    count_moving(joints)
    if plan.center < 0 and anybody > 0.0:
        u, v, w = center_of(plan, state, body)
        state.offset_x += x - u
        state.offset_y += y - v
        state.offset_z += z - w


@kernel
def _set_features(body, k, center, rest):
    """Set the features, and the means of the pose, of a joint that rests where it is."""
    for axis in range(3):
        at = body[k + X + axis * PAGE] - center[axis]
        body[k + POSE_X + axis * PAGE] = at
        body[k + MEAN_X + axis * PAGE] = at
        body[k + REST_X + axis * PAGE] = at
    body[k + LOG_SPEED] = rest
