"""Pose history: poses of the last seconds, thinned to about 30 Hz.

Speeds are measured from these poses over a tenth of a second. A key frame that moves to a likelier place takes the
poses in between with it. Poses are kept as 16-bit multiples of 1/8192 m relative to the centre.
"""

cdef double RATE = 30.0  # Hz
cdef double SPACING = 0.8 / RATE  # s; poses are kept at least this far apart
cdef double SPEED_WINDOW = 0.1  # s, over which speeds are taken
cdef float QUANTUM = 1.0 / 8192.0  # m
cdef float PER_QUANTUM = 8192.0
cdef float REST_SPEED = 0.1  # m/s, added before the logarithm, so that rest is log 0.1
cdef double MARGIN = 0.0001  # s, for the rounding of timestamps
cdef float LOG_2 = 0.6931471805599453
cdef enum:
    EXPONENT_SHIFT = 23  # of a float32
    ROOT_HALF = 0x3F3504F3  # the bits of √½
cdef float THIRD = 1.0 / 3.0, FIFTH = 1.0 / 5.0, SEVENTH = 1.0 / 7.0  # of the series of log((1 + z)/(1 - z))

cdef struct Mark:
    double time  # s
    int64_t frame  # its number
    double weight  # s that the pose stands for


cdef struct MarkSpan:
    Mark* at
    int64_t count


cdef struct History:
    int64_t head  # next place
    int64_t filled  # poses kept
    double debt  # s, since the last pose that was kept


cdef struct PoseHistory:  # Poses of the last seconds, as the functions below need them: a ring.
    History* state  # HISTORY
    MarkSpan marks  # (history_size,) MARK
    ShortPlanes poses  # (history_size, 3, padded_joints) 1/8192 m
    Floats body  # see joint_pages.pxi


cdef void start_history(History* state) noexcept nogil:
    """Begin without a pose."""
    state.head = 0
    state.filled = 0
    state.debt = 0.0


cdef inline double keep_pose(
    PoseHistory* history, Floats body, int64_t frame, double time, double weight
) noexcept nogil:
    """Keep the pose of the last used frame if one is due, and return the time it stands for.

    Args:
        history: PoseHistory.
        body: See joint_pages.pxi.
        frame: Number of the frame.
        time: s.
        weight: s since the frame before.

    Returns:
        s; 0 for a pose that is not kept, or the first one.
    """
    cdef int64_t here, last, first, axis
    cdef double stood_for
    cdef Shorts target
    cdef History* state
    cdef MarkSpan marks
    state = history.state
    marks = history.marks
    state.debt += weight
    here = state.head
    last = here - 1 if here > 0 else marks.count - 1
    if state.filled > 0 and time - marks.at[last].time < SPACING - MARGIN:
        return 0.0
    marks.at[here].time = time
    marks.at[here].frame = frame
    marks.at[here].weight = state.debt
    for first from 0 <= first < history.poses.columns by PAGE:
        for axis in range(3):
            target = part_of_shorts(row_of_shorts(plane_of_shorts(history.poses, here), axis), first, first + PAGE)
            quantise(page_of(body, first).at + POSE_X + axis * PAGE, target.at, target.count, PER_QUANTUM)
    stood_for = state.debt
    state.debt = 0.0
    state.head = here + 1 if here + 1 < marks.count else 0
    state.filled = min(state.filled + 1, marks.count)
    return stood_for


cdef inline double follow_speeds(PoseHistory* history, Floats body, double time, float offset) noexcept nogil:
    """Set the log speeds of the joints in the body.

    Args:
        history: PoseHistory.
        body: See joint_pages.pxi.
        time: s, of this frame.
        offset: m/s, added before the logarithm.

    Returns:
        Sum of the squared speeds, (m/s)².
    """
    cdef double squares
    cdef int64_t joints, first
    cdef Floats page
    squares = measure_speeds(history, body, time, POSE_X, LOG_SPEED)
    joints = history.poses.columns
    for first from 0 <= first < joints by PAGE:
        page = page_of(body, first)
        _log_speeds(part_of_floats(page, LOG_SPEED, LOG_SPEED + min(PAGE, joints - first)), offset)
        _leave_out(page)
    return squares


cdef inline double measure_speeds(
    PoseHistory* history, Floats body, double time, int64_t pose, int64_t speed
) noexcept nogil:
    """Set the joints' speeds, m/s, in the body, and return the sum of their squares, (m/s)².

    Args:
        history: PoseHistory.
        body: See joint_pages.pxi.
        time: s, of this frame.
        pose: First of the three lines of a page where the pose stands.
        speed: Line where the speeds are to stand.
    """
    cdef ShortPlanes poses
    cdef int64_t past, first
    cdef float rate
    cdef double squares
    cdef Floats page, target
    poses = history.poses
    past = _past_place(history, time, 0)
    rate = _rate(history.marks, past, time)
    squares = 0.0
    for first from 0 <= first < poses.columns by PAGE:
        page = page_of(body, first)
        target = part_of_floats(page, speed, speed + min(PAGE, poses.columns - first))
        _speeds(_axes(from_floats(page, pose)), plane_of_shorts(poses, max(past, 0)), first, rate, target)
        squares += page_product(page.at, speed, speed)
    return squares


cdef inline void _leave_out(Floats page) noexcept nogil:
    """Set the log speed to 0 where no joint counts."""
    cdef int64_t j
    for j in range(PAGE):
        page.at[j + LOG_SPEED] *= page.at[j + LIVE]


cdef inline (Floats, Floats, Floats) _axes(Floats pose) noexcept nogil:
    return (pose, from_floats(pose, PAGE), from_floats(pose, 2 * PAGE))


