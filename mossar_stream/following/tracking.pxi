"""Tracking: what becomes of a followed move: begun, progress, done, left.

At each sample every example is aligned with the stream. Of all ways the one that costs least says how far along the
performer is. A way that has reached the end of its example is decided once no overlapping way ranks better. It is done
if it explains the movement well enough: what is left of its costs, once constant differences are taken away, is
compared with the costs of a performer who stands still. Once a performer has done a move, it may be done less well.
"""

# Chosen on five people and ten exercises, people left out in turn; all lie on wide plateaus (docs/lab-notes/following.md).
cdef double MOST_LEFT = 0.9  # residual above which nothing was done
cdef double MORE_LEFT = 1.4  # times that, for a performer who has done it before in the take
cdef double LEAST_GAIN = 0.25  # gain below which nothing was done
cdef double GAIN_WORTH = 0.6  # by how much a gain of 1 lowers the rank of an end
cdef double CLEARLY = 0.3  # by how much another move must rank better to be the one that was made
cdef double RIVAL = 0.3  # share of its example that a way has made which may yet rank better
cdef enum:
    WAITED = 7  # samples after which an end is decided at the latest
cdef double REMAINS = 0.05  # by how much what lies before a way raises its rank
cdef double BEGUN = 0.1  # progress at which a performance may be reported
cdef double WENT = 0.25  # share of the example's farthest pose that a performer has gone by then
cdef double DEAREST = 4.0  # cost above which nothing is being made
cdef double DEAREST_END = 8.0  # cost above which nothing was done, relative to the gain
cdef enum:
    MOST_SAMPLES = 1 << 30
cdef double GIVEN_UP_AFTER = 0.5  # s of that after which a performance is given up
cdef enum:
    NOTHING = 0
    BEGAN = 1
    GOES_ON = 2
    IS_DONE = 3
    GAVE_UP = 4
    REPORT_SIZE = 14


# ENTRY: called from Python
cdef int64_t follow_frame(Bytes memory, Bytes store, FloatRows positions, double time) noexcept nogil:
    """Process a frame; a function as readers have it.

    Args:
        memory: Of the performer; see `layout.py`.
        store: The bank.
        positions: (J, 3) float32 metres; NaN where a joint is missing.
        time: s.

    Returns:
        1 if a followed move changed, see `happened` of the moves; else 0.
    """
    cdef FollowBank bank
    cdef FollowMemory known
    # CHECK call of open_bank: open_bank(store)
    # CHECK call of open_memory: open_memory(memory, bank.head[0])
    bank = open_bank(store)
    known = open_memory(memory, &bank.head.at[0])
    if not is_new(known.state.at[0].frames, time, known.state.at[0].time, LEAST_SPACING):
        return 0
    _take(memory, &known, &bank, positions, time)
    return 1 if known.state.at[0].happened else 0


# ENTRY: called from Python
cdef void finish_take(Bytes memory, Bytes store) noexcept nogil:
    """Decide everything at the end of a take; see `happened` of the moves."""
    cdef FollowBank bank
    cdef FollowMemory known
    cdef int64_t m
    # CHECK call of open_bank: open_bank(store)
    # CHECK call of open_memory: open_memory(memory, bank.head[0])
    bank = open_bank(store)
    known = open_memory(memory, &bank.head.at[0])
    known.state.at[0].happened = 0
    for m in range(known.moves.count):
        known.happened.at[m] = NOTHING
        if known.moves.at[m].best < INFINITY and _is_done(memory, &known, &bank, m):
            _finish(memory, &known, &bank, m)
        elif known.moves.at[m].active:
            _give_up(memory, &known, &bank, m)


# ENTRY: called from Python
cdef void evaluate(Bytes memory, Bytes store, int64_t m) noexcept nogil:
    """Write what is to be reported of a move that is being made."""
    cdef FollowBank bank
    cdef FollowMemory known
    # CHECK call of open_bank: open_bank(store)
    # CHECK call of open_memory: open_memory(memory, bank.head[0])
    bank = open_bank(store)
    known = open_memory(memory, &bank.head.at[0])
    measure_way(memory, &known, &bank, m)
    write_report(&known, &bank, m, GOES_ON)


