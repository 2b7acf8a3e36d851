"""Hierarchy: Algorithm 3, the order in which key frames fall when the most similar neighbours are merged.

The strength of a key frame is the cost of the merge that removes it, made monotone along the run, so that every
level of the hierarchy is `strength >= level`: the paper's K + 1 nested sets, with nothing computed again.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.similarity.protocol import close, merge_into
from mossar_stream.similarity.protocol import strength as merge_cost

NONE = np.int64(-1)
WAITING, NEWEST = 3, 4  # rows of the links
UNKNOWN = np.int64(-9)  # identity of a boundary whose cost must not be remembered


@kernel
def fall(params, segments, places, nodes, count, bounds, memo, both, links, costs, tempo, strengths, order):
    """Run Algorithm 3 until no key frame is left.

    Similarities that an earlier iteration, or an earlier call, has computed are reused. On ties the earliest
    key frame falls.

    Args:
        params: Parameters of the similarity measure.
        segments: (any, slot) summaries, closed; left alone.
        places: (count + 1,) which of them lie between the key frames; used up.
        nodes: (count + 1, slot) room for merged ones.
        count: Number of key frames, K.
        bounds: (count + 2,) identities of the boundaries: left end, key frames, right end.
        memo: Costs remembered from earlier calls; may be empty.
        both: (slot,) room for a summary.
        links: (5, count + 1) int64, room for links between neighbours.
        costs: (count,) room for the costs of the merges.
        tempo: Costs are divided by this.
        strengths: (K,) set to the strength of each key frame.
        order: (K,) set to the key frames in the order in which they fall.
    """
    before, after = links[0], links[1]  # key frames beside each one; -1 and count for none
    node = links[2]  # the segment that ends at each key frame, and at the right end
    # Chains of nodes that belong to another one and are not merged into it yet: the next, and the last, of each.
    waiting, newest = links[WAITING], links[NEWEST]
    for i in range(count + 1):
        before[i] = i - 1
        after[i] = i + 1
        node[i] = newest[i] = i
        waiting[i] = NONE
    for i in range(count):
        a, b, c = bounds[i], bounds[i + 1], bounds[i + 2]
        costs[i] = _cost(params, segments, places, nodes, links, i, i + 1, a, b, c, memo, both)
    highest = 0.0
    for step in range(count):
        x = _cheapest(costs, count)
        highest = max(highest, costs[x] / tempo)
        strengths[x] = highest
        order[step] = x
        costs[x] = np.inf
        left, right = before[x], after[x]
        merged = node[x]
        waiting[newest[merged]] = node[right]
        newest[merged] = newest[node[right]]
        node[right] = merged
        before[right] = left
        a, b = bounds[left + 1], bounds[right + 1]
        if right < count:
            later = node[after[right]]
            c = bounds[after[right] + 1]
            costs[right] = _cost(params, segments, places, nodes, links, merged, later, a, b, c, memo, both)
        if left >= 0:
            after[left] = right
            earlier = node[left]
            c = bounds[before[left] + 1]
            costs[left] = _cost(params, segments, places, nodes, links, earlier, merged, c, a, b, memo, both)


@kernel
def _cheapest(costs, count):
    x = 0
    for i in range(1, count):
        if costs[i] < costs[x]:
            x = i
    return x


@inline_kernel
def _cost(params, segments, places, nodes, links, left, right, a, b, c, memo, both):
    """Return the cost of a merge, from memory if the same three boundaries were compared before."""
    if is_known(memo, a, b, c):
        return recall(memo, a, b, c)
    return _new_cost(params, segments, places, nodes, links, left, right, a, b, c, memo, both)


@kernel
def _new_cost(params, segments, places, nodes, links, left, right, a, b, c, memo, both):
    """Compute the cost of a merge, and remember it if its boundaries are to stay."""
    _complete(params, segments, places, nodes, links, left)
    _complete(params, segments, places, nodes, links, right)
    one = nodes[left] if places[left] == NONE else segments[places[left]]
    other = nodes[right] if places[right] == NONE else segments[places[right]]
    cost = merge_cost(params, one, other, both)
    if UNKNOWN not in (a, c):
        remember(memo, a, b, c, cost)
    return cost


@kernel
def _complete(params, segments, places, nodes, links, own):
    """Merge what belongs to a node into it: not before it is needed, for most costs are remembered.

    Many performers' segments together are more than any cache holds; those that are not looked at cost nothing.
    """
    waiting = links[WAITING]
    following = waiting[own]
    if following == NONE:
        return
    merged = nodes[own]
    if places[own] != NONE:
        for d in range(len(merged)):
            merged[d] = segments[places[own], d]
        places[own] = NONE
    while following != NONE:
        place = places[following]
        merge_into(params, merged, nodes[following] if place == NONE else segments[place])
        following = waiting[following]
    close(params, merged)
    waiting[own] = NONE
    links[NEWEST, own] = own


@inline_kernel
def _memo_place(memo, a, b, c):
    return ((a + 1) * 73856093 ^ (b + 1) * 19349663 ^ (c + 1) * 83492791) & (len(memo) - 1)


@inline_kernel
def is_known(memo, a, b, c):
    """Tell whether the cost of merging the segments between three boundaries is remembered."""
    if len(memo) == 0:
        return False
    known = memo[_memo_place(memo, a, b, c)]
    return known.left == a and known.middle == b and known.right == c


@inline_kernel
def recall(memo, a, b, c):
    """Return a cost that is remembered."""
    return memo[_memo_place(memo, a, b, c)].strength


@kernel
def remember(memo, a, b, c, cost):
    """Remember a cost, in place of another one."""
    if len(memo) > 0:
        known = memo[_memo_place(memo, a, b, c)]
        known.left, known.middle, known.right = a, b, c
        known.strength = cost


@kernel
def forget(memo, left):
    """Forget what is remembered of segments that begin at a boundary."""
    for i in range(len(memo)):
        if memo[i].left == left:
            memo[i].middle = UNKNOWN
