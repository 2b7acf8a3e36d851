"""The recogniser: frames in, recognised moves out, a bounded amount of work at each.

Once speed has come down from a peak, stretches that end now and begin at one of the last onsets or minima of speed are
compared with all examples, every `COMPARED_EVERY` seconds. A move is recognised when its cost is low enough; a clear
lead over every other move raises the limit. `AGREED` comparisons in a row must give the same move. No later move begins
before its end, but until the movement rests a longer stretch may show that it was another one.

The numbers were chosen on continuous sessions of ten players (14 moves on command, one and two examples of each), each
player left out in turn; they lie in the middle of wide plateaus.
"""

cdef double COMPARED_EVERY = 0.1  # s
cdef enum:
    AGREED = 2  # comparisons in a row that must name the same move
cdef double MOST = -0.75  # natural logarithm of a move's largest cost, where no rule says otherwise
cdef double STRICT_WORTH = 2.0  # by how much that is lower for a strictness of 1 than for 0
cdef double LEAD_WORTH = 0.8  # by how much a lead of 1 raises that
cdef double LEAD_COUNTED = 0.7  # of a lead (natural logarithm of the next move's cost over this one's) at most so much counts
cdef double FALLEN = 0.7  # of the peak of speed; comparisons begin below it
cdef double LOUD = 0.15  # m/s, mean over the joints: slower is rest
cdef double QUIET = 0.67  # s after the last loud pose for which comparisons go on
cdef enum:
    SHORTEST = 8  # poses, s, of a stretch
cdef double LONGEST = 3.0
cdef double REVISED = 0.5  # natural logarithm of how much cheaper another move must be to replace the one recognised
cdef double SETTLED = 1.5  # s after which a recognised move is final at the latest
cdef enum:
    CONFIRMED = 1  # what happened at a frame
    FINAL = 2
    WITHDRAWN = 4
    EXPLAINED = 8
cdef float RIVALS = 2.0137526988983154  # costs beyond so many times the best do not matter
cdef float HANDICAP = 1.6487212181091309
cdef enum:
    RECOGNITION_STATE_BYTES = RECOGNITION_STATE.itemsize
    ROWS = DIRECTIONS + 3  # of an example in `Bank.rows`: directions, box, shares, stance
    STORE_BYTES = 80
    JOINT_BYTES = 24
    EXAMPLE_BYTES = 32
    RULE_BYTES = 16
    SCRATCH_ROWS = POINTS + DIRECTIONS + 4  # of numbers: points, directions, shares, stance, box, low; then size and warping

cdef struct Decision:
    double next_comparison  # s, when stretches are compared next; nothing happens before, if no move is open
    double loud  # s, when speed was last above `LOUD`
    double peak  # m/s, largest speed since the last onset or decision
    int64_t from_pose  # a new move begins at this pose or later: what was before belongs to the last one
    int64_t leader  # move that was best at the last comparison, -1 for none
    int64_t agreed  # how many comparisons in a row it was


cdef struct FoundMove:
    int64_t move  # -1 for none
    int64_t number  # counts the performer's moves
    int64_t take  # in which it was confirmed
    int64_t limb  # that led, -1 for none
    double cost  # see measure.py
    int64_t first  # number of the pose where it begins
    double start  # s
    double end  # s
    double time  # s, when it was recognised


cdef struct Nearest:
    int64_t open  # whether a movement goes on of which something is known
    int64_t kept  # index into `explaining.REASONS`: what kept it from being recognised
    int64_t move  # that was nearest
    int64_t second  # the nearest other move, -1 for none
    double value  # what the logarithm of its cost, less its lead, was above the most; the least of the movement
    double most  # logarithm of what it might have cost without a lead
    double cost  # see measure.py
    double second_cost
    double posture  # factor of the cost that is due to another posture
    double start  # s
    double end  # s


cdef struct RecognitionState:
    double due  # s, from when on a frame becomes a pose; see readers.py
    Track track
    MoveActivity activity
    Decision decision
    FoundMove found  # the last move recognised, not final yet
    FoundMove before  # the one before, that the frame changed
    Nearest nearest  # what comes nearest in the movement that goes on, or has just ended
    int64_t happened  # at the last frame that became a pose
    double time  # s, of that frame


cdef struct MoveExample:
    int64_t move  # that it is an example of
    float size  # m, diagonal of its box
    float cost  # of the best stretch of this comparison; scratch
    float near  # the same of all stretches, where movements are explained
    float near_posture  # factor of `near` that is due to another posture
    int64_t near_first  # pose where that stretch begins


