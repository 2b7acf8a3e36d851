"""Scales: extent, speed and rest pose of a performer's movements, so that evidence needs no unit and no tempo.

    A  extent of the movements: rms distance of the joints from a slow mean of the pose
    V  usual speed: rms of the speed u
    τ  own time: A / V, in which the performer covers the extent of the movements; it doubles when the same person moves half as
       fast
    H  pose in which the performer dwells: mean of the poses, each weighted by 1 / (1 + (u / 0.3 V)²)
    g  steadiness: 1 for performers who linger (u < 0.3 V) little of the time, 0 for those who linger often

u is the rms over the joints of their speed over a tenth of a second. All are leaky sums with a weak prior.
Only that prior contains metres.
"""

cdef double SCALES_HALF_LIFE = 20.0  # s
cdef double REST_POSE_HALF_LIFE = 30.0
cdef double PRIOR_EXTENT = 0.05  # m and m/s, as if seen for one second
cdef double PRIOR_SPEED = 0.1
cdef double PRIOR_DWELT = 2.0  # s, weight of the first pose, as if held for so long
cdef double SLOW = 0.3  # share of V below which a performer dwells
cdef double LEAST_USUAL_SPEED = 0.0001  # m/s and m, of performers who never move
cdef double LEAST_EXTENT = 1e-05
cdef double ORDINARY = 0.25  # s, A / V of ordinary movements
cdef double SPEED_OFFSET = 0.1  # V, added to speeds before the logarithm
cdef double QUICKEST = 0.5  # limits of the tempo relative to it
cdef double SLOWEST = 2.0
# Shares of the time in which steady performers linger at most, and others at least. Medians of the labelled sets: punches 0.10,
# exercises 0.16, pick and place and gestures 0.27, at any speed from x0.6 to x2.5.
cdef double LINGERS_LITTLE = 0.16
cdef double LINGERS_OFTEN = 0.26
cdef double PRIOR_LINGERED = 0.25  # s, of the one second of the prior
cdef double STEADY_SLOWEST = 1.0  # added to the limit SLOWEST for steady performers
cdef double LEAST_OWN_TIME = 0.08  # s, limits of τ
cdef double MOST_OWN_TIME = 4.0
cdef double HAND = 0.15  # m; a larger extent does not count as slower

cdef struct Scales:
    double speed  # m/s, u of the last frame
    double speed_weight  # s
    double lingered  # s, part of `speed_weight` in which the performer lingered
    double squared_speed  # m²/s
    double spread_weight  # s
    double spread  # m² s
    double dwelt  # s, weight of the pose H
    double own_time  # s, τ within limits, at the last pose that was kept


cdef void start_scales(Scales* scales, Floats body, int64_t joints) noexcept nogil:
    """Begin a take with the prior, in the first pose."""
    start_mean(body, joints, MEAN_X)
    start_mean(body, joints, REST_X)
    scales.speed = 0.0
    scales.speed_weight = scales.spread_weight = 1.0
    scales.lingered = PRIOR_LINGERED
    scales.squared_speed = PRIOR_SPEED * PRIOR_SPEED
    scales.spread = PRIOR_EXTENT * PRIOR_EXTENT
    scales.dwelt = PRIOR_DWELT
    _set_own_time(scales)


cdef inline void follow_scales(Scales* scales, double squares, double dt) noexcept nogil:
    """Add the speed of a frame.

    Args:
        scales: SCALES.
        squares: m²/s², mean over the joints of their squared speed.
        dt: s since the last frame.
    """
    cdef double kept
    kept = exp2(-dt / SCALES_HALF_LIFE)
    scales.speed = sqrt(squares)
    scales.squared_speed = scales.squared_speed * kept + squares * dt
    scales.speed_weight = scales.speed_weight * kept + dt
    scales.lingered = scales.lingered * kept + (dt if lingers(scales) else 0.0)


cdef inline bint lingers(Scales* scales) noexcept nogil:
    """Return whether the performer is slow at the last frame."""
    return scales.speed < SLOW * usual_speed(scales)


cdef inline void follow_poses(Scales* scales, Floats body, int64_t joints, double dt) noexcept nogil:
    """Add a pose that stands for `dt` seconds.

    Args:
        scales: SCALES.
        body: See joint_pages.pxi.
        joints: Number of joints that can move relative to the centre.
        dt: s.
    """
    cdef double ratio, dwelling, squares, kept
    cdef float share, toward_rest
    ratio = scales.speed / (SLOW * usual_speed(scales))
    dwelling = dt / (1.0 + ratio * ratio)
    scales.dwelt = scales.dwelt * exp2(-dt / REST_POSE_HALF_LIFE) + dwelling
    share, toward_rest = <float>min(dt / MEAN_TIME, 1.0), <float>(dwelling / scales.dwelt)
    squares = squared_distance(body, MEAN_X)
    follow_mean(body, MEAN_X, share)
    follow_mean(body, REST_X, toward_rest)
    kept = exp2(-dt / SCALES_HALF_LIFE)
    scales.spread = scales.spread * kept + squares / joints * dt
    scales.spread_weight = scales.spread_weight * kept + dt
    _set_own_time(scales)


cdef inline void _set_own_time(Scales* scales) noexcept nogil:
    """Set τ."""
    scales.own_time = min(max(extent(scales) / usual_speed(scales), LEAST_OWN_TIME), MOST_OWN_TIME)


cdef inline double usual_speed(Scales* scales) noexcept nogil:
    """Return V, m/s."""
    return max(sqrt(scales.squared_speed / scales.speed_weight), LEAST_USUAL_SPEED)


cdef inline double extent(Scales* scales) noexcept nogil:
    """Return A, m."""
    return max(sqrt(scales.spread / scales.spread_weight), LEAST_EXTENT)


cdef inline double tempo_of(Scales* scales, bint own_time) noexcept nogil:
    """Return the slowness of the performer: A / V relative to ordinary, within limits.

    With `own_time`, the slowness of steady performers counts twice. They move on where others stop. The evidence of a change is
    in seconds of the tempo and would otherwise make several key frames of one movement.
    """
    cdef double steady, tempo = extent(scales) / usual_speed(scales) / ORDINARY, slowest = SLOWEST
    if own_time and tempo > 1.0:
        steady = steadiness(scales)
        tempo = pow(tempo, 1.0 + steady)
        slowest += STEADY_SLOWEST * steady
    return min(max(tempo, QUICKEST), slowest)


cdef inline double steadiness(Scales* scales) noexcept nogil:
    """Return g."""
    return min(max((LINGERS_OFTEN - scales.lingered / scales.speed_weight) / (LINGERS_OFTEN - LINGERS_LITTLE), 0.0), 1.0)


cdef inline double hand_time(Scales* scales) noexcept nogil:
    """Return τ with the extent limited to `HAND`, s: the slowness of a performer, regardless of the extent of the movements."""
    return min(extent(scales), HAND) / usual_speed(scales)


cdef double rest_distance(Floats body, int64_t joints) noexcept nogil:
    """Return the rms distance of the joints from the pose H, m."""
    return sqrt(squared_distance(body, REST_X) / joints)
