"""The recogniser: frames in, recognised moves out, a bounded amount of work at each.

Once speed has come down from a peak, stretches that end now and begin at one of the last onsets or minima of speed are
compared with all examples, every `COMPARED_EVERY` seconds. A move is recognised when its cost is low enough; a clear
lead over every other move raises the limit. `AGREED` comparisons in a row must give the same move. No later move begins
before its end, but until the movement rests a longer stretch may show that it was another one.

The numbers were chosen on continuous sessions of ten players (14 moves on command, one and two examples of each), each
player left out in turn; they lie in the middle of wide plateaus.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import entry_point, inline_kernel, kernel
from mossar_stream.jit.simd import padded
from mossar_stream.jit.views import part
from mossar_stream.moves.activity import ACTIVITY, STARTS, follow_activity, start_activity
from mossar_stream.moves.explaining import BY_AGREEMENT, BY_COST, BY_LEAD, BY_NOTHING, BY_PAUSE, BY_POSTURE
from mossar_stream.moves.measure import (
    DIRECTIONS,
    LEAST_COST,
    NEVER,
    POINTS,
    Description,
    correction,
    describe,
    first_half,
    strangeness,
    warped,
)
from mossar_stream.moves.points import EARLY, is_new
from mossar_stream.moves.track import JOINT, RAW, RING, TICK, TRACK, add_pose

COMPARED_EVERY = 0.1  # s
AGREED = 2  # comparisons in a row that must name the same move
MOST = -0.75  # natural logarithm of a move's largest cost, where no rule says otherwise
STRICT_WORTH = 2.0  # by how much that is lower for a strictness of 1 than for 0
LEAD_WORTH = 0.8  # by how much a lead of 1 raises that
LEAD_COUNTED = (
    0.7  # of a lead (natural logarithm of the next move's cost over this one's) at most so much counts
)
FALLEN = 0.7  # of the peak of speed; comparisons begin below it
LOUD = 0.15  # m/s, mean over the joints: slower is rest
QUIET = 0.67  # s after the last loud pose for which comparisons go on
SHORTEST, LONGEST = 8, 3.0  # poses, s, of a stretch
REVISED = 0.5  # natural logarithm of how much cheaper another move must be to replace the one recognised
SETTLED = 1.5  # s after which a recognised move is final at the latest

CONFIRMED, FINAL, WITHDRAWN, EXPLAINED = 1, 2, 4, 8  # what happened at a frame

RIVALS = np.float32(np.exp(LEAD_COUNTED))  # costs beyond so many times the best do not matter
HANDICAP = np.float32(np.exp(REVISED))

DECISION = np.dtype(
    [
        (
            "next_comparison",
            "f8",
        ),  # s, when stretches are compared next; nothing happens before, if no move is open
        ("loud", "f8"),  # s, when speed was last above `LOUD`
        ("peak", "f8"),  # m/s, largest speed since the last onset or decision
        (
            "from_pose",
            "i8",
        ),  # a new move begins at this pose or later: what was before belongs to the last one
        ("leader", "i8"),  # move that was best at the last comparison, -1 for none
        ("agreed", "i8"),  # how many comparisons in a row it was
    ],
)
FOUND = np.dtype(
    [
        ("move", "i8"),  # -1 for none
        ("number", "i8"),  # counts the performer's moves
        ("take", "i8"),  # in which it was confirmed
        ("limb", "i8"),  # that led, -1 for none
        ("cost", "f8"),  # see measure.py
        ("first", "i8"),  # number of the pose where it begins
        ("start", "f8"),  # s
        ("end", "f8"),  # s
        ("time", "f8"),  # s, when it was recognised
    ],
)
NEAREST = np.dtype(
    [
        ("open", "i8"),  # whether a movement goes on of which something is known
        ("kept", "i8"),  # index into `explaining.REASONS`: what kept it from being recognised
        ("move", "i8"),  # that was nearest
        ("second", "i8"),  # the nearest other move, -1 for none
        (
            "value",
            "f8",
        ),  # what the logarithm of its cost, less its lead, was above the most; the least of the movement
        ("most", "f8"),  # logarithm of what it might have cost without a lead
        ("cost", "f8"),  # see measure.py
        ("second_cost", "f8"),
        ("posture", "f8"),  # factor of the cost that is due to another posture
        ("start", "f8"),  # s
        ("end", "f8"),  # s
    ],
)
RECOGNITION_STATE = np.dtype(
    [
        ("due", "f8"),  # s, from when on a frame becomes a pose; see readers.py
        ("track", TRACK),
        ("activity", ACTIVITY),
        ("decision", DECISION),
        ("found", FOUND),  # the last move recognised, not final yet
        ("before", FOUND),  # the one before, that the frame changed
        ("nearest", NEAREST),  # what comes nearest in the movement that goes on, or has just ended
        ("happened", "i8"),  # at the last frame that became a pose
        ("time", "f8"),  # s, of that frame
    ],
)
RECOGNITION_STATE_BYTES = RECOGNITION_STATE.itemsize
EXAMPLE = np.dtype(
    [
        ("move", "i8"),  # that it is an example of
        ("size", "f4"),  # m, diagonal of its box
        ("cost", "f4"),  # of the best stretch of this comparison; scratch
        ("near", "f4"),  # the same of all stretches, where movements are explained
        ("near_posture", "f4"),  # factor of `near` that is due to another posture
        ("near_first", "i8"),  # pose where that stretch begins
    ],
)
RULE = np.dtype(
    [
        ("most", "f8"),  # natural logarithm of the largest cost, see `MOST`
        ("again", "f8"),  # s after it was confirmed during which it is not confirmed again
    ],
)
ROWS = DIRECTIONS + 3  # of an example in `Bank.rows`: directions, box, shares, stance


class Bank(NamedTuple):
    """The examples of all moves, described for the joints of one stream, and scratch; views of a store."""

    joints: NDArray[np.void]  # (K,) JOINT
    girdles: NDArray[np.int64]  # (4,) of these joints
    examples: NDArray[np.void]  # (T,) EXAMPLE
    rules: NDArray[np.void]  # (M,) RULE
    bar: np.float32  # no stretch that costs more can be recognised as any move
    rows: NDArray[np.float32]  # (T·ROWS, D)
    begin: NDArray[
        np.float32
    ]  # (D,) m, first pose of the first example: where a joint is that was never seen
    explains: int  # whether movements are explained
    scratch: Description


# A store is one array of bytes, because every array that is handed to a kernel takes its time: this record, then the
# arrays of `Bank` and of `Description` in their order.
STORE = np.dtype(
    [
        ("joints", "i8"),  # K
        ("examples", "i8"),  # T
        ("numbers", "i8"),  # D
        ("moves", "i8"),  # M
        ("bar", "f8"),  # see `Bank`
        (
            "girdles",
            "i8",
            (4,),
        ),  # of the joints, see `facing.GIRDLES`; -1: moves are recognised as they were shown
        (
            "explains",
            "i8",
        ),  # whether what came nearest in a movement is reported, too; it is in `nearest`
    ],
)
STORE_BYTES, JOINT_BYTES, EXAMPLE_BYTES, RULE_BYTES = (
    kind.itemsize for kind in (STORE, JOINT, EXAMPLE, RULE)
)
SCRATCH_ROWS = (
    POINTS + DIRECTIONS + 4
)  # of numbers: points, directions, shares, stance, box, low; then size and warping


def store_bytes(joints: int, examples: int, moves: int) -> int:
    """Return the bytes that examples of so many moves take, described for so many joints."""
    rows = examples * ROWS + 1 + SCRATCH_ROWS
    floats = rows * padded(3 * joints) + 2 * (DIRECTIONS + 1) + 1
    return STORE_BYTES + joints * JOINT_BYTES + examples * EXAMPLE_BYTES + moves * RULE_BYTES + 4 * floats


def memory_bytes(joints: int, moves: int) -> int:
    """Return the bytes that recognising takes for one performer, by the joints and the moves of the examples."""
    return RECOGNITION_STATE_BYTES + 4 * (RING + RAW) * padded(3 * joints) + 8 * moves


def new_memory(joints: int, moves: int) -> NDArray[np.uint8]:
    """Return the memory of a performer who has not been seen."""
    memory = np.zeros(memory_bytes(joints, moves), np.uint8)
    state = state_of(memory)
    state["due"] = -np.inf
    for which in ("found", "before"):
        state[which]["move"] = -1
    state["nearest"]["move"] = state["nearest"]["second"] = -1
    last_times(memory, moves)[:] = -np.inf
    return memory


def last_times(memory: NDArray[np.uint8], moves: int) -> NDArray[np.float64]:
    """Return a view of when each move was confirmed last, (M,) s, in a performer's memory; -inf for never."""
    return memory[len(memory) - 8 * moves :].view(np.float64)


