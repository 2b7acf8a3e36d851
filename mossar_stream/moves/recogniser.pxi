"""The recogniser: frames in, recognised moves out, with bounded work for each frame.

Once speed has come down from a peak, stretches that end now and begin at one of the last onsets or minima of
speed are compared with all examples, every `COMPARED_EVERY` seconds. A move is recognised when its cost is
low enough; a clear lead over every other move raises the limit. `AGREED` comparisons in a row must give the
same move. No later move begins before its end, but until the movement rests a longer stretch may show that it
was another one.

The numbers were chosen on continuous sessions of ten players (14 moves on command, one and two examples of
each), each player left out in turn; they lie in the middle of wide plateaus.
"""

cdef double COMPARED_EVERY = 0.1  # s
cdef double MOST = -0.75  # natural logarithm of a move's largest cost without a rule
cdef double STRICT_WORTH = 2.0  # decrease of that from strictness 0 to 1
cdef double LEAD_WORTH = 0.8  # rise of that for a lead of 1
# Of a lead (natural logarithm of the next move's cost over this one's) at most so much counts.
cdef double LEAD_COUNTED = 0.7
cdef double FALLEN = 0.7  # of the peak of speed; comparisons begin below it
cdef double LOUD = 0.15  # m/s, mean over the joints: slower is rest
cdef double QUIET = 0.67  # s after the last loud pose for which comparisons go on
cdef double LONGEST = 3.0  # s, of a stretch
# Natural logarithm of how much cheaper another move must be to replace the one recognised.
cdef double REVISED = 0.5
cdef double SETTLED = 1.5  # s after which a recognised move is final at the latest
cdef float RIVALS = exp(LEAD_COUNTED)  # costs beyond so many times the best do not matter
cdef float HANDICAP = exp(REVISED)
cdef enum:
    AGREED = 2  # comparisons in a row that must name the same move
    SHORTEST = 8  # poses, of a stretch
cdef enum:  # results of a frame
    CONFIRMED = 1
    FINAL = 2
    WITHDRAWN = 4
    EXPLAINED = 8
cdef enum:  # reasons why a move was not recognised
    BY_NOTHING = 0
    BY_COST = 1
    BY_LEAD = 2
    BY_POSTURE = 3
    BY_AGREEMENT = 4
    BY_PAUSE = 5

cdef struct Decision:
    double next_comparison  # s, when stretches are compared next; nothing happens before, if no move is open
    double loud  # s, when speed was last above `LOUD`
    double peak  # m/s, largest speed since the last onset or decision
    int64_t from_pose  # a new move begins at this pose or later: earlier poses belong to the last one
    int64_t leader  # move that was best at the last comparison, -1 for none
    int64_t agreed  # comparisons in a row in which it was best


cdef struct FoundMove:
    int64_t move  # -1 for none
    int64_t number  # counts the performer's moves
    int64_t take  # in which it was confirmed
    int64_t limb  # that led, -1 for none
    double cost  # see measure.pxi
    int64_t first  # number of the pose where it begins
    double start  # s
    double end  # s
    double time  # s, when it was recognised


cdef struct Nearest:
    int64_t open  # whether a movement goes on that was compared
    int64_t kept  # `BY_...`, the reason why it was not recognised
    int64_t move  # that was nearest
    int64_t second  # the nearest other move, -1 for none
    double value  # excess of its log cost, less its lead, over the most; least of the movement
    double most  # logarithm of its largest cost without a lead
    double cost  # see measure.pxi
    double second_cost
    double posture  # factor of the cost that is due to another posture
    double start  # s
    double end  # s


cdef struct RecognitionState:
    double due  # s, from when on a frame becomes a pose; see core/reader.pxi
    Track track
    MoveActivity activity
    Decision decision
    FoundMove found  # the last move recognised, not final yet
    FoundMove before  # the one before, that the frame changed
    Nearest nearest  # nearest move in the movement that goes on, or has just ended
    int64_t happened  # at the last frame that became a pose
    double time  # s, of that frame


cdef struct MoveMemory:  # The parts of a performer's memory.
    RecognitionState* state
    FloatRows poses  # (RING + RAW, D) m; see `add_track_pose`
    double* last_times  # (M,) s, when each move was confirmed last; -inf for never
    uint8_t* end


cdef MoveMemory open_move_memory(uint8_t* memory, MoveStore* head) noexcept nogil:
    """Return the parts of a performer's memory, without reading it."""
    cdef MoveMemory known
    known.state = <RecognitionState*>memory
    known.poses = floats_in_rows(<float*>(memory + sizeof(RecognitionState)), RING + RAW, head.numbers)
    known.last_times = <double*>(known.poses.at + known.poses.rows * known.poses.columns)
    known.end = <uint8_t*>(known.last_times + head.moves)
    return known


