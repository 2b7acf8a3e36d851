"""Joint pages: the numbers of each joint, laid out so that loops over joints vectorise.

A loop is vectorised only where the compiler sees that its arrays do not overlap. They therefore all lie in one
array, a constant distance apart: pages of `PAGE` joints, in each page one line for every number that is kept of a
joint. Joint j's number N is `body[place(j) + N]`; a loop over a page's joints takes `page[j + N]`, and all of a page,
for loops of a length that the compiler knows are straight-line code. Padding joints stay 0, or are ignored.
"""

cdef enum:
    PAGE = 32  # joints
cdef double FARTHEST = 100000.0  # m; a coordinate beyond this is no position
cdef enum:
    X = 0  # m, where the joint is taken to be, in the source's space
    Y = 32
    Z = 64
    GOOD_X = 96  # m, where it was last there
    GOOD_Y = 128
    GOOD_Z = 160
    MOVED_X = 192  # m, displacement in this frame, relative to the centre
    MOVED_Y = 224
    MOVED_Z = 256
    LAST_X = 288  # m, displacement in the frame before (noise)
    LAST_Y = 320
    LAST_Z = 352
    SMOOTH_X = 384  # m, displacement with the noise smoothed out
    SMOOTH_Y = 416
    SMOOTH_Z = 448
    MEAN_X = 480  # m, slow mean of the pose (tempo)
    MEAN_Y = 512
    MEAN_Z = 544
    STEP = 576  # m, path in this frame, and in the last one that was used
    STEP_BEFORE = 608
    # Features of the last frame: where the joint is relative to the centre, m, and its log(m/s);
    POSE_X = 640
    POSE_Y = 672
    POSE_Z = 704
    LOG_SPEED = 736
    SUM_X = 768  # sums of these over the frames that wait for a summary,
    SUM_Y = 800
    SUM_Z = 832
    SUM_SPEED = 864
    SQUARE_X = 896  # of their squares,
    SQUARE_Y = 928
    SQUARE_Z = 960
    SQUARE_SPEED = 992
    SUM_PATH = 1024  # and of the paths
    LIVE = 1056  # 1, or 0 for joints that do not count (joints.pxi) and for padding
    WORK = 1088  # scratch
    REST_X = 1120  # m, the pose in which the performer dwells (scales)
    REST_Y = 1152
    REST_Z = 1184
    LINES = 38  # of a page
    PAGE_SIZE = LINES * PAGE
    PADDING = 8  # joints are padded to a multiple of this, so that loops over joints vectorise

cdef struct Position:  # m; a frame is J of these
    float x
    float y
    float z


cdef struct PositionSpan:
    Position* at
    int64_t count


cdef inline PositionSpan part_of_position_span(PositionSpan span, int64_t begin, int64_t end) noexcept nogil:
    """Return joints begin … end - 1."""
    cdef PositionSpan found
    found.at, found.count = span.at + begin, end - begin
    return found


cdef int64_t place(int64_t j) noexcept nogil:
    """Return the place of joint j's numbers."""
    return j // PAGE * PAGE_SIZE + j % PAGE


cdef inline int64_t body_numbers(int64_t joints) noexcept nogil:
    """Return the length of a body with so many joints."""
    return (joints + PAGE - 1) // PAGE * PAGE_SIZE


cdef inline Floats page_of(Floats body, int64_t first) noexcept nogil:
    """Return the page that begins with a joint."""
    return floats(body.at + first // PAGE * PAGE_SIZE, PAGE_SIZE)


cdef inline double line_sum(Floats body, int64_t line) noexcept nogil:
    """Sum of a line of the body over all joints."""
    cdef double total
    cdef int64_t first
    total = 0.0
    for first from 0 <= first < body.count // LINES by PAGE:
        total += page_sum(page_of(body, first).at, line)
    return total


cdef (float, float, float) center_of(Plan* plan, JointsState* state, Floats body) noexcept nogil:
    """Return the place of the centre: the root, or the centroid of the joints that count.

    Args:
        plan: PLAN.
        state: JOINTS.
        body: The body.
    """
    cdef double x, y, z, live
    cdef int64_t j, k
    if plan.center >= 0:
        k = place(plan.center)
        return (body.at[k + X], body.at[k + Y], body.at[k + Z])
    x = y = z = live = 0.0
    for j in range(plan.joints):
        k = place(j)
        x += body.at[k + X] * body.at[k + LIVE]
        y += body.at[k + Y] * body.at[k + LIVE]
        z += body.at[k + Z] * body.at[k + LIVE]
        live += body.at[k + LIVE]
    live = max(live, 1.0)
    return (<float>(x / live + state.offset_x), <float>(y / live + state.offset_y), <float>(z / live + state.offset_z))


cdef void flatten(Floats body, FloatRows pose) noexcept nogil:
    """Copy the features of the last frame to rows without pages; x is NaN where a joint does not count.

    Args:
        body: The body.
        pose: (4, padded_joints), set.
    """
    cdef int64_t first, axis, begin, j
    cdef Floats line, values
    for first from 0 <= first < pose.columns by PAGE:
        for axis in range(4):
            begin = first // PAGE * PAGE_SIZE + POSE_X + axis * PAGE
            line = part_of_floats(row_of_floats(pose, axis), first, first + PAGE)
            values = part_of_floats(body, begin, begin + PAGE)
            for j in range(line.count):
                line.at[j] = values.at[j]
    mark_absent(body, pose)


cdef void mark_absent(Floats body, FloatRows pose) noexcept nogil:
    """Set x to NaN, in a (4, padded_joints) pose, where a joint does not count."""
    cdef int64_t j
    for j in range(pose.columns):
        if body.at[place(j) + LIVE] == 0.0:
            pose.at[j] = NAN