def state_of(memory: NDArray[np.uint8]) -> np.void:
    """Return a view of the state in a performer's memory."""
    found: np.void = memory[:RECOGNITION_STATE_BYTES].view(RECOGNITION_STATE)[0]
    return found


@inline_kernel(returns_views=True)
def open_store(store):
    """Return the bank that a store holds."""
    head = part(store, 0, STORE, (1,))[0]
    joints, examples, numbers = head.joints, head.examples, head.numbers
    at_examples = STORE_BYTES + joints * JOINT_BYTES
    at_rules = at_examples + examples * EXAMPLE_BYTES
    at_rows = at_rules + head.moves * RULE_BYTES
    line = 4 * numbers
    at_begin = at_rows + examples * ROWS * line
    at_scratch = at_begin + line
    after = at_scratch + SCRATCH_ROWS * line
    return Bank(
        part(store, STORE_BYTES, JOINT, (joints,)),
        head.girdles,
        part(store, at_examples, EXAMPLE, (examples,)),
        part(store, at_rules, RULE, (head.moves,)),
        np.float32(head.bar),
        part(store, at_rows, np.float32, (examples * ROWS, numbers)),
        part(store, at_begin, np.float32, (numbers,)),
        head.explains,
        Description(
            part(store, at_scratch, np.float32, (POINTS, numbers)),
            part(store, at_scratch + POINTS * line, np.float32, (DIRECTIONS, numbers)),
            part(store, after - 4 * line, np.float32, (numbers,)),
            part(store, after - 3 * line, np.float32, (numbers,)),
            part(store, after - 2 * line, np.float32, (numbers,)),
            part(store, after, np.float32, (1,)),
            part(store, after - line, np.float32, (numbers,)),
            part(store, after + 4, np.float32, (2, DIRECTIONS + 1)),
        ),
    )


