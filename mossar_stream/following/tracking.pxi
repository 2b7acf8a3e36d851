"""Tracking: the states of a followed move: begun, progress, done, left.

At each sample every example is aligned with the stream. Of all ways the one that costs least gives the progress.
A way that has reached the end of its example is decided once no overlapping way ranks better. It is done if it
explains the movement well enough: its costs without constant differences are compared with the costs of a performer
who stands still. Once a performer has done a move, it may be done less well.

People differ more than performances of one person do, so ways are misled by the example of another body: they stop half
way, or take the way back for the way there. Where the body's repetitions are counted, repeated.pxi corrects that.
"""

# Chosen on five people and ten exercises, people left out in turn; all lie on wide plateaus
# (docs/lab-notes/following.md).
cdef double MOST_LEFT = 0.9  # residual above which nothing was done
cdef double MORE_LEFT = 1.4  # times that, for a performer who has done it before in the take
cdef double MOST_NEAR = 1.6  # residual below which a performance may be done once it is repeated
cdef double LEAST_GAIN = 0.25  # gain below which nothing was done
cdef double GAIN_WORTH = 0.6  # by how much a gain of 1 lowers the rank of an end
cdef double CLEARLY = 0.3  # by how much another move must rank better to be the one that was made
cdef double RIVAL = 0.3  # share of its example that a way has made which may yet rank better
cdef double REMAINS = 0.05  # by how much the rest of the example raises the rank of a way
cdef double BEGUN = 0.1  # progress at which a performance may be reported
cdef double WENT = 0.25  # share of the example's farthest pose that a performer has gone by then
cdef double DEAREST = 4.0  # cost above which nothing is being made
cdef double DEAREST_END = 8.0  # cost above which nothing was done, relative to the gain
cdef double GIVEN_UP_AFTER = 0.5  # s of that after which a performance is given up
cdef double NEARLY_OVER = 0.7  # progress from which it is waited longer, because a begin of the next one may lead meanwhile:
cdef double GIVEN_UP_LATE = 1.0  # s
cdef double DEGREES = 180.0 / M_PI  # in a radian
cdef enum:
    WAITED = 7  # samples after which an end is decided at the latest
    MOST_SAMPLES = 1 << 30
cdef enum:  # what happened to a move
    MOVE_UNCHANGED = 0
    MOVE_BEGUN = 1
    MOVE_GOES_ON = 2
    MOVE_DONE = 3
    MOVE_LEFT = 4
cdef enum:  # why a performance was not done, in the order of `LEFT_REASONS` in events.py, the first of which is none
    BY_BREAK = 1  # it has not come to the end of the example
    BY_MOVEMENT = 2  # the movement differs from the example's
    BY_ONCE = 3  # the same, so little that it may count once it is repeated
    BY_ANOTHER = 4  # another followed move explains it better
    BY_HIDDEN = 5  # no bone was seen
    BY_GAP = 6  # frames were missing


cdef int64_t follow_frame(
    uint8_t* memory, uint8_t* store, float* positions, int64_t joints, double time
) noexcept nogil:
    """Process a frame; a function as readers have it.

    Args:
        memory: Of the performer.
        store: The bank.
        positions: (joints, 3) m; NaN where a joint is missing.
        joints: How many there are.
        time: s.

    Returns:
        1 if a followed move changed, see `happened` of the moves; else 0.
    """
    cdef FollowBank bank
    cdef FollowMemory known
    bank = open_follow_bank(store)
    known = open_follow_memory(memory, bank.head)
    if not is_new(known.state.frames, time, known.state.time, LEAST_SPACING):
        return 0
    _take_frame(&known, &bank, floats_in_rows(positions, joints, 3), time)
    return 1 if known.state.happened else 0


cdef bint finish_following(uint8_t* memory, uint8_t* store) noexcept nogil:
    """Decide everything at the end of a take; see `happened` of the moves.

    Returns:
        Whether there may be more to be decided.
    """
    cdef FollowBank bank
    cdef FollowMemory known
    cdef int64_t m
    cdef bint more = False
    bank = open_follow_bank(store)
    known = open_follow_memory(memory, bank.head)
    known.state.happened = 0
    for m in range(bank.head.moves):
        known.happened[m] = MOVE_UNCHANGED
        if known.moves[m].best < INFINITY and _decide_end(&known, &bank, m):
            more = True
        elif settle_repetition(&known, &bank, m, True):
            more = True
        elif known.moves[m].active:
            _give_up(&known, &bank, m)
    return more


