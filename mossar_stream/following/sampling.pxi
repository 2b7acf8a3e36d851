"""Sampling: frames in, the directions of bones out, at a fixed rate whatever the sensor's.

Samples lie on a grid of `PERIOD`, between two frames by interpolation, so that alignments count time, not frames.
"""

cdef double FACING_TIME = 1.0  # s, time constant with which the facing follows
cdef float SMALLEST = 9.999999974752427e-07  # m, of a bone
cdef double EARLY = 1e-06  # s by which a frame may come before the sample that is due
cdef double LEAST_SPACING = 1e-09  # s, frames nearer than this are one
cdef float LONGEST_HOLE = 0.10000000149011612  # s for which a point may be missing without its bones being hidden


cdef inline bint place_pose(FloatRows pose, FollowBank* bank, FloatRows positions) noexcept nogil:
    """Set a pose to the points of a frame relative to the centre; return whether all were there."""
    cdef BankHead* head
    cdef bint whole
    cdef int64_t d
    # CHECK place_points is called with several kinds of arguments
    head = &bank.head.at[0]
    whole = place_points(pose, bank.points, positions, (head.axis, head.sign))
    for d in range(3):  # directions of bones do not depend on where the body is
        pose.at[d] = <float>0.0
    return whole


cdef inline bint assume_missing(FloatRows pose, Floats absences, FollowBank* bank, FloatRows positions) noexcept nogil:
    """Set the points that are missing as a movement begins to where they are at the begin of the first example.

    They count as hidden until they are seen.

    Args:
        pose: (K, 3) m relative to the centre.
        absences: (K,) s.
        bank: `Bank`.
        positions: (J, 3) of the frame.

    Returns:
        Whether the centre is there: without it nothing can be followed.
    """
    cdef FloatRows assumed
    cdef int64_t k, d
    # CHECK is_hidden is called with several kinds of arguments
    # CHECK call of first_pose: first_pose(bank)
    if is_hidden(bank.points, 0, positions):
        return False
    assumed = first_pose(bank)
    for k in range(1, absences.count):
        if is_hidden(bank.points, k, positions):
            for d in range(3):
                pose.at[k * pose.columns + d] = assumed.at[k * assumed.columns + d]
            absences.at[k] = <float>INFINITY
    return True


cdef inline void note_absences(Floats absences, FollowBank* bank, FloatRows positions, bint whole, double seconds) noexcept nogil:
    """Note for how long each point has been missing.

    Args:
        absences: (K,) s.
        bank: `Bank`.
        positions: (J, 3) of a frame.
        whole: Whether no point is missing in it.
        seconds: Since the frame before.
    """
    cdef int64_t k
    # CHECK is_hidden is called with several kinds of arguments
    for k in range(absences.count):
        if whole or not is_hidden(bank.points, k, positions):
            absences.at[k] = <float>0.0
        else:
            absences.at[k] += <float>seconds


cdef inline void keep_sample(FloatRows line, Bytes hidden, FollowMemory* known, FollowBank* bank) noexcept nogil:
    """Keep the directions of the sample that was taken, and which bones were hidden in it.

    Args:
        line: (B, 3) gets the directions.
        hidden: (B,) uint8.
        known: `Memory`.
        bank: `Bank`.
    """
    cdef int64_t b, d
    cdef FloatRows directions
    cdef Floats absences
    cdef BoneSpan bones
    directions = known.directions
    absences = known.absences
    bones = bank.bones
    for b in range(bones.count):
        for d in range(3):
            line.at[b * line.columns + d] = directions.at[b * directions.columns + d]
        hidden.at[b] = max(absences.at[bones.at[b].begin], absences.at[bones.at[b].end]) > LONGEST_HOLE


cdef void take_sample(FollowMemory* known, FollowBank* bank, double share, double seconds) noexcept nogil:
    """Write the directions of bones between the last two frames, as of a body that faces the same way all the time.

    Args:
        known: `Memory`; the later frame is `poses[1]`.
        bank: `Bank`.
        share: Of the way from the earlier to the later frame, 0..1.
        seconds: Since the last sample, s.
    """
    cdef float later, earlier, cosine, sine, x, y, z, length, scale
    cdef int64_t b, begin, end
    cdef FollowingState* state
    cdef FloatPlanes poses
    cdef FloatRows directions
    cdef BoneSpan bones
    # CHECK turned_back is called with several kinds of arguments
    state = &known.state.at[0]
    poses = known.poses
    directions = known.directions
    bones = bank.bones
    later = <float>share
    earlier = <float>1.0 - later
    cosine, sine = _facing(state, &bank.head.at[0], plane_of_floats(poses, 1), known.absences, seconds)
    for b in range(bones.count):
        begin, end = bones.at[b].begin, bones.at[b].end
        x = later * (poses.at[(1 * poses.rows + end) * poses.columns + 0] - poses.at[(1 * poses.rows + begin) * poses.columns + 0]) + earlier * (poses.at[(0 * poses.rows + end) * poses.columns + 0] - poses.at[(0 * poses.rows + begin) * poses.columns + 0])
        y = later * (poses.at[(1 * poses.rows + end) * poses.columns + 1] - poses.at[(1 * poses.rows + begin) * poses.columns + 1]) + earlier * (poses.at[(0 * poses.rows + end) * poses.columns + 1] - poses.at[(0 * poses.rows + begin) * poses.columns + 1])
        z = later * (poses.at[(1 * poses.rows + end) * poses.columns + 2] - poses.at[(1 * poses.rows + begin) * poses.columns + 2]) + earlier * (poses.at[(0 * poses.rows + end) * poses.columns + 2] - poses.at[(0 * poses.rows + begin) * poses.columns + 2])
        length = sqrtf(x * x + y * y + z * z)
        scale = <float>1.0 / max(length, SMALLEST)
        x, z = turned_back(x, z, cosine, sine)
        directions.at[b * directions.columns + 0] = scale * x
        directions.at[b * directions.columns + 1] = scale * y
        directions.at[b * directions.columns + 2] = scale * z


cdef inline (float, float) _facing(FollowingState* state, BankHead* head, FloatRows pose, Floats absences, double seconds) noexcept nogil:
    """Let the facing follow hips and shoulders that are seen; return the cosine and the sine of the heading."""
    cdef (int64_t, int64_t, int64_t, int64_t) girdles
    cdef double share, cosine, sine
    cdef float x, z
    # CHECK facing_of is called with several kinds of arguments
    # CHECK heading is called with several kinds of arguments
    if head.left < 0:
        return (<float>1.0, <float>0.0)
    girdles = (_seen(head.left, absences), _seen(head.right, absences), _seen(head.left_shoulder, absences), _seen(head.right_shoulder, absences))
    x, z = facing_of(pose, girdles)
    share = 1.0 if state.samples == 0 else 1.0 - exp(-seconds / FACING_TIME)
    if x * x + z * z == 0.0:  # neither both hips nor both shoulders are seen
        share = 0.0
    state.facing[0] += share * (x - state.facing[0])
    state.facing[1] += share * (z - state.facing[1])
    cosine, sine = heading(state.facing[0], state.facing[1])
    return (<float>cosine, <float>sine)


cdef inline int64_t _seen(int64_t point, Floats absences) noexcept nogil:
    """Return a point of a girdle; -1 if it is hidden or there is none."""
    return point if point >= 0 and absences.at[point] <= LONGEST_HOLE else -1
