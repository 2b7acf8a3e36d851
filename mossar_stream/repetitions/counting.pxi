"""Counting: an analysis of the window every second, and the changes that it makes to the counted cycles.

Each of the leading components proposes cycles that begin at its maxima or at its minima. The proposal that covers most of
the window with cycles that are alike wins, with a bonus for beginning where cycles were counted before. It replaces
the counted cycles in the last part of the window; older ones stay.
"""

cdef enum:
    PROPOSING = 3  # components,
    SMOOTHED_PROPOSING = 2  # and those of them that also propose smoothed
cdef double OPEN_TO_CHANGE = 0.5  # of the window
cdef double NEAR_REST_POSE = 0.4  # for beginning nearer to how the take began
cdef double HALVES = 0.29  # threshold of `alternation` from which on cycles are halves
cdef double BONUS = 0.34  # for beginning where cycles were counted before
cdef double UPRIGHT = 0.6  # for beginning where limbs are straighter and upright
cdef double RECURRING = 1.0  # for a whole posture that recurs one cycle later: that of halves of cycles recurs less
cdef double MOST_PREFERRED = (1.0 + BONUS) * (1.0 + NEAR_REST_POSE) * (1.0 + UPRIGHT) * (1.0 + RECURRING)
cdef double MUCH_LESS = 0.6  # of the range of the window: if the last `RECENT` samples swing less, another posture came first
cdef double NEAR_BOUNDARY = 0.15  # of a cycle
cdef double OVERLAP = 0.45  # of the shorter of two cycles, their longest overlap
cdef double LEAST_LEAD = 0.2  # of a cycle, least part before the first cycle of a bout;
cdef double WHOLE = 0.75  # with the part after the last cycle it makes one more repetition from this share on
cdef double LEAST_GAP = 0.76  # cycles; a gap within these limits holds missed cycles if the movement went on
cdef double LONGEST_GAP = 2.1
cdef double SWING_GOES_ON = 0.54  # of a swing
cdef enum:
    DOUBTFUL = 5  # windows, for which unreported cycles are kept
cdef double LEAST_WIDTHS = 3.0  # least mean duration of cycles, in widths of the smoothing: it flattens shorter ones
cdef double SHARE_POWER = 0.32  # power of the share of the movement that a component has


cdef bint analyse_repetitions(uint8_t* state, uint8_t* store, double time) noexcept nogil:
    """Analyse the window if an analysis is due before a frame.

    Args:
        state: Bytes of the count: `Counting`, `Periods` and the samples, see `periods_at` and `samples_at`.
        store: Bytes in which an analysis works, see `store_size`.
        time: s, of the frame; inf to analyse all samples once.

    Returns:
        Whether the analysis changed the count.
    """
    cdef Counting* header = <Counting*>state
    cdef CountingScratch* scratch = <CountingScratch*>store
    cdef float* room = <float*>(store + in_lines(sizeof(CountingScratch)))
    cdef Samples samples = all_samples(state + samples_at(), room, header.joints)
    cdef bint changed
    if time == INFINITY:
        if header.begun == 0:
            return False
        append_sample(header, &samples, samples.before)
    elif time < header.due:
        return False
    changed = _analyse_once(header, &samples, scratch)
    note_periods(<Periods*>(state + periods_at()), header)
    return changed


cdef bint _analyse_once(Counting* header, Samples* samples, CountingScratch* scratch) noexcept nogil:
    """Analyse the window and renew the cycles counted in it; return whether anything changed."""
    cdef int64_t n, was_clear
    cdef Winner* winner
    cdef bint changed
    note_analysis(header)
    if window_size(header) < LEAST_SAMPLES:
        return False
    n = find_components(header, samples, scratch)
    _choose_proposal(header, samples, n, scratch)
    winner = &scratch.winner
    if winner.count == 0:
        return False
    was_clear = header.clear
    header.clear |= winner.clear
    changed = _renew(header, samples, n, scratch)
    if header.clear and not was_clear:
        _forget_doubtful(header)
        header.changed = 0
        time_cycles(header, header.changed)
        return header.cycles > 0
    if changed:
        time_cycles(header, header.changed)
    return changed and header.clear == 1