cdef void begin_move_memory(MoveMemory* known, int64_t moves) noexcept nogil:
    """Set the memory to that of a new performer."""
    cdef RecognitionState* state = known.state
    cdef int64_t m
    memset(<uint8_t*>state, 0, known.end - <uint8_t*>state)
    state.due = -INFINITY
    state.found.move = state.before.move = state.nearest.move = state.nearest.second = -1
    for m in range(moves):
        known.last_times[m] = -INFINITY


cdef int64_t recognise(
    uint8_t* memory, uint8_t* store, float* positions, int64_t joints, double time
) noexcept nogil:
    """Process a frame; a function of a reader.

    Args:
        memory: Of the performer.
        store: The examples.
        positions: (joints, 3) m; NaN where a joint is missing.
        joints: Number of joints.
        time: s.

    Returns:
        1 if a move changed, see `happened` of its record; else 0.
    """
    cdef MoveBank bank
    cdef MoveMemory known
    cdef RecognitionState* state
    bank = open_move_store(store)
    known = open_move_memory(memory, bank.head)
    state = known.state
    if not is_new(state.track.poses, time, state.track.time, TICK - EARLY):
        return 0
    _follow_moves(&known, &bank, floats_in_rows(positions, joints, 3), time)
    state.due = state.track.time + TICK - EARLY if state.track.poses > 0 else -INFINITY
    return 1 if state.happened != 0 else 0


cdef void _follow_moves(MoveMemory* known, MoveBank* bank, FloatRows positions, double time) noexcept nogil:
    """Process one frame."""
    cdef RecognitionState* state
    cdef int64_t was_moving
    cdef bint goes_on, rests
    state = known.state
    state.happened = 0
    state.time = time
    goes_on = add_track_pose(&state.track, known.poses, positions, bank, time)
    if state.track.poses == 0:
        return
    if not goes_on:
        _settle_move(state, FINAL)
        if state.nearest.open == 1:
            _explain(state)
        _start_recognition(state, time)
        return
    was_moving = state.activity.moving
    follow_move_activity(&state.activity, &state.track)
    if _is_comparison_due(&state.decision, &state.activity, was_moving, time):
        _compare_stretches(known, bank)
    elif bank.head.explains != 0:
        _end_movement(state, time)
    rests = state.activity.moving == 0 or time - state.found.time > SETTLED + EARLY
    if rests and state.found.move >= 0 and (state.happened & ~EXPLAINED) == 0:
        _settle_move(state, FINAL)


cdef inline bint _is_comparison_due(
    Decision* decision, MoveActivity* activity, int64_t was_moving, double time
) noexcept nogil:
    cdef double speed
    speed = activity.speed
    decision.peak = speed if activity.moving > was_moving else max(decision.peak, speed)
    if speed > LOUD:
        decision.loud = time
    if time < decision.next_comparison:
        return False
    decision.next_comparison = time + COMPARED_EVERY - 0.001  # times of frames are not exact
    return time - decision.loud <= QUIET + EARLY and speed <= FALLEN * decision.peak


cdef void _start_recognition(RecognitionState* state, double time) noexcept nogil:
    start_move_activity(&state.activity)
    state.decision.next_comparison = time
    state.decision.loud = -INFINITY
    _decide_anew(&state.decision, state.track.first)


cdef inline void _decide_anew(Decision* decision, int64_t from_pose) noexcept nogil:
    """Set the first pose at which the next move may begin."""
    decision.from_pose = from_pose
    decision.peak = 0.0
    decision.leader = -1
    decision.agreed = 0


cdef void _settle_move(RecognitionState* state, int64_t how) noexcept nogil:
    """Report the end of the last recognised move: final or withdrawn."""
    if state.found.move >= 0:
        state.before = state.found
        state.found.move = -1
        state.happened |= how


cdef void _compare_stretches(MoveMemory* known, MoveBank* bank) noexcept nogil:
    """Compare the stretches that end at the last pose with the examples, and decide."""
    cdef RecognitionState* state
    cdef Doubles path
    cdef float best, cost
    cdef int64_t i, t, last, first, best_first, move
    state = known.state
    path = doubles(state.track.path, RING)
    last = state.track.poses - 1
    for t in range(bank.head.examples):
        bank.examples[t].cost = bank.examples[t].near = NEVER
    best, best_first = NEVER, -1
    for i in range(STARTS):
        first = max(state.activity.starts[i] - 1, state.track.first)
        if state.activity.starts[i] < 0 or not _may_begin(state, first, last):
            continue
        describe_stretch(
            known.poses, path, first, last, bank.head.joints, bank.head.girdles, &bank.scratch
        )
        cost = _compare_examples(state, bank, first, best)
        if cost < best:
            best, best_first = cost, first
        if bank.head.explains != 0 and first >= state.decision.from_pose:
            _compare_without_limits(bank, first)
    if bank.head.explains != 0:
        _note_nearest(state, bank)
    if best_first < 0 or not _is_agreed(&state.decision, bank, best):
        return
    move = state.decision.leader
    if 0.0 <= state.time - known.last_times[move] < bank.rules[move].again - EARLY:
        _pass_over(state, last)
        return
    known.last_times[move] = state.time
    _confirm(known, bank, best_first, last)
    if bank.head.explains != 0:
        _explain_found(state, bank)


