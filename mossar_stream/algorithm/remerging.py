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

The loop runs until the list is empty, and α and β choose from what it found, so that both can be moved with nothing
computed again: the strength of a key frame is the cost of the merge that removes it, made monotone along the run. The
paper's K + 1 nested sets are `strength >= β`, or the last α key frames removed: see `is_kept`. The paper's form
is in `tools/checks/reference/algorithms.py`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.repetition_labels import ENDS, WITHIN
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.similarity.evidence import CERTAIN
from mossar_stream.similarity.protocol import close, merge_into
from mossar_stream.similarity.protocol import strength as merge_cost

NO_NODE = np.int64(-1)
BEFORE, AFTER, NODE, WAITING, LAST_WAITING = range(5)  # rows of the links
UNKNOWN_BOUNDARY = np.int64(-9)  # identity of a boundary whose cost must not be remembered
MEMO = np.dtype([("key", "i8"), ("cost", "f8")])  # key: the three boundaries of two segments
BOUNDARY_BITS = (
    21  # of each: so many key frames later their numbers come again, and nothing is remembered so long
)
BOUNDARY = (1 << BOUNDARY_BITS) - 1
EMPTY = np.int64(-1)  # no key is negative
DEAREST_MERGE = 1e300  # no cost is above it, and none is NaN: those of key frames that are gone are inf


class Remerging(NamedTuple):
    """What one run of Algorithm 3 works on, for K key frames."""

    params: np.void  # of the similarity measure
    segments: NDArray[np.float64]  # (any, slot) summaries, closed; left alone
    memo: NDArray[np.void]  # MEMO, costs remembered from earlier runs; may be empty
    places: NDArray[np.int64]  # (K + 1,) which segments lie between the key frames; used up
    bounds: NDArray[np.int64]  # (K + 2,) identities of the boundaries: left end, key frames, right end
    nodes: NDArray[np.float64]  # (K + 1, slot) scratch for merged segments
    both: NDArray[np.float64]  # (slot,) scratch for a summary
    links: NDArray[np.int64]  # (5, K + 1) scratch for links between neighbours
    costs: NDArray[np.float64]  # (K,) scratch for the costs of the merges
    strengths: NDArray[np.float64]  # (K,) set to the strength of each key frame
    removed: NDArray[np.int64]  # (K,) set to the key frames in the order in which they are removed
    labels: NDArray[np.int64]  # (K,) on whether each ends a repetition, see repetition_labels.py


@inline_kernel(returns_views=True)
def prepared(params, summaries, memo, scratch, nodes, both):
    """Return what a run needs; `places`, `bounds` and `labels` of the scratch say between which segments."""
    return Remerging(
        params,
        summaries,
        memo,
        scratch.places,
        scratch.bounds,
        nodes,
        both,
        scratch.links,
        scratch.costs,
        scratch.strengths,
        scratch.removed,
        scratch.labels,
    )


@kernel
def remerge(run, count, tempo):
    """Run Algorithm 3 until no key frame is left.

    Similarities that an earlier iteration, or an earlier run, has computed are reused.

    Args:
        run: Remerging.
        count: Number of key frames, K.
        tempo: Costs are divided by this.
    """
    _list_key_frames(run, count)  # line 2
    highest = 0.0
    for step in range(count):  # line 3
        x = _cheapest(run.costs, count)  # lines 6 to 12
        highest = max(highest, run.costs[x] / tempo)
        run.strengths[x] = highest
        run.removed[step] = x
        _remove(run, count, x)  # line 17


@inline_kernel
def is_kept(key, count, alpha, beta):
    """Tell whether the loop would have ended before a key frame is removed (Algorithm 3, lines 4 and 15).

    Args:
        key: With `place`, how many are removed before it, and `strength`.
        count: Number of key frames, K.
        alpha: α, at which the loop ends; 0 for none.
        beta: β, as a strength.
    """
    return (alpha > 0 and count - key.place <= alpha) or not key.strength < beta


@inline_kernel
def _list_key_frames(run, count):
    """Link the key frames with their neighbours and compute the costs of all merges (lines 2 and 9)."""
    links = run.links
    for i in range(count + 1):
        links[BEFORE, i] = i - 1  # the key frames beside each one; -1 and count for none
        links[AFTER, i] = i + 1
        links[NODE, i] = i  # the segment that ends at each key frame, and at the right end
        # Chains of nodes that belong to another one and are not merged into it yet: the next, and the last, of each.
        links[WAITING, i] = NO_NODE
        links[LAST_WAITING, i] = i
    for i in range(count):
        bounds = run.bounds[i], run.bounds[i + 1], run.bounds[i + 2]
        run.costs[i] = _judged(run, i, _cost(run, i, i + 1, bounds))


