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

cdef enum:
    FRONTIER_SLOTS = 13  # four bits each, and two for the number of ends, in one int64
    # What a slot of the frontier says of its vertex.
    UNUSED = 0  # on no path yet
    INNER = 1  # both its edges are chosen
    LOOSE = 2  # one tip of a piece whose other tip is a settled end of the path
    FIRST_MATE = 3  # FIRST_MATE + k: one tip of a piece whose other tip sits in slot k
    CODE = 15  # the bits of a slot
cdef int64_t ONE_END = 4503599627370496  # added once for each settled end
cdef int64_t OPEN_PIECES = 4203359652212462  # bits set only where a slot is neither UNUSED nor INNER
cdef enum:
    SETTLED_END = -1  # in place of a slot: the tip is a settled end
    EMPTY = -1  # in place of a key: nothing stored here
    TOO_SMALL = -1  # in place of a number of states: the table is too small
cdef int64_t SCATTER = 2177342782468422677  # odd, near 2^61 · golden ratio: spreads the keys

cdef struct States:  # The states after a vertex, as they are found, and the paths that become complete with it.
    Ints keys  # (size,)
    DoubleRows sums  # (size, 2)
    Doubles complete  # (4,) their sum, its derivative by ends[0], and both as they were before the vertex


cdef struct Vertex:  # The vertex that is settled, and the edges from it that are not.
    int64_t slot
    Ints reach  # slots of its neighbours that are not settled; the first `degree` count
    DoubleRows gains  # (…, 2) weight of the edges to them, without and with the weight of the neighbour
    int64_t degree
    double inner  # its weight if a path runs through it
    double end  # its weight if a path ends at it
    bint is_first  # whether it is vertex 0, by whose `end` the sums are differentiated


cdef (double, int64_t) elimination_order(Ints near, Ints order) noexcept nogil:
    """Find an order of settling the vertices of a block that keeps the frontier narrow.

    Args:
        near: (n,) as in `blocks`.
        order: (n,) filled with the order.

    Returns:
        The estimated cost of `frontier_sum` and the number of slots it needs.
    """
    cdef int64_t n, width, start, slots, k
    cdef Ints trial
    cdef double best, cost
    # CHECK np.empty: np.empty(n, np.int64)
    n = near.count
    trial = np.empty(n, np.int64)
    best = INFINITY
    width = 0
    for start in range(n):
        cost, slots = _greedy_order(near, start, best, trial)
        if cost < best:
            best = cost
            width = slots
            for k in range(n):
                order.at[k] = trial.at[k]
    return best, width


cdef (double, int64_t) _greedy_order(Ints near, int64_t start, double limit, Ints order) noexcept nogil:
    """Settle from `start` on whatever adds fewest vertices to the frontier; give up at the limit."""
    cdef double cost, states
    cdef int64_t width, frontier, fresh, size, k, pick, fewest, rest, _, v, added, new
    cost = 0.0
    width = 0
    frontier = <int64_t>1 << start
    fresh = ~frontier  # neither settled nor on the frontier
    size = 1
    for k in range(near.count):
        pick = 0
        fewest = near.count
        rest = frontier
        while rest != 0 and fewest > 0:
            v = lowest_bit(rest)
            rest &= rest - 1
            added = 0
            new = near.at[v] & fresh
            while new != 0:
                new &= new - 1
                added += 1
            if added < fewest:
                pick = v
                fewest = added
        order.at[k] = pick
        frontier = (frontier | near.at[pick] & fresh) & ~(<int64_t>1 << pick)
        fresh &= ~near.at[pick]
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


cdef (double, double) frontier_sum(Ints near, DoubleRows link, Doubles inner, Doubles ends, Ints order) noexcept nogil:
    """Sum the paths of a block by settling its vertices one by one; result as in `path_sum.block_sum`.

    Args:
        near: As in `blocks`, like the next three.
        link: (n, n).
        inner: (n,).
        ends: (n,).
        order: (n,) order of settling, which must never need more than FRONTIER_SLOTS slots.
    """
    cdef int64_t n, free, many, settled, entered, k, v, rest, d, size, u, at
    cdef Ints slot_of, reach, keys, after
    cdef Doubles complete
    cdef DoubleRows gains, sums, after_sums
    cdef Vertex vertex
    # CHECK np.zeros: np.zeros(n, np.int64)
    # CHECK np.zeros: np.zeros(4)
    # CHECK np.empty: np.empty(n, np.int64)
    # CHECK np.empty: np.empty((n, 2))
    # CHECK np.zeros: np.zeros(1, np.int64)
    # CHECK np.zeros: np.zeros((1, 2))
    # CHECK np.empty: np.empty(size, np.int64)
    # CHECK np.empty: np.empty((size, 2))
    n = near.count
    slot_of = np.zeros(n, np.int64)
    free = (<int64_t>1 << FRONTIER_SLOTS) - 1
    complete = np.zeros(4)
    reach = np.empty(n, np.int64)
    gains = np.empty((n, 2))
    keys = np.zeros(1, np.int64)
    sums = np.zeros((1, 2))
    sums.at[0] = 1.0
    many = 1
    settled = entered = 0
    for k in range(n):
        v = order.at[k]
        settled |= <int64_t>1 << v
        rest = (near.at[v] | <int64_t>1 << v) & ~entered
        entered |= rest
        while rest != 0:
            slot_of.at[lowest_bit(rest)] = lowest_bit(free)
            rest &= rest - 1
            free &= free - 1
        rest = near.at[v] & ~settled
        d = 0
        while rest != 0:
            u = lowest_bit(rest)
            rest &= rest - 1
            reach.at[d] = slot_of.at[u]
            gains.at[d * gains.columns + 0] = link.at[v * link.columns + u]
            gains.at[d * gains.columns + 1] = link.at[v * link.columns + u] * inner.at[u]
            d += 1
        complete.at[2], complete.at[3] = complete.at[0], complete.at[1]
        vertex = Vertex(slot_of.at[v], reach, gains, d, inner.at[v], ends.at[v], v == 0)
        size = 16
        while size < 4 * many or size < 2 + d + d * d:
            size *= 2
        while True:
            after = np.empty(size, np.int64)
            for at in range(size):
                after.at[at] = EMPTY
            after_sums = np.empty((size, 2))
            many = _frontier_settle(keys, sums, &vertex, &States(after, after_sums, complete))
            if many != TOO_SMALL:
                break
            size *= 2
            complete.at[0], complete.at[1] = complete.at[2], complete.at[3]
        keys = after
        sums = after_sums
        free |= <int64_t>1 << slot_of.at[v]
    return (complete.at[0], complete.at[1])