cdef void evaluate_move(uint8_t* memory, uint8_t* store, int64_t m) noexcept nogil:
    """Write the report of a move that is being made."""
    cdef FollowBank bank
    cdef FollowMemory known
    bank = open_follow_bank(store)
    known = open_follow_memory(memory, bank.head)
    measure_way(&known, &bank, m)
    write_report(&known, &bank, m, &known.moves[m], MOVE_GOES_ON)


cdef void _take_frame(FollowMemory* known, FollowBank* bank, FloatRows positions, double time) noexcept nogil:
    """Process one frame."""
    cdef FollowingState* state
    cdef FloatRows earlier, pose
    cdef double share, past
    cdef int64_t m
    cdef bint fresh, whole
    state = known.state
    state.happened = 0
    for m in range(bank.head.moves):
        known.happened[m] = MOVE_UNCHANGED
    fresh = not follows(state.frames, time, state.time)
    if fresh and state.frames > 0:
        _restart(known, bank)
    earlier, pose = plane_of_floats(known.poses, 0), plane_of_floats(known.poses, 1)
    memcpy(earlier.at, pose.at, 3 * pose.rows * sizeof(float))
    whole = place_pose(pose, bank.points, positions, bank.head.axis, <float>bank.head.sign)
    if fresh:
        if not whole and not assume_missing(pose, known.absences, bank, positions):
            return
        memcpy(earlier.at, pose.at, 3 * pose.rows * sizeof(float))
        state.begin = state.time = time
    note_absences(known.absences, bank, positions, whole, time - state.time)
    # Samples are counted: adding up their times, or taking them from the clock's origin, would round them more and more.
    past = time - state.begin - state.samples * PERIOD
    while past >= -EARLY:
        share = 1.0 if fresh else min(1.0, 1.0 - past / (time - state.time))
        take_sample(known, bank, share, time - past - state.sampled)
        state.sampled = time - past
        _follow_examples(known, bank)
        state.samples += 1
        past = time - state.begin - state.samples * PERIOD
        fresh = False
    state.time = time
    state.frames += 1


cdef void _restart(FollowMemory* known, FollowBank* bank) noexcept nogil:
    """Give up all moves that are being made, after a gap."""
    cdef Cells cells
    cdef int64_t m, t
    known.state.frames = 0
    known.state.samples = 0
    for m in range(bank.head.moves):
        if known.moves[m].active:
            known.moves[m].refused = BY_GAP
            _give_up(known, bank, m)
        known.moves[m].best = known.moves[m].done = INFINITY
    for t in range(bank.head.examples):
        cells = open_cells(known.memory, &bank.examples[t])
        forget_ways(&cells, MOST_SAMPLES)


cdef void _report_move(FollowMemory* known, FollowBank* bank, int64_t m, int64_t what) noexcept nogil:
    cdef FollowedMove* move
    move = &known.moves[m]
    known.happened[m] = what
    known.state.happened = 1
    move.reported = known.state.sampled
    if not move.active and what != MOVE_LEFT:
        known.state.number += 1
        move.number = known.state.number
        move.rev = 0
    if what == MOVE_BEGUN:
        move.active = 1
        move.recents = 0
        move.refused = BY_BREAK
    elif what != MOVE_GOES_ON:
        move.active = 0
    move.rev += 1
    write_report(known, bank, m, move, what)


cdef void write_report(
    FollowMemory* known, FollowBank* bank, int64_t m, FollowedMove* move, int64_t what
) noexcept nogil:
    """Write the report of move m from `move`, rounded."""
    cdef FollowReport* report
    cdef const float* strays
    cdef const float* weights
    cdef double* limbs
    cdef const float* standing
    cdef double farthest, deviation, posture, unjudged, angle
    cdef int64_t limb, b, joint, count, judged
    report = <FollowReport*>row_of_doubles(known.reports, m).at
    limbs = <double*>(report + 1)
    strays, standing = row_of_floats(known.strays, m).at, row_of_floats(known.standing, m).at
    weights = row_of_floats(weights_of_bones(bank), move.example).at
    for limb in range(bank.head.limbs):
        limbs[limb] = 0.0
    farthest, joint, deviation, posture, unjudged = -1.0, -1, 0.0, 0.0, 0.0
    for b in range(bank.head.bones):
        if strays[b] == UNJUDGED:
            unjudged += weights[b]
            continue
        angle = _angle_of(strays[b])
        deviation += angle * weights[b]
        posture += _angle_of(standing[b]) * weights[b]
        if angle > farthest:
            farthest, joint = angle, b
        if bank.bones[b].limb >= 0:
            limbs[bank.bones[b].limb] += angle
    for limb in range(bank.head.limbs):
        count = judged = 0
        for b in range(bank.head.bones):
            count += bank.bones[b].limb == limb
            judged += bank.bones[b].limb == limb and strays[b] != UNJUDGED
        limbs[limb] = NAN if 2 * judged < count else _rounded(limbs[limb] / judged, 100.0)
    if joint >= 0:
        deviation /= 1.0 - unjudged
        posture /= 1.0 - unjudged
    report.number, report.rev, report.count = move.number, move.rev, move.count
    report.start, report.time = _rounded(move.start, 1e6), _rounded(move.time, 1e6)
    report.progress, report.tempo = _rounded(move.progress, 1e4), _rounded(_tempo(move, bank, what), 1e3)
    report.deviation, report.joint, report.example = _rounded(deviation, 100.0), joint, move.example
    report.posture = _rounded(posture, 100.0)
    report.cost, report.gain, report.went = move.cost, move.gain, move.went
    report.residual, report.refused = move.residual, move.refused


