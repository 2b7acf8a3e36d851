"""Points: what readers see of a frame: joints, or middles of two, relative to the first point, the centre.

Recognised moves, followed moves and held poses place the points of their examples in a stream alike, and agree on which
frames follow each other.
"""

cdef double LATE = 1.0  # s, frames that are so late are repeated or out of order
cdef double MAX_STEP = 0.25  # s, a longer time without frames breaks the movement
cdef double EARLY = 1e-06  # s, for the rounding of times: where the clock's origin lies must not matter
# CHECK tuple Y_UP = (1, 1.0)  # axis and sign
cdef float FARTHEST_SUM = 100000.0  # m, of the three coordinates


cdef inline bint is_new(int64_t frames, double time, double latest, double spacing) noexcept nogil:
    """Tell whether a frame is to be processed; late ones are not, time that was set back begins anew.

    Args:
        frames: How many were processed so far.
        time: s, of the frame.
        latest: s, of the last frame that was processed.
        spacing: s, least time between two.
    """
    return isfinite(time) and (frames == 0 or not -LATE <= time - latest < spacing)


cdef inline bint follows(int64_t frames, double time, double latest) noexcept nogil:
    """Tell whether a frame follows the last one without a gap; arguments as for `is_new`."""
    return frames > 0 and 0.0 < time - latest <= MAX_STEP + EARLY


cdef inline bint place_points(FloatRows pose, TrackJointSpan points, FloatRows positions, (int64_t, double) up) noexcept nogil:
    """Set a pose to the points of a frame, y upwards; a missing point, or one beyond 100 km, stays where it was.

    Args:
        pose: (K, 3) float32 m, the pose before; the centre's own place, then the other points relative to it.
        points: (K,) records with two joints, `one` and `other`, in whose middle a point lies; -1 for the mean of all joints.
        positions: (J, 3) float32 m, NaN where a joint is missing.
        up: Axis that points upwards, and its sign.

    Returns:
        Whether all points were there.
    """
    cdef double sign
    cdef bint whole
    cdef float x, y, z, px, py, pz
    cdef int64_t k, axis
    # CHECK numba gave sign the types float32, float64
    # CHECK _place_of is called with several kinds of arguments
    axis, sign = up
    sign = <float>sign
    whole = True
    x = y = z = <float>0.0
    for k in range(points.count):
        px, py, pz = _place_of(&points.at[k], positions)
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
        pose.at[k * pose.columns + 0], pose.at[k * pose.columns + 1], pose.at[k * pose.columns + 2] = sign * px, sign * py, pz
    return whole


cdef inline bint is_hidden(TrackJointSpan points, int64_t k, FloatRows positions) noexcept nogil:
    """Tell whether `place_points` leaves point k where it was, because it is missing or too far; arguments as there."""
    cdef float x, y, z, px, py, pz
    # CHECK _place_of is called with several kinds of arguments
    x, y, z = _place_of(&points.at[0], positions)
    if k == 0:
        return not _is_near(x, y, z)
    px, py, pz = _place_of(&points.at[k], positions)
    return not _is_near(px - x, py - y, pz - z)


cdef inline (float, float, float) _place_of(TrackJoint* point, FloatRows positions) noexcept nogil:
    """Return where a point lies in a frame, m; NaN if a joint is missing."""
    cdef float half
    cdef int64_t a, b
    a, b = point.one, point.other
    if a < 0:
        return _mean(positions)
    half = <float>0.5
    return (half * (positions.at[a * positions.columns + 0] + positions.at[b * positions.columns + 0]), half * (positions.at[a * positions.columns + 1] + positions.at[b * positions.columns + 1]), half * (positions.at[a * positions.columns + 2] + positions.at[b * positions.columns + 2]))


cdef inline bint _is_near(float x, float y, float z) noexcept nogil:
    return abs(x) + abs(y) + abs(z) < FARTHEST_SUM


cdef inline (float, float, float) _mean(FloatRows positions) noexcept nogil:
    cdef float x, y, z, share
    cdef int64_t count, j
    x = y = z = <float>0.0
    count = 0
    for j in range(positions.rows):
        if not isnan(positions.at[j * positions.columns + 0] + positions.at[j * positions.columns + 1] + positions.at[j * positions.columns + 2]):
            x += positions.at[j * positions.columns + 0]
            y += positions.at[j * positions.columns + 1]
            z += positions.at[j * positions.columns + 2]
            count += 1
    share = <float>1.0 / <float>count
    return x * share, y * share, z * share