cdef int64_t _frontier_settle(Ints keys, DoubleRows sums, Vertex* vertex, States* after) noexcept nogil:
    """Choose in every state which edges a path takes at the vertex being settled: none, one or two.

    Args:
        keys: States before.
        sums: Their sums.
        vertex: `Vertex`.
        after: `States`, an empty table for the states after.

    Returns:
        How many states there are after, or TOO_SMALL.
    """
    cdef int64_t most, stored, at, d, key, code, tip, i, led
    cdef Ints reach
    cdef bint unused, may_end
    cdef double x, slope, ended, ended_slope, gain
    # CHECK sign (C truncates): d * (d - 1) // 2
    d = vertex.degree
    reach = vertex.reach
    most = 1 + d + d * (d - 1) // 2
    stored = 0
    for at in range(keys.count):
        key = keys.at[at]
        if key == EMPTY:
            continue
        if 2 * (stored + most) > after.keys.count:
            return TOO_SMALL
        x, slope = sums.at[at * sums.columns + 0], sums.at[at * sums.columns + 1]
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
            stored += _frontier_join(after, key + ONE_END, tip, SETTLED_END, (ended, ended_slope))
        # An unused vertex takes two edges, the later one first, or one and ends; on a piece it takes one.
        for i in range(1 if unused else d, d + 1):
            led, gain = key, 1.0
            if i < d:
                code = key >> 4 * reach.at[i] & CODE
                if code == INNER:
                    continue
                gain = vertex.gains.at[i * vertex.gains.columns + (0 if code == UNUSED else 1)]
                tip = reach.at[i] if code == UNUSED else SETTLED_END if code == LOOSE else code - FIRST_MATE
                led = key if code == UNUSED else key ^ (code ^ INNER) << 4 * reach.at[i]
            elif unused:
                if not may_end:
                    continue
                led, tip, x, slope = key + ONE_END, SETTLED_END, ended, ended_slope
            stored += _extend(after, vertex, i, led, tip, (x * gain, slope * gain))
    return stored


cdef int64_t _extend(States* after, Vertex* vertex, int64_t stop, int64_t key, int64_t tip, (double, double) weight) noexcept nogil:
    """Lead a piece on along one of the edges before `stop`; return the number of new states.

    Args:
        after: `States`.
        vertex: `Vertex`.
        stop: How many of its edges may be taken.
        key: The state without the piece.
        tip: Slot of the other tip of the piece, or SETTLED.
        weight: Of the state, and its derivative.
    """
    cdef int64_t stored, i, slot, code, other, led
    cdef double x, slope, gain
    stored = 0
    x, slope = weight
    for i in range(stop):
        slot = vertex.reach.at[i]
        code = key >> 4 * slot & CODE
        if code == INNER or slot == tip:  # taken, or it would close a cycle
            continue
        gain = vertex.gains.at[i * vertex.gains.columns + (0 if code == UNUSED else 1)]
        other = slot if code == UNUSED else SETTLED_END if code == LOOSE else code - FIRST_MATE
        led = key if code == UNUSED else key ^ (code ^ INNER) << 4 * slot
        stored += _frontier_join(after, led, tip, other, (x * gain, slope * gain))
    return stored


cdef int64_t _frontier_join(States* after, int64_t key, int64_t tip, int64_t other, (double, double) weight) noexcept nogil:
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
            after.complete.at[0] += weight[0]
            after.complete.at[1] += weight[1]
        return 0
    key &= ~(CODE << 4 * tip)
    if other == SETTLED_END:
        key |= LOOSE << 4 * tip
    else:
        key = key & ~(CODE << 4 * other) | FIRST_MATE + other << 4 * tip | FIRST_MATE + tip << 4 * other
    return _insert(after, key, weight[0], weight[1])


cdef int64_t _insert(States* states, int64_t key, double x, double slope) noexcept nogil:
    """Add to the sums of a state; return 1 if it is new to the table, else 0."""
    cdef int64_t last, at
    cdef Ints keys
    cdef DoubleRows sums
    keys = states.keys
    sums = states.sums
    last = keys.count - 1
    at = (key ^ key >> 32) * SCATTER >> 32 & last
    while keys.at[at] != key:
        if keys.at[at] == EMPTY:
            keys.at[at], sums.at[at * sums.columns + 0], sums.at[at * sums.columns + 1] = key, x, slope
            return 1
        at = at + 1 & last
    sums.at[at * sums.columns + 0] += x
    sums.at[at * sums.columns + 1] += slope
    return 0
