"""Functions for tests, oracles and stopwatches: single kernels, and the constants that only they need.

Arrays are numpy's, C-contiguous and of the types that the kernels name. Nothing is checked.
"""

cdef enum:
    VELOCITY_ALONE = 0  # how far `split_frames` goes
    SPLITTING = 1


cdef inline float* floats_at(cnp.ndarray array):
    return <float*>cnp.PyArray_DATA(array)


cdef inline double* doubles_at(cnp.ndarray array):
    return <double*>cnp.PyArray_DATA(array)


def simd_page_sum(cnp.ndarray page, int64_t line, /):
    return page_sum(floats_at(page), line)


def simd_page_product(cnp.ndarray page, int64_t one, int64_t other, /):
    return page_product(floats_at(page), one, other)


def simd_page_within(cnp.ndarray page, int64_t line, double limit, /):
    return bool(page_within(floats_at(page), line, <float>limit))


def simd_line_product(cnp.ndarray one, cnp.ndarray other, /):
    return line_product(floats_at(one), floats_at(other), len(one))


def simd_line_products(cnp.ndarray goal, cnp.ndarray lines, cnp.ndarray others, int64_t count, /):
    line_products(
        floats_at(goal), cnp.PyArray_DIM(goal, 1), floats_at(lines), floats_at(others),
        len(others), cnp.PyArray_DIM(others, 1), count,
    )


def simd_weighted_sums(cnp.ndarray goal, cnp.ndarray weights, cnp.ndarray lines, int64_t count, /):
    weighted_sums(
        floats_at(goal), floats_at(weights), cnp.PyArray_DIM(weights, 1), floats_at(lines),
        len(lines), cnp.PyArray_DIM(lines, 1), count,
    )


def simd_variance_product(
    cnp.ndarray sums, cnp.ndarray squares, int64_t begin, int64_t end, double scale, double floor, /
):
    """Return mantissa and exponent."""
    cdef int64_t exponent = 0
    cdef double* some = doubles_at(sums)
    cdef double mantissa = variance_product(some, doubles_at(squares), begin, end, scale, floor, &exponent)
    return mantissa, exponent


def simd_spread_product(
    cnp.ndarray sums, cnp.ndarray squares, int64_t begin, int64_t end, int64_t lines, int64_t stride,
    double scale, double floor, /
):
    return spread_product(doubles_at(sums), doubles_at(squares), begin, end, lines, stride, scale, floor)


def simd_lowest_bit(int64_t mask, /):
    return lowest_bit(mask)


def simd_quantise(cnp.ndarray values, cnp.ndarray target, double scale, /):
    quantise(floats_at(values), <int16_t*>cnp.PyArray_DATA(target), len(values), <float>scale)


def label_candidates(
    cnp.ndarray labels, cnp.ndarray notes, cnp.ndarray periods, cnp.ndarray times, cnp.ndarray speeds, cnp.ndarray found,
    cnp.ndarray ways=None, /
):
    """Note candidates at these times, s, in the pose of rest, and set `found` to the label of each.

    Args:
        labels: (1,) Labels.
        notes: (NOTED_CANDIDATES,) Note.
        periods: (1,) Periods.
        times: (n,) float64 s.
        speeds: (n,) float64 V.
        found: (n,) int64, set.
        ways: (1,) Ways; None for a performer whose ways are not believed.
    """
    cdef RepetitionLabels own
    cdef int64_t i
    own.state = <Labels*>cnp.PyArray_DATA(labels)
    own.notes.at, own.notes.count = <Note*>cnp.PyArray_DATA(notes), len(notes)
    own.periods = <Periods*>cnp.PyArray_DATA(periods)
    own.longest = LONGEST_PERIOD
    own.ways = NULL if ways is None else <Ways*>cnp.PyArray_DATA(ways)
    start_labels(own.state)
    for i in range(len(times)):
        note_candidate(&own, doubles_at(times)[i], doubles_at(times)[i], 0.0, doubles_at(speeds)[i])
    for i in range(len(times)):
        (<int64_t*>cnp.PyArray_DATA(found))[i] = label_candidate(&own)


def pause_frame(cnp.ndarray dwells, cnp.ndarray slow, cnp.ndarray times, double time, /):
    """Return the frame in the middle of the dwell near a time, s, after frames in which the performer is slow or not.

    Args:
        dwells: (1,) Dwells, set.
        slow: (n,) uint8.
        times: (n,) float64 s.
        time: s.

    Returns:
        The frame; `NO_DWELL` if no dwell is near.
    """
    cdef Dwells* own = <Dwells*>cnp.PyArray_DATA(dwells)
    cdef int64_t i, dwell
    start_dwells(own)
    for i in range(len(times)):
        follow_dwells(own, (<uint8_t*>cnp.PyArray_DATA(slow))[i] == 1, i, doubles_at(times)[i])
    dwell = dwell_near(own, time)
    return NO_DWELL if dwell == NO_DWELL else middle_of(own, dwell).frame


