"""The exact weighted sum over all simple paths of a graph: the heart of the path kernel.

The paper (Mossar 2018, sections 2.2.1 and 2.2.2; the kernel is Li and Leung's) compares two motion segments
by all the paths their graphs share. The number of paths grows with the square root of N! for N edges, and the
paper visits them one by one. Their weighted sum needs no such visit:

1. Cut the graph into biconnected blocks (Tarjan 1972). A path passes a cut vertex at most once, so whatever
   hangs below a cut vertex is folded into one factor of that vertex: ``below`` = 1 + weighted paths leaving
   it downwards. Pendant trees are blocks of two vertices and cost one multiplication an edge.
2. Sum each block by the cheapest exact method: go through the sets of vertices a path can cover (Held and
   Karp 1962; small blocks, and those with many vertices that can be swapped) or through the states of a frontier
   (Knuth's Simpath; large sparse blocks). A block too wide for either, which takes far more than 45 edges, is left to
   a visit of every path. So is one for whose states there is no memory.
"""

cdef enum:
    FEW_STATES = 1 << 12  # up to here the sets are so few that they always beat a frontier
    MOST_STATES = 1 << MOST_GROUPS  # of 17 vertices are 18 MB


cdef struct WeightedGraph:  # A graph, and the sums that the search has made so far.
    const double* weights  # (V,) of the vertices
    int64_t first[MOST_JOINTS + 1]  # (V + 1,) where each vertex's entries begin in the next two
    int64_t neighbour[2 * MOST_EDGES]  # (2E,)
    double link[2 * MOST_EDGES]  # (2E,) weight of the edge to it
    double below[MOST_JOINTS]  # (V,) 1 + weighted paths that leave the vertex into the blocks summed so far


cdef struct Search:  # Tarjan's search: (V,) each, zero before the first component.
    int32_t found[MOST_JOINTS]  # when the vertex was found, from 1
    int32_t low[MOST_JOINTS]  # the earliest one that is reached from below it
    int32_t tried[MOST_JOINTS]  # of its neighbours
    int32_t trail[MOST_JOINTS]  # from the root to where the search is
    int32_t waiting[MOST_JOINTS]  # found, and in no block yet
    int32_t rank[MOST_JOINTS]  # in the block that is summed


cdef double path_sum(
    const double* vertex_weights, int64_t count, const int64_t* edges, const double* edge_weights,
    int64_t edge_count,
) noexcept nogil:
    """Sum the products of weights over all simple paths of an undirected graph.

    Computes sum over paths P of prod(vertex weights on P) * prod(edge weights on P), every undirected path
    once and single vertices as paths of length 0: the path kernel of section 2.2.1 of the paper, with the
    vertex and edge kernels as weights. To damp long paths multiply every edge weight by the decay.

    The time is that of the hardest biconnected block: microseconds for the graphs of a skeleton, milliseconds
    for any graph of 45 edges. More edges are summed, too, but the time is exponential in the width of the graph.

    Args:
        vertex_weights: (V,) >= 0.
        count: V <= MOST_JOINTS.
        edges: (E, 2) pairs of different vertices, no pair twice in either direction.
        edge_weights: (E,) >= 0.
        edge_count: E <= MOST_EDGES.

    Returns:
        The sum. Weights of zero take their vertex or edge out of the graph; NaN on any path gives NaN.
    """
    cdef int64_t v
    cdef double total = 0.0
    cdef WeightedGraph graph
    cdef Search search
    graph.weights = vertex_weights
    _list_neighbours(&graph, count, edges, edge_weights, edge_count)
    for v in range(count):
        graph.below[v] = 1.0
        search.found[v] = search.low[v] = search.tried[v] = search.rank[v] = 0
    for v in range(count):
        total += vertex_weights[v]
        if search.found[v] == 0 and graph.first[v] < graph.first[v + 1]:
            total += _component_sum(&graph, v, &search)
    return total


