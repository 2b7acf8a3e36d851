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

cdef enum:
    MOST_EDGES = 64  # a biconnected block of as many edges has no more vertices than an int64 has bits
    FEW_STATES = 2 ** 12  # up to here the sets are so few that they always beat a frontier
    NOTHING = 0
    MOST_STATES = 2 ** 17  # of 17 vertices are 18 MB

cdef struct WeightedGraph:  # A graph as the search goes through it, and what it has summed so far.
    Ints first  # (V + 1,) where each vertex's entries begin in the next two
    Ints neighbour  # (2E,)
    Doubles link  # (2E,) weight of the edge to it
    Doubles weights  # (V,) of the vertices
    Doubles below  # (V,) 1 + weighted paths that leave the vertex into the blocks summed so far


cdef struct Search:  # Tarjan's search: (V,) int64 each, zero before the first component.
    Ints found  # when the vertex was found, from 1
    Ints low  # the earliest one that is reached from below it
    Ints tried  # of its neighbours
    Ints trail  # from the root to where the search is
    Ints waiting  # found, and in no block yet
    Ints place  # in the block that is summed


cdef double path_sum(Doubles vertex_weights, IntRows edges, Doubles edge_weights) noexcept nogil:
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
    cdef int64_t count, v
    cdef WeightedGraph graph
    cdef IntRows places
    cdef Search search
    cdef double total
    cdef Ints first, neighbour
    cdef Doubles link
    # CHECK np.ones: np.ones(count)
    # CHECK np.zeros: np.zeros((6, count), np.int64)
    if edges.rows > MOST_EDGES:
        # CHECK raise ValueError('edges: at most 64 are supported')
    count = vertex_weights.count
    first, neighbour, link = _neighbour_lists(vertex_weights, edges, edge_weights)
    graph = WeightedGraph(first, neighbour, link, vertex_weights, np.ones(count))
    places = np.zeros((6, count), np.int64)
    search = Search(row_of_ints(places, 0), row_of_ints(places, 1), row_of_ints(places, 2), row_of_ints(places, 3), row_of_ints(places, 4), row_of_ints(places, 5))
    total = 0.0
    for v in range(count):
        total += vertex_weights.at[v]
        if search.found.at[v] == 0 and first.at[v] < first.at[v + 1]:
            total += _component_sum(&graph, v, &search)
    return total


cdef double _component_sum(WeightedGraph* graph, int64_t root, Search* search) noexcept nogil:
    """Sum the paths of length >= 1 of one component, block by block as Tarjan's search completes them.

    Args:
        graph: `WeightedGraph`; `below` is brought up to date.
        root: A vertex of the component.
        search: `Search`.
    """
    cdef int64_t clock, depth, held, v, entry, parent, begin, u
    cdef double total, down, within
    cdef Ints first, found, low, tried, trail, waiting
    cdef Doubles weights, below
    first = graph.first
    weights = graph.weights
    below = graph.below
    found = search.found
    low = search.low
    tried = search.tried
    trail = search.trail
    waiting = search.waiting
    found.at[root] = low.at[root] = clock = 1
    trail.at[0] = root
    depth = held = NOTHING
    total = 0.0
    while True:
        v = trail.at[depth]
        entry = first.at[v] + tried.at[v]
        if entry < first.at[v + 1]:
            tried.at[v] += 1
            u = graph.neighbour.at[entry]
            if found.at[u] > 0:
                low.at[v] = min(low.at[v], found.at[u])
            else:
                clock += 1
                found.at[u] = low.at[u] = clock
                depth += 1
                trail.at[depth] = waiting.at[held] = u
                held += 1
            continue
        if depth == 0:
            return total
        depth -= 1
        parent = trail.at[depth]
        low.at[parent] = min(low.at[parent], low.at[v])
        if low.at[v] < found.at[parent]:
            continue
        begin = held - 1  # all that waits since v forms a block with the parent
        while waiting.at[begin] != v:
            begin -= 1
        if begin == held - 1:
            down = graph.link.at[first.at[parent] + tried.at[parent] - 1] * weights.at[v] * below.at[v]
            total += weights.at[parent] * below.at[parent] * down
        else:
            within, down = _graph_block_sum(graph, parent, part_of_ints(waiting, begin, held), search.place)
            total += within
        below.at[parent] += down
        held = begin