def tempo_in_force(cnp.ndarray scales, bint own_time, /):
    """Return the tempo that evidence is divided by.

    Args:
        scales: (1,) Scales.
        own_time: Whether it follows the performer's own time.
    """
    return tempo_of(<Scales*>cnp.PyArray_DATA(scales), own_time)


def swing_range_of(cnp.ndarray scores, cnp.ndarray counts, /):
    """Return the range of a component, (n,) float32; counts are (BINS,) int32, set."""
    cdef Floats own = floats(floats_at(scores), len(scores))
    return swing_range(own, own.count, ints32(<int32_t*>cnp.PyArray_DATA(counts), len(counts)))


def step_body(Performer performer, cnp.ndarray positions, cnp.ndarray times, /):
    """Process frames of a body until one causes something; return the stop code, and the number of processed frames.

    Args:
        performer: Whose body it is.
        positions: (n, J, 3) float32 m.
        times: (n,) float64 s.
    """
    cdef Part* body = performer.seat.parts
    cdef int64_t used = 0
    cdef int64_t stop = advance(
        body.row, body.measure, floats_at(positions), doubles_at(times), len(times), &used
    )
    return stop, used


def step_events(Performer performer, /):
    """Run the window step after a frame that caused something; the events lie in the buffer."""
    cdef Part* body = performer.seat.parts
    cdef Room* room = &performer.workspace.room
    room.events.performer = 0
    step_window(body.row, body.measure, room.scratch, room.events, FOLLOW)


def hand_out_events(Performer performer, /):
    """Move the events of the buffer to the performer's pending ones."""
    performer.workspace.hand_out([performer])


def analyse_body(Performer performer, double time, /):
    """Analyse the repetitions that are due before a time, s."""
    analyse_repetitions(<uint8_t*>counting_of(performer.body().row), performer.workspace.room.store.at, time)


def split_frames(cnp.ndarray row, cnp.ndarray positions, cnp.ndarray times, int64_t until, /):
    """Run the beginning of `advance` alone: joints, velocity, range, envelope, Algorithms 1 and 2.

    Args:
        row: Bytes of the performer.
        positions: (n, J, 3) float32 m.
        times: (n,) float64 s, increasing.
        until: VELOCITY_ALONE or SPLITTING.

    Returns:
        Key frames confirmed.
    """
    cdef Row* state = <Row*>cnp.PyArray_DATA(row)
    cdef Arrays a = _arrays_of(state, NULL)
    cdef float* points = floats_at(positions)
    cdef double* moments = doubles_at(times)
    cdef int64_t i, count = len(times), found = 0
    with nogil:
        for i in range(count):
            found += _split_frame(state, &a, points + 3 * i * state.plan.joints, moments[i], until)
    return found


cdef inline int64_t _split_frame(
    Row* state, Arrays* a, float* positions, double time, int64_t until
) noexcept nogil:
    """Process one frame, and return whether a key frame was confirmed."""
    cdef Plan* plan = &state.plan
    cdef Clock* clock = &state.clock
    cdef bint first = clock.open == 0
    cdef double dt = 0.0, displacement = 0.0
    cdef double velocity, value, scale
    cdef int64_t happened = 0
    cdef PositionSpan frame
    frame.at, frame.count = <Position*>positions, plan.joints
    if first:
        clock.open = 1
        start_joints(&a.joints, frame, time)
    else:
        dt = min(time - clock.time, plan.max_gap)
        displacement = step_joints(&a.joints, frame, clock.time, time)
    velocity = travel(&state.velocity, a.ring_time, a.ring_step, time, displacement, plan.window)
    if until == SPLITTING:
        value, scale = normalise(&state.range, plan, 0.0, velocity, dt)
        if first:
            start_curve(&state.curve, value, plan.theta * scale, scale, clock.next_frame, time)
        else:
            happened = follow_curve(&state.curve, value, plan.theta * scale, scale, clock.next_frame, time)
            happened &= CROSSED | ACCEPTED
        if happened:
            forget_candidate(&state.curve)
    clock.time = time
    clock.next_frame += 1
    return 1 if happened else 0