cdef struct MoveRule:
    double most  # natural logarithm of the largest cost, see `MOST`
    double again  # s after it was confirmed during which it is not confirmed again


cdef struct MoveStore:
    int64_t joints  # K
    int64_t examples  # T
    int64_t numbers  # D
    int64_t moves  # M
    double bar  # see `Bank`
    int64_t girdles[4]  # of the joints, see `facing.GIRDLES`; -1: moves are recognised as they were shown
    int64_t explains  # whether what came nearest in a movement is reported, too; it is in `nearest`


cdef struct MoveBank:  # The examples of all moves, described for the joints of one stream, and scratch; views of a store.
    TrackJointSpan joints  # (K,) JOINT
    Ints girdles  # (4,) of these joints
    MoveExampleSpan examples  # (T,) EXAMPLE
    MoveRuleSpan rules  # (M,) RULE
    float bar  # no stretch that costs more can be recognised as any move
    FloatRows rows  # (T·ROWS, D)
    Floats begin  # (D,) m, first pose of the first example: where a joint is that was never seen
    int64_t explains  # whether movements are explained
    Description scratch


# NOT COMPILED IN ANY RUN: open_store
# def open_store(store):
#     """Return the bank that a store holds."""
#     head = part(store, 0, STORE, (1,))[0]
#     joints, examples, numbers = head.joints, head.examples, head.numbers
#     at_examples = STORE_BYTES + joints * JOINT_BYTES
#     at_rules = at_examples + examples * EXAMPLE_BYTES
#     at_rows = at_rules + head.moves * RULE_BYTES
#     line = 4 * numbers
#     at_begin = at_rows + examples * ROWS * line
#     at_scratch = at_begin + line
#     after = at_scratch + SCRATCH_ROWS * line
#     return Bank(
#         part(store, STORE_BYTES, JOINT, (joints,)),
#         head.girdles,
#         part(store, at_examples, EXAMPLE, (examples,)),
#         part(store, at_rules, RULE, (head.moves,)),
#         np.float32(head.bar),
#         part(store, at_rows, np.float32, (examples * ROWS, numbers)),
#         part(store, at_begin, np.float32, (numbers,)),
#         head.explains,
#         Description(
#             part(store, at_scratch, np.float32, (POINTS, numbers)),
#             part(store, at_scratch + POINTS * line, np.float32, (DIRECTIONS, numbers)),
#             part(store, after - 4 * line, np.float32, (numbers,)),
#             part(store, after - 3 * line, np.float32, (numbers,)),
#             part(store, after - 2 * line, np.float32, (numbers,)),
#             part(store, after, np.float32, (1,)),
#             part(store, after - line, np.float32, (numbers,)),
#             part(store, after + 4, np.float32, (2, DIRECTIONS + 1)),
#         ),
#     )


# ENTRY: called from Python
cdef int64_t recognise(Bytes memory, Bytes store, FloatRows positions, double time) noexcept nogil:
    """Process a frame; a function as readers have it.

    Args:
        memory: (memory_bytes,) uint8 of the performer.
        store: (store_bytes,) uint8, the examples.
        positions: (J, 3) float32 metres; NaN where a joint is missing.
        time: s.

    Returns:
        1 if a move changed, see `happened` of its record; else 0.
    """
    cdef MoveBank bank
    cdef RecognitionState* state
    cdef int64_t numbers
    cdef FloatRows poses
    cdef Doubles last_times
    # CHECK call of open_store: open_store(store)
    # CHECK call of part: part(memory, 0, RECOGNITION_STATE, (1,))
    # CHECK subscript part(memory, 0, RECOGNITION_STATE, (1,))[0]
    # CHECK call of part: part(memory, RECOGNITION_STATE_BYTES, np.float32, (RING + RAW, numbers))
    # CHECK call of part: part(memory, RECOGNITION_STATE_BYTES + 4 * (RING + RAW) * numbers, np.float64, (bank.rules.size,))
    bank = open_store(store)
    state = part(memory, 0, RECOGNITION_STATE, (1,))[0]
    if not is_new(state.track.poses, time, state.track.time, TICK - EARLY):
        return 0
    numbers = bank.scratch.box.count
    poses = part(memory, RECOGNITION_STATE_BYTES, np.float32, (RING + RAW, numbers))
    last_times = part(memory, RECOGNITION_STATE_BYTES + 4 * (RING + RAW) * numbers, np.float64, (bank.rules.count))
    _recogniser_follow(state, poses, last_times, &bank, positions, time)
    state.due = state.track.time + TICK - EARLY if state.track.poses > 0 else -INFINITY
    return 1 if state.happened != 0 else 0