cdef inline double _angle_of(double square) noexcept nogil:
    """Return the angle whose chord has this square, degrees."""
    return 2.0 * asin(0.5 * sqrt(min(max(square, 0.0), 4.0))) * DEGREES


cdef inline double _rounded(double number, double parts) noexcept nogil:
    return floor(number * parts + 0.5) / parts


cdef inline double _tempo(FollowedMove* move, FollowBank* bank, int64_t what) noexcept nogil:
    """Return the tempo relative to the example over the last second; of a performance that is done, over the whole."""
    cdef FollowedExample* example
    cdef double seconds
    cdef float way
    cdef int64_t last, back
    example = &bank.examples[move.example]
    seconds = (example.phases - 1) * example.stride * PERIOD
    if what == MOVE_DONE:
        return seconds / max(move.time - move.start, PERIOD)
    if move.recents < 2:
        return 1.0
    last = move.recents - 1
    back = min(last, TEMPO_SAMPLES)
    way = move.recent[last % RECENT_SAMPLES] - move.recent[(last - back) % RECENT_SAMPLES]
    return max(0.0, <double>way) * seconds / (back * PERIOD)


cdef void _follow_examples(FollowMemory* known, FollowBank* bank) noexcept nogil:
    """Align the sample that was taken with all examples, and update each move accordingly."""
    cdef FollowedExample* example
    cdef Cells cells
    cdef int64_t at, m, first, sample
    at = 0
    for m in range(bank.head.moves):
        first = at
        while at < bank.head.examples and bank.examples[at].move == m:
            example = &bank.examples[at]
            if known.state.samples % example.stride == 0:
                sample = known.state.samples // example.stride
                keep_sample(known, bank, example.ring, sample % bank.head.ring)
                cells = open_cells(known.memory, example)
                compare_sample(known, bank, example)
                advance_ways(&cells, known, sample)
                _note_end(&cells, known, m, at, example)
            at += 1
        settle_repetition(known, bank, m, False)
        _see_who_leads(known, bank, m, first, at)


cdef void _note_end(
    Cells* cells, FollowMemory* known, int64_t m, int64_t t, FollowedExample* example
) noexcept nogil:
    """Note a way that has reached the end of its example, if it ranks best."""
    cdef FollowedMove* move
    cdef double gain, rank
    cdef int64_t end, layer, place
    move = &known.moves[m]
    end = cells.costs.columns - 1
    for layer in range(LAYERS):
        place = layer * cells.costs.columns + end
        gain = <double>cells.gains.at[place] / (end + 1)
        rank = <double>cells.costs.at[place] / cells.weights.at[place] - GAIN_WORTH * gain
        if rank < move.best and gain > LEAST_GAIN and rank + GAIN_WORTH * gain < DEAREST_END * gain:
            move.best = rank
            move.best_gain = gain
            move.best_first = cells.firsts.at[place] * example.stride
            move.best_last = known.state.samples
            move.best_layer = layer
            move.best_example = t


