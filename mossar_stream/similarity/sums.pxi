"""Sums of the positions and the log speeds of a segment's frames, and of their squares: for measures of variances.

Frames come one by one, and their features wait in the body, in single precision, until `flush_waiting` adds them to a
summary.
"""

cdef double LOG_OF_2 = 0.6931471805599453


cdef struct Sums:  # Places of the sums in a summary; the sums of squares follow in the same order.
    int64_t start
    int64_t dimensions  # padded; how many there are before their squares
    int64_t positions  # of them: 3 for each padded joint, or 0
    int64_t speeds  # 1 for each padded joint, or 0


cdef void add_features(Doubles summary, SummaryFrame* frame) noexcept nogil:
    """Add a frame to a segment's summary; its positions, speeds and paths wait in the body for `flush_waiting`."""
    cdef int64_t first = 0
    summary.at[FRAMES] += 1.0
    summary.at[MOVING_FRAMES] += frame.moving
    summary.at[DURATION] += frame.weight
    while first < frame.pose.columns:
        _gather(page_of(frame.body, first).at, <float>frame.weight)
        first += PAGE


cdef inline void _gather(float* page, float weight) noexcept nogil:
    """Add the features of a page's joints to the sums that wait."""
    cdef int64_t j
    cdef float x, y, z, speed
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


cdef void flush_waiting(Sums* sums, Doubles summary, Floats body, int64_t padded_joints) noexcept nogil:
    """Add the sums that wait to a summary, and empty them."""
    cdef int64_t count, axis, first = 0
    cdef float* page
    cdef double* own
    while first < padded_joints:
        page, count = page_of(body, first).at, min(PAGE, padded_joints - first)
        _add_line(summary.at + PATH + first, page + SUM_PATH, count)
        own = summary.at + sums.start + first
        for axis in range(4):
            if _has_axis(sums, axis):
                _add_line(own, page + SUM_X + axis * PAGE, count)
                _add_line(own + sums.dimensions, page + SQUARE_X + axis * PAGE, count)
                own += padded_joints
        memset(page + SUM_X, 0, (SUM_PATH + PAGE - SUM_X) * sizeof(float))
        first += PAGE


cdef inline bint _has_axis(Sums* sums, int64_t axis) noexcept nogil:
    """Return whether there are sums of x, y and z (0 to 2), or of log speeds (3)."""
    return sums.positions > 0 if axis < 3 else sums.speeds > 0


cdef inline void _add_line(double* sums, const float* line, int64_t count) noexcept nogil:
    cdef int64_t j
    for j in range(count):
        sums[j] += line[j]


cdef inline void add_all(double* sums, const double* others, int64_t count) noexcept nogil:
    """Add numbers to as many sums."""
    cdef int64_t j
    for j in range(count):
        sums[j] += others[j]


cdef void add_pose_sums(Sums* sums, Doubles summary, FloatRows pose, double weight) noexcept nogil:
    """Add a pose alone, or take it out: to the duration and the sums, not to frames and paths.

    Args:
        sums: Of the measure.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1); x is NaN where a joint does not count.
        weight: s that the pose stands for; negative to take it out.
    """
    cdef int64_t axis
    cdef double* own = summary.at + sums.start
    summary.at[DURATION] += weight
    for axis in range(4):
        if _has_axis(sums, axis):
            _add_values(own, own + sums.dimensions, row_of_floats(pose, axis), pose.at, weight)
            own += pose.columns


cdef inline void _add_values(
    double* sums, double* squares, Floats values, const float* counted, double weight
) noexcept nogil:
    """Add numbers and their squares, but not where `counted` is no number."""
    cdef int64_t j
    cdef float value
    cdef double weighted
    for j in range(values.count):
        value = values.at[j] if fabsf(counted[j]) < INFINITY else <float>0.0
        weighted = weight * value
        sums[j] += weighted
        squares[j] += weighted * value


cdef void add_resting_joint(Sums* sums, Doubles summary, FloatRows pose, int64_t j) noexcept nogil:
    """Add a joint to a summary as if it had rested at its present place all the time.

    Args:
        sums: Of the measure.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1).
        j: Index of the joint.
    """
    cdef int64_t axis, at = sums.start
    for axis in range(4):
        if _has_axis(sums, axis):
            set_constant(sums, summary, at + j, pose.at[axis * pose.columns + j])
            at += pose.columns


cdef inline void set_constant(Sums* sums, Doubles summary, int64_t d, float value) noexcept nogil:
    """Set a dimension to one value for the whole summary."""
    cdef double weighted = summary.at[DURATION] * value
    summary.at[d] = weighted
    summary.at[d + sums.dimensions] = weighted * value
