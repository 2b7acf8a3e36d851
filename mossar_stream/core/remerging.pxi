"""Remerging: Algorithm 3 of the paper, the order in which key frames are removed.

    Algorithm 3   Remerging process

     1  procedure remergingLoop()
     2    List ← an initial list of key frames
     3    while List.Count() > 2 do
     4      if List.Count() <= α then TERMINATE
     6      σmax = -1
     7      x = 0
     8      for i = 2; i < List.Count() + 1; i++ do
     9        σ = Similarity(S[i-2, i-1], S[i-1, i])
    10        if σ > σmax then
    11          σmax = σ
    12          x = i - 1
    15      if σmax < β then TERMINATE
    17      List.Remove(x)

The list is taken as k1 … kK without f and l (the printed bounds are off by one), and α counts these. Where the paper
compares similarities σ, merge costs are compared here, the cheapest merge being that of the most similar segments; on
ties the earliest key frame goes.

The loop runs until the list is empty, and α and β choose from its result, so that both can change without another
run: the strength of a key frame is the cost of the merge that removes it, made monotone along the run. The
paper's K + 1 nested sets are `strength >= β`, or the last α key frames removed: see `is_kept`. The paper's form
is in `tools/checks/reference/algorithms.py`.
"""

cdef enum:
    NO_NODE = -1
    UNKNOWN_BOUNDARY = -9  # identity of a boundary whose cost must not be remembered
    BOUNDARY_BITS = 21  # of each: their numbers repeat after so many key frames, and no cost is remembered so long
    BOUNDARY = (1 << BOUNDARY_BITS) - 1
    EMPTY = -1  # no key is negative
cdef double DEAREST_MERGE = 1e+300  # no cost is above it, and none is NaN: those of key frames that are gone are inf

cdef struct Memo:
    int64_t key  # the three boundaries of two segments
    double cost


cdef struct MemoSpan:
    Memo* at
    int64_t count


cdef struct Remerging:  # Data of one run of Algorithm 3, for K key frames.
    Measure* params  # of the similarity measure
    DoubleRows segments  # (any, slot) summaries, closed; unchanged
    MemoSpan memo  # MEMO, costs remembered from earlier runs; may be empty
    Ints places  # (K + 1,) which segments lie between the key frames; used up
    Ints bounds  # (K + 2,) identities of the boundaries: left end, key frames, right end
    DoubleRows nodes  # (K + 1, slot) scratch for merged segments
    Doubles both  # (slot,) scratch for a summary
    # (K + 1,) scratch for links between neighbours:
    int64_t* before  # the key frame before each one, -1 for none,
    int64_t* after  # and the one after it, K for none
    int64_t* node  # the segment that ends at each key frame, and at the right end
    int64_t* waiting  # of each segment the next one to merge into it once its summary is needed
    int64_t* last_waiting  # and the last one of these
    Doubles costs  # (K,) scratch for the costs of the merges
    Doubles strengths  # (K,) set to the strength of each key frame
    Ints removed  # (K,) set to the key frames in the order in which they are removed
    Ints tree  # (K,) scratch for the cheaper key frame of each two neighbours, of each two of these, and so on
    Ints labels  # (K,) on whether each ends a repetition, see repetition_labels.pxi


cdef void remerge(Remerging* run, int64_t count, double tempo) noexcept nogil:
    """Run Algorithm 3 until no key frame is left.

    Similarities that an earlier iteration, or an earlier run, has computed are reused.

    Args:
        run: Remerging.
        count: Number of key frames, K.
        tempo: Costs are divided by this.
    """
    cdef double highest
    cdef int64_t step, x
    _list_key_frames(run, count)  # line 2
    highest = 0.0
    for step in range(count):  # line 3
        x = _cheapest(run, count)  # lines 6 to 12
        highest = max(highest, run.costs.at[x] / tempo)
        run.strengths.at[x] = highest
        run.removed.at[step] = x
        _remove(run, count, x)  # line 17


cdef inline bint is_kept(Key* key, int64_t count, int64_t alpha, double beta) noexcept nogil:
    """Return whether the loop would have ended before a key frame is removed (Algorithm 3, lines 4 and 15).

    Args:
        key: With `place`, how many are removed before it, and `strength`.
        count: Number of key frames, K.
        alpha: α, at which the loop ends; 0 for none.
        beta: β, as a strength.
    """
    return alpha > 0 and count - key.place <= alpha or not key.strength < beta