cdef void _forget_doubtful(Counting* header) noexcept nogil:
    """Forget cycles from long before it became clear that a movement repeats."""
    cdef int64_t first, q
    first = 0
    while first < header.cycles and header.cycle[first].end < header.open - DOUBTFUL * SAMPLES:
        first += 1
    for q in range(first, header.cycles):
        header.cycle[q - first] = header.cycle[q]
    header.cycles -= first
    header.dropped = 0


cdef void _choose_proposal(Counting* header, Samples* samples, int64_t n, CountingScratch* scratch) noexcept nogil:
    """Set the winning proposal and its cycles, and the smoothed scores in which it was found."""
    cdef Winner* winner
    cdef double spread, share, before
    cdef int64_t attempt, k, width
    winner = &scratch.winner
    winner.covered, winner.count, winner.clear = 0.0, 0, 0
    spread = 1e-12
    for k in range(COMPONENTS):
        spread += _square(row_of_floats(samples.scores, k), n)
    for attempt in range(3):
        width = (2 << attempt) - 1  # 1, 3, 7 samples of smoothing: it removes extremes within uneven cycles
        smooth_scores(samples, n, width)
        for k in range(PROPOSING if width == 1 else SMOOTHED_PROPOSING):
            share = pow(_square(row_of_floats(samples.smooth, k), n) / spread, SHARE_POWER)
            if n * share * MOST_PREFERRED <= winner.covered:
                continue  # it cannot win
            before = winner.covered
            _propose(header, samples, (n, k, width, share), scratch)
            if winner.covered > before:
                winner.width = width
    if winner.count > 0 and winner.width != 7:
        smooth_scores(samples, n, winner.width)


cdef void _propose(
    Counting* header, Samples* samples, (int64_t, int64_t, int64_t, double) what, CountingScratch* scratch
) noexcept nogil:
    """Propose the cycles of one component, with the hysteresis for the window and with that for its last part.

    The proposal wins if it covers more than the winner so far.

    Args:
        header: `Counting`.
        samples: `Samples`.
        what: Number of samples, the component, the width of its smoothing in samples, its share of the movement.
        scratch: `CountingScratch`.
    """
    cdef int64_t half, n, k, begin
    cdef Floats scores
    cdef float whole, swing
    n, k = what[0], what[1]
    scores = row_of_floats(samples.smooth, k)
    whole = <float>0.0
    # One call serves both: code that runs once a second takes longer to fetch than to run.
    for half in range(2 if n > RECENT else 1):
        begin = half * (n - RECENT)
        swing = swing_range(part_of_floats(scores, begin, n), n - begin, ints32(scratch.counts, BINS))
        if swing <= 0 or swing < scratch.least:
            return
        if half == 0:
            whole = swing
        elif swing > MUCH_LESS * whole:
            return
        _propose_turns(header, samples, what, scratch, <float>HYSTERESIS * swing)


