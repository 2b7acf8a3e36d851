"""Tracking: what becomes of a followed move: begun, progress, done, left.

At each sample every example is aligned with the stream. Of all ways the one that costs least says how far along the
performer is. A way that has reached the end of its example is decided once no overlapping way ranks better. It is done
if it explains the movement well enough: what is left of its costs, once constant differences are taken away, is
compared with the costs of a performer who stands still. Once a performer has done a move, it may be done less well.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.following.layout import LAYERS, PERIOD, RECENT_SAMPLES, REPORT, TEMPO_SAMPLES
from mossar_stream.following.sampling import (
    EARLY,
    LEAST_SPACING,
    assume_missing,
    keep_sample,
    note_absences,
    place_pose,
    take_sample,
)
from mossar_stream.following.views import (
    mean_of_example,
    open_bank,
    open_cells,
    open_memory,
    rows_of_example,
    weights_of_bones,
)
from mossar_stream.following.warping import UNJUDGED, advance, compare, forget, measure, trace
from mossar_stream.jit.decorators import entry_point, inline_kernel, kernel
from mossar_stream.moves.points import follows, is_new

# Chosen on five people and ten exercises, people left out in turn; all lie on wide plateaus (docs/lab-notes/following.md).
MOST_LEFT = 0.9  # residual above which nothing was done
MORE_LEFT = 1.4  # times that, for a performer who has done it before in the take
LEAST_GAIN = 0.25  # gain below which nothing was done
GAIN_WORTH = 0.6  # by how much a gain of 1 lowers the rank of an end
CLEARLY = 0.3  # by how much another move must rank better to be the one that was made
RIVAL = 0.3  # share of its example that a way has made which may yet rank better
WAITED = 7  # samples after which an end is decided at the latest
REMAINS = 0.05  # by how much what lies before a way raises its rank
BEGUN = 0.1  # progress at which a performance may be reported
WENT = 0.25  # share of the example's farthest pose that a performer has gone by then
DEAREST = 4.0  # cost above which nothing is being made
DEAREST_END = 8.0  # cost above which nothing was done, relative to the gain
MOST_SAMPLES = 1 << 30
GIVEN_UP_AFTER = 0.5  # s of that after which a performance is given up

NOTHING, BEGAN, GOES_ON, IS_DONE, GAVE_UP = 0, 1, 2, 3, 4
REPORT_SIZE = len(REPORT)


@entry_point(makes_arrays=False)
def follow_frame(
    memory: NDArray[np.uint8], store: NDArray[np.uint8], positions: NDArray[np.float32], time: float
) -> int:
    """Process a frame; a function as readers have it.

    Args:
        memory: Of the performer; see `layout.py`.
        store: The bank.
        positions: (J, 3) float32 metres; NaN where a joint is missing.
        time: s.

    Returns:
        1 if a followed move changed, see `happened` of the moves; else 0.
    """
    bank = open_bank(store)
    known = open_memory(memory, bank.head[0])
    if not is_new(known.state[0].frames, time, known.state[0].time, LEAST_SPACING):
        return 0
    _take(memory, known, bank, positions, time)
    return 1 if known.state[0].happened else 0


@entry_point(makes_arrays=False)
def finish_take(memory: NDArray[np.uint8], store: NDArray[np.uint8]) -> None:
    """Decide everything at the end of a take; see `happened` of the moves."""
    bank = open_bank(store)
    known = open_memory(memory, bank.head[0])
    known.state[0].happened = 0
    for m in range(known.moves.size):
        known.happened[m] = NOTHING
        if known.moves[m].best < np.inf and _is_done(memory, known, bank, m):
            _finish(memory, known, bank, m)
        elif known.moves[m].active:
            _give_up(memory, known, bank, m)


@entry_point(makes_arrays=False)
def evaluate(memory: NDArray[np.uint8], store: NDArray[np.uint8], m: int) -> None:
    """Write what is to be reported of a move that is being made."""
    bank = open_bank(store)
    known = open_memory(memory, bank.head[0])
    measure_way(memory, known, bank, m)
    write_report(known, bank, m, GOES_ON)


@kernel
def _take(memory, known, bank, positions, time):
    """Process one frame."""
    state, moves = known.state[0], known.moves
    state.happened = 0
    for m in range(moves.size):
        known.happened[m] = NOTHING
    fresh = not follows(state.frames, time, state.time)
    if fresh and state.frames > 0:
        _restart(memory, known, bank)
    poses = known.poses
    _copy_pose(poses, 0, 1)
    whole = place_pose(poses[1], bank, positions)
    if fresh:
        if not whole and not assume_missing(poses[1], known.absences, bank, positions):
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
        state.next = max(state.next + PERIOD, np.nextafter(state.next, np.inf))
        fresh = False
    state.time = time
    state.frames += 1


@inline_kernel
def _copy_pose(poses, to, of):
    for k in range(poses.shape[1]):
        for d in range(3):
            poses[to, k, d] = poses[of, k, d]


@kernel
def _restart(memory, known, bank):
    """Give up what is being made, after a gap."""
    state, moves, examples = known.state[0], known.moves, bank.examples
    state.frames = 0
    state.samples = 0
    for m in range(moves.size):
        if moves[m].active:
            _give_up(memory, known, bank, m)
        moves[m].best = moves[m].done = np.inf
    for t in range(examples.size):
        forget(open_cells(memory, examples[t]), MOST_SAMPLES)


@kernel
def _tell(known, bank, m, what):
    move = known.moves[m]
    known.happened[m] = what
    known.state[0].happened = 1
    move.reported = known.state[0].sampled
    if not move.active and what != GAVE_UP:
        known.state[0].number += 1
        move.number = known.state[0].number
        move.rev = 0
    if what == BEGAN:
        move.active = 1
        move.recents = 0
    elif what != GOES_ON:
        move.active = 0
    move.rev += 1
    write_report(known, bank, m, what)


@kernel
def write_report(known, bank, m, what):
    """Write what is reported of a move, rounded."""
    move, strays, report = known.moves[m], known.strays[m], known.reports[m]
    weights, bones = weights_of_bones(bank), bank.bones
    limbs = report.size - REPORT_SIZE
    for limb in range(limbs):
        report[REPORT_SIZE + limb] = 0.0
    farthest, joint, deviation, unjudged = -1.0, -1, 0.0, 0.0
    for b in range(strays.size):
        if strays[b] == UNJUDGED:
            unjudged += weights[move.example, b]
            continue
        chord = np.sqrt(min(max(np.float64(strays[b]), 0.0), 4.0))
        angle = np.degrees(2.0 * np.arcsin(0.5 * chord))
        deviation += angle * weights[move.example, b]
        if angle > farthest:
            farthest, joint = angle, b
        if bones[b].limb >= 0:
            report[REPORT_SIZE + bones[b].limb] += angle
    for limb in range(limbs):
        count = judged = 0
        for b in range(bones.size):
            count += bones[b].limb == limb
            judged += bones[b].limb == limb and strays[b] != UNJUDGED
        if 2 * judged < count:
            report[REPORT_SIZE + limb] = np.nan
        else:
            report[REPORT_SIZE + limb] = _rounded(report[REPORT_SIZE + limb] / judged, 100.0)
    if joint >= 0:
        deviation /= 1.0 - unjudged
    report[0], report[1], report[2] = move.number, move.rev, move.count
    report[3], report[4] = _rounded(move.start, 1e6), _rounded(move.time, 1e6)
    report[5], report[6] = _rounded(move.progress, 1e4), _rounded(_tempo(move, bank, what), 1e3)
    report[7], report[8], report[9] = _rounded(deviation, 100.0), joint, move.example
    report[10], report[11], report[12], report[13] = move.cost, move.gain, move.went, move.residual


@inline_kernel
def _rounded(number, parts):
    return np.floor(number * parts + 0.5) / parts


@inline_kernel
def _tempo(move, bank, what):
    """Return the tempo relative to the example over the last second, of what is done that of the whole."""
    example = bank.examples[move.example]
    seconds = (example.phases - 1) * example.stride * PERIOD
    if what == IS_DONE:
        return seconds / max(move.time - move.start, PERIOD)
    if move.recents < 2:
        return 1.0
    back = min(move.recents - 1, TEMPO_SAMPLES)
    way = (
        move.recent[(move.recents - 1) % RECENT_SAMPLES]
        - move.recent[(move.recents - 1 - back) % RECENT_SAMPLES]
    )
    return max(0.0, np.float64(way)) * seconds / (back * PERIOD)


@kernel
def _follow_all(memory, known, bank):
    """Align the sample that was taken with all examples, and see what that says of each move."""
    state, examples, rings = known.state[0], bank.examples, known.rings
    at = 0
    for m in range(known.moves.size):
        first = at
        while at < examples.size and examples[at].move == m:
            example = examples[at]
            if state.samples % example.stride == 0:
                number = state.samples // example.stride
                line = number % rings.shape[1]
                keep_sample(rings[example.ring, line], known.hidden[example.ring, line], known, bank)
                cells = open_cells(memory, example)
                compare(known, rows_of_example(bank, example), mean_of_example(bank, example), example)
                advance(cells, known, number, number % cells.steps.shape[0])
                _note_end(cells, known, m, at, example)
            at += 1
        _lead(memory, known, bank, m, first, at)


@kernel
def _note_end(cells, known, m, t, example):
    """Take note of a way that has reached the end of its example, if it ranks best."""
    move = known.moves[m]
    end = cells.costs.shape[1] - 1
    for layer in range(LAYERS):
        gain = np.float64(cells.gains[layer, end]) / (end + 1)
        rank = np.float64(cells.costs[layer, end]) / cells.weights[layer, end] - GAIN_WORTH * gain
        if rank < move.best and gain > LEAST_GAIN and rank + GAIN_WORTH * gain < DEAREST_END * gain:
            move.best = rank
            move.best_gain = gain
            move.best_first = cells.firsts[layer, end] * example.stride
            move.best_last = known.state[0].samples
            move.best_layer = layer
            move.best_example = t


@kernel
def _lead(memory, known, bank, m, first, last):
    """See which way leads, and what that says of move m, whose examples are `first` to `last`."""
    move, samples = known.moves[m], known.state[0].samples
    least, leader, layer, phase = np.inf, -1, 0, 0
    waits = False
    for t in range(first, last):
        example = bank.examples[t]
        cells = open_cells(memory, example)
        count = cells.costs.shape[1]
        for other in range(LAYERS):
            for j in range(count):
                cost = np.float64(cells.costs[other, j])
                if not cost < np.inf:
                    continue
                cost /= cells.weights[other, j]
                rank = cost + REMAINS * (1.0 - (j + 1.0) / count)
                if rank < least:
                    least, leader, layer, phase = rank, t, other, j
                if j >= RIVAL * count and cells.firsts[other, j] * example.stride <= move.best_last:
                    waits |= cost - GAIN_WORTH * cells.gains[other, j] / count < move.best
    is_over = move.best < np.inf and move.best_last < samples
    stride = bank.examples[move.best_example].stride
    if is_over and (not waits or samples - move.best_last > WAITED * stride) and known.happened[m] == NOTHING:
        if _is_done(memory, known, bank, m):
            _finish(memory, known, bank, m)
            return
        move.best = np.inf
    if leader >= 0:
        _go_on(memory, known, bank, m, (leader, layer, phase))


@kernel
def _is_done(memory, known, bank, m):
    """Tell whether the best end explains the movement well enough, and note how far each bone strays in it."""
    move = known.moves[m]
    stride = bank.examples[move.best_example].stride
    move.example, move.layer = move.best_example, move.best_layer
    move.phase = bank.examples[move.best_example].phases - 1
    move.first, move.last = move.best_first // stride, move.best_last // stride
    measure_way(memory, known, bank, m)
    if _is_another(known, m) or _largest(known.strays[m]) == UNJUDGED:
        return False
    return move.residual < (MOST_LEFT * MORE_LEFT if move.count else MOST_LEFT)


@inline_kernel
def _largest(strays):
    largest = UNJUDGED
    for b in range(strays.size):
        largest = max(largest, strays[b])
    return largest


@kernel
def _is_another(known, m):
    """Tell whether the best end is that of another followed move, which explains the same movement better."""
    moves = known.moves
    move = moves[m]
    half = (move.best_last - move.best_first) // 2
    for o in range(moves.size):
        if o == m:
            continue
        other = moves[o]
        both = min(move.best_last, other.best_last) - max(move.best_first, other.best_first)
        if other.best + CLEARLY < move.best and both > half:
            return True
        both = min(move.best_last, other.done_last) - max(move.best_first, other.done_first)
        if other.done + CLEARLY < move.best and both > half:
            return True
    return False


@kernel
def measure_way(memory, known, bank, m):
    """Note how far each bone strays along the way that a move is followed by, and what is left of its costs."""
    move = known.moves[m]
    example = bank.examples[move.example]
    cells = open_cells(memory, example)
    count = trace(cells, known.way, move.layer, move.phase, move.last, move.first)
    ring, hidden = known.rings[example.ring], known.hidden[example.ring]
    left = measure(known, rows_of_example(bank, example), (ring, hidden), count, known.strays[m])
    move.residual = left / example.dear


@kernel
def _go_on(memory, known, bank, m, lead):
    """Report a performance that begins, goes on, or is given up."""
    move, state = known.moves[m], known.state[0]
    leader, layer, phase = lead
    example = bank.examples[leader]
    cells = open_cells(memory, example)
    cost = cells.costs[layer, phase] / cells.weights[layer, phase]
    progress = phase / (cells.costs.shape[1] - 1.0)
    first = cells.firsts[layer, phase]
    went = _went(known, bank, example, first)
    if move.active and first == move.first and leader == move.example:
        went = max(went, move.went)
    if not (cost < DEAREST and progress >= BEGUN and went >= WENT):
        if move.active and state.sampled - move.seen > GIVEN_UP_AFTER and known.happened[m] == NOTHING:
            _give_up(memory, known, bank, m)
        return
    move.example, move.layer, move.phase = leader, layer, phase
    move.first, move.last = first, state.samples // example.stride
    move.start = state.sampled - (state.samples - first * example.stride) * PERIOD
    move.time, move.progress, move.cost, move.went = state.sampled, progress, cost, went
    move.gain = cells.gains[layer, phase] / cells.costs.shape[1]
    move.recent[move.recents % RECENT_SAMPLES] = progress
    move.recents += 1
    move.seen = state.sampled
    if known.happened[m] != NOTHING:
        return
    if not move.active:
        measure_way(memory, known, bank, m)
        _tell(known, bank, m, BEGAN)
    elif state.sampled - move.reported >= state.every - EARLY:
        measure_way(memory, known, bank, m)
        _tell(known, bank, m, GOES_ON)


@kernel
def _went(known, bank, example, first):
    """Return how far the performer is from the first pose of a way, relative to the example's farthest pose."""
    rings, directions = known.rings, known.directions
    begin = rings[example.ring, first % rings.shape[1]]
    total = np.float32(0.0)
    for b in range(directions.shape[0]):
        x, y, z = (
            directions[b, 0] - begin[b, 0],
            directions[b, 1] - begin[b, 1],
            directions[b, 2] - begin[b, 2],
        )
        total += x * x + y * y + z * z
    return total / (directions.shape[0] * example.farthest)