cdef void _recogniser_follow(RecognitionState* state, FloatRows poses, Doubles last_times, MoveBank* bank, FloatRows positions, double time) noexcept nogil:
    """Take one frame in."""
    cdef bint goes_on, rests
    cdef int64_t pose, was_moving
    state.happened = 0
    state.time = time
    goes_on = track_add_pose(&state.track, poses, positions, bank, time)
    if state.track.poses == 0:
        return
    if not goes_on:
        _recogniser_settle(state, FINAL)
        if state.nearest.open == 1:
            _explain(state)
        _start(state, time)
        return
    pose = state.track.poses - 1
    was_moving = state.activity.moving
    activity_follow_activity(&state.activity, state.track.speed, state.track.times, state.track.first, pose)
    if _is_comparison_due(&state.decision, &state.activity, was_moving, time):
        _compare_stretches(state, poses, last_times, bank, pose)
    elif bank.explains != 0:
        _end_movement(state, time)
    rests = state.activity.moving == 0 or time - state.found.time > SETTLED + EARLY
    if rests and state.found.move >= 0 and state.happened & ~EXPLAINED == 0:
        _recogniser_settle(state, FINAL)


cdef inline bint _is_comparison_due(Decision* decision, MoveActivity* activity, int64_t was_moving, double time) noexcept nogil:
    cdef double speed
    speed = activity.speed
    decision.peak = speed if activity.moving > was_moving else max(decision.peak, speed)
    if speed > LOUD:
        decision.loud = time
    if time < decision.next_comparison:
        return False
    decision.next_comparison = time + COMPARED_EVERY - 0.001  # times of frames are not exact
    return time - decision.loud <= QUIET + EARLY and speed <= FALLEN * decision.peak


cdef void _start(RecognitionState* state, double time) noexcept nogil:
    cdef Decision* decision
    activity_start_activity(&state.activity)
    decision = &state.decision
    decision.next_comparison = time
    decision.loud = -INFINITY
    decision.peak = 0.0
    decision.from_pose = state.track.first
    decision.leader = -1
    decision.agreed = 0


cdef void _recogniser_settle(RecognitionState* state, int64_t how) noexcept nogil:
    """Say what became of the last move recognised."""
    if state.found.move >= 0:
        _recogniser_copy(&state.before, &state.found)
        state.found.move = -1
        state.happened |= how


cdef inline void _recogniser_copy(FoundMove* to, FoundMove* found) noexcept nogil:
    to.move = found.move
    to.number = found.number
    to.take = found.take
    to.limb = found.limb
    to.cost = found.cost
    to.first = found.first
    to.start = found.start
    to.end = found.end
    to.time = found.time


cdef void _compare_stretches(RecognitionState* state, FloatRows poses, Doubles last_times, MoveBank* bank, int64_t last) noexcept nogil:
    """Compare the stretches that end at pose `last` with the examples, and decide."""
    cdef MoveExampleSpan examples
    cdef int64_t t, i, move, best_first, first
    cdef float best, cost
    examples = bank.examples
    for t in range(examples.count):
        examples.at[t].cost = examples.at[t].near = NEVER
    best, best_first = NEVER, -1
    for i in range(STARTS):
        first = max(state.activity.starts[i] - 1, state.track.first)
        if state.activity.starts[i] < 0 or not _may_begin(state, first, last):
            continue
        measure_describe(poses, state.track.path, first, last, bank)
        cost = _recogniser_compare(state, bank, first, best)
        if cost < best:
            best, best_first = cost, first
        if bank.explains != 0 and first >= state.decision.from_pose:
            compare_without_limits(bank, first)
    if bank.explains != 0:
        _note_nearest(state, bank)
    if best_first < 0 or not _is_agreed(&state.decision, bank, best):
        return
    move = state.decision.leader
    if 0.0 <= state.time - last_times.at[move] < bank.rules.at[move].again - EARLY:
        _pass_over(state, last)
        return
    last_times.at[move] = state.time
    _confirm(state, poses, bank, best_first, last)
    if bank.explains != 0:
        _explain_found(state, bank)


cdef inline bint _may_begin(RecognitionState* state, int64_t first, int64_t last) noexcept nogil:
    cdef Track* track
    # CHECK sign (C truncates): last % RING; first % RING
    track = &state.track
    if last - first < SHORTEST or last - first >= RING - 1:
        return False
    if track.times[last % RING] - track.times[first % RING] > LONGEST + EARLY:
        return False
    return first >= state.decision.from_pose or state.found.move >= 0 and first >= state.found.first