cdef inline bint _may_begin(RecognitionState* state, int64_t first, int64_t last) noexcept nogil:
    if last - first < SHORTEST or last - first >= RING - 1:
        return False
    if state.track.times[last % RING] - state.track.times[first % RING] > LONGEST + EARLY:
        return False
    return first >= state.decision.from_pose or (state.found.move >= 0 and first >= state.found.first)


cdef float _compare_examples(
    RecognitionState* state, MoveBank* bank, int64_t first, float best
) noexcept nogil:
    """Note the costs of examples where this stretch is the cheapest so far; return the least, or `best`."""
    cdef MoveExample* example
    cdef float bar, limit, factor, cost
    cdef int64_t t
    cdef bint revision
    revision = first < state.decision.from_pose
    bar = <float>bank.head.bar
    if revision:
        bar = min(bar, <float>state.found.cost)
    for t in range(bank.head.examples):
        example = &bank.examples[t]
        if revision and example.move == state.found.move:
            continue
        limit = min(example.cost, min(best, bar) * RIVALS)
        factor = _posture_of(bank, t)
        if revision:
            factor *= HANDICAP
        if LEAST_COST * factor >= limit:
            continue
        factor *= _correction_of(bank, t)
        if LEAST_COST * factor >= limit:
            continue
        cost = factor * warped(&bank.scratch, directions_of_example(bank, t), limit / factor)
        if cost < example.cost:
            example.cost = cost
            best = min(best, cost)
    return best


cdef inline float _posture_of(MoveBank* bank, int64_t t) noexcept nogil:
    """Return the factor of another posture in the cost of taking the stretch for example t."""
    return strangeness(&bank.scratch, row_of_example(bank, t, DIRECTIONS + 2))


cdef inline float _correction_of(MoveBank* bank, int64_t t) noexcept nogil:
    """Return the factor that is due to other shares, boxes and sizes."""
    return correction(
        &bank.scratch, row_of_example(bank, t, DIRECTIONS), row_of_example(bank, t, DIRECTIONS + 1),
        bank.examples[t].size,
    )


cdef inline bint _is_agreed(Decision* decision, MoveBank* bank, float best) noexcept nogil:
    """Return whether the move with the least cost is recognised now."""
    cdef MoveExample* examples
    cdef float second
    cdef double lead
    cdef int64_t move, t
    examples = bank.examples
    move = -1
    for t in range(bank.head.examples):
        if examples[t].cost == best:
            move = examples[t].move
            break
    second = NEVER
    for t in range(bank.head.examples):
        if examples[t].move != move:
            second = min(second, examples[t].cost)
    lead = min(<double>logf(second / best), LEAD_COUNTED)
    if not logf(best) - LEAD_WORTH * lead < bank.rules[move].most:
        decision.leader = -1
        decision.agreed = 0
        return False
    decision.agreed = decision.agreed + 1 if decision.leader == move else 1
    decision.leader = move
    return decision.agreed >= AGREED


cdef void _confirm(MoveMemory* known, MoveBank* bank, int64_t first, int64_t last) noexcept nogil:
    cdef RecognitionState* state
    cdef FoundMove* found
    cdef float cost
    cdef int64_t move, t
    state = known.state
    move = state.decision.leader
    cost = NEVER
    for t in range(bank.head.examples):
        if bank.examples[t].move == move:
            cost = min(cost, bank.examples[t].cost)
    _settle_move(state, WITHDRAWN if first < state.decision.from_pose else FINAL)
    found = &state.found
    found.move = move
    found.number += 1
    found.cost = cost
    found.first = first
    found.start = state.track.times[first % RING]
    found.end = found.time = state.time
    describe_stretch(
        known.poses, doubles(state.track.path, RING), first, last,
        bank.head.joints, bank.head.girdles, &bank.scratch,
    )
    found.limb = _leading_limb(bank)
    state.happened |= CONFIRMED
    _decide_anew(&state.decision, last)