def follow_speeds_alone(cnp.ndarray row, cnp.ndarray bouts, cnp.ndarray speeds, cnp.ndarray times, /):
    """Feed speeds to the activity, and return how often it changed.

    Args:
        row: Bytes of the performer.
        bouts: (bouts,) Bout.
        speeds: (n,) float64 m/s, rms over the joints.
        times: (n,) float64 s, increasing.
    """
    cdef Row* state = <Row*>cnp.PyArray_DATA(row)
    cdef Plan* plan = &state.plan
    cdef double* speed = doubles_at(speeds)
    cdef double* time = doubles_at(times)
    cdef int64_t i, count = len(times)
    cdef (double, double) noises
    cdef (double, bint) moment
    cdef Activity own
    own.state = &state.activity
    own.bouts.at, own.bouts.count = <Bout*>cnp.PyArray_DATA(bouts), len(bouts)
    with nogil:
        activity_start_activity(own.state, time[0])
        for i in range(count):
            noises = noises_of_speed(&state.noise, plan.moving_joints, plan.is_filtered == 1)
            moment = (time[i], ends_stillness(&state.noise))
            activity_follow_activity(&own, body_of(state), speed[i], noises, moment, plan.rest_seconds)
    return own.state.number


# Constants for tests and for the oracles in plain Python; `kernels` offers them by name.
TESTED_CONSTANTS = {
    "ANALYSIS_DUE": ANALYSIS_DUE,
    "ANALYSIS_INTERVAL": ANALYSIS_INTERVAL,
    "BEGINNING": BEGINNING,
    "BINS": BINS,
    "CACHE_LINE": CACHE_LINE,
    "DEVIATIONS": DEVIATIONS,
    "DOUBLING": DOUBLING,
    "DOUBT": DOUBT,
    "DWELL_GAP": DWELL_GAP,
    "ENDS": ENDS,
    "HAND": HAND,
    "HAPPENED": HAPPENED,
    "INTERVAL": INTERVAL,
    "LATE_DWELL": LATE_DWELL,
    "LEAST_EXTENT": LEAST_EXTENT,
    "LEAST_OWN_TIME": LEAST_OWN_TIME,
    "LEAST_STEADY": LEAST_STEADY,
    "LEAST_USUAL_SPEED": LEAST_USUAL_SPEED,
    "LINGERS_LITTLE": LINGERS_LITTLE,
    "LINGERS_OFTEN": LINGERS_OFTEN,
    "LONGEST_IN_OWN_TIME": LONGEST_IN_OWN_TIME,
    "LONGEST_PERIOD": LONGEST_PERIOD,
    "LONGEST_RATIO": LONGEST_RATIO,
    "LONGEST_SILENCE": LONGEST_SILENCE,
    "MEAN_TIME": MEAN_TIME,
    "MEAN_X": MEAN_X,
    "MEMORY": MEMORY,
    "MORE_ROOM": MORE_ROOM,
    "MOST_OWN_TIME": MOST_OWN_TIME,
    "MOST_RAISED": MOST_RAISED,
    "NEAREST_END": NEAREST_END,
    "NEAR_DWELL": NEAR_DWELL,
    "NO_DWELL": NO_DWELL,
    "OFF_BOUND": OFF_BOUND,
    "ORDINARY": ORDINARY,
    "PER_QUANTUM": PER_QUANTUM,
    "PRIOR_DWELT": PRIOR_DWELT,
    "PRIOR_EXTENT": PRIOR_EXTENT,
    "PRIOR_LINGERED": PRIOR_LINGERED,
    "PRIOR_SPEED": PRIOR_SPEED,
    "QUICK": QUICK,
    "QUICKEST": QUICKEST,
    "REPORTED_ABOVE_NOISE": REPORTED_ABOVE_NOISE,
    "REST_GROWS": REST_GROWS,
    "REST_GROWS_FROM": REST_GROWS_FROM,
    "REST_POSE_HALF_LIFE": REST_POSE_HALF_LIFE,
    "REST_X": REST_X,
    "RISEN": RISEN,
    "SCALES_HALF_LIFE": SCALES_HALF_LIFE,
    "SHORTEST_REST": SHORTEST_REST,
    "SHORT_INTERVAL": SHORT_INTERVAL,
    "SLOW": SLOW,
    "SLOWEST": SLOWEST,
    "SMOOTHING": SMOOTHING,
    "SPEED_OFFSET": SPEED_OFFSET,
    "SPEED_SETTLING": SPEED_SETTLING,
    "SPLITTING": SPLITTING,
    "STEADY_SLOWEST": STEADY_SLOWEST,
    "STEP": STEP,
    "TURNED_BACK": TURNED_BACK,
    "UNLABELLED": UNLABELLED,
    "VELOCITY_ALONE": VELOCITY_ALONE,
    "WAITS_AT_MOST": WAITS_AT_MOST,
    "WAITS_FROM": WAITS_FROM,
    "WAITS_MORE": WAITS_MORE,
    "WITHIN": WITHIN,
    "WORK": WORK,
    "X": X,
}