cdef float _recogniser_compare(RecognitionState* state, MoveBank* bank, int64_t first, float best) noexcept nogil:
    """Note each example's cost where this stretch is the cheapest so far; return the least that is below `best`."""
    cdef bint revision
    cdef float bar, limit, factor, cost
    cdef int64_t t, at
    cdef Description* scratch
    cdef MoveExampleSpan examples
    cdef FloatRows rows
    scratch = &bank.scratch
    examples = bank.examples
    rows = bank.rows
    revision = first < state.decision.from_pose
    bar = min(bank.bar, <float>state.found.cost) if revision else bank.bar
    for t in range(examples.count):
        if revision and examples.at[t].move == state.found.move:
            continue
        at = t * ROWS
        limit = min(examples.at[t].cost, min(best, bar) * RIVALS)
        factor = strangeness(scratch, row_of_floats(rows, at + DIRECTIONS + 2))
        if revision:
            factor *= HANDICAP
        if LEAST_COST * factor >= limit:
            continue
        factor *= correction(scratch, row_of_floats(rows, at + DIRECTIONS), row_of_floats(rows, at + DIRECTIONS + 1), examples.at[t].size)
        if LEAST_COST * factor >= limit:
            continue
        cost = factor * warped(scratch, rows_of_floats(rows, at, at + DIRECTIONS), limit / factor)
        if cost < examples.at[t].cost:
            examples.at[t].cost = cost
            best = min(best, cost)
    return best


cdef inline bint _is_agreed(Decision* decision, MoveBank* bank, float best) noexcept nogil:
    """Tell whether the move with the least cost is recognised now."""
    cdef MoveExampleSpan examples
    cdef int64_t move, t
    cdef float second
    cdef double lead
    examples = bank.examples
    move = -1
    for t in range(examples.count):
        if examples.at[t].cost == best:
            move = examples.at[t].move
            break
    second = NEVER
    for t in range(examples.count):
        if examples.at[t].move != move:
            second = min(second, examples.at[t].cost)
    lead = min(logf(second / best), LEAD_COUNTED)
    if not logf(best) - LEAD_WORTH * lead < bank.rules.at[move].most:
        decision.leader = -1
        decision.agreed = 0
        return False
    decision.agreed = decision.agreed + 1 if decision.leader == move else 1
    decision.leader = move
    return decision.agreed >= AGREED


cdef void _confirm(RecognitionState* state, FloatRows poses, MoveBank* bank, int64_t first, int64_t last) noexcept nogil:
    cdef Decision* decision
    cdef int64_t move, t
    cdef float cost
    cdef FoundMove* found
    # CHECK sign (C truncates): first % RING
    decision = &state.decision
    move = decision.leader
    cost = NEVER
    for t in range(bank.examples.count):
        if bank.examples.at[t].move == move:
            cost = min(cost, bank.examples.at[t].cost)
    _recogniser_settle(state, WITHDRAWN if first < decision.from_pose else FINAL)
    found = &state.found
    found.move = move
    found.number += 1
    found.cost = cost
    found.first = first
    found.start = state.track.times[first % RING]
    found.end = found.time = state.time
    measure_describe(poses, state.track.path, first, last, bank)
    found.limb = _leading_limb(bank)
    state.happened |= CONFIRMED
    decision.from_pose = last
    decision.peak = 0.0
    decision.leader = -1
    decision.agreed = 0


cdef inline void _pass_over(RecognitionState* state, int64_t last) noexcept nogil:
    """Let a move that was made again too soon be over without a word."""
    cdef Decision* decision
    decision = &state.decision
    decision.from_pose = last
    decision.peak = 0.0
    decision.leader = -1
    decision.agreed = 0
    if state.nearest.open == 1:
        state.nearest.kept = BY_PAUSE
        _explain(state)


cdef void compare_without_limits(MoveBank* bank, int64_t first) noexcept nogil:
    """Note what it costs to take a stretch, which is described, for each example, where no other stretch cost less."""
    cdef int64_t t, at
    cdef Description* scratch
    cdef MoveExampleSpan examples
    cdef FloatRows rows
    cdef float posture, factor, cost
    scratch = &bank.scratch
    examples = bank.examples
    rows = bank.rows
    for t in range(examples.count):
        at = t * ROWS
        posture = strangeness(scratch, row_of_floats(rows, at + DIRECTIONS + 2))
        factor = posture * correction(scratch, row_of_floats(rows, at + DIRECTIONS), row_of_floats(rows, at + DIRECTIONS + 1), examples.at[t].size)
        cost = factor * warped(scratch, rows_of_floats(rows, at, at + DIRECTIONS), NEVER)
        if cost < examples.at[t].near:
            examples.at[t].near, examples.at[t].near_posture, examples.at[t].near_first = cost, posture, first


