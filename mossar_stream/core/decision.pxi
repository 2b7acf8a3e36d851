"""Decision: the due time of the oldest undecided key frame, and its way out of the window."""

cdef enum:
    OLDEST_KEY = 0
    STILL_NEAR = 4  # newest key frames, whose dwells may go on

# With `tempo`, and before the performer's repetitions are counted, slow performers' key frames wait longer: the first cycle of
# a slow exercise lasts several seconds. No performer of the labelled sets is slow enough at the original speed.
cdef double WAITS_FROM = 0.5  # s that a hand's width (`hand_time`) takes
cdef double WAITS_MORE = 20.0  # s of waiting added for each second above that
cdef double WAITS_AT_MOST = 3.0  # times the ordinary waiting time


cdef inline void set_due_time(Window* w) noexcept nogil:
    """Set the time at which the oldest undecided key frame must be decided, or a label of a candidate is due."""
    cdef double due
    due = INFINITY
    if w.state.undecided > 0 and w.plan.offline == 0:
        due = w.keys.at[0].time + hold_of(w)
    w.state.due_time = min(due, due_label(&w.labels, label_delay(w)))


cdef inline double hold_of(Window* w) noexcept nogil:
    """Return the age of a key frame at its decision, s."""
    cdef double more
    if w.plan.own_time == 0 or w.labels.periods.clear == 1:
        return w.plan.hold
    more = WAITS_MORE * (hand_time(w.scales) - WAITS_FROM)
    return min(w.plan.hold + max(more, 0.0), WAITS_AT_MOST * w.plan.hold)


cdef inline double label_delay(Window* w) noexcept nogil:
    """Return the age at which a candidate is judged, s; it is not decided earlier. See repetition_labels.pxi."""
    if w.plan.labels_late == 1:
        return LABELLED_LATE
    return hold_of(w) if w.plan.own_time == 1 else min(w.plan.hold, LABELLED_AFTER)


cdef void note_pauses(Window* w) noexcept nogil:
    """Note the middle of the dwell near the oldest key frame and the newest ones, while it is remembered."""
    cdef int64_t i
    if w.plan.own_time == 0 or w.state.undecided == 0:
        return
    _note_pause(w, &w.keys.at[OLDEST_KEY])
    for i in range(max(OLDEST_KEY + 1, w.state.undecided - STILL_NEAR), w.state.undecided):
        _note_pause(w, &w.keys.at[i])


cdef inline void _note_pause(Window* w, Key* key) noexcept nogil:
    """Note the middle of the dwell near a key frame."""
    cdef Moment* moment
    cdef int64_t dwell = dwell_near(w.dwells, key.at_time)
    if dwell != NO_DWELL:
        moment = middle_of(w.dwells, dwell)
        key.pause_frame, key.pause_time = moment.frame, moment.time


cdef void judge_candidates(Window* w, double until) noexcept nogil:
    """Judge the candidates that are due until a time, s, and label their key frames."""
    cdef int64_t first, ordinal, label
    first = w.state.ordinal - w.state.undecided
    while due_label(&w.labels, label_delay(w)) <= until:
        ordinal = w.labels.state.labelled
        label = label_candidate(&w.labels)
        if ordinal >= first and label != UNLABELLED:
            w.keys.at[ordinal - first].label = label
            w.state.ranked = 0


cdef inline bint is_due(Window* w) noexcept nogil:
    """Return whether the oldest key frame must be decided now."""
    cdef WindowState* state
    state = w.state
    if state.undecided == 0:
        return False
    return state.undecided > w.plan.capacity or w.clock.time >= w.keys.at[0].time + hold_of(w)


cdef int64_t decide_oldest(Window* w, int64_t settled, int64_t open_slot, int64_t end_frame) noexcept nogil:
    """Decide the oldest key frame: final if it is kept at the level, merged if not.

    Args:
        w: Window.
        settled: Slot of the open segment that follows the newest key frame.
        open_slot: Slot with the summary of all frames since the newest key frame.
        end_frame: Frame up to which the settled slot is complete. A final key frame moves to a frame before it.

    Returns:
        The slot of the open segment that now follows the newest key frame.
    """
    cdef int64_t i, frame, following, passed
    cdef Event* segment
    cdef double time
    cdef Key* key
    cdef WindowState* state
    key = &w.keys.at[0]
    state = w.state
    if key.kept == 0:
        if key.reported == 1:
            _put_decided(w, OLDEST_KEY, KEY_MERGED, key.at_frame, key.at_time)
        elif key.rev > 0:
            _put_decided(w, OLDEST_KEY, KEY_WITHDRAWN, key.frame, key.time)
        following = w.order.at[1] if state.undecided > 1 else settled
        # The later segment is merged into the earlier one, which then takes its place.
        merge_into(w.params, row_of_doubles(w.summaries, w.order.at[0]), row_of_doubles(w.summaries, following))
        close(w.params, row_of_doubles(w.summaries, w.order.at[0]))
        free_slot(w.slots, w.unused, following)
        if state.undecided > 1:
            w.order.at[1] = w.order.at[0]
        else:
            settled = w.order.at[0]
        _shift(w, 1)
        return settled
    frame, time, passed = _locate(w, open_slot, end_frame)
    _put_decided(w, OLDEST_KEY, KEY_FINAL, frame, time)
    for i in range(1, passed + 1):
        _put_decided(w, i, KEY_MERGED, w.keys.at[i].at_frame, w.keys.at[i].at_time)
    put_segment(w, state.left_ordinal, OLDEST_KEY, SEGMENT_FINAL)
    segment = &w.events.at[w.events.used[0] - 1]
    segment.until_frame = frame
    segment.until_time = time
    note_span(w, segment)
    _decision_leave(w, settled, passed, frame, time)
    return settled