cdef void _take(Bytes memory, FollowMemory* known, FollowBank* bank, FloatRows positions, double time) noexcept nogil:
    """Process one frame."""
    cdef int64_t m
    cdef bint fresh, whole
    cdef FloatPlanes poses
    cdef FollowingState* state
    cdef FollowedMoveSpan moves
    cdef double share
    # CHECK place_pose is called with several kinds of arguments
    state = &known.state.at[0]
    moves = known.moves
    state.happened = 0
    for m in range(moves.count):
        known.happened.at[m] = NOTHING
    fresh = not follows(state.frames, time, state.time)
    if fresh and state.frames > 0:
        _restart(memory, known, bank)
    poses = known.poses
    _copy_pose(poses, 0, 1)
    whole = place_pose(plane_of_floats(poses, 1), bank, positions)
    if fresh:
        if not whole and not assume_missing(plane_of_floats(poses, 1), known.absences, bank, positions):
            return
        _copy_pose(poses, 0, 1)
        state.next = state.time = time
    note_absences(known.absences, bank, positions, whole, time - state.time)
    while state.next <= time + EARLY:
        share = 1.0 if fresh else min(1.0, 1.0 - (time - state.next) / (time - state.time))
        take_sample(known, bank, share, state.next - state.sampled)
        state.sampled = state.next
        _follow_all(memory, known, bank)
        state.samples += 1
        # Far from zero a period is less than the spacing of floats: then the next float is the next sample's time.
        state.next = max(state.next + PERIOD, nextafter(state.next, INFINITY))
        fresh = False
    state.time = time
    state.frames += 1


cdef inline void _copy_pose(FloatPlanes poses, int64_t to, int64_t of) noexcept nogil:
    cdef int64_t k, d
    for k in range(poses.rows):
        for d in range(3):
            poses.at[(to * poses.rows + k) * poses.columns + d] = poses.at[(of * poses.rows + k) * poses.columns + d]


cdef void _restart(Bytes memory, FollowMemory* known, FollowBank* bank) noexcept nogil:
    """Give up what is being made, after a gap."""
    cdef int64_t m, t
    cdef FollowingState* state
    cdef FollowedMoveSpan moves
    cdef FollowedExampleSpan examples
    # CHECK call of open_cells: open_cells(memory, examples[t])
    state = &known.state.at[0]
    moves = known.moves
    examples = bank.examples
    state.frames = 0
    state.samples = 0
    for m in range(moves.count):
        if moves.at[m].active:
            _give_up(memory, known, bank, m)
        moves.at[m].best = moves.at[m].done = INFINITY
    for t in range(examples.count):
        warping_forget(open_cells(memory, &examples.at[t]), MOST_SAMPLES)


cdef void _tell(FollowMemory* known, FollowBank* bank, int64_t m, int64_t what) noexcept nogil:
    cdef FollowedMove* move
    move = &known.moves.at[m]
    known.happened.at[m] = what
    known.state.at[0].happened = 1
    move.reported = known.state.at[0].sampled
    if not move.active and what != GAVE_UP:
        known.state.at[0].number += 1
        move.number = known.state.at[0].number
        move.rev = 0
    if what == BEGAN:
        move.active = 1
        move.recents = 0
    elif what != GOES_ON:
        move.active = 0
    move.rev += 1
    write_report(known, bank, m, what)


