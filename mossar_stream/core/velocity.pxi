"""Velocity: equation 1 of the paper, over a trailing window in seconds, and its smoothing.

The paper's velocity of a joint is the path it travelled over the last `fps` frames; the velocities of the joints
are summed. Live sources run at 10 to 240 Hz with jitter, so the window is in seconds here: a displacement that
ends at t_i counts at time t while t - t_i < window (less a microsecond, so that a constant rate gives exactly
ceil(window · fps) displacements).

Displacements are kept as whole multiples of 2^-40 m: sums of integers neither drift over ten million frames nor
depend on the order of additions, and equal velocities compare equal.
"""

cdef double PATH_UNIT = 2.0 ** (-40)  # m
cdef int64_t MOST_UNITS = 1152921504606846976  # of one displacement, in units: far beyond any body

cdef struct Velocity:  # the displacements in the window: a ring of times, and of steps
    int64_t head  # next place in the ring
    int64_t filled  # entries in the ring
    int64_t travelled  # 2^-40 m, sum of the ring


cdef struct Average:  # the velocities under the moving average: a ring
    int64_t head
    int64_t filled
    int64_t sum  # 2^-40 m


cdef void start_velocity(Velocity* velocity, Average* average) noexcept nogil:
    """Begin with an empty window."""
    velocity.head = 0
    velocity.filled = 0
    velocity.travelled = 0
    average.head = 0
    average.filled = 0
    average.sum = 0


cdef inline bint ring_is_full(Velocity* velocity, Doubles ring_time, double time, double window) noexcept nogil:
    """Return whether the window, s, holds more displacements than the ring has places."""
    if velocity.filled < ring_time.count:
        return False
    return time - ring_time.at[_oldest(velocity, ring_time.count)] < window - TIME_ROUNDING


cdef inline int64_t _oldest(Velocity* velocity, int64_t places) noexcept nogil:
    """Return the place in the ring of the oldest displacement; without a division, which takes long."""
    cdef int64_t place
    place = velocity.head - velocity.filled
    return place + places if place < 0 else place


cdef inline double travel(
    Velocity* velocity, Doubles ring_time, Ints ring_step, double time, double displacement, double window
) noexcept nogil:
    """Add one displacement, drop those that left the window, and return the velocity (equation 1).

    Args:
        velocity: VELOCITY.
        ring_time: (ring,) s.
        ring_step: (ring,) 2^-40 m.
        time: s, at which the displacement ends.
        displacement: m, summed over the joints.
        window: s.

    Returns:
        Path within the window, summed over the joints, m.
    """
    cdef int64_t places, units, tail
    cdef double path
    places = ring_time.count
    path = displacement / PATH_UNIT + 0.5
    units = <int64_t>path if path < MOST_UNITS else MOST_UNITS  # infinite where a damaged snapshot has such positions
    tail = _oldest(velocity, places)
    while velocity.filled > 0 and time - ring_time.at[tail] >= window - TIME_ROUNDING:
        velocity.travelled -= ring_step.at[tail]
        velocity.filled -= 1
        tail = tail + 1 if tail + 1 < places else 0
    ring_time.at[velocity.head] = time
    ring_step.at[velocity.head] = units
    velocity.travelled += units
    velocity.filled += 1
    velocity.head = velocity.head + 1 if velocity.head + 1 < places else 0
    return velocity.travelled * PATH_UNIT


cdef void unroll_velocity(
    Velocity* velocity, Doubles ring_time, Ints ring_step, double* times, int64_t* steps
) noexcept nogil:
    """Copy the window to the beginning of a ring with more places.

    Args:
        velocity: VELOCITY, of the new ring from then on.
        ring_time: (ring,) s.
        ring_step: (ring,) 2^-40 m.
        times: Set.
        steps: Set.
    """
    cdef int64_t i, place = _oldest(velocity, ring_time.count)
    for i in range(velocity.filled):
        times[i], steps[i] = ring_time.at[place], ring_step.at[place]
        place = place + 1 if place + 1 < ring_time.count else 0
    velocity.head = velocity.filled


cdef double moving_average(Average* average, Ints values, double velocity) noexcept nogil:
    """Return the mean of the last wSize velocities, of fewer at the start.

    Args:
        average: AVERAGE.
        values: (smoothing_window,) 2^-40 m.
        velocity: m.
    """
    cdef int64_t units
    units = <int64_t>(velocity / PATH_UNIT)
    if average.filled == values.count:
        average.sum -= values.at[average.head]
    else:
        average.filled += 1
    values.at[average.head] = units
    average.sum += units
    average.head = (average.head + 1) % values.count
    return <double>average.sum / average.filled * PATH_UNIT