cdef void _propose_turns(
    Counting* header, Samples* samples, (int64_t, int64_t, int64_t, double) what, CountingScratch* scratch, float least
) noexcept nogil:
    """Propose the cycles between turning points that begin at maxima, and those that begin at minima.

    Args:
        header: `Counting`.
        samples: `Samples`.
        what: See `_propose`.
        scratch: `CountingScratch`.
        least: Hysteresis.
    """
    cdef int64_t found, direction, n, k, width, count, span, way, left
    cdef double share, covered
    cdef Winner* winner
    cdef Floats scores
    cdef Int32Rows turns, cycles, kept
    cdef bint halves, clear
    n, k, width, share = what
    winner = &scratch.winner
    scores = row_of_floats(samples.smooth, k)
    turns = in_cycles(&scratch.turns[0][0], 2)
    cycles = in_cycles(&scratch.cycles[0][0], 3)
    kept = in_cycles(&scratch.kept[0][0], 3)
    found = turning_points(scores, n, least, turns)
    for direction in range(1, -2, -2):  # at maxima, at minima
        count = cycles_between(turns, found, direction, n == header.open, cycles)
        if count < 2:
            continue
        span = scratch.cycles[2][count - 1] - scratch.cycles[0][0]
        if span * share * MOST_PREFERRED <= winner.covered:
            continue  # it cannot win
        describe_all(samples, k, cycles, count, scratch)
        halves = alternation(cycles, count, scratch) > HALVES
        for way in range(3 if halves else 1):  # as they are; joined from the first; from the second
            if way == 0:
                left = count
                copy_cycles(cycles, count, kept)
            else:
                left = join_pairs(scores, cycles, count, way - 1, kept)
                describe_all(samples, k, kept, left, scratch)
            left, covered, clear = keep_alike(header, n, scores, kept, left, scratch.alike)
            if left == 0 or width > 1 and duration(kept, left) < LEAST_WIDTHS * width * left:
                continue
            covered *= share
            if covered * MOST_PREFERRED <= winner.covered:
                continue  # it cannot win, and its preference takes long to compute
            covered *= _preference(header, samples, n, kept, left)
            if covered > winner.covered:
                winner.covered, winner.count, winner.component, winner.clear = covered, left, k, <int64_t>clear
                copy_cycles(kept, left, in_cycles(&scratch.best[0][0], 3))


cdef double _preference(Counting* header, Samples* samples, int64_t n, Int32Rows cycles, int64_t count) noexcept nogil:
    """Return the weight of a proposal.

    It grows with the share of cycles that begin where cycles were counted before, and with the recurrence of the posture. It also
    grows with the straightness of limbs and the nearness of the rest pose at the starts of cycles.
    """
    cdef double weight
    weight = 1.0 + BONUS * _agreeing(header, n, cycles, count)
    weight *= 1.0 + RECURRING * recurring(samples.scores, cycles, count)
    weight *= 1.0 + UPRIGHT * straightening(header, samples, cycles, count)
    return weight * (1.0 + NEAR_REST_POSE * rest_pose_nearness(samples, cycles, count))


cdef double _square(Floats row, int64_t n) noexcept nogil:
    cdef double total
    cdef int64_t i
    total = 0.0
    for i in range(n):
        total += row.at[i] * row.at[i]
    return total


cdef double _agreeing(Counting* header, int64_t n, Int32Rows cycles, int64_t count) noexcept nogil:
    """Return the share of proposed cycles that begin where a cycle was counted before."""
    cdef int64_t hits, oldest, i, q, apart
    cdef double slack
    if count == 0:
        return 0.0
    hits = 0
    oldest = header.open - n
    for i in range(count):
        slack = max(2.0, NEAR_BOUNDARY * (cycles.at[2 * cycles.columns + i] - cycles.at[i]))
        for q in range(header.cycles - 1, -1, -1):
            apart = cycles.at[i] + oldest - header.cycle[q].start
            if magnitude(apart) <= slack:
                hits += 1
            if apart >= -slack:
                break
    return <double>hits / count