cdef void write_report(FollowMemory* known, FollowBank* bank, int64_t m, int64_t what) noexcept nogil:
    """Write what is reported of a move, rounded."""
    cdef int64_t limbs, limb, b, joint, count, judged
    cdef FollowedMove* move
    cdef Floats strays
    cdef Doubles report
    cdef FloatRows weights
    cdef BoneSpan bones
    cdef double farthest, deviation, unjudged, chord, angle
    # CHECK call of weights_of_bones: weights_of_bones(bank)
    # CHECK np.degrees
    move = &known.moves.at[m]
    strays = row_of_floats(known.strays, m)
    report = row_of_doubles(known.reports, m)
    weights = weights_of_bones(bank)
    bones = bank.bones
    limbs = report.count - REPORT_SIZE
    for limb in range(limbs):
        report.at[REPORT_SIZE + limb] = 0.0
    farthest, joint, deviation, unjudged = -1.0, -1, 0.0, 0.0
    for b in range(strays.count):
        if strays.at[b] == UNJUDGED:
            unjudged += weights.at[move.example * weights.columns + b]
            continue
        chord = sqrt(min(max(<double>strays.at[b], 0.0), 4.0))
        angle = degrees(2.0 * asin(0.5 * chord))
        deviation += angle * weights.at[move.example * weights.columns + b]
        if angle > farthest:
            farthest, joint = angle, b
        if bones.at[b].limb >= 0:
            report.at[REPORT_SIZE + bones.at[b].limb] += angle
    for limb in range(limbs):
        count = judged = 0
        for b in range(bones.count):
            count += bones.at[b].limb == limb
            judged += bones.at[b].limb == limb and strays.at[b] != UNJUDGED
        if 2 * judged < count:
            report.at[REPORT_SIZE + limb] = NAN
        else:
            report.at[REPORT_SIZE + limb] = _rounded(report.at[REPORT_SIZE + limb] / judged, 100.0)
    if joint >= 0:
        deviation /= 1.0 - unjudged
    report.at[0], report.at[1], report.at[2] = move.number, move.rev, move.count
    report.at[3], report.at[4] = _rounded(move.start, 1e6), _rounded(move.time, 1e6)
    report.at[5], report.at[6] = _rounded(move.progress, 1e4), _rounded(_tempo(move, bank, what), 1e3)
    report.at[7], report.at[8], report.at[9] = _rounded(deviation, 100.0), joint, move.example
    report.at[10], report.at[11], report.at[12], report.at[13] = move.cost, move.gain, move.went, move.residual


cdef inline double _rounded(double number, double parts) noexcept nogil:
    return floor(number * parts + 0.5) / parts


cdef inline double _tempo(FollowedMove* move, FollowBank* bank, int64_t what) noexcept nogil:
    """Return the tempo relative to the example over the last second, of what is done that of the whole."""
    cdef FollowedExample* example
    cdef double seconds
    cdef int64_t back
    cdef float way
    # CHECK sign (C truncates): (move.recents - 1) % RECENT_SAMPLES; (move.recents - 1 - back) % RECENT_SAMPLES
    example = &bank.examples.at[move.example]
    seconds = (example.phases - 1) * example.stride * PERIOD
    if what == IS_DONE:
        return seconds / max(move.time - move.start, PERIOD)
    if move.recents < 2:
        return 1.0
    back = min(move.recents - 1, TEMPO_SAMPLES)
    way = move.recent[(move.recents - 1) % RECENT_SAMPLES] - move.recent[(move.recents - 1 - back) % RECENT_SAMPLES]
    return max(0.0, <double>way) * seconds / (back * PERIOD)


cdef void _follow_all(Bytes memory, FollowMemory* known, FollowBank* bank) noexcept nogil:
    """Align the sample that was taken with all examples, and see what that says of each move."""
    cdef int64_t at, m, first, number, line
    cdef FollowingState* state
    cdef FollowedExampleSpan examples
    cdef FloatBlocks rings
    cdef FollowedExample* example
    cdef Cells cells
    # CHECK sign (C truncates): state.samples % example.stride; state.samples // example.stride; number % rings.shape[1]; number % cells.steps.shape[0]
    # CHECK 4d rings[example.ring, line]
    # CHECK call of open_cells: open_cells(memory, example)
    # CHECK call of rows_of_example: rows_of_example(bank, example)
    # CHECK call of mean_of_example: mean_of_example(bank, example)
    state = &known.state.at[0]
    examples = bank.examples
    rings = known.rings
    at = 0
    for m in range(known.moves.count):
        first = at
        while at < examples.count and examples.at[at].move == m:
            example = &examples.at[at]
            if state.samples % example.stride == 0:
                number = state.samples // example.stride
                line = number % rings.planes
                keep_sample(FOURD(rings[example.ring, line]), row_of_bytes(plane_of_bytes(known.hidden, example.ring), line), known, bank)
                cells = open_cells(memory, example)
                compare(known, rows_of_example(bank, example), mean_of_example(bank, example), example)
                warping_advance(&cells, known, number, number % cells.steps.rows)
                _note_end(&cells, known, m, at, example)
            at += 1
        _lead(memory, known, bank, m, first, at)


