"""The exact sum over the paths of a large sparse block by a frontier programme (see `path_sum.pxi`).

The vertices are settled one by one. A state describes how the edges chosen at the settled vertices meet the
frontier, the vertices that are not settled but have a settled neighbour. States that agree have the same
futures, so only the sum of their weights is kept: this is Knuth's Simpath (The Art of Computer Programming
4A, exercise 7.1.4-225), with free ends and with weights in place of a decision diagram. The number of states
grows with the width of the frontier instead of the number of paths.

A state is one number of 64 bits: four for each slot of the frontier and, above them, the number of settled ends. The
states lie in an open-addressing hash table whose size is a power of two.
"""

cdef enum:
    FRONTIER_SLOTS = 13  # four bits each, and two for the number of ends, in one state
    # Codes of a vertex in a slot of the frontier.
    UNUSED = 0  # on no path yet
    INNER = 1  # both its edges are chosen
    LOOSE = 2  # one tip of a piece whose other tip is a settled end of the path
    FIRST_MATE = 3  # FIRST_MATE + k: one tip of a piece whose other tip sits in slot k
    CODE = 15  # the bits of a slot
    SETTLED_END = -1  # in place of a slot: the tip is a settled end

cdef uint64_t ONE_END = <uint64_t>1 << 52  # added once for each settled end
cdef uint64_t OPEN_PIECES = 0xEEEEEEEEEEEEE  # bits set only where a slot is neither UNUSED nor INNER
cdef uint64_t NO_STATE = ~<uint64_t>0  # in place of a state: nothing stored here
cdef uint64_t SCATTER = 0x1E3779B97F4A7C15  # odd, near 2^61 · golden ratio: spreads the states


cdef struct PathState:
    uint64_t key  # the state, or NO_STATE
    double sum  # weight of the choices that lead there
    double slope  # its derivative by ends[0]


cdef struct States:  # A table of states.
    PathState* at
    int64_t size  # a power of two
    int64_t many  # number of them


cdef struct Vertex:  # The vertex that is settled, and the edges from it that are not.
    int64_t slot
    int64_t degree
    int64_t reach[MOST_VERTICES]  # (degree,) slots of its neighbours that are not settled
    double gains[2 * MOST_VERTICES]  # (degree, 2) weight of the edges to them, without and with that of the neighbour
    double inner  # its weight if a path runs through it
    double end  # its weight if a path ends at it
    bint is_first  # whether it is vertex 0, by whose `end` the sums are differentiated


cdef (double, int64_t) elimination_order(const Block* block, int64_t* order) noexcept nogil:
    """Find an order of settling the vertices of a block that keeps the frontier narrow.

    Args:
        block: The block.
        order: (n,) filled with the order.

    Returns:
        The estimated cost of `frontier_sum` and the number of slots it needs.
    """
    cdef int64_t trial[MOST_VERTICES]
    cdef int64_t start, slots, width = 0
    cdef double cost, best = INFINITY
    for start in range(block.count):
        cost, slots = _greedy_order(block, start, best, trial)
        if cost < best:
            best, width = cost, slots
            memcpy(order, trial, block.count * sizeof(int64_t))
    return best, width


cdef (double, int64_t) _greedy_order(
    const Block* block, int64_t start, double limit, int64_t* order
) noexcept nogil:
    """Settle, from `start` on, the vertex that adds fewest others to the frontier; give up at the limit."""
    cdef double states, cost = 0.0
    cdef uint64_t rest, new, frontier = bit(start)
    cdef uint64_t fresh = ~frontier  # neither settled nor on the frontier
    cdef int64_t k, v, i, pick, added, fewest, size = 1, width = 0
    for k in range(block.count):
        pick = 0
        fewest = block.count
        rest = frontier
        while rest != 0 and fewest > 0:
            v = lowest_bit(rest)
            rest &= rest - 1
            added = 0
            new = block.near[v] & fresh
            while new != 0:
                new &= new - 1
                added += 1
            if added < fewest:
                pick = v
                fewest = added
        order[k] = pick
        frontier = (frontier | (block.near[pick] & fresh)) & ~bit(pick)
        fresh &= ~block.near[pick]
        size += fewest
        width = max(width, size)
        size -= 1
        states = 1.0
        for i in range(size):
            states *= 3.6  # states seen per vertex of the frontier
        cost += states
        if cost >= limit:
            break
    return cost, width


