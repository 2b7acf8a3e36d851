"""Hierarchy: Algorithm 3, the order in which key frames fall when the most similar neighbours are merged.

The strength of a key frame is the cost of the merge that removes it, made monotone along the run, so that every
level of the hierarchy is `strength >= level`: the paper's K + 1 nested sets, with nothing computed again.
"""

import numpy as np

from mossar_stream.compiled import compiled
from mossar_stream.similarity import close, merge_into
from mossar_stream.similarity import strength as merge_cost

UNKNOWN = -9  # identity of a boundary whose cost must not be remembered


@compiled
def fall(params, nodes, count, bounds, memo, tempo, strengths, order):
    """Run Algorithm 3 until no key frame is left.

    Similarities that an earlier iteration, or an earlier call, has computed are reused. On ties the earliest
    key frame falls.

    Args:
        params: Parameters of the similarity measure.
        nodes: (count + 1, slot) summaries of the segments between the key frames, closed; used up.
        count: Number of key frames, K.
        bounds: (count + 2,) identities of the boundaries: left end, key frames, right end.
        memo: Costs remembered from earlier calls; may be empty.
        tempo: Costs are divided by this.
        strengths: (K,) set to the strength of each key frame.
        order: (K,) set to the key frames in the order in which they fall.
    """
    both = np.empty(nodes.shape[1])
    before = np.arange(-1, count - 1)
    after = np.arange(1, count + 1)
    node = np.arange(count)  # the segment that ends at each key frame; the last one is `count`
    costs = np.empty(count)
    for i in range(count):
        costs[i] = _cost(params, nodes[i], nodes[i + 1], bounds[i], bounds[i + 1], bounds[i + 2], memo, both)
    highest = 0.0
    for step in range(count):
        x = _cheapest(costs)
        highest = max(highest, costs[x] / tempo)
        strengths[x] = highest
        order[step] = x
        costs[x] = np.inf
        left, right = before[x], after[x]
        kept = node[x]
        gone = node[right] if right < count else count
        merge_into(params, nodes[kept], nodes[gone])
        close(params, nodes[kept])
        if right < count:
            node[right] = kept
            before[right] = left
        else:
            nodes[count, :] = nodes[kept]
        if left >= 0:
            after[left] = right
            end = bounds[right + 1]
            start = bounds[before[left] + 1]
            last = nodes[kept] if right < count else nodes[count]
            costs[left] = _cost(params, nodes[node[left]], last, start, bounds[left + 1], end, memo, both)
        if right < count:
            follower = nodes[node[after[right]]] if after[right] < count else nodes[count]
            end = bounds[after[right] + 1]
            costs[right] = _cost(
                params, nodes[kept], follower, bounds[left + 1], bounds[right + 1], end, memo, both
            )


@compiled
def _cheapest(costs):
    x = 0
    for i in range(1, len(costs)):
        if costs[i] < costs[x]:
            x = i
    return x


@compiled
def _cost(params, left, right, a, b, c, memo, both):
    """Return the cost of a merge, from memory if the same three boundaries were compared before."""
    if len(memo) == 0 or a == UNKNOWN or c == UNKNOWN:
        return merge_cost(params, left, right, both)
    place = ((a + 1) * 73856093 ^ (b + 1) * 19349663 ^ (c + 1) * 83492791) & (len(memo) - 1)
    known = memo[place]
    if known.left != a or known.middle != b or known.right != c:
        known.left, known.middle, known.right = a, b, c
        known.strength = merge_cost(params, left, right, both)
    return known.strength
