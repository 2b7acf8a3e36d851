r"""Activity: whether the performer moves or rests, reported while it happens.

The signal is the rms speed of the joints over the last tenth of a second, which every level measures for its features.
Two lines make the hysteresis: the performer moves once the speed has been above the upper line for `ONSET_CONFIRMED`;
after exact stillness, which shows that there is no noise, the first frame above it is enough. A rest needs a speed below
the lower line for the setting `rest_seconds`, so a turning point is not a rest. Both lines rise with the speed that the
sensor's noise adds.

    speed    ___/‾‾‾\_/‾‾‾‾\_______________
                ^start           ^start of the rest
    moving       ├──────────────────┤ ... reported after rest_seconds

The latest bouts are kept, so that a segment knows when the performer moved in it.
"""

# m/s, rms over the joints. Labelled recordings rest at 0.02 to 0.03, and turn at less than 0.06 for a frame or two.
cdef double UPPER_LINE = 0.06
cdef double LOWER_LINE = 0.04
# Factors of the speed that the noise adds at its quietest and, for the begin of a movement, of the speed that it adds now,
# which follows joints that jump. In ten minutes of standing with 5 mm of noise two frames in a row reach 2.7 and 2.1 times
# at most, those of limbs included.
cdef double UPPER_NOISE = 2.5
cdef double UPPER_NOISE_NOW = 2.2
cdef double LOWER_NOISE = 2.0
cdef double ONSET_CONFIRMED = 0.03  # s above the upper line: a second frame at 30 Hz
# s at the start of a take, in which the speed spans too little time and noise is not known
cdef double ACTIVITY_SETTLING = 0.15
cdef double BRIEF_BOUT = 0.15  # s; a bout that reaches into a segment for so long at most does not count in it
cdef enum:
    IS_RESTING = 0  # as events.SEGMENT_STATES
    IS_MOVING = 1
    BOUTS = 6  # kept on a stream, the oldest two becoming one

cdef struct ActivityState:
    int32_t moving
    int32_t changed  # whether that is still to be reported
    int32_t number  # changes in this take
    int32_t joint  # the fastest one when the performer began to move
    int64_t bouts  # that are kept
    double since  # s, when the state began; the take's start at first
    double before  # s, duration of the state before it; NaN at first
    # s; at rest the first frame above the upper line, inf if there is none; in motion the last one above the lower line
    double above


cdef struct Bout:
    double begin  # s
    double end  # s


cdef struct BoutSpan:
    Bout* at
    int64_t count


cdef struct Activity:  # Whether the performer moves, as the functions below need it.
    ActivityState* state  # ACTIVITY_STATE
    BoutSpan bouts  # (bouts,) BOUT, from the oldest to the newest that has ended


cdef void activity_start_activity(ActivityState* state, double time) noexcept nogil:
    """Begin a take at rest."""
    state.moving = state.changed = state.number = 0
    state.joint = -1
    state.bouts = 0
    state.since = time
    state.before = NAN
    state.above = INFINITY


cdef inline void activity_follow_activity(
    Activity* activity, Floats body, double speed, (double, double) noises, (double, bint) moment, double rest_seconds
) noexcept nogil:
    """Process the speed of a frame.

    Args:
        activity: Activity; `state.changed` is set where the state changes.
        body: See joint_pages.pxi; the log speeds are those of the frame.
        speed: m/s, rms over the joints.
        noises: m/s, the speed that the sensor's noise adds: at its quietest of late, and now.
        moment: s, and whether nothing at all had moved before: a speed above the line then counts at once.
        rest_seconds: s.
    """
    cdef ActivityState* state
    cdef double noise, noise_now, time
    cdef bint after_stillness, is_settled
    state = activity.state
    noise, noise_now = noises
    time, after_stillness = moment
    if state.moving == 1:
        if speed > max(LOWER_LINE, LOWER_NOISE * noise):
            state.above = time
        elif time - state.above >= rest_seconds - MARGIN:
            _rest(activity)
    elif speed > max(UPPER_LINE, UPPER_NOISE * noise, UPPER_NOISE_NOW * noise_now):
        state.above = min(state.above, time)
        is_settled = state.number > 0 or time - state.since >= ACTIVITY_SETTLING - MARGIN
        if after_stillness or is_settled and time - state.above >= ONSET_CONFIRMED - MARGIN:
            state.joint = _fastest(body)
            _activity_change(state, IS_MOVING)
            state.above = time
    else:
        state.above = INFINITY


cdef bint rests_at_end(Activity* activity, double time) noexcept nogil:
    """Change to resting at the end of a take if the speed was below the line in its last frame; return whether it was."""
    cdef ActivityState* state
    state = activity.state
    if state.moving == 0 or not state.above < time:
        return False
    _rest(activity)
    return True


