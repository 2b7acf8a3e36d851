"""Labels of candidates: a candidate ends a repetition or lies inside one.

While `repetitions` counts a repeated movement, every candidate of Algorithm 2 gets a label when it is `LABELLED_AFTER` old,
or decided. In a recording nothing is decided before the take ends, and a candidate waits for `LABELLED_LATE`: by then even
the first repetitions of a bout are counted. A candidate is compared with all candidates within half a period around it. It
ends a repetition if it is the best of them: slowest, nearest to the rest pose, and nearest to a boundary between two
repetitions. The first two have the same weights as in the evidence of a key frame.

Only even bouts are labelled: their longest period is at most twice the shortest. Beats of gestures are alike in shape, but
uneven in time, and annotators do not cut at them. The candidates of the comparison are fixed. The label does not depend on
the window of Algorithm 3.

Before anything is counted, the latest way out and back (ways.pxi) gives labels: candidates within it lie inside a repetition,
and the best one after it ends the repetition.
"""

cdef enum:
    NOTED_CANDIDATES = 32  # remembered on a stream,
    NOTED_LATE = 256  # and of a recording
cdef double LABELLED_AFTER = 1.5 - 1e-06  # s; a little less, for the rounding of timestamps
# s; the first repetitions of a take are counted 3 to 8 s after it began. Labelled recordings of exercises (UI-PRMD): final
# F1 0.804 instead of 0.781, other sets within 0.003.
cdef double LABELLED_LATE = 12.0 - 1e-06
# s; a longer period has no labels. Half of it exceeds the 3 s that a key frame waits, and some candidates of the comparison
# are still to come.
cdef double LONGEST_PERIOD = 6.0
cdef double LONGEST_IN_OWN_TIME = 20.0  # τ; with `tempo` longer periods of slow performers have labels, too
cdef double NEAREST_END = 0.75  # least periods between the ends of two repetitions
cdef double OFF_BOUND = 5.0  # log odds per period of distance from a boundary between two repetitions
cdef enum:
    UNLABELLED = 0  # labels: no repetition, end of one, inside one
    ENDS = 1
    WITHIN = 2

cdef struct Labels:
    double last_time  # s, end of the last repetition
    int64_t candidates  # noted so far
    int64_t labelled  # of them


cdef struct Note:
    double time  # s, of Algorithm 2's frame
    double reported  # s, reported time
    double cost  # low for the likely end of a repetition


cdef struct NoteSpan:
    Note* at
    int64_t count


cdef struct RepetitionLabels:  # The inputs of the functions below.
    Labels* state  # LABELS
    NoteSpan notes  # (NOTED_CANDIDATES or NOTED_LATE,) NOTE, ring
    Periods* periods  # (1,) PERIODS of the performer's repetitions
    double longest  # s, period with labels
    Ways* ways  # the performer's; NULL if labels do not use them


cdef void start_labels(Labels* state) noexcept nogil:
    """Begin a take."""
    state.last_time = -INFINITY
    state.candidates = 0
    state.labelled = 0


cdef inline double longest_period(Scales* scales) noexcept nogil:
    """Return the longest period that has labels at the performer's own time, s."""
    return max(LONGEST_PERIOD, LONGEST_IN_OWN_TIME * scales.own_time)


cdef inline void note_candidate(
    RepetitionLabels* labels, double time, double reported, double rest_distance, double speed
) noexcept nogil:
    """Remember a candidate that Algorithm 2 accepted.

    Args:
        labels: RepetitionLabels.
        time: s, of the candidate.
        reported: s, reported time.
        rest_distance: Distance from the pose in which the performer dwells, in A.
        speed: In V.
    """
    cdef Note* note
    note = &labels.notes.at[labels.state.candidates % labels.notes.count]
    note.time = time
    note.reported = reported
    note.cost = WEIGHTS_REST_DISTANCE * rest_distance + (WEIGHTS_STOP - WEIGHTS_REST) * log(speed + SPEED_FLOOR_OF_ODDS)
    labels.state.candidates += 1


cdef inline double due_label(RepetitionLabels* labels, double delay) noexcept nogil:
    """Return the time at which the next candidate must be judged, s; inf if none waits."""
    cdef Labels* state
    state = labels.state
    if state.labelled == state.candidates:
        return INFINITY
    return labels.notes.at[state.labelled % labels.notes.count].time + delay