cdef inline void _list_key_frames(Remerging* run, int64_t count) noexcept nogil:
    """Link the key frames with their neighbours and compute the costs of all merges (lines 2 and 9)."""
    cdef int64_t i
    cdef (int64_t, int64_t, int64_t) bounds
    for i in range(count + 1):
        run.before[i] = i - 1  # the key frames beside each one; -1 and count for none
        run.after[i] = i + 1
        run.node[i] = i  # the segment that ends at each key frame, and at the right end
        # Chains of nodes that belong to another one and are not merged into it yet: the next, and the last, of each.
        run.waiting[i] = NO_NODE
        run.last_waiting[i] = i
    for i in range(count):
        bounds = (run.bounds.at[i], run.bounds.at[i + 1], run.bounds.at[i + 2])
        run.costs.at[i] = _judged(run, i, _cost(run, i, i + 1, bounds))
    _grow_tree(run, count)


cdef inline int64_t _cheapest(Remerging* run, int64_t count) noexcept nogil:
    """Return the key frame with the cheapest merge, the earliest of several, in one step."""
    return run.tree.at[1] if count > 1 else 0


cdef inline void _grow_tree(Remerging* run, int64_t count) noexcept nogil:
    """Compare all key frames, two by two, from the leaves to the root; node i has the children 2 i and 2 i + 1."""
    cdef int64_t i
    for i in range(count - 1, 0, -1):
        run.tree.at[i] = _cheaper(run, count, 2 * i)


cdef inline void _compare_again(Remerging* run, int64_t count, int64_t x) noexcept nogil:
    """Update the tree after the cost of a key frame has changed: as many steps as the tree is high."""
    cdef int64_t i = (x + count) // 2
    while i > 0:
        run.tree.at[i] = _cheaper(run, count, 2 * i)
        i //= 2


cdef inline int64_t _cheaper(Remerging* run, int64_t count, int64_t child) noexcept nogil:
    """Return the cheaper key frame of two neighbours in the tree, the earlier one if they cost the same."""
    cdef int64_t one, other
    one = run.tree.at[child] if child < count else child - count
    other = run.tree.at[child + 1] if child + 1 < count else child + 1 - count
    if run.costs.at[other] < run.costs.at[one]:
        return other
    return min(one, other) if run.costs.at[other] == run.costs.at[one] else one


cdef inline void _remove(Remerging* run, int64_t count, int64_t x) noexcept nogil:
    """Remove a key frame, merge the segments beside it, and compute the costs of merging the result."""
    cdef int64_t merged, left, right, a, b, later, earlier
    cdef Doubles costs
    cdef Ints bounds
    cdef double cost
    costs = run.costs
    bounds = run.bounds
    costs.at[x] = INFINITY
    _compare_again(run, count, x)
    left, right = run.before[x], run.after[x]
    merged = run.node[x]
    run.waiting[run.last_waiting[merged]] = run.node[right]
    run.last_waiting[merged] = run.last_waiting[run.node[right]]
    run.node[right] = merged
    run.before[right] = left
    a, b = bounds.at[left + 1], bounds.at[right + 1]
    if right < count:
        later = run.after[right]
        cost = _cost(run, merged, run.node[later], (a, b, bounds.at[later + 1]))
        costs.at[right] = _judged(run, right, cost)
        _compare_again(run, count, right)
    if left >= 0:
        run.after[left] = right
        earlier = bounds.at[run.before[left] + 1]
        costs.at[left] = _judged(run, left, _cost(run, run.node[left], merged, (earlier, a, b)))
        _compare_again(run, count, left)


cdef inline double _judged(Remerging* run, int64_t x, double cost) noexcept nogil:
    """Return the cost of a merge with the label of its key frame applied; one that cannot be computed is `DEAREST_MERGE`."""
    if not cost < DEAREST_MERGE:
        cost = DEAREST_MERGE
    if run.labels.at[x] == WITHIN:
        return 0.0
    if run.labels.at[x] == ENDS:
        return max(cost, CERTAIN)
    return cost