@entry_point
def recognise(
    memory: NDArray[np.uint8], store: NDArray[np.uint8], positions: NDArray[np.float32], time: float
) -> int:
    """Process a frame; a function as readers have it.

    Args:
        memory: (memory_bytes,) uint8 of the performer.
        store: (store_bytes,) uint8, the examples.
        positions: (J, 3) float32 metres; NaN where a joint is missing.
        time: s.

    Returns:
        1 if a move changed, see `happened` of its record; else 0.
    """
    bank = open_store(store)
    state = part(memory, 0, RECOGNITION_STATE, (1,))[0]
    if not is_new(state.track.poses, time, state.track.time, TICK - EARLY):
        return 0
    numbers = bank.scratch.box.size
    poses = part(memory, RECOGNITION_STATE_BYTES, np.float32, (RING + RAW, numbers))
    last_times = part(
        memory, RECOGNITION_STATE_BYTES + 4 * (RING + RAW) * numbers, np.float64, (bank.rules.size,)
    )
    _follow(state, poses, last_times, bank, positions, time)
    state.due = state.track.time + TICK - EARLY if state.track.poses > 0 else -np.inf
    return 1 if state.happened != 0 else 0


@kernel
def _follow(state, poses, last_times, bank, positions, time):
    """Take one frame in."""
    state.happened = 0
    state.time = time
    goes_on = add_pose(state.track, poses, positions, bank, time)
    if state.track.poses == 0:
        return
    if not goes_on:
        _settle(state, FINAL)
        if state.nearest.open == 1:
            _explain(state)
        _start(state, time)
        return
    pose = state.track.poses - 1
    was_moving = state.activity.moving
    follow_activity(state.activity, state.track.speed, state.track.times, state.track.first, pose)
    if _is_comparison_due(state.decision, state.activity, was_moving, time):
        _compare_stretches(state, poses, last_times, bank, pose)
    elif bank.explains != 0:
        _end_movement(state, time)
    rests = state.activity.moving == 0 or time - state.found.time > SETTLED + EARLY
    if rests and state.found.move >= 0 and (state.happened & ~EXPLAINED) == 0:
        _settle(state, FINAL)


@inline_kernel
def _is_comparison_due(decision, activity, was_moving, time):
    speed = activity.speed
    decision.peak = speed if activity.moving > was_moving else max(decision.peak, speed)
    if speed > LOUD:
        decision.loud = time
    if time < decision.next_comparison:
        return False
    decision.next_comparison = time + COMPARED_EVERY - 0.001  # times of frames are not exact
    return time - decision.loud <= QUIET + EARLY and speed <= FALLEN * decision.peak


@kernel
def _start(state, time):
    start_activity(state.activity)
    decision = state.decision
    decision.next_comparison = time
    decision.loud = -np.inf
    decision.peak = 0.0
    decision.from_pose = state.track.first
    decision.leader = -1
    decision.agreed = 0