cdef void _note_end(Cells* cells, FollowMemory* known, int64_t m, int64_t t, FollowedExample* example) noexcept nogil:
    """Take note of a way that has reached the end of its example, if it ranks best."""
    cdef FollowedMove* move
    cdef int64_t end, layer
    cdef double gain, rank
    move = &known.moves.at[m]
    end = cells.costs.columns - 1
    for layer in range(LAYERS):
        gain = <double>cells.gains.at[layer * cells.gains.columns + end] / (end + 1)
        rank = <double>cells.costs.at[layer * cells.costs.columns + end] / cells.weights.at[layer * cells.weights.columns + end] - GAIN_WORTH * gain
        if rank < move.best and gain > LEAST_GAIN and rank + GAIN_WORTH * gain < DEAREST_END * gain:
            move.best = rank
            move.best_gain = gain
            move.best_first = cells.firsts.at[layer * cells.firsts.columns + end] * example.stride
            move.best_last = known.state.at[0].samples
            move.best_layer = layer
            move.best_example = t


cdef void _lead(Bytes memory, FollowMemory* known, FollowBank* bank, int64_t m, int64_t first, int64_t last) noexcept nogil:
    """See which way leads, and what that says of move m, whose examples are `first` to `last`."""
    cdef bint waits, is_over
    cdef int64_t t, stride, samples, leader, layer, phase, count, other, j
    cdef FollowedMove* move
    cdef double least, cost, rank
    cdef FollowedExample* example
    cdef Cells cells
    # CHECK call of open_cells: open_cells(memory, example)
    move = &known.moves.at[m]
    samples = known.state.at[0].samples
    least, leader, layer, phase = INFINITY, -1, 0, 0
    waits = False
    for t in range(first, last):
        example = &bank.examples.at[t]
        cells = open_cells(memory, example)
        count = cells.costs.columns
        for other in range(LAYERS):
            for j in range(count):
                cost = <double>cells.costs.at[other * cells.costs.columns + j]
                if not cost < INFINITY:
                    continue
                cost /= cells.weights.at[other * cells.weights.columns + j]
                rank = cost + REMAINS * (1.0 - (j + 1.0) / count)
                if rank < least:
                    least, leader, layer, phase = rank, t, other, j
                if j >= RIVAL * count and cells.firsts.at[other * cells.firsts.columns + j] * example.stride <= move.best_last:
                    waits |= cost - GAIN_WORTH * cells.gains.at[other * cells.gains.columns + j] / count < move.best
    is_over = move.best < INFINITY and move.best_last < samples
    stride = bank.examples.at[move.best_example].stride
    if is_over and (not waits or samples - move.best_last > WAITED * stride) and known.happened.at[m] == NOTHING:
        if _is_done(memory, known, bank, m):
            _finish(memory, known, bank, m)
            return
        move.best = INFINITY
    if leader >= 0:
        _tracking_go_on(memory, known, bank, m, (leader, layer, phase))


cdef bint _is_done(Bytes memory, FollowMemory* known, FollowBank* bank, int64_t m) noexcept nogil:
    """Tell whether the best end explains the movement well enough, and note how far each bone strays in it."""
    cdef FollowedMove* move
    cdef int64_t stride
    # CHECK sign (C truncates): move.best_first // stride; move.best_last // stride
    move = &known.moves.at[m]
    stride = bank.examples.at[move.best_example].stride
    move.example, move.layer = move.best_example, move.best_layer
    move.phase = bank.examples.at[move.best_example].phases - 1
    move.first, move.last = move.best_first // stride, move.best_last // stride
    measure_way(memory, known, bank, m)
    if _is_another(known, m) or _tracking_largest(row_of_floats(known.strays, m)) == UNJUDGED:
        return False
    return move.residual < (MOST_LEFT * MORE_LEFT if move.count else MOST_LEFT)


