"""Clock: takes, frame numbers and time of one performer, and counters of used and dropped frames."""

cdef double TIME_ROUNDING = 1e-06  # s, for the rounding of timestamps: the origin of the clock must not matter
cdef enum:
    IN_TIME = 0  # where in the take a frame lies
    IN_VAIN = 1
    BEYOND = 2

cdef struct Clock:
    int64_t channel  # 0 of the body, then those of limbs; events carry it
    int64_t take
    int64_t open  # whether a take is open
    int64_t next_frame  # number of the next one
    double time  # s, of the last frame that came in time
    int64_t used_frame  # its number
    double seen_time  # s, of the last processed frame with a joint
    int64_t shown_frame  # number of the last frame in time with a joint, processed or not
    double shown_time  # s, of that frame
    double taken_time  # s, of the last processed frame; see `comes_too_soon`


cdef struct Counters:  # since the row was made
    int64_t frames
    int64_t out_of_order
    int64_t outliers
    int64_t held
    int64_t gaps
    int64_t unseen  # without a single joint


cdef inline int64_t place_in_time(Clock* clock, double time, double max_pause) noexcept nogil:
    """Tell where in the take a frame lies.

    Args:
        clock: CLOCK.
        time: s, of the frame.
        max_pause: s.

    Returns:
        IN_TIME for a frame that can be processed; IN_VAIN for one without a time, or not later than the last one;
        BEYOND for one before which the take ends, since its time is so far from the last one's.
    """
    cdef double dt
    if not abs(time) < INFINITY:
        return IN_VAIN
    if clock.open == 0:
        return IN_TIME
    dt = time - clock.time
    if dt > max_pause or dt < -max_pause:
        return BEYOND
    return IN_VAIN if dt <= 0.0 else IN_TIME


cdef inline bint is_left_alone(Clock* clock, double time, double max_pause) noexcept nogil:
    """Return whether no joint was seen for longer than `max_pause`, s, before a frame without a joint: the take ends."""
    return clock.open == 1 and time - clock.seen_time > max_pause


cdef inline bint comes_too_soon(Clock* clock, double time, double spacing) noexcept nogil:
    """Return whether a frame follows the last processed one by less than the spacing, s, and is skipped."""
    return clock.open == 1 and time - clock.taken_time < spacing


cdef inline void note_time(Clock* clock, double time) noexcept nogil:
    """Note a frame that came in time."""
    clock.time = time
    clock.used_frame = clock.next_frame


cdef inline void note_shown(Clock* clock) noexcept nogil:
    """Note that there is a joint in the frame that came in time last."""
    clock.shown_frame = clock.used_frame
    clock.shown_time = clock.time


cdef inline void count_frame(Clock* clock, Counters* counters) noexcept nogil:
    """Count a frame, used or not."""
    clock.next_frame += 1
    counters.frames += 1


cdef void end_take(Clock* clock) noexcept nogil:
    """End the take; the next one has the next number, and frames are numbered from 0."""
    clock.open = 0
    clock.take += 1
    clock.next_frame = 0