cdef inline void _pass_over(RecognitionState* state, int64_t last) noexcept nogil:
    """End a move that was made again too soon without an event."""
    _decide_anew(&state.decision, last)
    if state.nearest.open == 1:
        state.nearest.kept = BY_PAUSE
        _explain(state)


cdef void _compare_without_limits(MoveBank* bank, int64_t first) noexcept nogil:
    """Note the cost of taking the stretch for each example where no other stretch cost less."""
    cdef MoveExample* example
    cdef float posture, factor, cost
    cdef int64_t t
    for t in range(bank.head.examples):
        example = &bank.examples[t]
        posture = _posture_of(bank, t)
        factor = posture * _correction_of(bank, t)
        cost = factor * warped(&bank.scratch, directions_of_example(bank, t), NEVER)
        if cost < example.near:
            example.near, example.near_posture, example.near_first = cost, posture, first


cdef void _note_nearest(RecognitionState* state, MoveBank* bank) noexcept nogil:
    """Note the nearest move at this comparison, if none was nearer in this movement."""
    cdef MoveExample* examples
    cdef MoveExample* best
    cdef MoveExample* second
    cdef Nearest* nearest
    cdef double cost, most, second_cost, lead
    cdef int64_t t
    examples, nearest = bank.examples, &state.nearest
    best = second = NULL
    for t in range(bank.head.examples):
        if examples[t].near < NEVER and (best == NULL or examples[t].near < best.near):
            best = &examples[t]
    if best == NULL:
        return
    for t in range(bank.head.examples):
        if examples[t].near < NEVER and examples[t].move != best.move:
            if second == NULL or examples[t].near < second.near:
                second = &examples[t]
    cost = log(max(best.near, <float>1e-6))
    most = bank.rules[best.move].most
    second_cost = INFINITY if second == NULL else second.near
    lead = LEAD_WORTH * min(log(second_cost) - cost, LEAD_COUNTED)
    if nearest.open == 1 and nearest.value <= cost - lead - most:
        return
    nearest.open = 1
    nearest.value = cost - lead - most
    nearest.most = most
    nearest.kept = _what_kept(nearest.value, lead, log(best.near_posture))
    nearest.move = best.move
    nearest.second = -1 if second == NULL else second.move
    nearest.cost = best.near
    nearest.second_cost = second_cost
    nearest.posture = best.near_posture
    nearest.start = state.track.times[best.near_first % RING]
    nearest.end = state.time


cdef inline int64_t _what_kept(double value, double lead, double posture) noexcept nogil:
    """Return the reason why a move was not recognised: the smallest change that would have sufficed."""
    if value < 0.0:
        return BY_AGREEMENT
    if value - posture < 0.0:
        return BY_POSTURE
    if value + lead - LEAD_WORTH * LEAD_COUNTED < 0.0:
        return BY_LEAD
    return BY_COST


cdef inline void _explain_found(RecognitionState* state, MoveBank* bank) noexcept nogil:
    """Explain a move that has just been recognised by its cost and lead."""
    cdef FoundMove* found
    cdef Nearest* nearest
    found, nearest = &state.found, &state.nearest
    if nearest.open == 0 or nearest.move != found.move:  # a longer stretch has shown that it was another one
        nearest.move, nearest.second = found.move, -1
        nearest.most = bank.rules[found.move].most
        nearest.cost, nearest.second_cost, nearest.posture = found.cost, INFINITY, 1.0
    nearest.start, nearest.end = found.start, found.end
    nearest.kept = BY_NOTHING
    _explain(state)


cdef inline void _end_movement(RecognitionState* state, double time) noexcept nogil:
    """Explain the nearest move in a movement that is over."""
    if state.nearest.open == 0:
        return
    if time - state.decision.loud > QUIET + EARLY or time - state.nearest.end > LONGEST + EARLY:
        _explain(state)


cdef inline void _explain(RecognitionState* state) noexcept nogil:
    state.nearest.open = 0
    state.happened |= EXPLAINED


cdef int64_t _leading_limb(MoveBank* bank) noexcept nogil:
    """Return the limb whose joints fill the largest boxes in the first half of the stretch, -1 for none."""
    cdef float* extent
    cdef const float* box
    cdef int64_t best, k, limb
    first_half(&bank.scratch)
    extent = bank.scratch.row.at
    for k in range(DIRECTIONS + 1):
        extent[k] = 0.0
    best = -1
    for k in range(bank.head.joints):
        box, limb = bank.scratch.box.at + 3 * k, bank.limbs[k]
        if limb >= 0:
            extent[limb] += box[0] * box[0] + box[1] * box[1] + box[2] * box[2]
            if best < 0 or extent[limb] > extent[best]:
                best = limb
    return best