cdef inline float _tracking_largest(Floats strays) noexcept nogil:
    cdef float largest
    cdef int64_t b
    largest = UNJUDGED
    for b in range(strays.count):
        largest = max(largest, strays.at[b])
    return largest


cdef bint _is_another(FollowMemory* known, int64_t m) noexcept nogil:
    """Tell whether the best end is that of another followed move, which explains the same movement better."""
    cdef FollowedMoveSpan moves
    cdef FollowedMove* move, other
    cdef int64_t half, o, both
    # CHECK sign (C truncates): (move.best_last - move.best_first) // 2
    moves = known.moves
    move = &moves.at[m]
    half = (move.best_last - move.best_first) // 2
    for o in range(moves.count):
        if o == m:
            continue
        other = &moves.at[o]
        both = min(move.best_last, other.best_last) - max(move.best_first, other.best_first)
        if other.best + CLEARLY < move.best and both > half:
            return True
        both = min(move.best_last, other.done_last) - max(move.best_first, other.done_first)
        if other.done + CLEARLY < move.best and both > half:
            return True
    return False


cdef void measure_way(Bytes memory, FollowMemory* known, FollowBank* bank, int64_t m) noexcept nogil:
    """Note how far each bone strays along the way that a move is followed by, and what is left of its costs."""
    cdef FollowedMove* move
    cdef FollowedExample* example
    cdef Cells cells
    cdef int64_t count
    cdef float left
    cdef FloatPlanes ring
    cdef ByteRows hidden
    # CHECK call of open_cells: open_cells(memory, example)
    # CHECK 4d known.rings[example.ring]
    # CHECK call of rows_of_example: rows_of_example(bank, example)
    move = &known.moves.at[m]
    example = &bank.examples.at[move.example]
    cells = open_cells(memory, example)
    count = trace(&cells, known.way, move.layer, move.phase, move.last, move.first)
    ring = FOURD(known.rings[example.ring])
    hidden = plane_of_bytes(known.hidden, example.ring)
    left = measure(known, rows_of_example(bank, example), (ring, hidden), count, row_of_floats(known.strays, m))
    move.residual = left / example.dear


cdef void _tracking_go_on(Bytes memory, FollowMemory* known, FollowBank* bank, int64_t m, (int64_t, int64_t, int64_t) lead) noexcept nogil:
    """Report a performance that begins, goes on, or is given up."""
    cdef FollowedExample* example
    cdef Cells cells
    cdef float cost
    cdef double progress, went
    cdef int32_t first
    cdef FollowedMove* move
    cdef FollowingState* state
    cdef int64_t leader, layer, phase
    # CHECK sign (C truncates): state.samples // example.stride; move.recents % RECENT_SAMPLES
    # CHECK call of open_cells: open_cells(memory, example)
    move = &known.moves.at[m]
    state = &known.state.at[0]
    leader, layer, phase = lead
    example = &bank.examples.at[leader]
    cells = open_cells(memory, example)
    cost = cells.costs.at[layer * cells.costs.columns + phase] / cells.weights.at[layer * cells.weights.columns + phase]
    progress = phase / (cells.costs.columns - 1.0)
    first = cells.firsts.at[layer * cells.firsts.columns + phase]
    went = _went(known, bank, example, first)
    if move.active and first == move.first and leader == move.example:
        went = max(went, move.went)
    if not (cost < DEAREST and progress >= BEGUN and went >= WENT):
        if move.active and state.sampled - move.seen > GIVEN_UP_AFTER and known.happened.at[m] == NOTHING:
            _give_up(memory, known, bank, m)
        return
    move.example, move.layer, move.phase = leader, layer, phase
    move.first, move.last = first, state.samples // example.stride
    move.start = state.sampled - (state.samples - first * example.stride) * PERIOD
    move.time, move.progress, move.cost, move.went = state.sampled, progress, cost, went
    move.gain = <double>cells.gains.at[layer * cells.gains.columns + phase] / cells.costs.columns
    move.recent[move.recents % RECENT_SAMPLES] = progress
    move.recents += 1
    move.seen = state.sampled
    if known.happened.at[m] != NOTHING:
        return
    if not move.active:
        measure_way(memory, known, bank, m)
        _tell(known, bank, m, BEGAN)
    elif state.sampled - move.reported >= state.every - EARLY:
        measure_way(memory, known, bank, m)
        _tell(known, bank, m, GOES_ON)


