"""Frame step: the work on each frame, in order.

    clock       in order? or does the take end here?
    joints      present, held, left out; path of each relative to the centre
    velocity    equation 1, smoothing, normalisation
    splitter    Algorithms 1 and 2: candidates, key frames
    summary     the frame before joins the open segment, now that it is known on which side of a candidate it lies
    pose        history and means of the pose

One compiled call processes a chunk of frames; it stops early only where the caller has to act.
"""

cdef enum:
    DONE = 0  # stop codes
    HAPPENED = 1
    TAKE_ENDS = 2
    RING_FULL = 3
    ANALYSIS_DUE = 4
    # In the velocity window; a clock that gives more is wrong, and frames that are too many are dropped.
    MOST_STEPS = 1 << 14
    BY_AVERAGE = 1  # in PLAN.smoothing
    BY_ONE_EURO = 2

cdef struct Arrays:  # A row's arrays, as frames need them.
    Joints joints
    OpenSegment segment
    PoseHistory history
    Activity activity
    Counting* counting  # of repetitions, if they are counted here
    Samples samples  # likewise
    Periods* periods  # by which candidates are judged, if there are any
    DoubleRows filtered  # (6, padded_joints), or none
    Doubles ring_time  # (ring,)
    Ints ring_step  # (ring,)
    Ints average  # (smoothing_window,)
    MemoSpan memo  # (memo,) MEMO


cdef int64_t advance(
    Row* state, Measure* params, float* positions, double* times, int64_t count, int64_t* used
) noexcept nogil:
    """Process frames of one performer until they are used up or something happens.

    Args:
        state: The performer's.
        params: Of the similarity measure.
        positions: (count, J, 3) m.
        times: (count,) s.
        count: Their number.
        used: Set to the number of processed frames.

    Returns:
        DONE if all frames were processed; else the caller's next step: HAPPENED `step_window`, TAKE_ENDS end the take before
        the next frame, ANALYSIS_DUE analyse the repetitions before it (`analyse_repetitions`), RING_FULL make more room for
        displacements before it.
    """
    cdef Plan* plan = &state.plan
    cdef Clock* clock = &state.clock
    cdef Arrays a = _arrays_of(state, params)
    cdef PositionSpan frame
    cdef int64_t i, place
    cdef double time
    cdef bint empty
    frame.count = plan.joints
    for i in range(count):
        used[0] = i
        time = times[i]
        frame.at = <Position*>positions + i * plan.joints
        place = place_in_time(clock, time, plan.max_pause)
        if place == BEYOND:
            return TAKE_ENDS
        if plan.ends_alone == 1 and place == IN_TIME and (clock.open == 0 or state.joints.present == 0):
            empty = is_empty(frame)
            if empty and is_left_alone(clock, time, plan.max_pause):
                return TAKE_ENDS
            if empty and clock.open == 0:  # a take begins with the first visible joint
                count_frame(clock, &state.counters)
                count_nobody(&state.counters, frame)
                continue
        if place != IN_VAIN and _is_analysis_due(state, a.counting, time):
            return ANALYSIS_DUE
        if place != IN_VAIN and comes_too_soon(clock, time, plan.spacing):
            note_time(clock, time)
            if plan.ends_alone == 1 and not is_empty(frame):
                note_shown(clock)
            count_frame(clock, &state.counters)
            state.counters.unseen += 1 if state.joints.present == 0 else 0  # like the last judged frame
            continue
        if place != IN_VAIN and clock.open == 1 and ring_is_full(&state.velocity, a.ring_time, time, plan.window):
            if plan.ring < MOST_STEPS:
                return RING_FULL
            place = IN_VAIN
        if place == IN_VAIN:
            state.counters.out_of_order += 1
            count_frame(clock, &state.counters)
            continue
        _take_in(state, &a, frame, time)
        if plan.repetitions == 1:
            take_frame(a.counting, &a.samples, <float*>frame.at, time)
            if plan.own_time == 1 and is_way_longer(&state.ways, a.counting):
                follow_ways(&state.ways, a.counting, &a.samples)
        if state.curve.found.happened != 0 or state.activity.changed != 0 or time >= state.window.due_time:
            used[0] = i + 1
            return HAPPENED
    used[0] = count
    return DONE


