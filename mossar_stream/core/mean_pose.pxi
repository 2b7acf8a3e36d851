"""Mean pose: leaky means of the pose, from which tempo and scales measure the size of the movements."""

cdef double MEAN_TIME = 5.0  # s, of slow means


cdef void start_mean(Floats body, int64_t joints, int64_t line) noexcept nogil:
    """Begin a mean with the pose of the last frame.

    Args:
        body: See joint_pages.pxi.
        joints: J.
        line: Line of x of the mean in a page; y and z follow.
    """
    cdef int64_t j, k, axis
    for j in range(joints):
        k = place(j)
        for axis in range(3):
            body.at[k + line + axis * PAGE] = body.at[k + POSE_X + axis * PAGE]


cdef inline void follow_mean(Floats body, int64_t line, float share) noexcept nogil:
    """Update a mean with the pose of the last frame, weighted by `share`, float32."""
    cdef int64_t first, j
    cdef Floats page
    for first from 0 <= first < body.count // LINES by PAGE:
        page = page_of(body, first)
        for j in range(PAGE):
            page.at[j + line + X] += share * (page.at[j + POSE_X] - page.at[j + line + X])
            page.at[j + line + Y] += share * (page.at[j + POSE_Y] - page.at[j + line + Y])
            page.at[j + line + Z] += share * (page.at[j + POSE_Z] - page.at[j + line + Z])


cdef inline double squared_distance(Floats body, int64_t line) noexcept nogil:
    """Return the sum over the joints of their squared distances from a mean, m²; uses WORK."""
    cdef double squares
    cdef int64_t first, j
    cdef Floats page
    cdef float u, v, w
    squares = 0.0
    for first from 0 <= first < body.count // LINES by PAGE:
        page = page_of(body, first)
        for j in range(PAGE):
            u = page.at[j + POSE_X] - page.at[j + line + X]
            v = page.at[j + POSE_Y] - page.at[j + line + Y]
            w = page.at[j + POSE_Z] - page.at[j + line + Z]
            page.at[j + WORK] = u * u + v * v + w * w
        squares += page_sum(page.at, WORK)
    return squares
