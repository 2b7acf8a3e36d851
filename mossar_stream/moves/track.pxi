"""The last seconds of a performer's movement as examples see it: about 30 smoothed poses a second.

A pose has the centre's own place first, then each joint relative to it. Poses nearer than `TICK` to the one
kept before are left out, so that cost and memory do not grow with the sensor's rate.
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


cdef bint add_track_pose(
    Track* track, FloatRows poses, FloatRows positions, MoveBank* bank, double time
) noexcept nogil:
    """Keep a frame as a pose.

    A missing joint keeps its place. One that was never seen has its place from the begin of the first example. A
    performer whose legs no camera sees is thus recognised by the rest of the body.

    Args:
        track: The history.
        poses: (RING + RAW, D) m: the smoothed poses, then the last unsmoothed ones.
        positions: (J, 3) m; NaN where a joint is missing.
        bank: Whose joints have the centre first.
        time: s.

    Returns:
        Whether the movement goes on; if not, there was a gap, or nothing before.
    """
    cdef FloatRows raw
    cdef float* pose
    cdef const float* last
    cdef int64_t d, here, number
    cdef bint whole, goes_on
    number = track.poses
    raw = rows_of_floats(poses, RING, poses.rows)
    pose = raw.at + number % RAW * raw.columns
    last = raw.at + (number + RAW - 1) % RAW * raw.columns
    if number == 0:
        last = bank.begin
    for d in range(raw.columns):
        pose[d] = last[d]
    whole = place_points(floats_in_rows(pose, bank.head.joints, 3), bank.joints, positions, 1, 1.0)
    goes_on = follows(number, time, track.time)
    if number == 0 and not whole and is_hidden(bank.joints, 0, positions):
        return False
    if not goes_on:
        track.first = number
    here = number % RING
    track.times[here] = time
    track.path[here] = 0.0
    track.speed[here] = 0.0
    _smooth_track(track, poses, raw, number)
    if goes_on:
        _measure_step(track, poses, bank.head.joints, here, (number - 1) % RING)
    track.time = time
    track.poses = number + 1
    return goes_on


cdef inline void _smooth_track(Track* track, FloatRows poses, FloatRows raw, int64_t number) noexcept nogil:
    """Average the poses that are younger than `SMOOTHED`, so that a sensor's noise adds little path."""
    cdef float* pose
    cdef const float* older
    cdef float share
    cdef int64_t d, count
    pose = poses.at + number % RING * poses.columns
    older = raw.at + number % RAW * raw.columns
    for d in range(raw.columns):
        pose[d] = older[d]
    count = 1
    while count < RAW and number - count >= track.first:
        if not track.times[number % RING] - track.times[(number - count) % RING] < SMOOTHED - EARLY:
            break
        older = raw.at + (number - count) % RAW * raw.columns
        for d in range(raw.columns):
            pose[d] += older[d]
        count += 1
    share = <float>1.0 / <float>count
    for d in range(raw.columns):
        pose[d] *= share


cdef inline void _measure_step(
    Track* track, FloatRows poses, int64_t joints, int64_t here, int64_t before
) noexcept nogil:
    """Note the body's movement since the pose before."""
    cdef const float* pose
    cdef const float* earlier
    cdef float squares, steps, x, y, z, square
    cdef int64_t d
    squares = steps = 0.0
    pose, earlier = poses.at + here * poses.columns, poses.at + before * poses.columns
    for d in range(0, 3 * joints, 3):
        x, y, z = pose[d] - earlier[d], pose[d + 1] - earlier[d + 1], pose[d + 2] - earlier[d + 2]
        square = x * x + y * y + z * z
        squares += square
        steps += sqrtf(square)
    track.path[here] = track.path[before] + sqrt(squares)
    track.speed[here] = steps / (joints * (track.times[here] - track.times[before]))