cdef bint _renew(Counting* header, Samples* samples, int64_t n, CountingScratch* scratch) noexcept nogil:
    """Replace the counted cycles that the window shows anew; return whether anything changed."""
    cdef int64_t oldest, middle, i, component, before, q, start, end, missed, k, limit
    cdef double settled
    cdef int64_t last
    cdef Int32Rows cycles
    cdef int32_t* proposed
    cdef Cycle* before_it
    cdef Cycle* row
    component = scratch.winner.component
    cycles = in_cycles(&scratch.best[0][0], 3)
    proposed = scratch.missed
    oldest = header.open - n
    settled = header.open - OPEN_TO_CHANGE * SAMPLES
    middle = 2 * (oldest + cycles.at[0])
    before, header.changed = header.cycles, -1
    while header.cycles > 0:
        row = &header.cycle[header.cycles - 1]
        if row.end <= settled or row.start + row.end <= middle:
            break
        header.cycles -= 1
    for i in range(scratch.winner.count):
        start, end = oldest + cycles.at[i], oldest + cycles.at[2 * cycles.columns + i]
        last, missed = start, 0
        if header.cycles > 0:
            before_it = &header.cycle[header.cycles - 1]
            last = before_it.end
            if start < last - OVERLAP * min(end - start, last - before_it.start):
                continue
            missed = _missed(row_of_floats(samples.smooth, component), cycles, i, max(last - oldest, 0))
        for q in range(missed + 1):
            for k in range(3):
                proposed[k] = cycles.at[k * cycles.columns + i]
            if q < missed:
                proposed[0] = last - oldest + q * (start - last) // missed
                proposed[2] = last - oldest + (q + 1) * (start - last) // missed
                proposed[1] = (proposed[0] + proposed[2]) // 2
            before = _counting_write(header, samples, component, proposed, oldest, before)
            row = &header.cycle[header.cycles - 1]
            if q < missed:  # a missed cycle was not alike: its half ways are unknown
                row.out = 0.75 * row.leaves + 0.25 * row.arrives
                row.back = 0.25 * row.leaves + 0.75 * row.arrives
                row.straighter = row.resting = 0.0
            else:
                weigh(header, samples, component, proposed, row)
        if i + 1 == scratch.winner.count or cycles.at[i + 1] > cycles.at[2 * cycles.columns + i]:
            limit = n - 1 if i + 1 == scratch.winner.count else cycles.at[i + 1]
            before = _counting_go_on(header, samples, (n, oldest, component, limit), proposed, before)
    turn_chains(header)
    if header.changed < 0 and header.cycles != before:
        header.changed = header.cycles
    if header.changed > 0 and header.changed < header.cycles and header.cycle[header.changed].count > 1:
        header.changed -= 1  # its end is where this one begins
    return header.changed >= 0


cdef int64_t _counting_go_on(
    Counting* header, Samples* samples, (int64_t, int64_t, int64_t, int64_t) what, int32_t* cycle, int64_t before
) noexcept nogil:
    """Append one more repetition if the parts before the first cycle and after the last one make up a cycle.

    Cycles begin at an extreme, movements need not.

    Args:
        header: `Counting`.
        samples: `Samples`.
        what: Number of samples, the number of the oldest, the component, the last sample to examine.
        cycle: (3,) start, far extreme, end of the last cycle.
        before: Number of cycles before the analysis.
    """
    cdef double lead, shown, straighter, resting, lasts
    cdef Cycle* row
    cdef int64_t n, oldest, component, limit, last
    n, oldest, component, limit = what
    lead = header.cycle[header.cycles - 1].lead
    if lead < LEAST_LEAD:
        return before
    shown, last = goes_on(header, n, samples.smooth, cycle, 1, limit)
    if lead + shown < WHOLE or last <= cycle[2]:
        return before
    row = &header.cycle[header.cycles - 1]
    straighter, resting, lasts = row.straighter, row.resting, row.out - row.leaves
    cycle[0], cycle[1], cycle[2] = cycle[2], last, last
    before = _counting_write(header, samples, component, cycle, oldest, before)
    row = &header.cycle[header.cycles - 1]
    row.straighter, row.resting = straighter, resting
    row.out, row.back = min(row.leaves + lasts, row.arrives), row.arrives
    return before


cdef int64_t _missed(Floats scores, Int32Rows cycles, int64_t place, int64_t begin) noexcept nogil:
    """Return the number of missed cycles between an earlier one and one of these: the movement went on, but was not alike."""
    cdef int32_t start = cycles.at[place], far = cycles.at[cycles.columns + place], end = cycles.at[2 * cycles.columns + place]
    cdef float low, high
    cdef int64_t i, gap, period
    gap, period = start - begin, end - start
    if gap < LEAST_GAP * period or gap > LONGEST_GAP * period:
        return 0
    low = high = scores.at[begin]
    for i in range(begin, start):
        low, high = min(low, scores.at[i]), max(high, scores.at[i])
    if high - low < <float>SWING_GOES_ON * abs(scores.at[far] - scores.at[start]):
        return 0
    return <int64_t>(<double>gap / period + 0.5)


