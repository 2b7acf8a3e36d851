"""The exact weighted sum over all simple paths of a graph: the heart of the path kernel.

The paper (Mossar 2018, sections 2.2.1 and 2.2.2; the kernel is Li and Leung's) compares two motion segments
by all the paths their graphs share. The number of paths grows with the square root of N! for N edges, and the
paper visits them one by one. Their weighted sum needs no such visit:

1. Cut the graph into biconnected blocks (Tarjan 1972). A path passes a cut vertex at most once, so whatever
   hangs below a cut vertex is folded into one factor of that vertex: ``below`` = 1 + weighted paths leaving
   it downwards. Pendant trees are blocks of two vertices and cost one multiplication an edge.
2. Sum each block by the cheapest exact method: go through the sets of vertices a path can cover (Held and
   Karp 1962; small blocks, and those with many vertices that can be swapped) or through the states of a frontier (Knuth's Simpath; large sparse blocks). A
   block too wide for either, which takes far more than 45 edges, is left to a visit of every path.
"""

import numpy as np

from mossar_stream.jit.decorators import compiled
from mossar_stream.similarity.path_kernel.blocks import depth_first_sum, find_twins, subset_sum
from mossar_stream.similarity.path_kernel.frontier import FRONTIER_SLOTS, elimination_order, frontier_sum

MOST_EDGES = 64  # a biconnected block of as many edges has no more vertices than an int64 has bits
FEW_STATES = 2**12  # up to here the sets are so few that they always beat a frontier
NONE = np.int64(0)
MOST_STATES = 2**17  # of 17 vertices are 18 MB


@compiled
def path_sum(vertex_weights, edges, edge_weights):
    """Sum the products of weights over all simple paths of an undirected graph.

    Computes sum over paths P of prod(vertex weights on P) * prod(edge weights on P), every undirected path
    once and single vertices as paths of length 0: the path kernel of section 2.2.1 of the paper, with the
    vertex and edge kernels as weights. To damp long paths multiply every edge weight by the decay.

    The time is that of the hardest biconnected block: microseconds for the graphs of a skeleton, milliseconds
    for any graph of 45 edges. More edges are not refused up to MOST_EDGES, but the time is exponential in the
    width of the graph.

    Args:
        vertex_weights: (V,) float64, >= 0.
        edges: (E, 2) int64, C-contiguous, pairs of different vertices, no pair twice in either direction,
            E <= MOST_EDGES. The caller sees to that.
        edge_weights: (E,) float64, >= 0.

    Returns:
        The sum. Weights of zero take their vertex or edge out of the graph; NaN on any path gives NaN.

    Raises:
        ValueError: More than MOST_EDGES edges.
    """
    if len(edges) > MOST_EDGES:
        raise ValueError("edges: at most 64 are supported")
    count = len(vertex_weights)
    first, neighbour, link = _neighbour_lists(vertex_weights, edges, edge_weights)
    below = np.ones(count)
    scratch = np.zeros((6, count), np.int64)
    total = 0.0
    for v in range(count):
        total += vertex_weights[v]
        if scratch[0, v] == 0 and first[v] < first[v + 1]:
            total += _component_sum(first, neighbour, link, vertex_weights, below, v, scratch)
    return total


@compiled
def _component_sum(first, neighbour, link, vertex_weights, below, root, scratch):
    """Sum the paths of length >= 1 of one component, block by block as Tarjan's search completes them.

    Args:
        first: As `_neighbour_lists` returns it, like the next two.
        neighbour: (2E,).
        link: (2E,).
        vertex_weights: (V,).
        below: (V,), 1 + weighted paths that leave the vertex into the blocks summed so far; brought up to date.
        root: A vertex of the component.
        scratch: (6, V), zero before the first component.
    """
    found, low, tried, trail, waiting = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4]
    found[root] = low[root] = clock = 1
    trail[0] = root
    depth = held = NONE
    total = 0.0
    while True:
        v = trail[depth]
        entry = first[v] + tried[v]
        if entry < first[v + 1]:
            tried[v] += 1
            u = neighbour[entry]
            if found[u] > 0:
                low[v] = min(low[v], found[u])
            else:
                clock += 1
                found[u] = low[u] = clock
                depth += 1
                trail[depth] = waiting[held] = u
                held += 1
            continue
        if depth == 0:
            return total
        depth -= 1
        parent = trail[depth]
        low[parent] = min(low[parent], low[v])
        if low[v] < found[parent]:
            continue
        begin = held - 1  # all that waits since v forms a block with the parent
        while waiting[begin] != v:
            begin -= 1
        if begin == held - 1:
            down = link[first[parent] + tried[parent] - 1] * vertex_weights[v] * below[v]
            total += vertex_weights[parent] * below[parent] * down
        else:
            within, down = _graph_block_sum(
                first, neighbour, link, vertex_weights, below, parent, waiting, begin, held, scratch[5]
            )
            total += within
        below[parent] += down
        held = begin