cdef inline (double, double) noises_of_speed(Noise* noise, int64_t joints, bint is_filtered) noexcept nogil:
    """Return the speed that the sensor's noise adds, m/s: at its quietest of late, and now.

    Args:
        noise: NOISE.
        joints: Number of joints that can move relative to the centre.
        is_filtered: Whether the speed is that of poses in the low-pass filter, see candidate_features.noise_of_speed.
    """
    cdef double now, quietest, added, share
    if noise.step <= 0.0 or noise.known == 0 and noise.silent == 1:
        return 0.0, 0.0
    now = max(noise.estimate, noise.aside)
    quietest = min(now, noise.quietest) if noise.quietest > 0.0 else now
    added = noise.step / SPEED_WINDOW / joints
    if is_filtered:
        share = noise.step / (noise.step + SMOOTHING)
        added *= sqrt(share / (2.0 - share))
    return quietest * added, now * added


cdef void _rest(Activity* activity) noexcept nogil:
    """Change from moving to resting."""
    _keep_bout(activity)
    _activity_change(activity.state, IS_RESTING)


cdef void _activity_change(ActivityState* state, int64_t moving) noexcept nogil:
    """Change the state, which began at `above`; a resting performer waits for a first frame above the line."""
    state.before = state.above - state.since if state.number > 0 else NAN
    state.since = state.above
    state.above = INFINITY
    state.moving = moving
    state.number += 1
    state.changed = 1


cdef int64_t _fastest(Floats body) noexcept nogil:
    """Return the joint that moves fastest; -1 if there is none."""
    cdef int64_t j, best, k
    cdef double most
    best, most = -1, -INFINITY
    for j in range(body.count // LINES):
        k = place(j)
        if body.at[k + LIVE] > 0.0 and body.at[k + LOG_SPEED] > most:
            best, most = j, body.at[k + LOG_SPEED]
    return best


cdef void _keep_bout(Activity* activity) noexcept nogil:
    """Keep the bout that ends."""
    cdef ActivityState* state
    cdef BoutSpan bouts
    cdef int64_t i
    state = activity.state
    bouts = activity.bouts
    if state.bouts == bouts.count:
        bouts.at[0].end = bouts.at[1].end
        for i in range(1, bouts.count - 1):
            bouts.at[i].begin, bouts.at[i].end = bouts.at[i + 1].begin, bouts.at[i + 1].end
        state.bouts -= 1
    bouts.at[state.bouts].begin, bouts.at[state.bouts].end = state.since, state.above
    state.bouts += 1


cdef (double, double) active_span(
    Activity* activity, double begin, double end, double path, double late
) noexcept nogil:
    """Return the times of the first and the last movement in a segment, s; NaN if nothing moved.

    Args:
        activity: Activity.
        begin: s, of the segment.
        end: s.
        path: m, of all joints in the segment.
        late: s, by which bouts begin later than the key frames that are reported of them.
    """
    cdef double first, last, bout_begin, bout_end
    cdef int64_t i
    cdef ActivityState* state
    cdef BoutSpan bouts
    cdef bint is_over
    state = activity.state
    bouts = activity.bouts
    first = last = NAN
    if not path > 0.0:
        return first, last
    for i in range(_first_bout(activity, begin - 2.0 * MARGIN), state.bouts + state.moving):
        is_over = i < state.bouts
        bout_begin = bouts.at[i].begin if is_over else state.since
        bout_end = bouts.at[i].end if is_over else state.above
        if bout_begin > end + late + MARGIN:
            break
        if _is_in_segment(bout_begin, bout_end, begin, end, late):
            first = min(max(bout_begin, begin), end) if isnan(first) else first
            last = max(min(bout_end, end), first)
    return first, last


cdef inline int64_t _first_bout(Activity* activity, double time) noexcept nogil:
    """Return the place of the first bout that ends at a time, s, or later, by bisection: a recording has many."""
    cdef int64_t low, high, middle
    low, high = 0, activity.state.bouts
    while low < high:
        middle = (low + high) // 2
        if activity.bouts.at[middle].end < time:
            low = middle + 1
        else:
            high = middle
    return low


cdef inline bint _is_in_segment(double bout_begin, double bout_end, double begin, double end, double late) noexcept nogil:
    """Return whether a bout is one of a segment: a brief one where it begins, others where more than `BRIEF_BOUT` lies."""
    cdef double inside
    cdef bint covers
    if bout_end - bout_begin <= 2.0 * BRIEF_BOUT + late + MARGIN:
        return begin - MARGIN <= bout_begin - late < end - MARGIN
    inside = min(bout_end, end) - max(bout_begin, begin)
    covers = bout_begin <= begin + MARGIN and bout_end >= end - MARGIN
    return inside > BRIEF_BOUT + MARGIN or covers


cdef void put_activity(Clock* clock, EventSpan events, ActivityState* state) noexcept nogil:
    """Put the change of state into the event buffer."""
    cdef Event* event
    state.changed = 0
    event = next_event(clock, events, ACTIVITY_CHANGE)
    event.nature = state.moving
    event.id = state.number
    event.time = state.since
    event.until_time = clock.time
    event.strength = state.before
    event.joint0 = state.joint
