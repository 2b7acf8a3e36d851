"""Window step: the work after a frame in which the splitter found something.

The frame step stops after such a frame; this compiled call then reports the finding, updates the window and decides the
key frames that are due. Few frames come here, and it is compiled apart from the work on every frame.
"""

cdef enum:
    FOLLOW = 0  # reasons to call `step_window`
    LEVEL = 1
    END = 2
    RANK = 3
    DECIDE = 4
    REPORTED = 1
    UNREPORTED = 0
cdef double LAST_OF_ALL = 1.7976931348623157e+308  # s, when all labels are due
# a strength so many times the level, or less than one part in so many of it, is a clear decision
cdef double CLEAR = 2.0
cdef double LOG_REST_SPEED = -2.3025851249694824  # log speed of a joint at rest


cdef void step_window(Row* state, Measure* params, Bytes scratch, EventSpan events, int64_t reason) noexcept nogil:
    """Update the window after the last frame.

    Args:
        state: The performer's.
        params: Of the similarity measure.
        scratch: `scratch_size` bytes.
        events: The event buffer, with room for `most_events`.
        reason: FOLLOW after a frame at which the frame step stopped, LEVEL after the level moved, END to end the
            take: RANK to close its last segment and rank all key frames, then DECIDE.
    """
    cdef Window w
    cdef OpenSegment segment
    cdef int64_t begin
    if state.clock.open == 0:
        return
    w = _window_of(state, params, scratch, events)
    segment = open_segment_of(state, params)
    if reason == LEVEL:
        relabel(&w)
        set_due_time(&w)
    elif reason == FOLLOW:
        begin = w.events.used[0]
        if state.activity.changed == 1:
            put_activity(w.clock, w.events, &state.activity)
        _say_what_was_found(&w, &segment, state)
        judge_candidates(&w, w.clock.time)
        set_due_time(&w)
        if w.plan.offline == 0 and is_due(&w):
            _decide_what_is_due(&w, &segment, &state.curve, begin)
    else:
        if reason != DECIDE:
            if rests_at_end(&w.activity, w.clock.taken_time):
                put_activity(w.clock, w.events, &state.activity)
            _close_take(&w, &segment, &state.curve)
        if reason != RANK:
            _decide_all(&w, &segment)


cdef inline Window _window_of(Row* row, Measure* params, Bytes scratch, EventSpan events) noexcept nogil:
    """Return the places of all arrays in a row, the scratch and the event buffer, by the plan and `scratch_size`."""
    cdef uint8_t* begin = <uint8_t*>row
    cdef Plan* plan = &row.plan
    cdef Places* at = &row.at
    cdef int64_t places = plan.capacity + 2
    cdef int64_t counted = 0 if plan.offline == 1 else places
    cdef Window w
    w.plan = plan
    w.clock = &row.clock
    w.joints = &row.joints
    w.state = &row.window
    w.tempo = &row.tempo
    w.scales = &row.scales
    w.dwells = &row.dwells
    w.slots = &row.slots
    w.params = params
    w.history = history_of(row)
    w.labels.state = &row.labels
    w.labels.notes.at, w.labels.notes.count = <Note*>(begin + at.notes), plan.notes
    w.labels.longest = longest_period(&row.scales) if plan.own_time == 1 else LONGEST_PERIOD
    w.labels.ways = &row.ways if plan.own_time == 1 and steadiness(&row.scales) >= LEAST_STEADY else NULL
    w.labels.periods = <Periods*>(begin + (at.adopted if plan.adopts == 1 else at.periods))
    w.activity = activity_of(row)
    w.noise = &row.noise
    w.keys.at, w.keys.count = <Key*>(begin + at.keys), places
    w.order = ints(<int64_t*>(begin + at.order), places)
    w.unused = ints(<int64_t*>(begin + at.unused), plan.slot_count)
    w.summaries = doubles_in_rows(<double*>(begin + at.summaries), plan.slot_count, plan.slot)
    w.counts = ints32_in_rows(<int32_t*>(begin + at.counts), counted + 1, counted)
    w.memo.at, w.memo.count = <Memo*>(begin + at.memo), plan.memo_size
    w.events = events
    w.scratch = _scratch_of(plan, scratch)
    return w