cdef inline bint _is_analysis_due(Row* state, Counting* counting, double time) noexcept nogil:
    """Return whether the repetitions must be analysed before a frame."""
    if state.plan.repetitions == 0 or state.clock.open == 0:
        return False
    return time >= counting.due


cdef inline Arrays _arrays_of(Row* row, Measure* params) noexcept nogil:
    """Return the arrays of a row."""
    cdef uint8_t* begin = <uint8_t*>row
    cdef Plan* plan = &row.plan
    cdef Places* at = &row.at
    cdef Arrays a
    a.joints.plan = plan
    a.joints.state = &row.joints
    a.joints.counters = &row.counters
    a.joints.seen = doubles(<double*>(begin + at.seen), plan.padded_joints)
    a.joints.tracked = ints32(<int32_t*>(begin + at.tracked), plan.padded_joints)
    a.joints.body = body_of(row)
    a.segment = open_segment_of(row, params)
    a.history = history_of(row)
    a.activity = activity_of(row)
    a.counting = <Counting*>(begin + at.counted)
    a.samples = stored_samples(begin + at.samples, plan.repetitions * plan.joints)
    a.periods = <Periods*>(begin + (at.adopted if plan.adopts == 1 else at.periods))
    a.filtered = doubles_in_rows(<double*>(begin + at.filtered), 6, plan.filtered_joints)
    a.ring_time = doubles(<double*>(begin + at.ring_time), plan.ring)
    a.ring_step = ints(<int64_t*>(begin + at.ring_step), plan.ring)
    a.average = ints(<int64_t*>(begin + at.average), plan.average_size)
    a.memo.at, a.memo.count = <Memo*>(begin + at.memo), plan.memo_size
    return a


cdef inline void _take_in(Row* state, Arrays* a, PositionSpan frame, double time) noexcept nogil:
    """Process one frame, from its joints to its summary."""
    cdef bint first
    cdef double dt, velocity, value, scale
    cdef Plan* plan
    cdef Clock* clock
    cdef OpenSegment* segment
    cdef Doubles settled
    plan = &state.plan
    clock = &state.clock
    first = clock.open == 0
    dt = 0.0 if first else min(time - clock.taken_time, plan.max_gap)
    if first:
        _open_take(state, a, time)
    velocity = _velocity(state, a, frame, time, dt, first)
    value, scale = normalise(&state.range, plan, state.noise.floor, velocity, dt)
    note_time(clock, time)
    clock.taken_time = time
    if state.joints.present > 0:
        clock.seen_time = time
        note_shown(clock)
    count_frame(clock, &state.counters)
    if first:
        start_curve(&state.curve, value, plan.theta * scale, scale, clock.used_frame, time)
    else:
        if state.joints.complete == 0:
            value = _seen_velocity(state, a, value, time)
        split(&a.segment, &state.curve, clock, value, scale, state.joints.unseen_time < time)
        if plan.has_features == 1:
            _note_features(state, a)
    _describe(state, a, dt, first)
    if first and plan.pre_roll > 0.0:
        segment = &a.segment
        settled = row_of_doubles(segment.summaries, segment.state.settled)
        add_pose(segment.params, settled, segment.pose, plan.joints, time, plan.pre_roll)
    note_last_frame(&state.open_segment, time, dt, state.curve.moving, state.scales.speed)


