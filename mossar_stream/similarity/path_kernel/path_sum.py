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

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import kernel
from mossar_stream.similarity.path_kernel.blocks import depth_first_sum, find_twins, subset_sum
from mossar_stream.similarity.path_kernel.frontier import FRONTIER_SLOTS, elimination_order, frontier_sum

MOST_EDGES = 64  # a biconnected block of as many edges has no more vertices than an int64 has bits
FEW_STATES = 2**12  # up to here the sets are so few that they always beat a frontier
NOTHING = np.int64(0)
MOST_STATES = 2**17  # of 17 vertices are 18 MB


class WeightedGraph(NamedTuple):
    """A graph as the search goes through it, and what it has summed so far."""

    first: NDArray[np.int64]  # (V + 1,) where each vertex's entries begin in the next two
    neighbour: NDArray[np.int64]  # (2E,)
    link: NDArray[np.float64]  # (2E,) weight of the edge to it
    weights: NDArray[np.float64]  # (V,) of the vertices
    below: NDArray[np.float64]  # (V,) 1 + weighted paths that leave the vertex into the blocks summed so far


class Search(NamedTuple):
    """Tarjan's search: (V,) int64 each, zero before the first component."""

    found: NDArray[np.int64]  # when the vertex was found, from 1
    low: NDArray[np.int64]  # the earliest one that is reached from below it
    tried: NDArray[np.int64]  # of its neighbours
    trail: NDArray[np.int64]  # from the root to where the search is
    waiting: NDArray[np.int64]  # found, and in no block yet
    place: NDArray[np.int64]  # in the block that is summed


@kernel
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
    graph = WeightedGraph(first, neighbour, link, vertex_weights, np.ones(count))
    places = np.zeros((6, count), np.int64)
    search = Search(places[0], places[1], places[2], places[3], places[4], places[5])
    total = 0.0
    for v in range(count):
        total += vertex_weights[v]
        if search.found[v] == 0 and first[v] < first[v + 1]:
            total += _component_sum(graph, v, search)
    return total


@kernel
def _component_sum(graph, root, search):
    """Sum the paths of length >= 1 of one component, block by block as Tarjan's search completes them.

    Args:
        graph: `WeightedGraph`; `below` is brought up to date.
        root: A vertex of the component.
        search: `Search`.
    """
    first, weights, below = graph.first, graph.weights, graph.below
    found, low, tried, trail, waiting = search.found, search.low, search.tried, search.trail, search.waiting
    found[root] = low[root] = clock = 1
    trail[0] = root
    depth = held = NOTHING
    total = 0.0
    while True:
        v = trail[depth]
        entry = first[v] + tried[v]
        if entry < first[v + 1]:
            tried[v] += 1
            u = graph.neighbour[entry]
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
            down = graph.link[first[parent] + tried[parent] - 1] * weights[v] * below[v]
            total += weights[parent] * below[parent] * down
        else:
            within, down = _graph_block_sum(graph, parent, waiting[begin:held], search.place)
            total += within
        below[parent] += down
        held = begin


@kernel
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


@kernel
def _graph_block_sum(graph, parent, others, place):
    """Number the vertices of a block, the parent 0, collect the edges between them, and sum its paths.

    Args:
        graph: `WeightedGraph`.
        parent: Vertex of the block nearest the root.
        others: Its other vertices.
        place: (V,) int64, scratch.
    """
    n = len(others) + 1
    members = np.empty(n, np.int64)
    near = np.zeros(n, np.int64)
    inside = np.zeros((n, n))
    inner = np.empty(n)
    ends = np.empty(n)
    for i in range(n):
        v = others[i - 1] if i > 0 else parent
        members[i] = v
        place[v] = i
        inner[i] = graph.weights[v]
        ends[i] = graph.weights[v] * graph.below[v]
    for i in range(n):
        v = members[i]
        for entry in range(graph.first[v], graph.first[v + 1]):
            j = place[graph.neighbour[entry]]
            if j < n and members[j] == graph.neighbour[entry]:
                near[i] |= 1 << j
                inside[i, j] = graph.link[entry]
    return block_sum(near, inside, inner, ends)


@kernel
def block_sum(near, link, inner, ends):
    """Sum the paths of one block, as described in `blocks`, by the method that should cost least.

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