cdef int64_t label_candidate(RepetitionLabels* labels) noexcept nogil:
    """Return the label of the oldest candidate that has none."""
    cdef Labels* state
    cdef int64_t number, other, best
    cdef Note* note
    cdef Note* candidate
    cdef double period, least, off, cost
    state = labels.state
    number = state.labelled
    state.labelled += 1
    if state.candidates - number > labels.notes.count:
        return UNLABELLED
    if labels.periods.clear == 0:
        return UNLABELLED if labels.ways == NULL else _label_by_way(labels, number)
    note = &labels.notes.at[number % labels.notes.count]
    period = _period_at(labels.periods, note.reported)
    if not 0.0 < period <= labels.longest + MARGIN:
        return UNLABELLED
    best, least = number, INFINITY
    for other in range(max(0, state.candidates - labels.notes.count), state.candidates):
        candidate = &labels.notes.at[other % labels.notes.count]
        if abs(candidate.reported - note.reported) > 0.5 * period + MARGIN:
            continue
        off = _off_bound(labels.periods, candidate.reported) / period
        cost = candidate.cost + OFF_BOUND * off
        if cost < least:
            best, least = other, cost
    if best != number or note.reported - state.last_time < NEAREST_END * period - MARGIN:
        return WITHIN
    state.last_time = note.reported
    return ENDS


cdef int64_t _label_by_way(RepetitionLabels* labels, int64_t number) noexcept nogil:
    """Return the label of a candidate by the latest way out and back."""
    cdef Labels* state = labels.state
    cdef Note* note = &labels.notes.at[number % labels.notes.count]
    cdef Note* candidate
    cdef int64_t other
    if is_on_way(labels.ways, note.reported):
        return WITHIN
    if not is_after_way(labels.ways, note.reported):
        return UNLABELLED
    if state.last_time >= labels.ways.ends - MARGIN:
        return WITHIN
    for other in range(max(0, state.candidates - labels.notes.count), state.candidates):
        candidate = &labels.notes.at[other % labels.notes.count]
        if candidate.cost < note.cost and is_after_way(labels.ways, candidate.reported):
            return WITHIN
    state.last_time = note.reported
    return ENDS


cdef double _period_at(Periods* periods, double time) noexcept nogil:
    """Return the period of the even bout at a time, s, with the silence after the latest cycle; 0 outside a bout."""
    cdef double at, period, silence
    cdef int64_t place
    cdef CountedCycle* cycle
    cdef bint goes_on
    if periods.clear == 0:
        return 0.0
    at = time - periods.origin
    for place in range(periods.cycles - 1, -1, -1):
        cycle = &periods.cycle[place]
        period = _duration(cycle)
        silence = LONGEST_SILENCE * period + ANALYSIS_INTERVAL if place == periods.cycles - 1 else 0.0
        if at >= cycle.begins - MARGIN:
            goes_on = at <= cycle.ends + silence + MARGIN
            return period if goes_on and _repetition_labels_is_even(periods, place) else 0.0
    return 0.0


cdef bint _repetition_labels_is_even(Periods* periods, int64_t place) noexcept nogil:
    """Return whether all periods of a repetition's bout are alike."""
    cdef int64_t first, last, i
    cdef double shortest, longest, period
    first = last = place
    while first > 0 and periods.cycle[first].count > 1:
        first -= 1
    while last + 1 < periods.cycles and periods.cycle[last + 1].count > 1:
        last += 1
    shortest, longest = INFINITY, 0.0
    for i in range(first, last + 1):
        period = _duration(&periods.cycle[i])
        shortest, longest = min(shortest, period), max(longest, period)
    return longest <= LONGEST_RATIO * shortest + MARGIN


cdef inline double _duration(CountedCycle* cycle) noexcept nogil:
    """Return the period at a repetition, s; for the first one of a bout its duration."""
    return cycle.ends - cycle.begins if isnan(cycle.period) else cycle.period


cdef double _off_bound(Periods* periods, double time) noexcept nogil:
    """Return the distance of a time from the nearest start or end of a repetition, s; after the last one, of an expected end."""
    cdef double at, off, period, steps
    cdef int64_t place
    cdef CountedCycle* cycle
    at = time - periods.origin
    off = INFINITY
    for place in range(periods.cycles - 1, -1, -1):
        cycle = &periods.cycle[place]
        if place == periods.cycles - 1 and at > cycle.ends:
            period = _duration(cycle)
            steps = (at - cycle.ends) / period
            off = abs(steps - rint(steps)) * period
        off = min(off, abs(at - cycle.begins), abs(at - cycle.ends))
        if cycle.ends < at - off:  # earlier ones are farther away
            break
    return off


cdef inline void forget_newest(RepetitionLabels* labels) noexcept nogil:
    """Forget the newest candidate, which was withdrawn."""
    cdef Labels* state
    state = labels.state
    state.candidates -= 1
    state.labelled = min(state.labelled, state.candidates)