cdef double _went(FollowMemory* known, FollowBank* bank, FollowedExample* example, int32_t first) noexcept nogil:
    """Return how far the performer is from the first pose of a way, relative to the example's farthest pose."""
    cdef FloatRows begin, directions
    cdef float total, x, y, z
    cdef int64_t b
    cdef FloatBlocks rings
    # CHECK sign (C truncates): first % rings.shape[1]
    # CHECK 4d rings[example.ring, first % rings.shape[1]]
    rings = known.rings
    directions = known.directions
    begin = FOURD(rings[example.ring, first % rings.shape[1]])
    total = <float>0.0
    for b in range(directions.rows):
        x, y, z = directions.at[b * directions.columns + 0] - begin.at[b * begin.columns + 0], directions.at[b * directions.columns + 1] - begin.at[b * begin.columns + 1], directions.at[b * directions.columns + 2] - begin.at[b * begin.columns + 2]
        total += x * x + y * y + z * z
    return total / (directions.rows * example.farthest)


cdef void _give_up(Bytes memory, FollowMemory* known, FollowBank* bank, int64_t m) noexcept nogil:
    """Report a performance that is given up, with the numbers of when it was last followed well."""
    measure_way(memory, known, bank, m)
    _tell(known, bank, m, GAVE_UP)


cdef void _finish(Bytes memory, FollowMemory* known, FollowBank* bank, int64_t m) noexcept nogil:
    """Report a performance that is done; the next one begins after its end."""
    cdef FollowedExample* example, other
    cdef int64_t t
    cdef FollowedMove* move
    cdef FollowingState* state
    # CHECK sign (C truncates): (move.best_last + other.stride - 1) // other.stride
    # CHECK 4d known.boxes[m]
    # CHECK 4d known.rings[example.ring]
    # CHECK call of open_cells: open_cells(memory, other)
    move = &known.moves.at[m]
    state = &known.state.at[0]
    example = &bank.examples.at[move.example]
    move.progress, move.gain = 1.0, move.best_gain
    move.start = state.sampled - (state.samples - move.best_first) * PERIOD
    move.time = state.sampled - (state.samples - move.best_last) * PERIOD
    move.done, move.done_first, move.done_last = move.best, move.best_first, move.best_last
    move.best = INFINITY
    move.count += 1
    _tracking_box(FOURD(known.boxes[m]), FOURD(known.rings[example.ring]), move.first, move.last)
    _tell(known, bank, m, IS_DONE)
    for t in range(bank.examples.count):
        other = &bank.examples.at[t]
        if other.move == m:
            warping_forget(open_cells(memory, other), (move.best_last + other.stride - 1) // other.stride)


cdef void _tracking_box(FloatPlanes box, FloatPlanes ring, int64_t first, int64_t last) noexcept nogil:
    """Note the least and the largest direction of each bone during a performance."""
    cdef int64_t size, b, n, d
    # CHECK sign (C truncates): last % size; n % size
    size = ring.planes
    for b in range(ring.rows):
        for d in range(3):
            box.at[(0 * box.rows + b) * box.columns + d] = box.at[(1 * box.rows + b) * box.columns + d] = ring.at[(last % size * ring.rows + b) * ring.columns + d]
    for n in range(max(first, last - size + 1), last):
        for b in range(ring.rows):
            for d in range(3):
                box.at[(0 * box.rows + b) * box.columns + d] = min(box.at[(0 * box.rows + b) * box.columns + d], ring.at[(n % size * ring.rows + b) * ring.columns + d])
                box.at[(1 * box.rows + b) * box.columns + d] = max(box.at[(1 * box.rows + b) * box.columns + d], ring.at[(n % size * ring.rows + b) * ring.columns + d])
