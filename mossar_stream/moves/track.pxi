"""The last seconds of a performer's movement, as templates see it: joints relative to the centre, smoothed, about 30 a second.

A pose has the centre's own place first, then each joint relative to it. Poses nearer than `TICK` to the one kept before
are left out, so that cost and memory do not grow with the sensor's rate.
"""

cdef double TICK = 0.024  # s, least time between two poses that are kept: at most 41 Hz
cdef double SMOOTHED = 0.15  # s, poses younger than this are averaged
cdef enum:
    RAW = 8  # poses that may be averaged
    RING = 128  # poses, a power of two: 3.1 s at 41 Hz, 4.2 s at 30 Hz

cdef struct Track:
    int64_t poses  # kept so far; pose n lies in line n % RING
    int64_t first  # no stretch may begin before this pose: the first one after a gap
    double time  # s, of the last pose
    double times[128]  # s
    double path[128]  # m, length of the path up to each pose since the gap
    double speed[128]  # m/s, mean over the joints


cdef struct TrackJoint:
    int64_t one  # joint of the stream, -1 for the mean of all joints
    int64_t other  # another, if the template's joint lies in their middle, else the same
    int64_t limb  # index into the keys of `limbs.limbs_of`


cdef bint track_add_pose(Track* track, FloatRows poses, FloatRows positions, MoveBank* bank, double time) noexcept nogil:
    """Keep a frame as a pose.

    A joint that is missing stays where it was. One that was never seen is where it is at the begin of the first example, so
    that a performer whose legs no camera sees is recognised by what it sees.

    Args:
        track: Record of the history.
        poses: (RING + RAW, D) float32 metres: the smoothed poses, then the last ones as they came.
        positions: (J, 3) float32 metres; NaN where a joint is missing.
        bank: `recogniser.Bank`; its joints, (K,) records of `JOINT`, have the centre first.
        time: s.

    Returns:
        Whether the movement goes on; if not, there was a gap, or nothing before.
    """
    cdef FloatRows raw
    cdef int64_t d, here, number
    cdef bint whole, goes_on
    cdef TrackJointSpan joints
    cdef Floats pose, last
    # CHECK sign (C truncates): number % RAW; (number + RAW - 1) % RAW; number % RING; (number - 1) % RING
    # CHECK call pose[:3 * joints.size].reshape((joints.size, 3))
    # CHECK place_points is called with several kinds of arguments
    # CHECK is_hidden is called with several kinds of arguments
    number = track.poses
    joints = bank.joints
    raw = rows_of_floats(poses, RING, poses.rows)
    pose = row_of_floats(raw, number % RAW)
    last = row_of_floats(raw, (number + RAW - 1) % RAW)
    if number == 0:
        last = bank.begin
    for d in range(pose.count):
        pose.at[d] = last.at[d]
    whole = place_points(pose[: 3 * joints.size].reshape((joints.size, 3)), joints, positions, Y_UP)
    goes_on = follows(number, time, track.time)
    if number == 0 and not whole and is_hidden(joints, 0, positions):
        return False
    if not goes_on:
        track.first = number
    here = number % RING
    track.times[here] = time
    track.path[here] = 0.0
    track.speed[here] = 0.0
    _track_average(track, poses, raw, number)
    if goes_on:
        _measure_step(track, poses, joints.count, here, (number - 1) % RING)
    track.time = time
    track.poses = number + 1
    return goes_on


cdef inline void _track_average(Track* track, FloatRows poses, FloatRows raw, int64_t number) noexcept nogil:
    """Average the poses since the gap that are younger than `SMOOTHED`, so that a sensor's noise adds little path."""
    cdef Floats pose, older
    cdef int64_t d, count
    cdef float share
    # CHECK sign (C truncates): number % RING; number % RAW; (number - count) % RING; (number - count) % RAW
    pose = row_of_floats(poses, number % RING)
    for d in range(pose.count):
        pose.at[d] = raw.at[number % RAW * raw.columns + d]
    count = 1
    while count < RAW and number - count >= track.first:
        if not track.times[number % RING] - track.times[(number - count) % RING] < SMOOTHED - EARLY:
            break
        older = row_of_floats(raw, (number - count) % RAW)
        for d in range(pose.count):
            pose.at[d] += older.at[d]
        count += 1
    share = <float>1.0 / <float>count
    for d in range(pose.count):
        pose.at[d] *= share


cdef inline void _measure_step(Track* track, FloatRows poses, int64_t joints, int64_t here, int64_t before) noexcept nogil:
    """Note how far the body moved since the pose before."""
    cdef float squares, steps, x, y, z, square
    cdef int64_t k
    squares = <float>0.0
    steps = <float>0.0
    for k in range(joints):
        x = poses.at[here * poses.columns + 3 * k] - poses.at[before * poses.columns + 3 * k]
        y = poses.at[here * poses.columns + (3 * k + 1)] - poses.at[before * poses.columns + (3 * k + 1)]
        z = poses.at[here * poses.columns + (3 * k + 2)] - poses.at[before * poses.columns + (3 * k + 2)]
        square = x * x + y * y + z * z
        squares += square
        steps += sqrtf(square)
    track.path[here] = track.path[before] + sqrt(<double>squares)
    track.speed[here] = steps / (joints * (track.times[here] - track.times[before]))
