"""Tempo: a measure of slowness, so that the level applies equally to slow and quick performers.

T = sqrt(S / V): S is the squared distance of the joints from a slow mean of the pose, V their squared speed, both
leaky sums. T is the time in which the performer covers the size of their movements. Costs are divided by T relative
to an ordinary tempo, within limits. S follows the poses that are kept of the last seconds, V every frame.
"""

cdef double ORDINARY_PACE = 0.15  # s
cdef double SLOWEST_PACE = 4.0  # limits of the factor
cdef double QUICKEST_PACE = 0.8
cdef double TIME_CONSTANT = 30.0  # s, of the sums
cdef double PRIOR_TIME = 2.0  # s, weight of the prior: an ordinary performer who moved before the take
cdef double PRIOR_PACE_SPEED = 0.5  # m/s

cdef struct Tempo:
    double spread  # m² s, leaky sum of the joints' squared distances from the mean pose
    double squared_speed  # m²/s, leaky sum of their squared speeds


cdef void start_tempo(Tempo* tempo, int64_t joints, int64_t moving, Floats body) noexcept nogil:
    """Begin a take with the prior.

    Args:
        tempo: TEMPO.
        joints: J.
        moving: Number of joints that can move relative to the centre.
        body: See joint_pages.pxi.
    """
    start_mean(body, joints, MEAN_X)
    tempo.spread = moving * PRIOR_TIME * squared(PRIOR_PACE_SPEED * ORDINARY_PACE)
    tempo.squared_speed = moving * PRIOR_TIME * (PRIOR_PACE_SPEED * PRIOR_PACE_SPEED)


cdef inline void follow_speed(Tempo* tempo, Floats body, double dt) noexcept nogil:
    """Add the displacements of a frame.

    Args:
        tempo: TEMPO.
        body: See joint_pages.pxi.
        dt: s since the last frame.
    """
    cdef double squares
    cdef int64_t first
    if dt <= 0.0:
        return
    squares = 0.0
    for first from 0 <= first < body.count // LINES by PAGE:
        squares += page_product(page_of(body, first).at, STEP, STEP)
    tempo.squared_speed = tempo.squared_speed * _kept(dt) + squares / dt


cdef inline void follow_pose(Tempo* tempo, Floats body, double dt) noexcept nogil:
    """Add a pose that stands for `dt` seconds."""
    cdef double squares
    squares = squared_distance(body, MEAN_X)
    follow_mean(body, MEAN_X, <float>min(dt / MEAN_TIME, 1.0))
    tempo.spread = tempo.spread * _kept(dt) + squares * dt


cdef inline double _kept(double dt) noexcept nogil:
    """Return the share of a leaky sum that is left after `dt` seconds."""
    return max(0.0, 1.0 - dt / TIME_CONSTANT)


cdef double pace(Tempo* tempo) noexcept nogil:
    """Return the factor that costs are divided by."""
    return min(max(sqrt(tempo.spread / tempo.squared_speed) / ORDINARY_PACE, QUICKEST_PACE), SLOWEST_PACE)