@kernel
def _give_up(memory, known, bank, m):
    """Report a performance that is given up, with the numbers of when it was last followed well."""
    measure_way(memory, known, bank, m)
    _tell(known, bank, m, GAVE_UP)


@kernel
def _finish(memory, known, bank, m):
    """Report a performance that is done; the next one begins after its end."""
    move, state = known.moves[m], known.state[0]
    example = bank.examples[move.example]
    move.progress, move.gain = 1.0, move.best_gain
    move.start = state.sampled - (state.samples - move.best_first) * PERIOD
    move.time = state.sampled - (state.samples - move.best_last) * PERIOD
    move.done, move.done_first, move.done_last = move.best, move.best_first, move.best_last
    move.best = np.inf
    move.count += 1
    _box(known.boxes[m], known.rings[example.ring], move.first, move.last)
    _tell(known, bank, m, IS_DONE)
    for t in range(bank.examples.size):
        other = bank.examples[t]
        if other.move == m:
            forget(open_cells(memory, other), (move.best_last + other.stride - 1) // other.stride)


@kernel
def _box(box, ring, first, last):
    """Note the least and the largest direction of each bone during a performance."""
    size = ring.shape[0]
    for b in range(ring.shape[1]):
        for d in range(3):
            box[0, b, d] = box[1, b, d] = ring[last % size, b, d]
    for n in range(max(first, last - size + 1), last):
        for b in range(ring.shape[1]):
            for d in range(3):
                box[0, b, d] = min(box[0, b, d], ring[n % size, b, d])
                box[1, b, d] = max(box[1, b, d], ring[n % size, b, d])