cdef bint frontier_sum(const Block* block, const int64_t* order, BlockSum* found) noexcept nogil:
    """Sum the paths of a block by settling its vertices one by one.

    Args:
        block: The block.
        order: (n,) order of settling, which must never need more than FRONTIER_SLOTS slots.
        found: Set to the sums.

    Returns:
        False if there is no memory.
    """
    cdef PathState start = PathState(0, 1.0, 0.0)
    cdef States before = States(&start, 1, 1), after
    cdef Vertex vertex
    cdef int64_t slot_of[MOST_VERTICES]
    cdef int64_t k, v, u
    cdef uint64_t rest, free_slots = bit(FRONTIER_SLOTS) - 1, settled = 0, entered = 0
    found.total = found.down = 0.0
    for k in range(block.count):
        v = order[k]
        settled |= bit(v)
        rest = (block.near[v] | bit(v)) & ~entered
        entered |= rest
        while rest != 0:
            slot_of[lowest_bit(rest)] = lowest_bit(free_slots)
            rest &= rest - 1
            free_slots &= free_slots - 1
        vertex.slot, vertex.degree, vertex.is_first = slot_of[v], 0, v == 0
        vertex.inner, vertex.end = block.inner[v], block.ends[v]
        rest = block.near[v] & ~settled
        while rest != 0:
            u = lowest_bit(rest)
            rest &= rest - 1
            vertex.reach[vertex.degree] = slot_of[u]
            vertex.gains[2 * vertex.degree] = block.link[v * block.count + u]
            vertex.gains[2 * vertex.degree + 1] = block.link[v * block.count + u] * block.inner[u]
            vertex.degree += 1
        after = _settled(&before, &vertex, found)
        if before.at != &start:
            free(before.at)
        before = after
        if before.at == NULL:
            return False
        free_slots |= bit(slot_of[v])
    if before.at != &start:
        free(before.at)
    return True


cdef States _settled(const States* before, const Vertex* vertex, BlockSum* complete) noexcept nogil:
    """Return the states after a vertex is settled, in a table of their own, which is NULL if there is no memory.

    The paths that become complete with it are added.
    """
    cdef BlockSum earlier = complete[0]
    cdef int64_t i, d = vertex.degree
    cdef States after = States(NULL, 16, 0)
    while after.size < 4 * before.many or after.size < 2 + d + d * d:
        after.size *= 2
    while True:
        after.at, after.many = <PathState*>malloc(after.size * sizeof(PathState)), 0
        if after.at == NULL:
            return after
        for i in range(after.size):
            after.at[i].key = NO_STATE
        if _settle(before, vertex, &after, complete):
            return after
        free(after.at)
        after.size *= 2
        complete[0] = earlier


cdef bint _settle(
    const States* before, const Vertex* vertex, States* after, BlockSum* complete
) noexcept nogil:
    """Choose in every state which edges a path takes at the vertex being settled: none, one or two.

    Args:
        before: States before.
        vertex: The vertex.
        after: An empty table for the states after.
        complete: The paths that are complete, to be added to.

    Returns:
        False if the table is too small.
    """
    cdef int64_t d = vertex.degree, most = 1 + d + d * (d - 1) // 2
    cdef int64_t at, code, tip, i
    cdef uint64_t key, led
    cdef bint unused, may_end
    cdef double x, slope, ended, ended_slope, gain
    for at in range(before.size):
        key = before.at[at].key
        if key == NO_STATE:
            continue
        if 2 * (after.many + most) > after.size:
            return False
        x, slope = before.at[at].sum, before.at[at].slope
        code = _code(key, vertex.slot)
        key &= ~(<uint64_t>CODE << 4 * vertex.slot)
        unused = code == UNUSED
        if unused or code == INNER:
            _insert(after, key, x, slope)
            if not unused:
                continue
        may_end = key < 2 * ONE_END  # a path has two ends
        ended, ended_slope = x * vertex.end, x if vertex.is_first else slope * vertex.end
        x *= vertex.inner
        slope *= vertex.inner
        tip = _mate(code)
        if may_end and not unused:
            _join(after, complete, key + ONE_END, tip, SETTLED_END, ended, ended_slope)
        # An unused vertex takes two edges, the later one first, or one and ends; on a piece it takes one.
        for i in range(1 if unused else d, d + 1):
            led, gain = key, 1.0
            if i < d:
                code = _code(key, vertex.reach[i])
                if code == INNER:
                    continue
                gain = vertex.gains[2 * i + (0 if code == UNUSED else 1)]
                tip = vertex.reach[i] if code == UNUSED else _mate(code)
                led = _taken(key, vertex.reach[i], code)
            elif unused:
                if not may_end:
                    continue
                led, tip, x, slope = key + ONE_END, SETTLED_END, ended, ended_slope
            _extend(after, complete, vertex, i, led, tip, x * gain, slope * gain)
    return True


