"""Rests: which key frames begin and end a hold or a rest, with the setting `rests=keep`.

A rest is the time between two bouts of movement (activity.pxi) if it lasts `SHORTEST_REST`, of slow performers longer. The
candidate of Algorithm 2 nearest to its begin, and the one nearest to its end, are key frames at every named level; those
between them are not. Decisions made before a rest has lasted so long stay. With `tempo`, the only rest in each counted
repetition is a pause between two of them, and one key frame. Where the sensor's noise alone is as fast as a movement no rest
is judged: a seeming rest may be slow movement. With 5 mm of white noise that noise is 0.07 to 0.18 m/s on the labelled sets,
as recorded at most 0.052.
"""

cdef double SHORTEST_REST = 0.6  # s; shorter rests are part of the movement
# With `tempo` slow performers must rest for longer: so many seconds more for each second of τ above this one. Raising an
# arm in 0.8 s and holding it for 1 s gives a τ of 0.5 s; slow exercises with as long pauses give 0.6 s and more.
cdef double REST_GROWS = 3.0
cdef double REST_GROWS_FROM = 0.44  # s
# Of the period; if the last rest began before that, there is one rest in each repetition: a pause between two of them.
cdef double ONE_REST = 0.75
# s, by which the activity shows the end, and the begin, of a movement later than key frames: by the holds that were made
cdef double LATE_REST = 0.05
cdef double LATE_BOUT = 0.17
cdef double NEAR_REST = 0.35  # s, from there to a key frame
cdef double OTHER_KIND = 0.1  # s, that a key frame which is no crossing counts as farther off
cdef double UNSURE = 0.5  # s; while a rest goes on, key frames as new as this may belong to the next movement
cdef enum:
    LEFT_END = -1  # in place of a key frame: the window's left end; none
    NO_KEY = -2


cdef void label_rests(Window* w, int64_t count) noexcept nogil:
    """Set the labels of the first `count` key frames of a window that begin or end rests, or lie within one.

    Args:
        w: Window; `scratch.labels` is set.
        count: Number of key frames.
    """
    cdef int64_t b, i
    cdef ActivityState* state
    cdef BoutSpan bouts
    cdef double quietest, _, begin, end, shortest
    state = w.activity.state
    bouts = w.activity.bouts
    for i in range(count):
        w.keys.at[i].rests = 0
    shortest = _shortest_rest(w)
    quietest, _ = noises_of_speed(w.noise, w.plan.moving_joints, True)
    if quietest > UPPER_LINE:
        return
    _note_order(w, count)
    for b in range(-1, state.bouts):
        begin = w.state.left_time if b < 0 else bouts.at[b].end
        if b < 0 and w.state.left_ordinal >= 0:  # the take began earlier
            continue
        end = INFINITY
        if b + 1 < state.bouts:
            end = bouts.at[b + 1].begin
        elif state.moving == 1:
            end = state.since
        begin, end = begin - LATE_REST, end - LATE_BOUT
        if _is_pause(w, b, shortest):
            continue
        if min(end, w.clock.time) - begin >= shortest - MARGIN and end + NEAR_REST >= w.state.left_time - MARGIN:
            _judge_rest(w, count, begin, end, b < 0)


cdef inline double _shortest_rest(Window* w) noexcept nogil:
    """Return the least duration of a rest, s."""
    if w.plan.own_time == 0:
        return SHORTEST_REST
    return SHORTEST_REST + REST_GROWS * max(0.0, w.scales.own_time - REST_GROWS_FROM)


