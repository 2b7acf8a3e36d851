"""The exact sum over the paths of a large sparse block by a frontier programme (see `path_sum`).

The vertices are settled one by one. A state says how the edges chosen at the settled vertices meet the
frontier, the vertices that are not settled but have a settled neighbour. States that agree have the same
futures, so only the sum of their weights is kept: this is Knuth's Simpath (The Art of Computer Programming
4A, exercise 7.1.4-225), with free ends and with weights in place of a decision diagram. The number of states
grows with the width of the frontier instead of the number of paths.

A state is one int64: four bits for each slot of the frontier and, above them, the number of settled ends. The
states lie in an open-addressing hash table whose size is a power of two: `keys` (size,), EMPTY or the state, and
`sums` (size, 2), the weight of the choices that lead there and its derivative by ends[0].
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import kernel
from mossar_stream.jit.simd import lowest_bit

FRONTIER_SLOTS = np.int64(13)  # four bits each, and two for the number of ends, in one int64

# What a slot of the frontier says of its vertex.
UNUSED = np.int64(0)  # on no path yet
INNER = np.int64(1)  # both its edges are chosen
LOOSE = np.int64(2)  # one tip of a piece whose other tip is a settled end of the path
FIRST_MATE = np.int64(3)  # FIRST_MATE + k: one tip of a piece whose other tip sits in slot k
CODE = np.int64(15)  # the bits of a slot
ONE_END = np.int64(1 << 52)  # added once for each settled end
OPEN_PIECES = np.int64(0xEEEEEEEEEEEEE)  # bits set only where a slot is neither UNUSED nor INNER
SETTLED_END = np.int64(-1)  # in place of a slot: the tip is a settled end
EMPTY = np.int64(-1)  # in place of a key: nothing stored here
TOO_SMALL = np.int64(-1)  # in place of a number of states: the table is too small
SCATTER = np.int64(0x1E3779B97F4A7C15)  # odd, near 2^61 · golden ratio: spreads the keys


class States(NamedTuple):
    """The states after a vertex, as they are found, and the paths that become complete with it."""

    keys: NDArray[np.int64]  # (size,)
    sums: NDArray[np.float64]  # (size, 2)
    complete: NDArray[
        np.float64
    ]  # (4,) their sum, its derivative by ends[0], and both as they were before the vertex


class Vertex(NamedTuple):
    """The vertex that is settled, and the edges from it that are not."""

    slot: int
    reach: NDArray[np.int64]  # slots of its neighbours that are not settled; the first `degree` count
    gains: NDArray[
        np.float64
    ]  # (…, 2) weight of the edges to them, without and with the weight of the neighbour
    degree: int
    inner: float  # its weight if a path runs through it
    end: float  # its weight if a path ends at it
    is_first: bool  # whether it is vertex 0, by whose `end` the sums are differentiated


@kernel
def elimination_order(near, order):
    """Find an order of settling the vertices of a block that keeps the frontier narrow.

    Args:
        near: (n,) as in `blocks`.
        order: (n,) filled with the order.

    Returns:
        The estimated cost of `frontier_sum` and the number of slots it needs.
    """
    n = len(near)
    trial = np.empty(n, np.int64)
    best = np.inf
    width = 0
    for start in range(n):
        cost, slots = _greedy_order(near, start, best, trial)
        if cost < best:
            best = cost
            width = slots
            for k in range(n):
                order[k] = trial[k]
    return best, width


@kernel
def _greedy_order(near, start, limit, order):
    """Settle from `start` on whatever adds fewest vertices to the frontier; give up at the limit."""
    cost = 0.0
    width = 0
    frontier = 1 << start
    fresh = ~frontier  # neither settled nor on the frontier
    size = 1
    for k in range(len(near)):
        pick = 0
        fewest = len(near)
        rest = frontier
        while rest != 0 and fewest > 0:
            v = lowest_bit(rest)
            rest &= rest - 1
            added = 0
            new = near[v] & fresh
            while new != 0:
                new &= new - 1
                added += 1
            if added < fewest:
                pick = v
                fewest = added
        order[k] = pick
        frontier = (frontier | near[pick] & fresh) & ~(1 << pick)
        fresh &= ~near[pick]
        size += fewest
        width = max(width, size)
        size -= 1
        states = 1.0
        for _ in range(size):
            states *= 3.6  # states seen per vertex of the frontier
        cost += states
        if cost >= limit:
            break
    return cost, width


@kernel
def frontier_sum(near, link, inner, ends, order):
    """Sum the paths of a block by settling its vertices one by one; result as in `path_sum.block_sum`.

    Args:
        near: As in `blocks`, like the next three.
        link: (n, n).
        inner: (n,).
        ends: (n,).
        order: (n,) order of settling, which must never need more than FRONTIER_SLOTS slots.
    """
    n = len(near)
    slot_of = np.zeros(n, np.int64)
    free = (1 << FRONTIER_SLOTS) - 1
    complete = np.zeros(4)
    reach = np.empty(n, np.int64)
    gains = np.empty((n, 2))
    keys = np.zeros(1, np.int64)
    sums = np.zeros((1, 2))
    sums[0, 0] = 1.0
    many = 1
    settled = entered = 0
    for k in range(n):
        v = order[k]
        settled |= 1 << v
        rest = (near[v] | 1 << v) & ~entered
        entered |= rest
        while rest != 0:
            slot_of[lowest_bit(rest)] = lowest_bit(free)
            rest &= rest - 1
            free &= free - 1
        rest = near[v] & ~settled
        d = 0
        while rest != 0:
            u = lowest_bit(rest)
            rest &= rest - 1
            reach[d] = slot_of[u]
            gains[d, 0] = link[v, u]
            gains[d, 1] = link[v, u] * inner[u]
            d += 1
        complete[2], complete[3] = complete[0], complete[1]
        vertex = Vertex(slot_of[v], reach, gains, d, inner[v], ends[v], v == 0)
        size = 16
        while size < 4 * many or size < 2 + d + d * d:
            size *= 2
        while True:
            after = np.empty(size, np.int64)
            for at in range(size):
                after[at] = EMPTY
            after_sums = np.empty((size, 2))
            many = _settle(keys, sums, vertex, States(after, after_sums, complete))
            if many != TOO_SMALL:
                break
            size *= 2
            complete[0], complete[1] = complete[2], complete[3]
        keys, sums = after, after_sums
        free |= 1 << slot_of[v]
    return complete[0], complete[1]


@kernel
def _settle(keys, sums, vertex, after):
    """Choose in every state which edges a path takes at the vertex being settled: none, one or two.

    Args:
        keys: States before.
        sums: Their sums.
        vertex: `Vertex`.
        after: `States`, an empty table for the states after.

    Returns:
        How many states there are after, or TOO_SMALL.
    """
    d, reach = vertex.degree, vertex.reach
    most = 1 + d + d * (d - 1) // 2
    stored = 0
    for at in range(len(keys)):
        key = keys[at]
        if key == EMPTY:
            continue
        if 2 * (stored + most) > len(after.keys):
            return TOO_SMALL
        x, slope = sums[at, 0], sums[at, 1]
        code = key >> 4 * vertex.slot & CODE
        key &= ~(CODE << 4 * vertex.slot)
        unused = code == UNUSED
        if unused or code == INNER:
            stored += _insert(after, key, x, slope)
            if not unused:
                continue
        may_end = key < 2 * ONE_END  # a path has two ends
        ended, ended_slope = x * vertex.end, x if vertex.is_first else slope * vertex.end
        x *= vertex.inner
        slope *= vertex.inner
        tip = SETTLED_END if code == LOOSE else code - FIRST_MATE
        if may_end and not unused:
            stored += _join(after, key + ONE_END, tip, SETTLED_END, (ended, ended_slope))
        # An unused vertex takes two edges, the later one first, or one and ends; on a piece it takes one.
        for i in range(1 if unused else d, d + 1):
            led, gain = key, 1.0
            if i < d:
                code = key >> 4 * reach[i] & CODE
                if code == INNER:
                    continue
                gain = vertex.gains[i, 0 if code == UNUSED else 1]
                tip = reach[i] if code == UNUSED else SETTLED_END if code == LOOSE else code - FIRST_MATE
                led = key if code == UNUSED else key ^ (code ^ INNER) << 4 * reach[i]
            elif unused:
                if not may_end:
                    continue
                led, tip, x, slope = key + ONE_END, SETTLED_END, ended, ended_slope
            stored += _extend(after, vertex, i, led, tip, (x * gain, slope * gain))
    return stored


@kernel
def _extend(after, vertex, stop, key, tip, weight):
    """Lead a piece on along one of the edges before `stop`; return the number of new states.

    Args:
        after: `States`.
        vertex: `Vertex`.
        stop: How many of its edges may be taken.
        key: The state without the piece.
        tip: Slot of the other tip of the piece, or SETTLED.
        weight: Of the state, and its derivative.
    """
    stored = 0
    x, slope = weight
    for i in range(stop):
        slot = vertex.reach[i]
        code = key >> 4 * slot & CODE
        if code == INNER or slot == tip:  # taken, or it would close a cycle
            continue
        gain = vertex.gains[i, 0 if code == UNUSED else 1]
        other = slot if code == UNUSED else SETTLED_END if code == LOOSE else code - FIRST_MATE
        led = key if code == UNUSED else key ^ (code ^ INNER) << 4 * slot
        stored += _join(after, led, tip, other, (x * gain, slope * gain))
    return stored


@kernel
def _join(after, key, tip, other, weight):
    """Let a piece reach from one tip to another; return the number of new states.

    Tips are slots or SETTLED; a piece with two settled ends is a complete path and counted.

    Args:
        after: `States`.
        key: The state without the piece.
        tip: One tip.
        other: The other one.
        weight: Of the state, and its derivative.
    """
    if tip == SETTLED_END:
        tip, other = other, tip
    if tip == SETTLED_END:
        if key & OPEN_PIECES == 0:  # a second piece could never be joined to this path
            after.complete[0] += weight[0]
            after.complete[1] += weight[1]
        return 0
    key &= ~(CODE << 4 * tip)
    if other == SETTLED_END:
        key |= LOOSE << 4 * tip
    else:
        key = key & ~(CODE << 4 * other) | FIRST_MATE + other << 4 * tip | FIRST_MATE + tip << 4 * other
    return _insert(after, key, weight[0], weight[1])


@kernel
def _insert(states, key, x, slope):
    """Add to the sums of a state; return 1 if it is new to the table, else 0."""
    keys, sums = states.keys, states.sums
    last = len(keys) - 1
    at = ((key ^ key >> 32) * SCATTER >> 32) & last
    while keys[at] != key:
        if keys[at] == EMPTY:
            keys[at], sums[at, 0], sums[at, 1] = key, x, slope
            return 1
        at = (at + 1) & last
    sums[at, 0] += x
    sums[at, 1] += slope
    return 0
