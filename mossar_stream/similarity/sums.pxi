"""Sums: of the positions and the log speeds of a segment's frames, and of their squares, for measures that compare variances.

Frames come one by one, and their features wait in the body, in single precision, until `flush_sums` adds them to a
summary. The parameters of such a measure have `start`, where the sums begin in a summary, and `dimensions`, their
number before their squares. `positions` and `speeds` are the numbers of each kind: 3 or 1 for each padded joint, or 0.
"""

cdef double LOG_OF_2 = 0.6931471805599453


cdef void add_features(Doubles summary, SummaryFrame* frame) noexcept nogil:
    """Add a frame to a summary; its positions, speeds and paths wait in the body for `flush_sums`.

    Args:
        summary: Of the segment so far.
        frame: `SummaryFrame`.
    """
    cdef int64_t first
    # CHECK call of page_of: page_of(frame.body, first)
    summary.at[FRAMES] += 1.0
    summary.at[MOVING_FRAMES] += frame.moving
    summary.at[DURATION] += frame.weight
    for first in range(0, frame.pose.columns, PAGE):
        _sums_gather(page_of(frame.body, first), <float>frame.weight)


cdef void _sums_gather(Floats page, float weight) noexcept nogil:
    """Add the features of a page's joints to the sums that wait."""
    cdef int64_t j
    cdef float x, y, z, speed
    for j in range(PAGE):
        x, y, z, speed = page.at[j + POSE_X], page.at[j + POSE_Y], page.at[j + POSE_Z], page.at[j + LOG_SPEED]
        page.at[j + SUM_X] += weight * x
        page.at[j + SUM_Y] += weight * y
        page.at[j + SUM_Z] += weight * z
        page.at[j + SUM_SPEED] += weight * speed
        page.at[j + SQUARE_X] += weight * x * x
        page.at[j + SQUARE_Y] += weight * y * y
        page.at[j + SQUARE_Z] += weight * z * z
        page.at[j + SQUARE_SPEED] += weight * speed * speed
        page.at[j + SUM_PATH] += page.at[j + STEP_BEFORE]


cdef void sums_flush_sums(Evidence* params, Doubles summary, Floats body, int64_t padded_joints) noexcept nogil:
    """Add the sums that wait to a summary, and empty them."""
    cdef int64_t first, at, axis, i, count, begin, squares
    cdef Floats sums, page
    # CHECK call of page_of: page_of(body, first)
    # CHECK add_all is called with several kinds of arguments
    for first in range(0, padded_joints, PAGE):
        page = page_of(body, first)
        count = min(PAGE, padded_joints - first)
        add_all(part_of_doubles(summary, PATH + first, PATH + first + count), part_of_floats(page, SUM_PATH, SUM_PATH + PAGE))
        at = params.start + first
        for axis in range(4):
            if axis < 3 and params.positions > 0 or axis == 3 and params.speeds > 0:
                begin = SUM_X + axis * PAGE
                add_all(part_of_doubles(summary, at, at + count), part_of_floats(page, begin, begin + PAGE))
                begin = SQUARE_X + axis * PAGE
                squares = at + params.dimensions
                add_all(part_of_doubles(summary, squares, squares + count), part_of_floats(page, begin, begin + PAGE))
                at += padded_joints
        sums = part_of_floats(page, SUM_X, SUM_PATH + PAGE)
        for i in range(sums.count):
            sums.at[i] = 0.0


cdef void add_all(Doubles sums, Doubles others) noexcept nogil:
    """Add numbers to as many sums."""
    cdef int64_t j
    for j in range(sums.count):
        sums.at[j] += others.at[j]


cdef void add_pose_sums(Evidence* params, Doubles summary, FloatRows pose, double weight) noexcept nogil:
    """Add a pose alone, or take it out: to the duration and the sums, not to frames and paths.

    Args:
        params: Of the measure.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1); x is NaN where a joint does not count.
        weight: s that the pose stands for; negative to take it out.
    """
    cdef int64_t padded_joints, at, axis
    cdef Doubles sums, squares, own, square
    summary.at[DURATION] += weight
    padded_joints = pose.columns
    # Loops over slices: an index with an offset would be tested for its sign and not vectorise.
    sums = part_of_doubles(summary, params.start, params.start + params.dimensions)
    squares = part_of_doubles(summary, params.start + params.dimensions, params.start + 2 * params.dimensions)
    at = 0
    for axis in range(4):
        if axis < 3 and params.positions > 0 or axis == 3 and params.speeds > 0:
            own = part_of_doubles(sums, at, at + padded_joints)
            square = part_of_doubles(squares, at, at + padded_joints)
            _add_values(own, square, row_of_floats(pose, axis), row_of_floats(pose, 0), weight)
            at += padded_joints


cdef void _add_values(Doubles sums, Doubles squares, Floats values, Floats counted, double weight) noexcept nogil:
    cdef int64_t j
    cdef float value
    cdef double weighted
    for j in range(values.count):
        value = values.at[j] if abs(counted.at[j]) < INFINITY else <float>0.0
        weighted = weight * value
        sums.at[j] += weighted
        squares.at[j] += weighted * value


cdef void add_resting_joint(Evidence* params, Doubles summary, FloatRows pose, int64_t j) noexcept nogil:
    """Let a joint have rest where it is for as long as a summary lasts.

    Args:
        params: Of the measure.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1).
        j: Which joint.
    """
    cdef int64_t at, axis
    at = params.start
    for axis in range(4):
        if axis < 3 and params.positions > 0 or axis == 3 and params.speeds > 0:
            set_constant(params, summary, at + j, pose.at[axis * pose.columns + j])
            at += pose.columns


cdef void set_constant(Evidence* params, Doubles summary, int64_t d, float value) noexcept nogil:
    """Let a dimension have had one value all along."""
    cdef double weighted
    weighted = summary.at[DURATION] * value
    summary.at[d] = weighted
    summary.at[d + params.dimensions] = weighted * value