cdef double _component_sum(WeightedGraph* graph, int64_t root, Search* search) noexcept nogil:
    """Sum the paths of length >= 1 of one component, block by block as Tarjan's search completes them.

    Args:
        graph: The graph; `below` is brought up to date.
        root: A vertex of the component.
        search: The search.
    """
    cdef int32_t clock = 1
    cdef int64_t v, u, entry, parent, begin, depth = 0, held = 0
    cdef double down, total = 0.0
    cdef BlockSum within
    search.found[root] = search.low[root] = clock
    search.trail[0] = root
    while True:
        v = search.trail[depth]
        entry = graph.first[v] + search.tried[v]
        if entry < graph.first[v + 1]:
            search.tried[v] += 1
            u = graph.neighbour[entry]
            if search.found[u] > 0:
                search.low[v] = min(search.low[v], search.found[u])
            else:
                clock += 1
                search.found[u] = search.low[u] = clock
                depth += 1
                search.trail[depth] = search.waiting[held] = u
                held += 1
            continue
        if depth == 0:
            return total
        depth -= 1
        parent = search.trail[depth]
        search.low[parent] = min(search.low[parent], search.low[v])
        if search.low[v] < search.found[parent]:
            continue
        begin = held - 1  # all that waits since v forms a block with the parent
        while search.waiting[begin] != v:
            begin -= 1
        if begin == held - 1:
            entry = graph.first[parent] + search.tried[parent] - 1
            down = graph.link[entry] * graph.weights[v] * graph.below[v]
            total += graph.weights[parent] * graph.below[parent] * down
        else:
            within = _graph_block_sum(graph, parent, search.waiting + begin, held - begin, search.rank)
            down = within.down
            total += within.total
        graph.below[parent] += down
        held = begin


cdef void _list_neighbours(
    WeightedGraph* graph, int64_t count, const int64_t* edges, const double* edge_weights, int64_t edge_count
) noexcept nogil:
    """List the neighbours of each vertex, without edges that no path of a weight above 0 takes."""
    cdef int64_t v, e, side, entry
    memset(graph.first, 0, (count + 1) * sizeof(int64_t))
    for e in range(edge_count):
        if _counts(graph, edges + 2 * e, edge_weights[e]):
            graph.first[edges[2 * e]] += 1
            graph.first[edges[2 * e + 1]] += 1
    for v in range(count):
        graph.first[v + 1] += graph.first[v]
    for e in range(edge_count):  # filled from the back, which leaves first[v] at the first entry of v
        if _counts(graph, edges + 2 * e, edge_weights[e]):
            for side in range(2):
                v = edges[2 * e + side]
                graph.first[v] -= 1
                entry = graph.first[v]
                graph.neighbour[entry] = edges[2 * e + 1 - side]
                graph.link[entry] = edge_weights[e]


cdef inline bint _counts(const WeightedGraph* graph, const int64_t* edge, double weight) noexcept nogil:
    """Return whether a path over an edge can have a weight above 0."""
    return weight != 0.0 and graph.weights[edge[0]] != 0.0 and graph.weights[edge[1]] != 0.0


cdef BlockSum _graph_block_sum(
    const WeightedGraph* graph, int64_t parent, const int32_t* others, int64_t count, int32_t* rank
) noexcept nogil:
    """Number the vertices of a block, the parent 0, collect the edges between them, and sum its paths.

    Args:
        graph: The graph.
        parent: Vertex of the block nearest the root.
        others: Its other vertices.
        count: Their number.
        rank: (V,) scratch, zero at first.
    """
    cdef Block block
    cdef int64_t members[MOST_VERTICES]
    cdef int64_t i, j, v, entry, n = count + 1
    block.count = n
    memset(block.near, 0, n * sizeof(uint64_t))
    memset(block.link, 0, n * n * sizeof(double))
    for i in range(n):
        v = others[i - 1] if i > 0 else parent
        members[i] = v
        rank[v] = i
        block.inner[i] = graph.weights[v]
        block.ends[i] = graph.weights[v] * graph.below[v]
    for i in range(n):
        v = members[i]
        for entry in range(graph.first[v], graph.first[v + 1]):
            j = rank[graph.neighbour[entry]]
            if j < n and members[j] == graph.neighbour[entry]:
                block.near[i] |= bit(j)
                block.link[i * n + j] = graph.link[entry]
    return block_sum(&block)


cdef BlockSum block_sum(const Block* block) noexcept nogil:
    """Sum the paths of one block by the method that should cost least."""
    cdef Twins twins
    cdef int64_t order[MOST_VERTICES]
    cdef int64_t width
    cdef double cost
    cdef BlockSum found
    cdef void* room
    find_twins(block, &twins)
    cost, width = INFINITY, 0
    if twins.states > FEW_STATES:
        cost, width = elimination_order(block, order)
    if twins.states <= MOST_STATES and (twins.count * twins.states < 30.0 * cost):  # the factor is measured
        room = malloc(subset_room(&twins))
        if room != NULL:
            found = subset_sum(block, &twins, room)
            free(room)
            return found
    elif width <= FRONTIER_SLOTS and frontier_sum(block, order, &found):
        return found
    return depth_first_sum(block)  # slow but exact