cdef inline double _cost(
    Remerging* run, int64_t left, int64_t right, (int64_t, int64_t, int64_t) bounds
) noexcept nogil:
    """Return the cost of a merge, from memory if the same three boundaries were compared before."""
    cdef int64_t a, b, c
    a, b, c = bounds
    if is_known(run.memo, a, b, c):
        return recall(run.memo, a, b, c)
    return _new_cost(run, left, right, bounds)


cdef double _new_cost(Remerging* run, int64_t left, int64_t right, (int64_t, int64_t, int64_t) bounds) noexcept nogil:
    """Compute the cost of a merge, and remember it if its boundaries are to stay."""
    cdef double cost
    cdef int64_t a, b, c
    _complete(run, left)
    _complete(run, right)
    cost = strength(run.params, _summary_of(run, left), _summary_of(run, right), run.both)
    a, b, c = bounds
    if UNKNOWN_BOUNDARY not in (a, c):
        remember(run.memo, a, b, c, cost)
    return cost


cdef inline Doubles _summary_of(Remerging* run, int64_t own) noexcept nogil:
    """Return the summary of a segment: its node's if something was merged into it."""
    if run.places.at[own] == NO_NODE:
        return row_of_doubles(run.nodes, own)
    return row_of_doubles(run.segments, run.places.at[own])


cdef void _complete(Remerging* run, int64_t own) noexcept nogil:
    """Merge the waiting segments of a node into it, only when its summary is needed: most costs are remembered.

    Many performers' segments together exceed any cache; unused ones cost nothing.
    """
    cdef int64_t following, first, d
    cdef DoubleRows segments
    cdef Ints places
    cdef Doubles merged
    segments = run.segments
    places = run.places
    following = run.waiting[own]
    if following == NO_NODE:
        return
    merged = row_of_doubles(run.nodes, own)
    first = places.at[own]
    if first != NO_NODE:
        for d in range(merged.count):
            merged.at[d] = segments.at[first * segments.columns + d]
        places.at[own] = NO_NODE
    while following != NO_NODE:
        merge_into(run.params, merged, _summary_of(run, following))
        following = run.waiting[following]
    close(run.params, merged)
    run.waiting[own] = NO_NODE
    run.last_waiting[own] = own


cdef void start_memo(MemoSpan memo) noexcept nogil:
    """Begin with no cost remembered."""
    cdef int64_t i
    for i in range(memo.count):
        memo.at[i].key = EMPTY


cdef inline int64_t _memo_place(MemoSpan memo, int64_t a, int64_t b, int64_t c) noexcept nogil:
    return ((a + 1) * 73856093 ^ (b + 1) * 19349663 ^ (c + 1) * 83492791) & memo.count - 1


cdef inline int64_t _memo_key(int64_t a, int64_t b, int64_t c) noexcept nogil:
    return (a & BOUNDARY) << 2 * BOUNDARY_BITS | (b & BOUNDARY) << BOUNDARY_BITS | c & BOUNDARY


cdef inline bint is_known(MemoSpan memo, int64_t a, int64_t b, int64_t c) noexcept nogil:
    """Return whether the cost of merging the segments between three boundaries is remembered."""
    if memo.count == 0:
        return False
    return memo.at[_memo_place(memo, a, b, c)].key == _memo_key(a, b, c)


cdef inline double recall(MemoSpan memo, int64_t a, int64_t b, int64_t c) noexcept nogil:
    """Return a cost that is remembered."""
    return memo.at[_memo_place(memo, a, b, c)].cost


cdef void remember(MemoSpan memo, int64_t a, int64_t b, int64_t c, double cost) noexcept nogil:
    """Remember a cost, in place of another one."""
    cdef Memo* known
    if memo.count > 0:
        known = &memo.at[_memo_place(memo, a, b, c)]
        known.key = _memo_key(a, b, c)
        known.cost = cost


cdef void remerging_forget(MemoSpan memo, int64_t left) noexcept nogil:
    """Forget the costs of segments that begin at a boundary."""
    cdef int64_t i
    for i in range(memo.count):
        if memo.at[i].key >> 2 * BOUNDARY_BITS == left & BOUNDARY:
            memo.at[i].key = EMPTY