cdef void _open_take(Row* state, Arrays* a, double time) noexcept nogil:
    """Clear the state of a take; the range and the estimate of the noise outlast it."""
    cdef Plan* plan
    cdef Clock* clock
    cdef OpenSegment* segment
    plan = &state.plan
    clock = &state.clock
    segment = &a.segment
    clock.open = 1
    clock.seen_time = time
    clock.shown_frame, clock.shown_time = clock.next_frame, time
    start_velocity(&state.velocity, &state.average)
    start_noise(&state.noise.recent)
    start_history(&state.history)
    start_slots(segment.slots, segment.unused)
    start_open_segment(segment)
    start_window(&state.window, clock.next_frame, time)
    start_memo(a.memo)
    start_candidate(&state.candidate, clock.next_frame, time)
    start_labels(&state.labels)
    start_dwells(&state.dwells)
    start_ways(&state.ways)
    activity_start_activity(&state.activity, time)
    if plan.repetitions == 1:
        begin(a.counting, &a.samples, time)
    if plan.adopts == 1 or plan.repetitions == 1:
        forget_periods(a.periods)


cdef inline double _velocity(
    Row* state, Arrays* a, PositionSpan frame, double time, double dt, bint first
) noexcept nogil:
    """Return the velocity of a frame (equation 1), smoothed; the first one of a take has none."""
    cdef double displacement, velocity
    cdef Plan* plan
    cdef Clock* clock
    cdef Floats body
    plan = &state.plan
    clock = &state.clock
    body = a.joints.body
    displacement = 0.0
    if first:
        start_joints(&a.joints, frame, time)
    else:
        state.counters.gaps += 1 if time - clock.taken_time > plan.max_gap else 0
        displacement = step_joints(&a.joints, frame, clock.taken_time, time)
        if state.joints.returned == 1:
            resume(&a.joints, &a.history, a.filtered)
    if plan.smoothing == BY_ONE_EURO:
        displacement = filter_joints(plan, body, a.filtered, dt)
    if plan.is_rms == 1:
        displacement = _rms_displacement(plan, body, displacement)
    if plan.noise_margin > 0.0:
        displacement = calm_noise(&state.noise, plan, state.range.largest, body, displacement, dt)
    else:
        hear_aside(&state.noise, body, plan.padded_joints, displacement, dt)
    velocity = travel(&state.velocity, a.ring_time, a.ring_step, time, displacement, plan.window)
    if state.noise.loud == 1:
        velocity = _velocity_in_noise(state, a, time, dt)
    if plan.smoothing == BY_AVERAGE:
        velocity = moving_average(&state.average, a.average, velocity)
    return velocity


cdef double _seen_velocity(Row* state, Arrays* a, double value, double time) noexcept nogil:
    """Return the velocity of a frame in which a joint is missing: an unseen joint neither slows down nor comes to rest.

    While nothing is there that moves, the last velocity stands for `max_gap` seconds, then none: Algorithm 2 finds no
    extremum in either, and a crossing in a frame that was not seen is no key frame.
    """
    cdef double seen
    seen = last_seen(&a.joints)
    if seen >= time:
        return value
    state.joints.unseen_time = time
    return state.curve.value if time - seen <= state.plan.max_gap else 0.0


cdef inline double _rms_displacement(Plan* plan, Floats body, double displacement) noexcept nogil:
    """Return the rms path of the joints times their number: long steps of a few joints weigh more than in the sum.

    Args:
        plan: PLAN.
        body: See joint_pages.pxi.
        displacement: m, the sum, scaled up where joints are missing.
    """
    cdef double path, squares
    cdef int64_t first
    path = line_sum(body, STEP)
    if path <= 0.0:
        return displacement
    squares = 0.0
    for first from 0 <= first < plan.padded_joints by PAGE:
        squares += page_product(page_of(body, first).at, STEP, STEP)
    return sqrt(squares * plan.moving_joints * displacement / path)


cdef double _velocity_in_noise(Row* state, Arrays* a, double time, double dt) noexcept nogil:
    """Set `noise.floor`, and return the way of the filtered poses, with little noise, over the window.

    It is the rms over the joints, times as many as there are, like displacements where evidence decides.
    """
    cdef double speed, left, squares
    cdef Plan* plan
    cdef Scales* scales
    cdef Noise* noise
    plan = &state.plan
    scales = &state.scales
    noise = &state.noise
    speed = scales.speed
    if state.joints.arrived == 0:  # a joint that has just come has no past yet
        squares = speed_to_come(&a.joints, &a.history, smoothing_weights(dt), time)
        speed = sqrt(squares / state.joints.moving)
    left = noise_of_speed(noise, plan.moving_joints) * plan.window * plan.moving_joints
    noise.floor = noise_floor(left, plan, state.range.largest)
    return speed * plan.window * plan.moving_joints