@kernel
def _cheapest(costs, count):
    x = 0
    for i in range(1, count):
        if costs[i] < costs[x]:
            x = i
    return x


@inline_kernel
def _remove(run, count, x):
    """Remove a key frame, let the segments beside it be one, and compute what merges with that cost."""
    links, costs, bounds = run.links, run.costs, run.bounds
    costs[x] = np.inf
    left, right = links[BEFORE, x], links[AFTER, x]
    merged = links[NODE, x]
    links[WAITING, links[LAST_WAITING, merged]] = links[NODE, right]
    links[LAST_WAITING, merged] = links[LAST_WAITING, links[NODE, right]]
    links[NODE, right] = merged
    links[BEFORE, right] = left
    a, b = bounds[left + 1], bounds[right + 1]
    if right < count:
        later = links[AFTER, right]
        cost = _cost(run, merged, links[NODE, later], (a, b, bounds[later + 1]))
        costs[right] = _judged(run, right, cost)
    if left >= 0:
        links[AFTER, left] = right
        earlier = bounds[links[BEFORE, left] + 1]
        costs[left] = _judged(run, left, _cost(run, links[NODE, left], merged, (earlier, a, b)))


@inline_kernel
def _judged(run, x, cost):
    """Return the cost of a merge as the label of its key frame leaves it; one that cannot be computed is `DEAREST_MERGE`."""
    if not cost < DEAREST_MERGE:
        cost = DEAREST_MERGE
    if run.labels[x] == WITHIN:
        return 0.0
    if run.labels[x] == ENDS:
        return max(cost, CERTAIN)
    return cost


@inline_kernel
def _cost(run, left, right, bounds):
    """Return the cost of a merge, from memory if the same three boundaries were compared before."""
    a, b, c = bounds
    if is_known(run.memo, a, b, c):
        return recall(run.memo, a, b, c)
    return _new_cost(run, left, right, bounds)


@kernel
def _new_cost(run, left, right, bounds):
    """Compute the cost of a merge, and remember it if its boundaries are to stay."""
    _complete(run, left)
    _complete(run, right)
    one = run.nodes[left] if run.places[left] == NO_NODE else run.segments[run.places[left]]
    other = run.nodes[right] if run.places[right] == NO_NODE else run.segments[run.places[right]]
    cost = merge_cost(run.params, one, other, run.both)
    a, b, c = bounds
    if UNKNOWN_BOUNDARY not in (a, c):
        remember(run.memo, a, b, c, cost)
    return cost


@kernel
def _complete(run, own):
    """Merge what belongs to a node into it: not before it is needed, for most costs are remembered.

    Many performers' segments together are more than any cache holds; those that are not looked at cost nothing.
    """
    segments, places, nodes, waiting = run.segments, run.places, run.nodes, run.links[WAITING]
    following = waiting[own]
    if following == NO_NODE:
        return
    merged, first = nodes[own], places[own]
    if first != NO_NODE:
        for d in range(len(merged)):
            merged[d] = segments[first, d]
        places[own] = NO_NODE
    while following != NO_NODE:
        place = places[following]
        merge_into(run.params, merged, nodes[following] if place == NO_NODE else segments[place])
        following = waiting[following]
    close(run.params, merged)
    waiting[own] = NO_NODE
    run.links[LAST_WAITING, own] = own


@kernel
def start_memo(memo):
    """Begin with no cost remembered."""
    for i in range(len(memo)):
        memo[i].key = EMPTY


@inline_kernel
def _memo_place(memo, a, b, c):
    return ((a + 1) * 73856093 ^ (b + 1) * 19349663 ^ (c + 1) * 83492791) & (len(memo) - 1)


@inline_kernel
def _memo_key(a, b, c):
    return (a & BOUNDARY) << 2 * BOUNDARY_BITS | (b & BOUNDARY) << BOUNDARY_BITS | (c & BOUNDARY)


@inline_kernel
def is_known(memo, a, b, c):
    """Tell whether the cost of merging the segments between three boundaries is remembered."""
    if len(memo) == 0:
        return False
    return memo[_memo_place(memo, a, b, c)].key == _memo_key(a, b, c)


@inline_kernel
def recall(memo, a, b, c):
    """Return a cost that is remembered."""
    return memo[_memo_place(memo, a, b, c)].cost


@kernel
def remember(memo, a, b, c, cost):
    """Remember a cost, in place of another one."""
    if len(memo) > 0:
        known = memo[_memo_place(memo, a, b, c)]
        known.key = _memo_key(a, b, c)
        known.cost = cost


@kernel
def forget(memo, left):
    """Forget what is remembered of segments that begin at a boundary."""
    for i in range(len(memo)):
        if memo[i].key >> 2 * BOUNDARY_BITS == left & BOUNDARY:
            memo[i].key = EMPTY