cdef void _see_who_leads(
    FollowMemory* known, FollowBank* bank, int64_t m, int64_t first, int64_t last
) noexcept nogil:
    """Find the way that leads, and update move m, whose examples are `first` to `last`."""
    cdef FollowedMove* move
    cdef FollowedExample* example
    cdef Cells cells
    cdef double least, cost, rank
    cdef int64_t t, stride, samples, leader, layer, phase, count, other, j, place
    cdef bint waits, is_over
    move, samples = &known.moves[m], known.state.samples
    least, leader, layer, phase = INFINITY, -1, 0, 0
    waits = False
    for t in range(first, last):
        example = &bank.examples[t]
        cells = open_cells(known.memory, example)
        count = example.phases
        for other in range(LAYERS):
            for j in range(count):
                place = other * count + j
                cost = cells.costs.at[place]
                if not cost < INFINITY:
                    continue
                cost /= cells.weights.at[place]
                rank = cost + REMAINS * (1.0 - (j + 1.0) / count)
                if rank < least:
                    least, leader, layer, phase = rank, t, other, j
                if j >= RIVAL * count and cells.firsts.at[place] * example.stride <= move.best_last:
                    waits |= cost - GAIN_WORTH * cells.gains.at[place] / count < move.best
    is_over = move.best < INFINITY and move.best_last < samples
    stride = bank.examples[move.best_example].stride
    waits = waits and samples - move.best_last <= WAITED * stride
    if is_over and not waits and known.happened[m] == MOVE_UNCHANGED:
        if _decide_end(known, bank, m):
            return
        move.best = INFINITY
    if leader >= 0:
        _go_on(known, bank, m, leader, layer, phase)


cdef bint _decide_end(FollowMemory* known, FollowBank* bank, int64_t m) noexcept nogil:
    """Decide about the best end; return whether a performance is done."""
    cdef FollowedMove* move = &known.moves[m]
    cdef FollowedExample* example = &bank.examples[move.best_example]
    move.example, move.layer = move.best_example, move.best_layer
    move.phase = example.phases - 1
    move.first, move.last = move.best_first // example.stride, move.best_last // example.stride
    measure_way(known, bank, m)
    if is_another(known, bank.head.moves, m):
        move.refused = BY_ANOTHER
    elif is_unjudged(row_of_floats(known.strays, m)):
        move.refused = BY_HIDDEN
    elif not move.residual < MOST_NEAR:
        move.refused = BY_MOVEMENT
    elif not move.residual < (MOST_LEFT * MORE_LEFT if move.count else MOST_LEFT):
        move.refused = BY_ONCE
    elif is_settled(known, move):
        move.refused = BY_BREAK
    else:
        _finish(known, bank, m)
        return True
    return False


cdef inline bint is_unjudged(Floats strays) noexcept nogil:
    """Tell whether no bone was seen for long enough."""
    cdef int64_t b
    for b in range(strays.count):
        if strays.at[b] > UNJUDGED:
            return False
    return True


cdef bint is_another(FollowMemory* known, int64_t moves, int64_t m) noexcept nogil:
    """Tell whether the best end is that of another followed move, which explains the same movement better."""
    cdef FollowedMove* move
    cdef FollowedMove* other
    cdef int64_t half, o, both
    move = &known.moves[m]
    half = (move.best_last - move.best_first) // 2
    for o in range(moves):
        if o == m:
            continue
        other = &known.moves[o]
        both = min(move.best_last, other.best_last) - max(move.best_first, other.best_first)
        if other.best + CLEARLY < move.best and both > half:
            return True
        both = min(move.best_last, other.done_last) - max(move.best_first, other.done_first)
        if other.done + CLEARLY < move.best and both > half:
            return True
    return False


cdef int64_t measure_way(FollowMemory* known, FollowBank* bank, int64_t m) noexcept nogil:
    """Note how far each bone strays along the way of a move, and its costs without constant differences."""
    cdef FollowedMove* move
    cdef FollowedExample* example
    cdef Cells cells
    cdef int64_t count
    move = &known.moves[m]
    example = &bank.examples[move.example]
    cells = open_cells(known.memory, example)
    count = trace(&cells, known.way, move)
    move.residual = measure_strays(
        known, bank, example, count, row_of_floats(known.strays, m).at, row_of_floats(known.standing, m).at
    ) / example.dear
    return count


