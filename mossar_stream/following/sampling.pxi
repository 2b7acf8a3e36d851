"""Sampling: frames in, the directions of bones out, at a fixed rate whatever the sensor's.

Samples lie on a grid of `PERIOD`, between two frames by interpolation, so that time is counted, not frames.
"""

cdef double FACING_TIME = 1.0  # s, time constant with which the facing follows
cdef float SMALLEST = 1e-6  # m, of a bone
cdef double LEAST_SPACING = 1e-9  # s, frames nearer than this are one
cdef float LONGEST_HOLE = 0.1  # s for which a point may be missing without its bones being hidden


cdef inline bint place_pose(
    FloatRows pose, JointPair* points, FloatRows positions, int64_t axis, float sign
) noexcept nogil:
    """Set a pose to the points of a frame relative to the centre; see `place_points`."""
    cdef int64_t d
    cdef bint whole
    whole = place_points(pose, points, positions, axis, sign)
    for d in range(3):  # directions of bones do not depend on where the body is
        pose.at[d] = 0.0
    return whole


cdef inline bint assume_missing(
    FloatRows pose, float* absences, FollowBank* bank, FloatRows positions
) noexcept nogil:
    """Set the points that are missing as a movement begins to where they are as the first example begins.

    They count as hidden until they are seen.

    Args:
        pose: (K, 3) m relative to the centre.
        absences: (K,) s.
        bank: The followed examples.
        positions: (J, 3) m of the frame.

    Returns:
        Whether the centre is there: without it nothing can be followed.
    """
    cdef FloatRows assumed
    cdef int64_t k, d
    if is_hidden(bank.points, 0, positions):
        return False
    assumed = first_pose(bank)
    for k in range(1, pose.rows):
        if is_hidden(bank.points, k, positions):
            for d in range(3):
                pose.at[3 * k + d] = assumed.at[3 * k + d]
            absences[k] = INFINITY
    return True


cdef inline void note_absences(
    float* absences, FollowBank* bank, FloatRows positions, bint whole, double seconds
) noexcept nogil:
    """Note for how long each point has been missing.

    Args:
        absences: (K,) s.
        bank: The followed examples.
        positions: (J, 3) m of a frame.
        whole: Whether no point is missing in it.
        seconds: Since the frame before.
    """
    cdef int64_t k
    for k in range(bank.head.points):
        if whole or not is_hidden(bank.points, k, positions):
            absences[k] = 0.0
        else:
            absences[k] += <float>seconds


cdef inline void keep_sample(
    FollowMemory* known, FollowBank* bank, int64_t ring, int64_t line
) noexcept nogil:
    """Keep the sample that was taken in a line of a ring, and which bones were hidden in it."""
    cdef float* kept
    cdef uint8_t* hidden
    cdef Bone* bone
    cdef int64_t b, d, bones
    bones = bank.head.bones
    kept = row_of_ring(known, ring, line)
    hidden = known.hidden.at + (ring * known.hidden.rows + line) * bones
    for b in range(bones):
        bone = &bank.bones[b]
        for d in range(3):
            kept[3 * b + d] = known.directions.at[3 * b + d]
        hidden[b] = max(known.absences[bone.begin], known.absences[bone.end]) > LONGEST_HOLE


cdef void take_sample(FollowMemory* known, FollowBank* bank, double share, double seconds) noexcept nogil:
    """Write the directions of bones between the last two frames, as of a body that always faces one way.

    Args:
        known: The performer's memory; the later frame is `poses[1]`.
        bank: The followed examples.
        share: Of the way from the earlier to the later frame, 0..1.
        seconds: Since the last sample, s.
    """
    cdef FloatRows after, before
    cdef float* direction
    cdef float later, earlier, cosine, sine, x, y, z, length, scale
    cdef int64_t b, begin, end
    before, after = plane_of_floats(known.poses, 0), plane_of_floats(known.poses, 1)
    later = <float>share
    earlier = <float>1.0 - later
    cosine, sine = _follow_facing(known, bank.head, after, seconds)
    for b in range(bank.head.bones):
        begin, end = 3 * bank.bones[b].begin, 3 * bank.bones[b].end
        x = later * (after.at[end] - after.at[begin]) + earlier * (before.at[end] - before.at[begin])
        y = later * (after.at[end + 1] - after.at[begin + 1]) + earlier * (
            before.at[end + 1] - before.at[begin + 1]
        )
        z = later * (after.at[end + 2] - after.at[begin + 2]) + earlier * (
            before.at[end + 2] - before.at[begin + 2]
        )
        length = sqrtf(x * x + y * y + z * z)
        scale = <float>1.0 / max(length, SMALLEST)
        x, z = turned_back_in_floats(x, z, cosine, sine)
        direction = known.directions.at + 3 * b
        direction[0], direction[1], direction[2] = scale * x, scale * y, scale * z


cdef inline (float, float) _follow_facing(
    FollowMemory* known, FollowHead* head, FloatRows pose, double seconds
) noexcept nogil:
    """Update the facing from hips and shoulders that are seen; return cosine and sine of the heading."""
    cdef FollowingState* state
    cdef int64_t girdles[4]
    cdef double share, cosine, sine
    cdef float x, z
    cdef int64_t i
    if head.girdles[0] < 0:
        return 1.0, 0.0
    state = known.state
    for i in range(4):
        girdles[i] = _seen_point(head.girdles[i], known.absences)
    x, z = facing_of(pose, girdles)
    share = 1.0 if state.samples == 0 else 1.0 - exp(-seconds / FACING_TIME)
    if x * x + z * z == 0.0:  # neither both hips nor both shoulders are seen
        share = 0.0
    state.facing[0] += share * (x - state.facing[0])
    state.facing[1] += share * (z - state.facing[1])
    cosine, sine = heading(state.facing[0], state.facing[1])
    return <float>cosine, <float>sine


cdef inline int64_t _seen_point(int64_t point, float* absences) noexcept nogil:
    """Return a point of a girdle; -1 if it is hidden or there is none."""
    return point if point >= 0 and absences[point] <= LONGEST_HOLE else -1