cdef void _note_nearest(RecognitionState* state, MoveBank* bank) noexcept nogil:
    """Note which move came nearest at this comparison, if none was nearer in this movement."""
    cdef int64_t best, t, second
    cdef double cost, most, second_cost, lead
    cdef MoveExampleSpan examples
    cdef Nearest* nearest
    cdef bint other
    # CHECK sign (C truncates): examples[best].near_first % RING
    examples = bank.examples
    nearest = &state.nearest
    best = -1
    for t in range(examples.count):
        if examples.at[t].near < NEVER and (best < 0 or examples.at[t].near < examples.at[best].near):
            best = t
    if best < 0:
        return
    second = -1
    for t in range(examples.count):
        other = examples.at[t].near < NEVER and examples.at[t].move != examples.at[best].move
        if other and (second < 0 or examples.at[t].near < examples.at[second].near):
            second = t
    cost = log(<double>max(examples.at[best].near, <float>1e-6))
    most = bank.rules.at[examples.at[best].move].most
    second_cost = <double>examples.at[second].near if second >= 0 else INFINITY
    lead = LEAD_WORTH * min(log(second_cost) - cost, LEAD_COUNTED)
    if nearest.open == 1 and nearest.value <= cost - lead - most:
        return
    nearest.open = 1
    nearest.value = cost - lead - most
    nearest.most = most
    nearest.kept = _what_kept(nearest.value, lead, log(<double>examples.at[best].near_posture))
    nearest.move = examples.at[best].move
    nearest.second = examples.at[second].move if second >= 0 else -1
    nearest.cost = examples.at[best].near
    nearest.second_cost = second_cost
    nearest.posture = examples.at[best].near_posture
    nearest.start = state.track.times[examples.at[best].near_first % RING]
    nearest.end = state.time


cdef inline int64_t _what_kept(double value, double lead, double posture) noexcept nogil:
    """Return what kept a move from being recognised: the least that would have had to be otherwise."""
    if value < 0.0:
        return BY_AGREEMENT
    if value - posture < 0.0:
        return BY_POSTURE
    if value + lead - LEAD_WORTH * LEAD_COUNTED < 0.0:
        return BY_LEAD
    return BY_COST


cdef inline void _explain_found(RecognitionState* state, MoveBank* bank) noexcept nogil:
    """Say of a move that has just been recognised how near it came."""
    cdef Nearest* nearest
    nearest = &state.nearest
    if nearest.open == 0 or nearest.move != state.found.move:
        nearest.open = 1
        nearest.move, nearest.second = state.found.move, -1
        nearest.most = bank.rules.at[state.found.move].most
        nearest.cost, nearest.second_cost, nearest.posture = state.found.cost, INFINITY, 1.0
    nearest.start, nearest.end = state.found.start, state.found.end
    nearest.kept = BY_NOTHING
    _explain(state)


cdef inline void _end_movement(RecognitionState* state, double time) noexcept nogil:
    """Say what came nearest in a movement that is over."""
    cdef Nearest* nearest
    nearest = &state.nearest
    if nearest.open == 0:
        return
    if time - state.decision.loud > QUIET + EARLY or time - nearest.end > LONGEST + EARLY:
        _explain(state)


cdef inline void _explain(RecognitionState* state) noexcept nogil:
    state.nearest.open = 0
    state.happened |= EXPLAINED


cdef int64_t _leading_limb(MoveBank* bank) noexcept nogil:
    """Return the limb whose joints fill the largest boxes in the first half of the stretch, -1 if there is none."""
    cdef Floats extent, box
    cdef int64_t best, k, limb
    first_half(&bank.scratch)
    extent = row_of_floats(bank.scratch.row, 0)
    from_floats(extent, 0) = <float>0.0
    box = bank.scratch.box
    best = -1
    for k in range(bank.joints.count):
        limb = bank.joints.at[k].limb
        if limb >= 0:
            extent.at[limb] += box.at[3 * k] * box.at[3 * k] + box.at[3 * k + 1] * box.at[3 * k + 1] + box.at[3 * k + 2] * box.at[3 * k + 2]
            if best < 0 or extent.at[limb] > extent.at[best]:
                best = limb
    return best