@kernel
def _settle(state, how):
    """Say what became of the last move recognised."""
    if state.found.move >= 0:
        _copy(state.before, state.found)
        state.found.move = -1
        state.happened |= how


@inline_kernel
def _copy(to, found):
    to.move = found.move
    to.number = found.number
    to.take = found.take
    to.limb = found.limb
    to.cost = found.cost
    to.first = found.first
    to.start = found.start
    to.end = found.end
    to.time = found.time


@kernel
def _compare_stretches(state, poses, last_times, bank, last):
    """Compare the stretches that end at pose `last` with the examples, and decide."""
    examples = bank.examples
    for t in range(examples.size):
        examples[t].cost = examples[t].near = NEVER
    best, best_first = NEVER, -1
    for i in range(STARTS):
        first = max(state.activity.starts[i] - 1, state.track.first)
        if state.activity.starts[i] < 0 or not _may_begin(state, first, last):
            continue
        describe(poses, state.track.path, first, last, bank)
        cost = _compare(state, bank, first, best)
        if cost < best:
            best, best_first = cost, first
        if bank.explains != 0 and first >= state.decision.from_pose:
            compare_without_limits(bank, first)
    if bank.explains != 0:
        _note_nearest(state, bank)
    if best_first < 0 or not _is_agreed(state.decision, bank, best):
        return
    move = state.decision.leader
    if 0.0 <= state.time - last_times[move] < bank.rules[move].again - EARLY:
        _pass_over(state, last)
        return
    last_times[move] = state.time
    _confirm(state, poses, bank, best_first, last)
    if bank.explains != 0:
        _explain_found(state, bank)


@inline_kernel
def _may_begin(state, first, last):
    track = state.track
    if last - first < SHORTEST or last - first >= RING - 1:
        return False
    if track.times[last % RING] - track.times[first % RING] > LONGEST + EARLY:
        return False
    return first >= state.decision.from_pose or (state.found.move >= 0 and first >= state.found.first)


@kernel
def _compare(state, bank, first, best):
    """Note each example's cost where this stretch is the cheapest so far; return the least that is below `best`."""
    scratch, examples, rows = bank.scratch, bank.examples, bank.rows
    revision = first < state.decision.from_pose
    bar = min(bank.bar, np.float32(state.found.cost)) if revision else bank.bar
    for t in range(examples.size):
        if revision and examples[t].move == state.found.move:
            continue
        at = t * ROWS
        limit = min(examples[t].cost, min(best, bar) * RIVALS)
        factor = strangeness(scratch, rows[at + DIRECTIONS + 2])
        if revision:
            factor *= HANDICAP
        if LEAST_COST * factor >= limit:
            continue
        factor *= correction(scratch, rows[at + DIRECTIONS], rows[at + DIRECTIONS + 1], examples[t].size)
        if LEAST_COST * factor >= limit:
            continue
        cost = factor * warped(scratch, rows[at : at + DIRECTIONS], limit / factor)
        if cost < examples[t].cost:
            examples[t].cost = cost
            best = min(best, cost)
    return best


@inline_kernel
def _is_agreed(decision, bank, best):
    """Tell whether the move with the least cost is recognised now."""
    examples = bank.examples
    move = -1
    for t in range(examples.size):
        if examples[t].cost == best:
            move = examples[t].move
            break
    second = NEVER
    for t in range(examples.size):
        if examples[t].move != move:
            second = min(second, examples[t].cost)
    lead = min(np.log(second / best), LEAD_COUNTED)
    if not np.log(best) - LEAD_WORTH * lead < bank.rules[move].most:
        decision.leader = -1
        decision.agreed = 0
        return False
    decision.agreed = decision.agreed + 1 if decision.leader == move else 1
    decision.leader = move
    return decision.agreed >= AGREED


@kernel
def _confirm(state, poses, bank, first, last):
    decision = state.decision
    move = decision.leader
    cost = NEVER
    for t in range(bank.examples.size):
        if bank.examples[t].move == move:
            cost = min(cost, bank.examples[t].cost)
    _settle(state, WITHDRAWN if first < decision.from_pose else FINAL)
    found = state.found
    found.move = move
    found.number += 1
    found.cost = cost
    found.first = first
    found.start = state.track.times[first % RING]
    found.end = found.time = state.time
    describe(poses, state.track.path, first, last, bank)
    found.limb = _leading_limb(bank)
    state.happened |= CONFIRMED
    decision.from_pose = last
    decision.peak = 0.0
    decision.leader = -1
    decision.agreed = 0


