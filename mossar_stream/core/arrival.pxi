"""Arrival: joints that are there for the first time in a take, or again.

Absent joints must not count. A new joint therefore counts as if it had rested at its present place, relative to the
centre, since the take began: in the means of the pose, in the poses that are kept, and in the summaries of the
segments. Then neither its arrival nor its earlier place makes segments unlike.

A joint that was left out and is back elsewhere did not move there in this moment. For filters and speeds it has rested
at the new place; the summaries of the segments keep the old one.
"""


cdef void add_newcomers(
    Joints* joints, OpenSegment* segment, PoseHistory* history, DoubleRows filtered, float rest
) noexcept nogil:
    """Include the joints that are there for the first time, before the features of the frame are set.

    Args:
        joints: Joints.
        segment: OpenSegment.
        history: PoseHistory.
        filtered: (6, filtered_joints) m and m/s, see one_euro.pxi.
        rest: Log speed of a performer at rest.
    """
    cdef (float, float, float) center
    cdef int64_t j, slot
    cdef Plan* plan
    cdef Floats body
    cdef Doubles summary
    plan = joints.plan
    body = joints.body
    joints.state.arrived = 0
    add_waiting_frames(segment)
    _let_count(joints, filtered)
    center = center_of(plan, joints.state, body)
    for j in range(plan.joints):
        if body.at[place(j) + WORK] > 0.0:
            _set_features(body, place(j), center, rest)
            keep_all_along(history, j)
    flatten(body, segment.pose)
    for slot in range(segment.summaries.rows):
        summary = row_of_doubles(segment.summaries, slot)
        for j in range(plan.joints):
            if body.at[place(j) + WORK] > 0.0:
                add_joint(segment.params, summary, segment.pose, plan.joints, j)
        if summary.at[DURATION] > 0.0:
            close(segment.params, summary)


cdef void resume(Joints* joints, PoseHistory* history, DoubleRows filtered) noexcept nogil:
    """Set the joints that are back to rest where they are, before anything is filtered.

    Args:
        joints: Joints; WORK is 1 for those that are back.
        history: PoseHistory.
        filtered: (6, filtered_joints) m and m/s, see one_euro.pxi.
    """
    cdef bint all_moved
    cdef (float, float, float) center
    cdef int64_t j, k, axis
    cdef Plan* plan
    cdef Floats body
    plan = joints.plan
    body = joints.body
    joints.state.returned = 0
    all_moved = plan.center >= 0 and body.at[place(plan.center) + WORK] > 0.0
    center = center_of(plan, joints.state, body)
    for j in range(plan.joints):
        k = place(j)
        if body.at[k + WORK] > 0.0 and plan.filtered_joints > 0:
            begin_filter(body, filtered, j)
        if plan.is_filtered == 1 and body.at[k + LIVE] > 0.0 and (all_moved or body.at[k + WORK] > 0.0):
            for axis in range(3):
                body.at[k + POSE_X + axis * PAGE] = body.at[k + X + axis * PAGE] - along(center, axis)
            keep_all_along(history, j)


cdef void _let_count(Joints* joints, DoubleRows filtered) noexcept nogil:
    """Include the joints that arrive and mark them in WORK; the centroid stays where it was."""
    cdef double anybody
    cdef int64_t j, k
    cdef Plan* plan
    cdef Floats body
    cdef JointsState* state
    cdef float x, y, z, u, v, w
    cdef bint arrives
    plan = joints.plan
    body = joints.body
    state = joints.state
    x, y, z = center_of(plan, state, body)
    anybody = 0.0
    for j in range(plan.joints):
        k = place(j)
        anybody += body.at[k + LIVE]
        arrives = body.at[k + LIVE] == 0.0 and counts(joints, j)
        body.at[k + WORK] = 1.0 if arrives else 0.0
        if arrives and plan.filtered_joints > 0:
            begin_filter(body, filtered, j)
    for j in range(plan.joints):
        body.at[place(j) + LIVE] += body.at[place(j) + WORK]
    count_moving(joints)
    if plan.center < 0 and anybody > 0.0:
        u, v, w = center_of(plan, state, body)
        state.offset_x += x - u
        state.offset_y += y - v
        state.offset_z += z - w


cdef void _set_features(Floats body, int64_t k, (float, float, float) center, float rest) noexcept nogil:
    """Set the features, and the means of the pose, of a joint that rests where it is."""
    cdef int64_t axis
    cdef float at
    for axis in range(3):
        at = body.at[k + X + axis * PAGE] - along(center, axis)
        body.at[k + POSE_X + axis * PAGE] = at
        body.at[k + MEAN_X + axis * PAGE] = at
        body.at[k + REST_X + axis * PAGE] = at
    body.at[k + LOG_SPEED] = rest