cdef (Ints, Ints, Doubles) _neighbour_lists(Doubles vertex_weights, IntRows edges, Doubles edge_weights) noexcept nogil:
    """List the neighbours of each vertex, leaving out the edges on which every path weighs nothing.

    Returns:
        (V + 1,) where each vertex's entries begin, (2E,) neighbours, (2E,) weights of the edges to them.
    """
    cdef int64_t count, many, side, v, e, u
    cdef Ints first, neighbour
    cdef Doubles link
    # CHECK np.zeros: np.zeros(count + 1, np.int64)
    # CHECK np.empty: np.empty(many, np.int64)
    # CHECK np.empty: np.empty(many)
    count = vertex_weights.count
    first = np.zeros(count + 1, np.int64)
    many = 0
    for side in range(2 * edges.rows):
        e = side >> 1
        if edge_weights.at[e] != 0.0 and vertex_weights.at[edges.at[e * edges.columns + 0]] != 0.0 and vertex_weights.at[edges.at[e * edges.columns + 1]] != 0.0:
            first.at[edges.at[e * edges.columns + (side & 1)]] += 1
            many += 1
    for v in range(count):
        first.at[v + 1] += first.at[v]
    neighbour = np.empty(many, np.int64)
    link = np.empty(many)
    for side in range(2 * edges.rows):  # filled from the back, which leaves first[v] at the first entry of v
        e = side >> 1
        u, v = edges.at[e * edges.columns + (side & 1)], edges.at[e * edges.columns + (1 - (side & 1))]
        if edge_weights.at[e] != 0.0 and vertex_weights.at[u] != 0.0 and vertex_weights.at[v] != 0.0:
            first.at[u] -= 1
            neighbour.at[first.at[u]] = v
            link.at[first.at[u]] = edge_weights.at[e]
    return first, neighbour, link


cdef (double, double) _graph_block_sum(WeightedGraph* graph, int64_t parent, Ints others, Ints place) noexcept nogil:
    """Number the vertices of a block, the parent 0, collect the edges between them, and sum its paths.

    Args:
        graph: `WeightedGraph`.
        parent: Vertex of the block nearest the root.
        others: Its other vertices.
        place: (V,) int64, scratch.
    """
    cdef int64_t n, i, v, entry, j
    cdef Ints members, near
    cdef DoubleRows inside
    cdef Doubles inner, ends
    # CHECK np.empty: np.empty(n, np.int64)
    # CHECK np.zeros: np.zeros(n, np.int64)
    # CHECK np.zeros: np.zeros((n, n))
    # CHECK np.empty: np.empty(n)
    n = others.count + 1
    members = np.empty(n, np.int64)
    near = np.zeros(n, np.int64)
    inside = np.zeros((n, n))
    inner = np.empty(n)
    ends = np.empty(n)
    for i in range(n):
        v = others.at[i - 1] if i > 0 else parent
        members.at[i] = v
        place.at[v] = i
        inner.at[i] = graph.weights.at[v]
        ends.at[i] = graph.weights.at[v] * graph.below.at[v]
    for i in range(n):
        v = members.at[i]
        for entry in range(graph.first.at[v], graph.first.at[v + 1]):
            j = place.at[graph.neighbour.at[entry]]
            if j < n and members.at[j] == graph.neighbour.at[entry]:
                near.at[i] |= <int64_t>1 << j
                inside.at[i * inside.columns + j] = graph.link.at[entry]
    return block_sum(near, inside, inner, ends)


cdef (double, double) block_sum(Ints near, DoubleRows link, Doubles inner, Doubles ends) noexcept nogil:
    """Sum the paths of one block, as described in `blocks`, by the method that should cost least.

    Returns:
        The sum over its paths of length >= 1, and the part of it that ends at vertex 0, over ends[0].
    """
    cdef int64_t n, count, width
    cdef IntRows twins
    cdef Ints order
    cdef double states, cost
    # CHECK np.empty: np.empty((4, n), np.int64)
    # CHECK np.empty: np.empty(n, np.int64)
    n = near.count
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
