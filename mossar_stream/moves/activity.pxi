"""Possible begins of moves: onsets and significant minima of the recogniser's own speed.

The body's key frames depend on settings that users change; recognition must not. The recogniser therefore
follows a speed of its own (mean over the joints, m/s), in the manner of Algorithm 2: an onset where it rises
above a share of its range, a minimum where it has fallen and risen by a significant share.
"""

cdef enum:
    STARTS = 4  # of which the last ones are remembered
    LOOK_BACK = 15  # poses: so far before an onset a move may have begun
cdef double AVERAGED = 0.12  # s, of speed
cdef double ONSET = 0.12  # of the range: faster is moving
cdef double SIGNIFICANT = 0.06  # of the range: depth of a minimum below its surroundings
cdef double HALF_LIFE = 20.0  # s, of the range
cdef double LEAST_RANGE = 0.3  # m/s

cdef struct MoveActivity:
    double range  # m/s, largest speed, decaying
    double speed  # m/s, now
    int64_t moving  # whether speed is above the threshold
    int64_t rising  # whether a maximum is looked for, else a minimum
    double top  # m/s, largest speed since the last minimum
    double low  # m/s, least speed since the last maximum
    int64_t low_pose  # pose of it
    int64_t starts[4]  # STARTS, numbers of poses where moves may have begun, the latest first; -1 for none


cdef void start_move_activity(MoveActivity* activity) noexcept nogil:
    """Forget everything but the range."""
    cdef int64_t i
    activity.range = max(activity.range, LEAST_RANGE)
    activity.speed = 0.0
    activity.moving = 0
    activity.rising = 1
    activity.top = 0.0
    activity.low = 0.0
    activity.low_pose = 0
    for i in range(STARTS):
        activity.starts[i] = -1


cdef void follow_move_activity(MoveActivity* activity, Track* track) noexcept nogil:
    """Process the speed at the last pose; the pose before it comes after the last gap, too."""
    cdef double seconds, speed
    cdef int64_t pose, moving
    pose = track.poses - 1
    seconds = track.times[pose % RING] - track.times[(pose - 1) % RING]
    speed = activity.speed = mean_speed(track, pose)
    activity.range = max(activity.range * exp2(-seconds / HALF_LIFE), speed, LEAST_RANGE)
    moving = 1 if speed > ONSET * activity.range else 0
    if moving != activity.moving:
        activity.moving = moving
        if moving:
            activity.rising = 1
            activity.top = speed
            _remember_start(activity, _rise(track, pose))
    elif moving:
        _find_minimum(activity, speed, pose)


cdef inline double mean_speed(Track* track, int64_t pose) noexcept nogil:
    """Return the mean speed over the last `AVERAGED` seconds up to a pose, m/s."""
    cdef double total, time
    cdef int64_t count
    total = 0.0
    count = 0
    time = track.times[pose % RING]
    while pose - count > track.first and time - track.times[(pose - count) % RING] < AVERAGED - EARLY:
        total += track.speed[(pose - count) % RING]
        count += 1
    return total / max(count, 1)


cdef inline int64_t _rise(Track* track, int64_t pose) noexcept nogil:
    """Return the pose at which the rise above the threshold began."""
    cdef double last, before
    cdef int64_t here
    here = pose
    last = mean_speed(track, here)
    while here - 1 > max(track.first, pose - LOOK_BACK):
        before = mean_speed(track, here - 1)
        if not before < last:
            break
        here -= 1
        last = before
    return here


cdef inline void _find_minimum(MoveActivity* activity, double speed, int64_t pose) noexcept nogil:
    cdef double significant
    significant = SIGNIFICANT * activity.range
    if activity.rising == 1:
        activity.top = max(activity.top, speed)
        if speed < activity.top - significant:
            activity.rising = 0
            activity.low = speed
            activity.low_pose = pose
    elif speed < activity.low:
        activity.low = speed
        activity.low_pose = pose
    elif speed > activity.low + significant:
        activity.rising = 1
        activity.top = speed
        _remember_start(activity, activity.low_pose)


cdef inline void _remember_start(MoveActivity* activity, int64_t pose) noexcept nogil:
    cdef int64_t i
    for i in range(STARTS - 1, 0, -1):
        activity.starts[i] = activity.starts[i - 1]
    activity.starts[0] = pose