cdef inline int64_t _past_place(PoseHistory* history, double time, int64_t newest) noexcept nogil:
    """Return the place of the pose from which a speed is taken: that of about a tenth of a second ago, or -1.

    Args:
        history: PoseHistory.
        time: s, of the pose whose speeds are wanted.
        newest: How many kept poses are later than this one; 0 on the live end.
    """
    cdef int64_t past, back
    cdef History* state
    cdef MarkSpan marks
    state = history.state
    marks = history.marks
    past = -1
    for back in range(newest + 1, state.filled + 1):
        past = state.head - back
        past += marks.count if past < 0 else 0
        if marks.at[past].time <= time - SPEED_WINDOW + MARGIN:
            break
    return past


cdef inline float _rate(MarkSpan marks, int64_t past, double time) noexcept nogil:
    """Return the factor from a way since a kept pose to a speed, 1/s; 0 without such a pose, when `past` is -1."""
    cdef double span
    span = time - marks.at[past].time if past >= 0 else 0.0
    return <float>(1.0 / span if span > MARGIN else 0.0)


cdef inline void _speeds(
    (Floats, Floats, Floats) axes, ShortRows past, int64_t first, float rate, Floats speeds
) noexcept nogil:
    """Set `speeds` to the joints' speeds, m/s."""
    cdef int64_t j
    cdef Floats x, y, z
    cdef Shorts a, b, c
    cdef float u, v, w
    x, y, z = axes
    a = from_shorts(row_of_shorts(past, 0), first)
    b = from_shorts(row_of_shorts(past, 1), first)
    c = from_shorts(row_of_shorts(past, 2), first)
    for j in range(speeds.count):
        u = x.at[j] - <float>a.at[j] * QUANTUM
        v = y.at[j] - <float>b.at[j] * QUANTUM
        w = z.at[j] - <float>c.at[j] * QUANTUM
        speeds.at[j] = sqrtf(u * u + v * v + w * w) * rate


cdef inline void _log_speeds(Floats speeds, float offset) noexcept nogil:
    """Turn speeds into log(speed + offset)."""
    cdef int64_t j
    for j in range(speeds.count):
        speeds.at[j] += offset
    logarithm(speeds)


cdef inline void logarithm(Floats values) noexcept nogil:
    """Replace positive numbers by their natural logarithms, to 3e-7; unlike np.log this vectorises."""
    cdef int64_t i
    cdef int32_t bits, exponent
    cdef float mantissa, z, q, odd
    for i in range(values.count):
        bits = bits_of(values.at[i])
        # From √½ to √2, where the series needs few terms.
        exponent = (bits - ROOT_HALF) >> EXPONENT_SHIFT
        mantissa = float_of(bits - exponent * (1 << EXPONENT_SHIFT))
        z = (mantissa - <float>1.0) / (mantissa + <float>1.0)
        q = z * z
        odd = THIRD + q * (FIFTH + q * SEVENTH)
        values.at[i] = <float>exponent * LOG_2 + <float>2.0 * z * (<float>1.0 + q * odd)


cdef inline int64_t mark_at(PoseHistory* history, double time) noexcept nogil:
    """Return the place of the kept pose that lies nearest to a time, the later of two; -1 if none was kept."""
    cdef int64_t back, best, here
    cdef History* state
    cdef MarkSpan marks
    cdef double least, distance
    state = history.state
    marks = history.marks
    best, least = -1, INFINITY
    for back in range(state.filled):
        here = place_back(history, back)
        distance = abs(marks.at[here].time - time)
        if distance < least - MARGIN:
            best, least = here, distance
        elif marks.at[here].time <= time:
            break  # those before it lie farther off
    return best


cdef inline int64_t place_back(PoseHistory* history, int64_t back) noexcept nogil:
    """Return the place of the pose that was kept `back` poses before the newest."""
    cdef int64_t here
    here = history.state.head - 1 - back
    return here + history.marks.count if here < 0 else here


cdef void load_pose(PoseHistory* history, FloatRows pose, int64_t back) noexcept nogil:
    """Set `pose` to a kept one, with its log speeds; x is NaN where a joint does not count.

    Args:
        history: PoseHistory.
        pose: (4, padded_joints), set.
        back: Which one, counted from the newest, 0.
    """
    cdef int64_t here, axis, past, j
    cdef double time
    cdef float rate
    cdef ShortRows kept
    cdef (Floats, Floats, Floats) axes
    here = place_back(history, back)
    kept = plane_of_shorts(history.poses, here)
    for axis in range(3):
        for j in range(pose.columns):
            pose.at[axis * pose.columns + j] = <float>kept.at[axis * kept.columns + j] * QUANTUM
    time = history.marks.at[here].time
    past = _past_place(history, time, back + 1)
    rate = _rate(history.marks, past, time)
    axes = row_of_floats(pose, 0), row_of_floats(pose, 1), row_of_floats(pose, 2)
    _speeds(axes, plane_of_shorts(history.poses, max(past, 0)), 0, rate, row_of_floats(pose, 3))
    _log_speeds(row_of_floats(pose, 3), REST_SPEED)
    mark_absent(history.body, pose)


cdef void keep_all_along(PoseHistory* history, int64_t j) noexcept nogil:
    """Set a joint to its present place in all kept poses."""
    cdef int64_t k, axis, back
    cdef Shorts target
    k = place(j)
    for axis in range(3):
        for back in range(history.state.filled):
            target = row_of_shorts(plane_of_shorts(history.poses, place_back(history, back)), axis)
            quantise(history.body.at + k + POSE_X + axis * PAGE, target.at + j, 1, PER_QUANTUM)
