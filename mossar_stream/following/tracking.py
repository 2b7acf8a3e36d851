"""Tracking: what becomes of a followed move: begun, progress, done, left.

At each sample every example is aligned with the stream. Of all ways the one that leads says how far along the performer
is. A way that has reached the end of its example is done once no other way that overlaps it can become cheaper.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.following.layout import LAYERS, PERIOD, RECENT, RING
from mossar_stream.following.sampling import EARLY, goes_on, is_in_order, localise, take_sample
from mossar_stream.following.views import open_bank, open_cells, open_memory
from mossar_stream.following.warping import advance, compare, forget
from mossar_stream.jit.decorators import entry_point, inline_kernel, kernel
from mossar_stream.jit.views import part

BEGUN = 0.2  # progress at which a performance is reported
LEFT = 0.5  # s without a way that is cheap enough
SETTLED = 0.5  # s after its end by which a performance is decided
REMAINS = 0.05  # what a way that has everything before it must be cheaper than one at its end

NOTHING, BEGAN, GOES_ON, DONE, GAVE_UP = 0, 1, 2, 3, 4


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
        1 if there is news of a move that is followed, which stands in `happened` of the moves; else 0.
    """
    bank = open_bank(store)
    known = open_memory(memory, bank.head[0])
    if not is_in_order(known.state[0], time):
        return 0
    _take(memory, known, bank, positions, time)
    return 1 if known.state[0].happened else 0


@entry_point(makes_arrays=False)
def finish_take(memory: NDArray[np.uint8], store: NDArray[np.uint8]) -> None:
    """Decide everything at the end of a take; the news stand in `happened` of the moves."""
    bank = open_bank(store)
    known = open_memory(memory, bank.head[0])
    known.state[0].happened = 0
    for m in range(known.moves.size):
        known.moves[m].happened = NOTHING
        if known.moves[m].best < np.inf:
            _finish(memory, known, bank, m)
        elif known.moves[m].active:
            _tell(known, m, GAVE_UP)


@kernel
def _take(memory, known, bank, positions, time):
    """Process one frame."""
    state, moves = known.state[0], known.moves
    state.happened = 0
    for m in range(moves.size):
        moves[m].happened = NOTHING
    fresh = not goes_on(state, time)
    if fresh and state.frames > 0:
        _restart(memory, known, bank)
    poses = known.poses
    for k in range(poses.shape[1]):
        for d in range(3):
            poses[0, k, d] = poses[1, k, d]
    whole = localise(poses[1], poses[0], bank.points, positions, state.frames > 0)
    if fresh:
        if not whole:
            return
        _copy_pose(poses)
        state.next = time
    while state.next <= time + EARLY:
        share = 1.0 if fresh else min(1.0, 1.0 - (time - state.next) / (time - state.time))
        take_sample(known, bank, share, state.next - state.sampled)
        state.sampled = state.next
        _follow_all(memory, known, bank)
        state.samples += 1
        state.next += PERIOD
        fresh = False
    state.time = time
    state.frames += 1


@kernel
def _restart(memory, known, bank):
    """Give up what is being made, after a gap."""
    state, moves, examples = known.state[0], known.moves, bank.examples
    state.frames = 0
    state.samples = 0
    state.poses = 0
    for m in range(moves.size):
        if moves[m].active:
            _tell(known, m, GAVE_UP)
        moves[m].best = np.inf
        moves[m].recents = 0
    for t in range(examples.size):
        forget(open_cells(memory, examples[t], bank.head[0].lanes), np.inf)


@kernel
def _tell(known, m, what):
    move = known.moves[m]
    move.happened = what
    known.state[0].happened = 1
    move.told = known.state[0].sampled
    if not move.active and what != GAVE_UP:
        known.state[0].number += 1
        move.number = known.state[0].number
        move.rev = 0
    if what == BEGAN:
        move.active = 1
    elif what != GOES_ON:
        move.active = 0
        move.recents = 0
    move.rev += 1


@kernel
def _follow_all(memory, known, bank):
    """Align the sample that was taken with all examples, and see what that says of each move."""
    state, head, examples = known.state[0], bank.head[0], bank.examples
    if state.samples % head.stride == 0:
        _keep(known.ring[state.poses % RING], known.directions)
        state.poses += 1
    at = 0
    for m in range(known.moves.size):
        first = at
        while at < examples.size and examples[at].move == m:
            if state.samples % examples[at].stride == 0:
                cells = open_cells(memory, examples[at], head.lanes)
                compare(cells, _rows(bank, examples[at], head.lanes), known.directions, head.bones)
                advance(cells, state.sampled)
                forget(cells, known.moves[m].from_time)
            at += 1
        _lead(memory, known, bank, m, first, at)


@inline_kernel(returns_views=True)
def _rows(bank, example, lanes):
    """Return the directions of an example, (n, 3, lanes)."""
    return part(bank.rows, 4 * example.rows, np.float32, (example.phases, 3, lanes))