cdef void _go_on(
    FollowMemory* known, FollowBank* bank, int64_t m, int64_t leader, int64_t layer, int64_t phase
) noexcept nogil:
    """Report a performance that begins, goes on, or is given up, as the way that leads says."""
    cdef FollowedMove* move
    cdef FollowingState* state
    cdef FollowedExample* example
    cdef Cells cells
    cdef float cost
    cdef double progress, went, patience
    cdef int64_t first, place
    move, state = &known.moves[m], known.state
    example = &bank.examples[leader]
    cells = open_cells(known.memory, example)
    place = layer * example.phases + phase
    cost = cells.costs.at[place] / cells.weights.at[place]
    progress = phase / (example.phases - 1.0)
    first = cells.firsts.at[place]
    went = _went(known, bank, example, first)
    if move.active and first == move.first and leader == move.example:
        went = max(went, move.went)
    if not (cost < DEAREST and progress >= BEGUN and went >= WENT):
        patience = GIVEN_UP_LATE if move.progress >= NEARLY_OVER else GIVEN_UP_AFTER
        if move.active and state.sampled - move.seen > patience and known.happened[m] == MOVE_UNCHANGED:
            _give_up(known, bank, m)
        return
    move.example, move.layer, move.phase = leader, layer, phase
    move.first, move.last = first, state.samples // example.stride
    move.start = time_of_sample(state, first * example.stride)
    move.time, move.progress, move.cost, move.went = state.sampled, progress, cost, went
    move.gain = <double>cells.gains.at[place] / example.phases
    move.recent[move.recents % RECENT_SAMPLES] = <float>progress
    move.recents += 1
    move.seen = state.sampled
    if known.happened[m] != MOVE_UNCHANGED:
        return
    if not move.active:
        measure_way(known, bank, m)
        _report_move(known, bank, m, MOVE_BEGUN)
    elif state.sampled - move.reported >= state.every - EARLY:
        measure_way(known, bank, m)
        _report_move(known, bank, m, MOVE_GOES_ON)


cdef double _went(
    FollowMemory* known, FollowBank* bank, FollowedExample* example, int64_t first
) noexcept nogil:
    """Return how far the performer is from a way's first pose, relative to the example's farthest pose."""
    cdef const float* begin
    cdef const float* here
    cdef float total, x, y, z
    cdef int64_t d
    begin = row_of_ring(known, example.ring, in_ring(first, bank.head.ring))
    here = known.directions.at
    total = 0.0
    for d in range(0, 3 * bank.head.bones, 3):
        x, y, z = here[d] - begin[d], here[d + 1] - begin[d + 1], here[d + 2] - begin[d + 2]
        total += x * x + y * y + z * z
    return total / (bank.head.bones * example.farthest)


cdef void _give_up(FollowMemory* known, FollowBank* bank, int64_t m) noexcept nogil:
    """Report a performance that is given up, with the numbers of when it was last followed well."""
    measure_way(known, bank, m)
    _report_move(known, bank, m, MOVE_LEFT)


cdef void _finish(FollowMemory* known, FollowBank* bank, int64_t m) noexcept nogil:
    """Report a performance that is done; the next one begins after its end."""
    cdef FollowedMove* move
    cdef FollowedExample* other
    cdef Cells cells
    cdef int64_t t
    move = &known.moves[m]
    move.progress, move.gain = 1.0, move.best_gain
    move.start = time_of_sample(known.state, move.best_first)
    move.time = time_of_sample(known.state, move.best_last)
    move.done, move.done_first, move.done_last = move.best, move.best_first, move.best_last
    note_box(box_of(known, m), ring_of(known, bank.examples[move.example].ring), move.first, move.last)
    move.best = INFINITY
    move.middles[move.count % LATEST_DONE] = 0.5 * (move.start + move.time)
    move.count += 1
    _report_move(known, bank, m, MOVE_DONE)
    for t in range(bank.head.examples):
        other = &bank.examples[t]
        if other.move == m:
            cells = open_cells(known.memory, other)
            forget_ways(&cells, (move.best_last + other.stride - 1) // other.stride)


cdef inline double time_of_sample(FollowingState* state, int64_t sample) noexcept nogil:
    """Return the time of a sample that was taken, s."""
    return state.begin + sample * PERIOD


cdef void note_box(FloatPlanes box, FloatPlanes ring, int64_t first, int64_t last) noexcept nogil:
    """Note the least and the largest direction of each bone during a performance."""
    cdef const float* sample
    cdef float* least
    cdef float* largest
    cdef int64_t count, n, d
    count = 3 * ring.rows
    least, largest = box.at, box.at + count
    sample = plane_of_floats(ring, in_ring(last, ring.planes)).at
    for d in range(count):
        least[d] = largest[d] = sample[d]
    for n in range(max(first, last - ring.planes + 1), last):
        sample = plane_of_floats(ring, in_ring(n, ring.planes)).at
        for d in range(count):
            least[d] = min(least[d], sample[d])
            largest[d] = max(largest[d], sample[d])