cdef inline (int64_t, double, int64_t) _locate(Window* w, int64_t open_slot, int64_t end_frame) noexcept nogil:
    """Return the best frame and time of the oldest key frame, and the number of others that it passes."""
    cdef Key* key
    cdef int64_t location, passed, back
    cdef Mark* mark
    key = &w.keys.at[0]
    location = w.plan.location
    if location == LOCATION_CANDIDATES:
        passed = best_candidate(w, open_slot)
        return (w.keys.at[passed].frame, w.keys.at[passed].time, passed)
    if location == LOCATION_FREE:
        back = best_pose(w, open_slot, end_frame)
        if back >= 0:
            mark = &w.history.marks.at[place_back(&w.history, back)]
            passed = 0
            while passed + 1 < w.state.undecided and w.keys.at[passed + 1].frame <= mark.frame:
                passed += 1
            return mark.frame, mark.time, passed
    if _lies_in_pause(w):
        return key.pause_frame, key.pause_time, 0
    return key.at_frame, key.at_time, 0


cdef inline bint _lies_in_pause(Window* w) noexcept nogil:
    """Return whether the oldest key frame ends a counted repetition; if it does, it belongs to the middle of the pause there."""
    cdef Key* key = &w.keys.at[0]
    cdef int64_t i, until = w.clock.used_frame + 1
    if key.label != ENDS or key.rests == 1 or key.pause_frame <= w.state.left_frame:
        return False
    for i in range(1, w.state.undecided):
        if w.keys.at[i].label != WITHIN:
            until = w.keys.at[i].at_frame
            break
    return key.pause_frame < until


cdef void _put_decided(Window* w, int64_t place, int64_t status, int64_t frame, double time) noexcept nogil:
    """Append the last event of a key frame to the event buffer."""
    cdef Key* key
    key = &w.keys.at[place]
    key.rev += 1
    put_key_frame(w.clock, w.events, point_of(key, frame, time, key.strength), status, key.rev, DECIDED)


cdef inline void _decision_leave(Window* w, int64_t settled, int64_t passed, int64_t frame, double time) noexcept nogil:
    """Make the oldest key frame, at its new place, the window's left end; merge the `passed` others."""
    cdef bint moves
    cdef int64_t ended, i, following, oldest, ordinal, places, origin
    cdef WindowState* state
    cdef DoubleRows summaries
    state = w.state
    summaries = w.summaries
    oldest, ordinal, origin = w.keys.at[0].frame, w.keys.at[0].ordinal, w.keys.at[passed].frame
    moves = w.plan.location != LOCATION_NONE
    ended = w.order.at[0]
    for i in range(1, passed + 1):
        merge_into(w.params, row_of_doubles(summaries, ended), row_of_doubles(summaries, w.order.at[i]))
        free_slot(w.slots, w.unused, w.order.at[i])
    close(w.params, row_of_doubles(summaries, ended))
    _shift(w, passed + 1)
    following = w.order.at[0] if state.undecided > 0 else settled
    if moves and frame < oldest:
        move_poses(w, ended, following, frame, oldest)
    elif moves and frame > origin:
        move_poses(w, following, ended, origin, frame)
    if state.has_before == 1:
        free_slot(w.slots, w.unused, state.before)
    state.before = ended
    state.has_before = 1
    state.left_frame = frame
    state.left_id = oldest
    state.left_time = time
    state.left_ordinal = ordinal
    places = w.plan.capacity + 2
    for i in range(w.counts.columns):
        w.counts.at[places * w.counts.columns + i] = w.counts.at[ordinal % places * w.counts.columns + i]
    if moves and frame != oldest and w.plan.offline == 0:  # a recording is not ranked after its first decision
        # The first segment has changed, and its remembered costs are void.
        remerging_forget(w.memo, ordinal)


cdef void _shift(Window* w, int64_t count) noexcept nogil:
    """Drop the leftmost key frames and segments; if none is left, the newest key frame stays in place 0.

    A recording has many key frames, all decided in one call. There the start of the window moves right instead.
    """
    cdef int64_t undecided, i
    undecided = w.state.undecided
    if w.plan.offline == 1:
        w.keys.at += min(count, undecided - 1)
        w.order.at += min(count, undecided - 1)
        w.state.undecided -= count
        return
    if count == undecided:
        w.keys.at[0] = w.keys.at[count - 1]
    for i in range(undecided - count):
        w.keys.at[i] = w.keys.at[i + count]
        w.order.at[i] = w.order.at[i + count]
    w.state.undecided -= count