@compiled
def _neighbour_lists(vertex_weights, edges, edge_weights):
    """List the neighbours of each vertex, leaving out the edges on which every path weighs nothing.

    Returns:
        (V + 1,) where each vertex's entries begin, (2E,) neighbours, (2E,) weights of the edges to them.
    """
    count = len(vertex_weights)
    first = np.zeros(count + 1, np.int64)
    many = 0
    for side in range(2 * len(edges)):
        e = side >> 1
        if (
            edge_weights[e] != 0.0
            and vertex_weights[edges[e, 0]] != 0.0
            and vertex_weights[edges[e, 1]] != 0.0
        ):
            first[edges[e, side & 1]] += 1
            many += 1
    for v in range(count):
        first[v + 1] += first[v]
    neighbour = np.empty(many, np.int64)
    link = np.empty(many)
    for side in range(2 * len(edges)):  # filled from the back, which leaves first[v] at the first entry of v
        e = side >> 1
        u, v = edges[e, side & 1], edges[e, 1 - (side & 1)]
        if edge_weights[e] != 0.0 and vertex_weights[u] != 0.0 and vertex_weights[v] != 0.0:
            first[u] -= 1
            neighbour[first[u]] = v
            link[first[u]] = edge_weights[e]
    return first, neighbour, link


@compiled
def _graph_block_sum(first, neighbour, link, vertex_weights, below, parent, waiting, begin, held, place):
    """Number the vertices of a block, the parent 0, collect the edges between them, and sum its paths.

    Args:
        first: As `_neighbour_lists` returns it, like the next two.
        neighbour: (2E,).
        link: (2E,).
        vertex_weights: (V,).
        below: (V,) as in `_component_sum`.
        parent: Vertex of the block nearest the root.
        waiting: Holds its other vertices from `begin` to `held`.
        begin: See there.
        held: See there.
        place: (V,) int64, scratch.
    """
    n = held - begin + 1
    members = np.empty(n, np.int64)
    near = np.zeros(n, np.int64)
    inside = np.zeros((n, n))
    inner = np.empty(n)
    ends = np.empty(n)
    for i in range(n):
        v = waiting[begin + i - 1] if i > 0 else parent
        members[i] = v
        place[v] = i
        inner[i] = vertex_weights[v]
        ends[i] = vertex_weights[v] * below[v]
    for i in range(n):
        v = members[i]
        for entry in range(first[v], first[v + 1]):
            j = place[neighbour[entry]]
            if j < n and members[j] == neighbour[entry]:
                near[i] |= 1 << j
                inside[i, j] = link[entry]
    return block_sum(near, inside, inner, ends)


@compiled
def block_sum(near, link, inner, ends):
    """Sum the paths of one block, as described in `path_blocks`, by the method that should cost least.

    Returns:
        The sum over its paths of length >= 1, and the part of it that ends at vertex 0, over ends[0].
    """
    n = len(near)
    twins = np.empty((4, n), np.int64)
    count, states = find_twins(near, link, inner, ends, twins)
    if states <= FEW_STATES:
        return subset_sum(link, inner, ends, twins, count)
    order = np.empty(n, np.int64)
    cost, width = elimination_order(near, order)
    if states <= MOST_STATES and count * states < 30.0 * cost:  # the factor is measured
        return subset_sum(link, inner, ends, twins, count)
    if width <= FRONTIER_SLOTS:
        return frontier_sum(near, link, inner, ends, order)
    return depth_first_sum(near, link, inner, ends)  # slow but exact; 45 edges are too few to come here
