"""Points: a frame as readers see it: joints, or middles of two, relative to the first point, the centre.

Recognised moves, followed moves and held poses place the points of their examples in a stream alike, and
agree on which frames follow each other.
"""

cdef double LATE = 1.0  # s, frames that are so late are repeated or out of order
cdef double MAX_STEP = 0.25  # s, a longer time without frames breaks the movement
cdef double EARLY = 1e-6  # s, for the rounding of times: the origin of the clock must not matter
cdef float FARTHEST_SUM = <float>FARTHEST  # m, of the three coordinates

cdef struct JointPair:  # Two joints of a stream, in whose middle a point lies.
    int64_t one  # -1 for the mean of all joints
    int64_t other  # the same as `one` for the joint itself


cdef inline bint is_new(int64_t frames, double time, double latest, double spacing) noexcept nogil:
    """Return whether to process a frame: late ones are dropped; a time that was set back begins anew.

    Args:
        frames: Number of frames processed so far.
        time: s, of the frame.
        latest: s, of the last frame that was processed.
        spacing: s, least time between two.
    """
    return isfinite(time) and (frames == 0 or not -LATE <= time - latest < spacing)


cdef inline bint follows(int64_t frames, double time, double latest) noexcept nogil:
    """Return whether a frame follows the last one without a gap; arguments as for `is_new`."""
    return frames > 0 and 0.0 < time - latest <= MAX_STEP + EARLY


cdef inline bint place_points(
    FloatRows pose, JointPair* points, FloatRows positions, int64_t axis, float sign
) noexcept nogil:
    """Set a pose to the points of a frame, y upwards; a point missing or beyond 100 km stays where it was.

    Args:
        pose: (K, 3) m, the pose before; the centre's own place, then the other points relative to it.
        points: (K,) which joints they are.
        positions: (J, 3) m, NaN where a joint is missing.
        axis: That points upwards.
        sign: Of that axis, 1 or -1.

    Returns:
        Whether all points were there.
    """
    cdef float x, y, z, px, py, pz
    cdef int64_t k
    cdef bint whole
    whole = True
    x = y = z = 0.0
    for k in range(pose.rows):
        px, py, pz = _place_of(&points[k], positions)
        if k == 0:
            x, y, z = px, py, pz
        else:
            px, py, pz = px - x, py - y, pz - z
        if not _is_near(px, py, pz):
            whole = False
            continue
        if axis == 0:
            px, py, pz = pz, px, py
        elif axis == 2:
            px, py, pz = py, pz, px
        pose.at[3 * k], pose.at[3 * k + 1], pose.at[3 * k + 2] = sign * px, sign * py, pz
    return whole


cdef inline bint is_hidden(JointPair* points, int64_t k, FloatRows positions) noexcept nogil:
    """Return whether `place_points` leaves point k at its place, because it is missing or too far."""
    cdef float x, y, z, px, py, pz
    x, y, z = _place_of(&points[0], positions)
    if k == 0:
        return not _is_near(x, y, z)
    px, py, pz = _place_of(&points[k], positions)
    return not _is_near(px - x, py - y, pz - z)


cdef inline (float, float, float) _place_of(JointPair* point, FloatRows positions) noexcept nogil:
    """Return the position of a point in a frame, m; NaN if a joint is missing."""
    cdef const float* one
    cdef const float* other
    cdef float half
    if point.one < 0:
        return _mean_of_joints(positions)
    one, other = positions.at + 3 * point.one, positions.at + 3 * point.other
    half = 0.5
    return half * (one[0] + other[0]), half * (one[1] + other[1]), half * (one[2] + other[2])


cdef inline bint _is_near(float x, float y, float z) noexcept nogil:
    return abs(x) + abs(y) + abs(z) < FARTHEST_SUM


cdef inline (float, float, float) _mean_of_joints(FloatRows positions) noexcept nogil:
    cdef const float* joint
    cdef float x, y, z, share
    cdef int64_t count, j
    x = y = z = 0.0
    count = 0
    for j in range(positions.rows):
        joint = positions.at + 3 * j
        if not isnan(joint[0] + joint[1] + joint[2]):
            x += joint[0]
            y += joint[1]
            z += joint[2]
            count += 1
    share = <float>1.0 / <float>count
    return x * share, y * share, z * share