@inline_kernel
def _pass_over(state, last):
    """Let a move that was made again too soon be over without a word."""
    decision = state.decision
    decision.from_pose = last
    decision.peak = 0.0
    decision.leader = -1
    decision.agreed = 0
    if state.nearest.open == 1:
        state.nearest.kept = BY_PAUSE
        _explain(state)


@kernel
def compare_without_limits(bank, first):
    """Note what it costs to take a stretch, which is described, for each example, where no other stretch cost less."""
    scratch, examples, rows = bank.scratch, bank.examples, bank.rows
    for t in range(examples.size):
        at = t * ROWS
        posture = strangeness(scratch, rows[at + DIRECTIONS + 2])
        factor = posture * correction(
            scratch, rows[at + DIRECTIONS], rows[at + DIRECTIONS + 1], examples[t].size
        )
        cost = factor * warped(scratch, rows[at : at + DIRECTIONS], NEVER)
        if cost < examples[t].near:
            examples[t].near, examples[t].near_posture, examples[t].near_first = cost, posture, first


@kernel
def _note_nearest(state, bank):
    """Note which move came nearest at this comparison, if none was nearer in this movement."""
    examples, nearest = bank.examples, state.nearest
    best = -1
    for t in range(examples.size):
        if examples[t].near < NEVER and (best < 0 or examples[t].near < examples[best].near):
            best = t
    if best < 0:
        return
    second = -1
    for t in range(examples.size):
        other = examples[t].near < NEVER and examples[t].move != examples[best].move
        if other and (second < 0 or examples[t].near < examples[second].near):
            second = t
    cost = np.log(np.float64(max(examples[best].near, np.float32(1e-6))))
    most = bank.rules[examples[best].move].most
    second_cost = np.float64(examples[second].near) if second >= 0 else np.inf
    lead = LEAD_WORTH * min(np.log(second_cost) - cost, LEAD_COUNTED)
    if nearest.open == 1 and nearest.value <= cost - lead - most:
        return
    nearest.open = 1
    nearest.value = cost - lead - most
    nearest.most = most
    nearest.kept = _what_kept(nearest.value, lead, np.log(np.float64(examples[best].near_posture)))
    nearest.move = examples[best].move
    nearest.second = examples[second].move if second >= 0 else -1
    nearest.cost = examples[best].near
    nearest.second_cost = second_cost
    nearest.posture = examples[best].near_posture
    nearest.start = state.track.times[examples[best].near_first % RING]
    nearest.end = state.time


@inline_kernel
def _what_kept(value, lead, posture):
    """Return what kept a move from being recognised: the least that would have had to be otherwise."""
    if value < 0.0:
        return BY_AGREEMENT
    if value - posture < 0.0:
        return BY_POSTURE
    if value + lead - LEAD_WORTH * LEAD_COUNTED < 0.0:
        return BY_LEAD
    return BY_COST


@inline_kernel
def _explain_found(state, bank):
    """Say of a move that has just been recognised how near it came."""
    nearest = state.nearest
    if (
        nearest.open == 0 or nearest.move != state.found.move
    ):  # a longer stretch has shown that it was another one
        nearest.open = 1
        nearest.move, nearest.second = state.found.move, -1
        nearest.most = bank.rules[state.found.move].most
        nearest.cost, nearest.second_cost, nearest.posture = state.found.cost, np.inf, 1.0
    nearest.start, nearest.end = state.found.start, state.found.end
    nearest.kept = BY_NOTHING
    _explain(state)


@inline_kernel
def _end_movement(state, time):
    """Say what came nearest in a movement that is over."""
    nearest = state.nearest
    if nearest.open == 0:
        return
    if time - state.decision.loud > QUIET + EARLY or time - nearest.end > LONGEST + EARLY:
        _explain(state)


@inline_kernel
def _explain(state):
    state.nearest.open = 0
    state.happened |= EXPLAINED


@kernel
def _leading_limb(bank):
    """Return the limb whose joints fill the largest boxes in the first half of the stretch, -1 if there is none."""
    first_half(bank.scratch)
    extent = bank.scratch.row[0]
    extent[:] = np.float32(0.0)
    box = bank.scratch.box
    best = -1
    for k in range(bank.joints.size):
        limb = bank.joints[k].limb
        if limb >= 0:
            extent[limb] += box[3 * k] ** 2 + box[3 * k + 1] ** 2 + box[3 * k + 2] ** 2
            if best < 0 or extent[limb] > extent[best]:
                best = limb
    return best