cdef bint _is_pause(Window* w, int64_t bout, double shortest) noexcept nogil:
    """Return whether the rest after a bout is the only one of a repetition that is counted."""
    cdef BoutSpan bouts = w.activity.bouts
    cdef double period, before
    if w.plan.own_time == 0 or bout < 0:
        return False
    period = _period_at(w.labels.periods, bouts.at[bout].end)
    if not 0.0 < period <= w.labels.longest + MARGIN:
        return False
    if bout > 0:
        before = bouts.at[bout - 1].end
        if bouts.at[bout].end - before <= ONE_REST * period and bouts.at[bout].begin - before >= 0.5 * shortest:
            return False
    # In recordings, where the first rest is judged late, the next one is known.
    return not (bout + 1 < w.activity.state.bouts and bouts.at[bout + 1].end - bouts.at[bout].end <= ONE_REST * period)


cdef void _note_order(Window* w, int64_t count) noexcept nogil:
    """Note of each key frame the latest time up to it, and the earliest from it on, s, so that `_keys_between` finds some.

    Key frames that were placed at candidates are nearly, but not always, in the order of their times. The scratch is
    that of costs and strengths, which are computed later.
    """
    cdef int64_t i
    cdef double latest, earliest
    latest, earliest = -INFINITY, INFINITY
    for i in range(count):
        latest = max(latest, w.keys.at[i].at_time)
        w.scratch.costs.at[i] = latest
    for i in range(count - 1, -1, -1):
        earliest = min(earliest, w.keys.at[i].at_time)
        w.scratch.strengths.at[i] = earliest


cdef (int64_t, int64_t) _keys_between(Window* w, int64_t count, double begin, double end) noexcept nogil:
    """Return the first key frame, and the one behind the last, between which all lie whose times are in between, s."""
    return _count_until(w.scratch.costs, count, begin), _count_until(w.scratch.strengths, count, end)


cdef int64_t _count_until(Doubles times, int64_t count, double time) noexcept nogil:
    """Return the number of ascending times up to this one, s."""
    cdef int64_t low, high, middle
    low, high = 0, count
    while low < high:
        middle = (low + high) // 2
        if times.at[middle] <= time:
            low = middle + 1
        else:
            high = middle
    return low


cdef void _judge_rest(Window* w, int64_t count, double begin, double end, bint is_first) noexcept nogil:
    """Set the labels of the key frames of one rest; the one that a take begins with has no key frame at its begin."""
    cdef int64_t first, last, i, some, behind
    cdef double after, before
    first = NO_KEY if is_first else _rests_nearest(w, count, begin, KIND_OFFSET)
    last = _rests_nearest(w, count, end, KIND_ONSET) if end < INFINITY else NO_KEY
    after = _time_of(w, first, begin)
    before = _time_of(w, last, min(end, w.clock.time - UNSURE))
    some, behind = _keys_between(w, count, after, before)
    for i in range(some, behind):
        if after + MARGIN < w.keys.at[i].at_time < before - MARGIN:
            w.scratch.labels.at[i] = WITHIN
    if first >= 0:
        w.scratch.labels.at[first] = ENDS
        w.keys.at[first].rests = 1
    if last >= 0:
        w.scratch.labels.at[last] = ENDS
        w.keys.at[last].rests = 1


cdef int64_t _rests_nearest(Window* w, int64_t count, double time, int64_t kind) noexcept nogil:
    """Return the key frame that is nearest to a time, s, if there is one near; of two at the same distance the first."""
    cdef int64_t i, best, some, behind
    cdef double least, distance
    best, least = NO_KEY, NEAR_REST
    if w.state.left_ordinal >= 0 and abs(w.state.left_time - time) < least - MARGIN:
        best, least = LEFT_END, abs(w.state.left_time - time)
    some, behind = _keys_between(w, count, time - NEAR_REST, time + NEAR_REST)
    for i in range(some, behind):
        distance = abs(w.keys.at[i].at_time - time)
        if w.keys.at[i].kind != kind:
            distance += OTHER_KIND
        if distance < least - MARGIN:
            best, least = i, distance
    return best


cdef double _time_of(Window* w, int64_t place, double otherwise) noexcept nogil:
    """Return the reported time of a key frame, s; some other time where there is none."""
    if place >= 0:
        return w.keys.at[place].at_time
    return w.state.left_time if place == LEFT_END else otherwise