cdef int64_t scratch_size(Plan* plan) noexcept nogil:
    """Return the bytes of the arrays to work in."""
    return 8 * ((plan.capacity + SPARE_SUMMARIES) * plan.slot + 2 * plan.padded_joints + 12 * (plan.capacity + 4))


cdef inline Scratch _scratch_of(Plan* plan, Bytes memory) noexcept nogil:
    """Return the places of the arrays in the bytes of a scratch of `scratch_size`."""
    cdef int64_t rows = plan.capacity + SPARE_SUMMARIES
    cdef int64_t places = plan.capacity + 4
    cdef float* pose = <float*>(memory.at + 8 * rows * plan.slot)
    cdef int64_t* integers = <int64_t*>(pose + 4 * plan.padded_joints)
    cdef double* numbers = <double*>(integers + 10 * places)
    cdef Scratch scratch
    scratch.summaries = doubles_in_rows(<double*>memory.at, rows, plan.slot)
    scratch.pose = floats_in_rows(pose, 4, plan.padded_joints)
    scratch.places = ints(integers, places)
    scratch.bounds = ints(integers + places, places)
    scratch.removed = ints(integers + 2 * places, places)
    scratch.active = ints(integers + 3 * places, places)
    scratch.labels = ints(integers + 4 * places, places)
    scratch.links = integers + 5 * places
    scratch.costs = doubles(numbers, places)
    scratch.strengths = doubles(numbers + places, places)
    return scratch


cdef inline void _say_what_was_found(Window* w, OpenSegment* segment, Row* state) noexcept nogil:
    """Report the finding of the splitter, and add the key frame if there is one."""
    cdef Curve* curve
    cdef int64_t happened, slot, kind, frame
    cdef FoundInFrame* found
    cdef Clock* clock
    cdef Point point
    curve = &state.curve
    found = &curve.found
    clock = w.clock
    happened = found.happened
    found.happened = 0
    if happened & REPLACED:
        _put_candidate(w, KEY_WITHDRAWN, found.former_frame, found.former_time, found.former_share)
    if happened & PROMOTED:
        _put_candidate(w, KEY_CANDIDATE, found.frame, found.time, found.share)
    if happened & FORGOTTEN:
        _put_candidate(w, KEY_WITHDRAWN, found.frame, found.time, found.share)
    if happened & (CROSSED | ACCEPTED) == 0:
        return
    add_waiting_frames(segment)
    slot = segment.state.closed
    segment.state.closed = NO_SLOT
    if happened & CROSSED:
        kind, frame = KIND_ONSET if curve.moving == 1 else KIND_OFFSET, clock.used_frame
        point = Point(kind, frame, frame, clock.time, curve.share, UNKNOWN_STRENGTH)
        _add_key(w, slot, state, point, FIRST_MESSAGE)
    else:
        point = Point(KIND_MINIMUM, found.frame, found.frame, found.time, found.share, UNKNOWN_STRENGTH)
        _add_key(w, slot, state, point, SECOND_MESSAGE)
    note_pauses(w)
    if w.plan.offline == 0:
        rank(w, NO_SLOT)
        relabel(w)
        w.state.ranked = 1
        set_due_time(w)


cdef void _add_key(Window* w, int64_t slot, Row* state, Point point, int64_t rev) noexcept nogil:
    """Add a key frame to the window, with its features if the measure asks for them."""
    cdef double noise, time, rest_distance, speed
    cdef int64_t reported, frame
    cdef Point placed
    cdef Candidate* candidate
    cdef Scales* scales
    cdef Features features
    if w.plan.has_features == 0:
        add_key(w, slot, point, point.time, rev, REPORTED)
        return
    candidate = &state.candidate
    scales = &state.scales
    noise = noise_of_speed(&state.noise, w.plan.moving_joints)
    features = features_of(candidate, scales, w.plan.own_time == 1, noise, state.joints.moving)
    write_features(w.params, row_of_doubles(w.summaries, slot), features)
    reported = UNREPORTED
    if is_reported(candidate, scales, point.time, noise):
        reported = REPORTED
        candidate.reported_time, candidate.reported_speed = point.time, candidate.speed
        candidate.peak = 0.0
    frame, time = point.frame, point.time
    if candidate.before < candidate.frame:
        frame, time = candidate.frame, candidate.time
    candidate.before = frame
    rest_distance, speed = candidate.rest_distance / extent(scales), candidate.speed / usual_speed(scales)
    note_candidate(&w.labels, point.time, time, rest_distance, speed)
    placed = Point(point.kind, point.id, frame, time, point.velocity, point.strength)
    add_key(w, slot, placed, point.time, rev, reported)