@inline_kernel
def _keep(to, directions):
    for d in range(3):
        for b in range(directions.shape[1]):
            to[d, b] = directions[d, b]


@inline_kernel
def _copy_pose(poses):
    for k in range(poses.shape[1]):
        for d in range(3):
            poses[0, k, d] = poses[1, k, d]


@kernel
def _lead(memory, known, bank, m, first, last):
    """See which way leads, and what that says of move m, whose examples are `first` to `last`."""
    move, time, lanes = known.moves[m], known.state[0].sampled, bank.head[0].lanes
    least, leader, layer, phase = np.inf, -1, 0, 0
    waits = False
    for t in range(first, last):
        cells = open_cells(memory, bank.examples[t], lanes)
        count = cells.distances.size
        for other in range(LAYERS):
            for j in range(count):
                cost = np.float64(cells.costs[other, j])
                if not cost < np.inf:
                    continue
                rank = cost / cells.weights[other, j] + REMAINS * (1.0 - (j + 1.0) / count)
                if rank < least:
                    least, leader, layer, phase = rank, t, other, j
                waits |= cells.starts[other, j] < move.best_time and cost / count < move.best
        _note_end(cells, known, m, t, bank.examples[t].dearest)
    if leader >= 0:
        cells = open_cells(memory, bank.examples[leader], lanes)
        _note_progress(cells, known, m, layer, phase)
        move.example = leader
    is_settled = move.best < np.inf and (not waits or time - move.best_time > SETTLED)
    if is_settled and move.best_time < time:
        _finish(memory, known, bank, m)
    elif leader >= 0:
        _go_on(known, m, bank.examples[leader].dearest)


@kernel
def _note_end(cells, known, m, t, dearest):
    """Take note of a way that has reached the end of its example, if it is the cheapest."""
    move = known.moves[m]
    end = cells.distances.size - 1
    for layer in range(LAYERS):
        cost = np.float64(cells.costs[layer, end]) / cells.weights[layer, end]
        if cost < min(move.best, dearest):
            move.best = cost
            move.best_start = cells.starts[layer, end]
            move.best_time = known.state[0].sampled
            move.best_example = t
            for b in range(cells.parts.shape[1]):
                known.best[m, b] = cells.sums[layer, end, b] / cells.weights[layer, end]


@kernel
def _note_progress(cells, known, m, layer, phase):
    move, time = known.moves[m], known.state[0].sampled
    move.progress = phase / (cells.distances.size - 1.0)
    move.start = cells.starts[layer, phase]
    move.time = time
    move.cost = cells.costs[layer, phase] / cells.weights[layer, phase]
    for b in range(cells.parts.shape[1]):
        known.strays[m, b] = cells.sums[layer, phase, b] / cells.weights[layer, phase]


@kernel
def _go_on(known, m, dearest):
    """Report a performance that begins, goes on, or is given up."""
    move, state = known.moves[m], known.state[0]
    move.recent[move.recents % RECENT] = move.progress
    move.recents += 1
    if move.cost < dearest and move.progress >= BEGUN:
        move.seen = state.sampled
        if not move.active:
            _tell(known, m, BEGAN)
        elif state.sampled - move.told >= state.every - EARLY and move.happened == NOTHING:
            _tell(known, m, GOES_ON)
    elif move.active and state.sampled - move.seen > LEFT and move.happened == NOTHING:
        _tell(known, m, GAVE_UP)


@kernel
def _finish(memory, known, bank, m):
    """Report a performance that is done; the next one begins after its end."""
    move = known.moves[m]
    if move.happened != NOTHING:
        return
    move.progress = 1.0
    move.start, move.time, move.example = move.best_start, move.best_time, move.best_example
    move.from_time = move.best_time
    move.best = np.inf
    move.count += 1
    for b in range(known.best.shape[1]):
        known.strays[m, b] = known.best[m, b]
    _measure(known, m, bank.head[0].stride * PERIOD)
    _tell(known, m, DONE)
    for t in range(bank.examples.size):
        if bank.examples[t].move == m:
            forget(open_cells(memory, bank.examples[t], bank.head[0].lanes), move.from_time)


@kernel
def _measure(known, m, spacing):
    """Note the least and the largest direction of each bone during the performance."""
    state, move, boxes = known.state[0], known.moves[m], known.boxes
    newest = state.poses - 1
    last = newest - round((state.sampled - move.time) / spacing)
    first = max(newest - round((state.sampled - move.start) / spacing), newest - RING + 1, 0)
    for d in range(3):
        for b in range(boxes.shape[3]):
            boxes[m, 0, d, b] = boxes[m, 1, d, b] = known.ring[first % RING, d, b]
    for n in range(first + 1, last + 1):
        for d in range(3):
            for b in range(boxes.shape[3]):
                direction = known.ring[n % RING, d, b]
                boxes[m, 0, d, b] = min(boxes[m, 0, d, b], direction)
                boxes[m, 1, d, b] = max(boxes[m, 1, d, b], direction)