cdef inline int64_t _code(uint64_t key, int64_t slot) noexcept nogil:
    """Return the code of a slot in a state."""
    return key >> 4 * slot & CODE


cdef inline int64_t _mate(int64_t code) noexcept nogil:
    """Return the other tip of a piece, given the code of one tip's slot."""
    return SETTLED_END if code == LOOSE else code - FIRST_MATE


cdef inline uint64_t _taken(uint64_t key, int64_t slot, int64_t code) noexcept nogil:
    """Return a state after an edge to a slot is chosen: a tip becomes inner, an unused vertex will get a mate."""
    return key if code == UNUSED else key ^ (<uint64_t>(code ^ INNER) << 4 * slot)


cdef void _extend(
    States* after, BlockSum* complete, const Vertex* vertex, int64_t stop, uint64_t key, int64_t tip, double x,
    double slope,
) noexcept nogil:
    """Lead a piece on along each of the edges before `stop`.

    Args:
        after: The table.
        complete: The paths that are complete.
        vertex: The vertex.
        stop: How many of its edges may be taken.
        key: The state without the piece.
        tip: Slot of the other tip of the piece, or SETTLED_END.
        x: Weight of the state.
        slope: Its derivative.
    """
    cdef int64_t i, slot, code, other
    cdef double gain
    for i in range(stop):
        slot = vertex.reach[i]
        code = _code(key, slot)
        if code == INNER or slot == tip:  # taken, or it would close a cycle
            continue
        gain = vertex.gains[2 * i + (0 if code == UNUSED else 1)]
        other = slot if code == UNUSED else _mate(code)
        _join(after, complete, _taken(key, slot, code), tip, other, x * gain, slope * gain)


cdef void _join(
    States* after, BlockSum* complete, uint64_t key, int64_t tip, int64_t other, double x, double slope
) noexcept nogil:
    """Join a piece between two tips.

    Tips are slots or SETTLED_END; a piece with two settled ends is a complete path and counted.

    Args:
        after: The table.
        complete: The paths that are complete.
        key: The state without the piece.
        tip: One tip.
        other: The other one.
        x: Weight of the state.
        slope: Its derivative.
    """
    if tip == SETTLED_END:
        tip, other = other, tip
    if tip == SETTLED_END:
        if key & OPEN_PIECES == 0:  # a second piece could never be joined to this path
            complete.total += x
            complete.down += slope
        return
    key &= ~(<uint64_t>CODE << 4 * tip)
    if other == SETTLED_END:
        key |= <uint64_t>LOOSE << 4 * tip
    else:
        key &= ~(<uint64_t>CODE << 4 * other)
        key |= <uint64_t>(FIRST_MATE + other) << 4 * tip | <uint64_t>(FIRST_MATE + tip) << 4 * other
    _insert(after, key, x, slope)


cdef inline void _insert(States* states, uint64_t key, double x, double slope) noexcept nogil:
    """Add to the sums of a state, which may be new to the table."""
    cdef uint64_t last = <uint64_t>states.size - 1
    cdef uint64_t at = ((key ^ key >> 32) * SCATTER >> 32) & last
    while states.at[at].key != key:
        if states.at[at].key == NO_STATE:
            states.at[at] = PathState(key, x, slope)
            states.many += 1
            return
        at = (at + 1) & last
    states.at[at].sum += x
    states.at[at].slope += slope