cdef void _put_candidate(Window* w, int64_t status, int64_t frame, double time, double share) noexcept nogil:
    cdef int64_t rev, decided
    cdef Point point
    rev = FIRST_MESSAGE if status == KEY_CANDIDATE else SECOND_MESSAGE
    decided = UNDECIDED if status == KEY_CANDIDATE else DECIDED
    point = Point(KIND_MINIMUM, frame, frame, time, share, UNKNOWN_STRENGTH)
    put_key_frame(w.clock, w.events, point, status, rev, decided)


cdef inline void _decide_what_is_due(Window* w, OpenSegment* segment, Curve* curve, int64_t begin) noexcept nogil:
    """Decide the oldest key frames while there are more than W or they are older than `remerge_seconds`.

    If several are due and cause more than `most_events`, the rest is left for the next frame.
    """
    cdef int64_t open_slot, end_frame, last
    cdef bint clear
    add_waiting_frames(segment)
    open_slot = NO_SLOT
    end_frame = curve.candidate if curve.candidate >= 0 else curve.run_frame
    last = begin + w.plan.most_events - (4 * w.plan.capacity + 12)  # with room for one more decision
    while is_due(w):
        if w.events.used[0] >= last:
            break
        clear = _is_clear(w)
        if open_slot == NO_SLOT and (w.keys.at[0].kept == 1 or not clear):
            open_slot = _gather_open(w, segment)
        if not clear:
            rank(w, open_slot)
            relabel(w)
        report_kept(w, 1)
        note_pauses(w)
        segment.state.settled = decide_oldest(w, segment.state.settled, open_slot, end_frame)
        w.state.ranked = 0
    if open_slot != NO_SLOT:
        free_slot(w.slots, w.unused, open_slot)
    set_due_time(w)


cdef inline bint _is_clear(Window* w) noexcept nogil:
    """Return whether the frames after the newest key frame hardly change the decision on the oldest one."""
    cdef double strength, beta
    if w.plan.has_features == 1 or w.plan.rests == 1:  # which changes with later frames
        return False
    strength, beta = w.keys.at[0].strength, w.plan.beta
    return w.state.ranked == 1 and (strength >= CLEAR * beta or CLEAR * strength <= beta)


cdef inline int64_t _gather_open(Window* w, OpenSegment* segment) noexcept nogil:
    """Return a slot with the closed summary of everything since the newest key frame."""
    cdef int64_t open_slot
    cdef Doubles own
    open_slot = take_slot(w.slots, w.unused, w.summaries)
    own = row_of_doubles(w.summaries, open_slot)
    merge_into(w.params, own, row_of_doubles(w.summaries, segment.state.settled))
    merge_into(w.params, own, row_of_doubles(w.summaries, segment.state.since))
    merge_into(w.params, own, row_of_doubles(w.summaries, segment.state.run))
    add_last_frame(segment, open_slot)
    flush_sums(w.params, own, segment.body, w.plan.padded_joints)
    close(w.params, own)
    return open_slot


