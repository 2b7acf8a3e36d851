"""Localising: positions of the joints relative to the centre (paper 3.1.1), low-pass filtered if the measure needs it.

Where the sensor is noisy, the velocity is that of the filtered poses. It is needed before the frame's features are
set: the splitter decides on which side of a candidate the features of the frame before lie.
"""


cdef inline void localise(Joints* joints, float kept, float moved) noexcept nogil:
    """Set the positions relative to the centre; joints that do not count lie in it.

    Args:
        joints: Joints.
        kept: Weight of the last filtered pose; 0 is no filter.
        moved: Weight of the newest displacement in the filtered pose.
    """
    cdef (float, float, float) center
    cdef int64_t first
    cdef Plan* plan
    cdef Floats body, page
    plan = joints.plan
    body = joints.body
    center = center_of(plan, joints.state, body)
    for first from 0 <= first < plan.padded_joints by PAGE:
        page = page_of(body, first)
        _filter(page, center, (kept, moved), POSE_X)
        _keep_paths(page)


cdef double speed_to_come(Joints* joints, PoseHistory* history, (float, float) weights, double time) noexcept nogil:
    """Return the sum of the squared speeds of the joints, (m/s)², in the filtered pose that the frame will have.

    Args:
        joints: Joints.
        history: PoseHistory.
        weights: `kept` and `moved` of `localise`.
        time: s, of the frame.
    """
    cdef (float, float, float) center
    cdef int64_t first
    cdef Plan* plan
    cdef Floats body
    plan = joints.plan
    body = joints.body
    center = center_of(plan, joints.state, body)
    for first from 0 <= first < plan.padded_joints by PAGE:
        # The lines of smoothed displacements: there are none where poses are filtered.
        _filter(page_of(body, first), center, weights, SMOOTH_X)
    return measure_speeds(history, body, time, SMOOTH_X, WORK)


cdef inline void _filter(Floats page, (float, float, float) center, (float, float) weights, int64_t to) noexcept nogil:
    """Write the filtered pose, given the one of the frame before, to three lines of a page."""
    cdef float new, cx, cy, cz, kept, moved, x, y, z, live, step
    cdef int64_t j
    cx, cy, cz = center
    kept, moved = weights
    new = <float>1.0 - kept
    for j in range(PAGE):
        live, step = new * page.at[j + LIVE], moved * page.at[j + LIVE]
        x = kept * page.at[j + POSE_X] + (page.at[j + X] - cx) * live + page.at[j + MOVED_X] * step
        y = kept * page.at[j + POSE_Y] + (page.at[j + Y] - cy) * live + page.at[j + MOVED_Y] * step
        z = kept * page.at[j + POSE_Z] + (page.at[j + Z] - cz) * live + page.at[j + MOVED_Z] * step
        page.at[j + to], page.at[j + to + PAGE], page.at[j + to + 2 * PAGE] = x, y, z


cdef inline void _keep_paths(Floats page) noexcept nogil:
    cdef int64_t j
    for j in range(PAGE):
        page.at[j + STEP_BEFORE] = page.at[j + STEP]