cdef void _note_features(Row* state, Arrays* a) noexcept nogil:
    """Note the features of the candidate or crossing that the splitter found, while those of the joints are the last frame's."""
    cdef FoundInFrame* found
    cdef Candidate* candidate
    cdef double time, earlier
    found = &state.curve.found
    candidate = &state.candidate
    if found.happened & (PROMOTED | CROSSED):
        time = state.clock.time if found.happened & CROSSED else found.time
        earlier = EARLIER_IN_NOISE if state.noise.loud == 1 else EARLIER
        note_place(candidate, &state.scales, &a.history, a.joints.body, time - earlier, state.joints.moving)
        if candidate.time <= state.joints.unseen_time:
            candidate.frame = NOT_PLACED
    else:
        candidate.speed = min(candidate.speed, state.scales.speed)


cdef inline void _describe(Row* state, Arrays* a, double dt, bint first) noexcept nogil:
    """Set the features of the frame, and update the history and the means of the pose."""
    cdef bint filtered
    cdef float offset, kept, moved
    cdef double squares, stood_for
    cdef Plan* plan
    cdef Clock* clock
    cdef Floats body
    plan = &state.plan
    clock = &state.clock
    body = a.joints.body
    filtered = plan.is_filtered == 1 and not first
    offset = REST_SPEED
    if filtered:
        offset = <float>(SPEED_OFFSET * usual_speed(&state.scales))
    if state.joints.arrived == 1:
        add_newcomers(&a.joints, &a.segment, &a.history, a.filtered, logf(offset))
    kept = moved = 0.0  # weights for unfiltered poses
    if filtered:
        kept, moved = smoothing_weights(dt)
    localise(&a.joints, kept, moved)
    squares = follow_speeds(&a.history, body, clock.time, offset)
    if plan.is_filtered == 1:
        _follow_scales(state, a, squares, dt, first)
    if not first:
        _follow_activity(state, a, squares)
    if plan.flat == 1 or first:
        flatten(body, a.segment.pose)
    if plan.tempo == 1:
        if first:
            start_tempo(&state.tempo, plan.joints, state.joints.moving, body)
        follow_speed(&state.tempo, body, dt)
    stood_for = keep_pose(&a.history, body, clock.used_frame, clock.time, dt)
    if plan.tempo == 1 and stood_for > 0.0:
        follow_pose(&state.tempo, body, stood_for)
    if plan.is_filtered == 1 and stood_for > 0.0:
        follow_poses(&state.scales, body, state.joints.moving, stood_for)


cdef inline void _follow_activity(Row* state, Arrays* a, double squares) noexcept nogil:
    """Update the activity; `squares` is the sum of the squared speeds, (m/s)²."""
    cdef Plan* plan
    cdef (double, double) noises
    cdef double speed
    cdef (double, bint) moment
    plan = &state.plan
    noises = noises_of_speed(&state.noise, plan.moving_joints, plan.is_filtered == 1)
    speed = sqrt(squares / state.joints.moving)
    moment = (state.clock.time, ends_stillness(&state.noise))
    activity_follow_activity(&a.activity, a.joints.body, speed, noises, moment, plan.rest_seconds)


cdef inline void _follow_scales(Row* state, Arrays* a, double squares, double dt, bint first) noexcept nogil:
    """Update the scales and the dwells."""
    if first:
        start_scales(&state.scales, a.joints.body, state.plan.joints)
    else:
        follow_scales(&state.scales, squares / state.joints.moving, dt)
    note_speed(&state.candidate, &state.scales, state.clock.time)
    if state.plan.own_time == 1:
        follow_dwells(&state.dwells, lingers(&state.scales), state.clock.used_frame, state.clock.time)