cdef inline void _close_take(Window* w, OpenSegment* segment, Curve* curve) noexcept nogil:
    """Close the last segment and rank all undecided key frames together."""
    cdef Doubles settled
    cdef int64_t j
    place_last_frame(segment, curve.candidate, curve.run_length, curve.run_length < 0)
    add_waiting_frames(segment)
    if curve.candidate >= 0:
        _put_candidate(w, KEY_WITHDRAWN, curve.candidate, curve.candidate_time, curve.candidate_share)
        forget_candidate(curve)
        settle(segment)
    if curve.awaiting == 1 and w.state.undecided > 0:
        _withdraw_newest(w, segment)
    settled = row_of_doubles(w.summaries, segment.state.settled)
    if w.plan.post_roll > 0.0:
        flatten(segment.body, segment.pose)
        for j in range(w.plan.padded_joints):
            segment.pose.at[3 * segment.pose.columns + j] = LOG_REST_SPEED
        add_pose(w.params, settled, segment.pose, w.plan.joints, w.clock.time, w.plan.post_roll)
    note_pauses(w)
    judge_candidates(w, LAST_OF_ALL)
    close(w.params, settled)
    rank(w, segment.state.settled)


cdef inline void _withdraw_newest(Window* w, OpenSegment* segment) noexcept nogil:
    """Take back the newest key frame, confirmed early, since the maximum that accepts it never came."""
    cdef int64_t newest, slot
    cdef Key* key
    cdef Point point
    newest = w.state.undecided - 1
    key = &w.keys.at[newest]
    if w.plan.offline == 0 and key.before != NOT_KEPT:
        put_segment(w, key.before, newest, SEGMENT_WITHDRAWN)
    point = point_of(key, key.at_frame, key.at_time, UNKNOWN_STRENGTH)
    put_key_frame(w.clock, w.events, point, KEY_WITHDRAWN, key.rev + 1, DECIDED)
    slot = w.order.at[newest]
    merge_into(w.params, row_of_doubles(w.summaries, slot), row_of_doubles(w.summaries, segment.state.settled))
    free_slot(w.slots, w.unused, segment.state.settled)
    segment.state.settled = slot
    w.state.undecided -= 1
    w.state.ordinal -= 1
    if w.plan.has_features == 1:
        forget_newest(&w.labels)


cdef inline void _decide_all(Window* w, OpenSegment* segment) noexcept nogil:
    """Decide all undecided key frames by their strengths, and end the take."""
    cdef int64_t settled
    relabel(w)
    report_kept(w, w.state.undecided)
    while w.state.undecided > 0:
        settled = segment.state.settled
        segment.state.settled = decide_oldest(w, settled, settled, w.clock.used_frame + 1)
    _put_last_segment(w, segment.state.settled)
    end_take(w.clock)


cdef inline void _put_last_segment(Window* w, int64_t settled) noexcept nogil:
    """Put the final message about the segment from the last final key frame to the end into the event buffer.

    The take ends with the last frame in which a joint was seen.
    """
    cdef int64_t d, places
    cdef bint left
    cdef Event* event
    cdef (int64_t, int64_t, int64_t) bounds
    cdef WindowState* state
    cdef Clock* clock
    cdef DoubleRows summaries
    state = w.state
    clock = w.clock
    summaries = w.scratch.summaries
    for d in range(w.plan.slot):
        summaries.at[OWN * summaries.columns + d] = w.summaries.at[settled * w.summaries.columns + d]
        if state.has_before == 1:
            summaries.at[PREVIOUS * summaries.columns + d] = w.summaries.at[state.before * w.summaries.columns + d]
    event = next_event(clock, w.events, SEGMENT)
    event.id = state.left_id
    event.frame = state.left_frame
    event.time = state.left_time
    left = w.plan.offline == 0 and state.left_time <= clock.shown_time < clock.time
    event.until_frame = clock.shown_frame if left else clock.used_frame
    event.until_time = clock.shown_time if left else clock.time
    event.end_id = event.until_frame
    event.rev = 1
    if w.plan.offline == 0 and state.ordinal > 0 and w.keys.at[0].frame == event.until_frame:
        # A key frame in the last frame, merged: there were messages about a segment of the same name.
        places = w.plan.capacity + 2
        event.rev += w.counts.at[places * w.counts.columns + (state.ordinal - 1) % places]
    bounds = BEFORE_WINDOW, state.left_ordinal, UNKNOWN_BOUNDARY
    window_describe(w, event, state.has_before == 1, SEGMENT_FINAL, bounds)