cdef int64_t _counting_write(
    Counting* header, Samples* samples, int64_t component, int32_t* cycle, int64_t oldest, int64_t before
) noexcept nogil:
    """Append a counted cycle, with its number in the bout; return the number of remembered cycles before the analysis."""
    cdef int64_t place, q, start, far, end, limit
    cdef Cycle* row
    cdef Cycle* last
    cdef bint same
    if header.cycles == CYCLES:
        for q in range(CYCLES - 1):
            header.cycle[q] = header.cycle[q + 1]
        header.dropped += 1
        header.cycles -= 1
        before -= 1
        header.changed = max(header.changed - 1, -1 if header.changed < 0 else 0)
    start, far, end = oldest + cycle[0], oldest + cycle[1], oldest + cycle[2]
    place = header.cycles
    header.cycles += 1
    row = &header.cycle[place]
    same = place < before and magnitude(row.start - start) <= 1 and magnitude(row.end - end) <= 1
    if not same and header.changed < 0:
        header.changed = place
    row.start, row.far, row.end = start, far, end
    _counting_measure(header, samples, component, cycle, header.open - oldest, row)
    row.count, row.lead = 1, 0.0
    if place > 0:
        last = &header.cycle[place - 1]
        if row.leaves - last.arrives <= LONGEST_PAUSE * (row.arrives - row.leaves) + STAMP_ROUNDING:
            row.count, row.lead = last.count + 1, last.lead
    if row.count == 1:
        limit = 0 if place == 0 else max(header.cycle[place - 1].end - oldest, 0)
        if limit < cycle[0]:
            row.lead = goes_on(header, header.open - oldest, samples.smooth, cycle, -1, limit)[0]
    return before


cdef void _counting_measure(
    Counting* header, Samples* samples, int64_t component, int32_t* cycle, int64_t n, Cycle* row
) noexcept nogil:
    """Set times, amplitude and the leading joint of a cycle.

    A missed cycle may lie before the window; the oldest sample replaces each sample outside the window.
    """
    cdef int64_t place, start, far, end
    cdef float swing
    cdef Floats scores, smooth
    scores = row_of_floats(samples.scores, component)
    smooth = row_of_floats(samples.smooth, component)
    start, far, end = max(cycle[0], 0), max(cycle[1], 0), max(cycle[2], 0)
    row.leaves = header.left[ring_place(header, n, start)]
    row.out = time_at(header, n, crossing(smooth, start, far, 0.5))
    place = ring_place(header, n, far)
    row.turns = 0.5 * (header.at[place] + header.left[place])
    row.back = time_at(header, n, crossing(smooth, end, far, 0.5))
    row.returning = <int64_t>(cycle[2] >= n - 2)
    row.arrives = header.at[ring_place(header, n, cycle[2])]
    swing = abs(scores.at[far] - <float>0.5 * (scores.at[start] + scores.at[end]))
    row.amplitude = swing / sqrt(<double>header.joints)
    row.joint = _leading_joint(header, row_of_floats(samples.axes, component))


cdef int64_t _leading_joint(Counting* header, Floats axis) noexcept nogil:
    """Return the joint that moves most along an axis."""
    cdef int64_t j, leading
    cdef float most, square
    most, leading = <float>(-1.0), 0
    for j in range(header.joints):
        square = (
            axis.at[3 * j] * axis.at[3 * j] + axis.at[3 * j + 1] * axis.at[3 * j + 1]
            + axis.at[3 * j + 2] * axis.at[3 * j + 2]
        )
        if square > most:
            most, leading = square, j
    return leading
