"""Path kernel: the paper's similarity of two segments, by all paths that their graphs share (paper 2.2.1).

    K = Σ over common simple paths of λ^length · Π vertex kernels · Π edge kernels

over the graphs of `graph.pxi`; a path is common if all its joints and edges are, a single joint is a path of length
0, and every undirected path counts once. The sum is exact (`path_sum.pxi`). The edge kernel is the smaller RRJRD
over the larger. Three forms, `kernel_form`:

    damped      vertex kernel 2⟨x,y⟩ / (|x|² + |y|²) on covariances with 1e-4 m² added on the diagonal, λ = 0.1;
                strength sqrt(T_a T_b / (T_a + T_b)) · (1 - K_ab / sqrt(K_aa K_bb)), T durations in s
    normalised  vertex kernel the cosine of the covariances, λ = 1; strength 1 - K_ab / sqrt(K_aa K_bb)
    sum         the same kernels; strength 1 / (1 + K_ab), as the paper compares its raw sums

Where the paper is silent: a joint whose covariance is below 1e-12 m² (a micrometre) does not move; two joints that
do not move are alike (1), one that moves and one that does not are not (0). Poses are weighted by the time they
stand for, and one that stands for no time is left out. A joint that was not seen yet is no vertex (0) and has no edge.
A segment without a duration is no evidence: its strength is 0, as with every measure.

After the fields of `summary.pxi`, a summary has the parts that `set_params` (kernel.py) lays out: sums, lows and highs
of the distances (`graph.pxi`), clock and bins of moments (`pyramid.pxi`), and of a closed segment the covariances of
each joint and the list of edges. TERM is K of the segment with itself.
"""

cdef enum:
    DAMPED = 0
    NORMALISED = 1
    SUM = 2

cdef double AT_REST = 1e-12  # m², norm of a covariance below which a joint does not move


cdef void path_kernel_add_frame(PathKernel* params, Doubles summary, SummaryFrame* frame) noexcept nogil:
    """Add one frame to a summary."""
    cdef int64_t j
    summary.at[FRAMES] += 1.0
    summary.at[MOVING_FRAMES] += frame.moving
    for j in range(frame.joints):
        summary.at[PATH + j] += frame.body.at[place(j) + STEP_BEFORE]
    path_kernel_add_pose(params, summary, frame.pose, frame.time, frame.weight)


cdef void path_kernel_add_pose(
    PathKernel* params, Doubles summary, FloatRows pose, double time, double weight
) noexcept nogil:
    """Add the pose alone: to the duration and the sums, not to frames and paths."""
    if weight > 0.0:
        add_moments(params, summary, pose, time, weight)
        add_distances(params, summary, pose, weight)
        summary.at[DURATION] += weight


cdef void path_kernel_add_joint(
    PathKernel* params, Doubles summary, FloatRows pose, int64_t j
) noexcept nogil:
    """Add a joint to a summary as if it had rested at its present place all the time."""
    if summary.at[DURATION] > 0.0:
        rest_in_moments(params, summary, pose, j)
        rest_in_distances(params, summary, pose, j)


cdef void path_kernel_merge_into(PathKernel* params, Doubles target, Doubles other) noexcept nogil:
    """Make `target` the summary of both segments; neither order nor grouping matters beyond rounding."""
    cdef int64_t d
    target.at[FRAMES] += other.at[FRAMES]
    target.at[MOVING_FRAMES] += other.at[MOVING_FRAMES]
    add_all(target.at + PATH, other.at + PATH, params.joints)
    if other.at[DURATION] == 0.0:
        return
    if target.at[DURATION] == 0.0:
        for d in range(PATH + params.padded_joints, params.size):
            target.at[d] = other.at[d]
    else:
        merge_moments(params, target, other)
        merge_distances(params, target, other)
    target.at[DURATION] += other.at[DURATION]


cdef void path_kernel_close(PathKernel* params, Doubles summary) noexcept nogil:
    """Set the covariances, the edges and, in TERM, the kernel of the segment with itself."""
    summary.at[TERM] = 0.0
    if summary.at[DURATION] > SHORTEST_SEGMENT:
        set_covariances(params, summary)
        set_edges(params, summary)
        if params.form != SUM:
            summary.at[TERM] = _kernel(params, summary, summary)


cdef double path_kernel_strength(PathKernel* params, Doubles left, Doubles right) noexcept nogil:
    """Return the strength of the key frame between two closed neighbours, >= 0."""
    cdef double alike, most, unlike
    if not (left.at[DURATION] > SHORTEST_SEGMENT and right.at[DURATION] > SHORTEST_SEGMENT):
        return 0.0
    alike = _kernel(params, left, right)
    if params.form == SUM:
        return 1.0 / (1.0 + alike)
    most = sqrt(left.at[TERM] * right.at[TERM])
    unlike = max(0.0, 1.0 - alike / most) if most > 0.0 else 0.0  # no joint was seen
    if params.form == NORMALISED:
        return unlike
    return sqrt(left.at[DURATION] * right.at[DURATION] / (left.at[DURATION] + right.at[DURATION])) * unlike


cdef double path_kernel_similarity(
    PathKernel* params, double cost, Doubles left, Doubles right
) noexcept nogil:
    """Return the similarity of a strength, in 0..1: K_ab / sqrt(K_aa K_bb), or K_ab / (1 + K_ab)."""
    cdef double total, scale = 1.0
    if params.form == DAMPED:
        total = left.at[DURATION] + right.at[DURATION]
        scale = sqrt(left.at[DURATION] * right.at[DURATION] / total) if total > 0.0 else 0.0
    return max(0.0, 1.0 - cost / scale) if scale > 0.0 else 1.0


cdef double _kernel(PathKernel* params, Doubles left, Doubles right) noexcept nogil:
    """Return K of two closed segments."""
    cdef double weights[MOST_JOINTS]
    cdef int64_t edges[2 * MOST_EDGES]
    cdef double ratios[MOST_EDGES]
    cdef const double* one = left.at + params.edges_at
    cdef const double* other = right.at + params.edges_at
    cdef double x, y
    cdef int64_t j, pair, a = 0, b = 0, count = 0
    for j in range(params.joints):
        weights[j] = _vertex_kernel(params, left, right, params.covariances_at + j * params.covariance)
    while a < one[0] and b < other[0]:
        pair = <int64_t>min(one[1 + a], other[1 + b])
        if one[1 + a] == other[1 + b]:
            x, y = one[1 + params.edges + a], other[1 + params.edges + b]
            j = pair % params.padded_joints
            edges[2 * count] = j
            edges[2 * count + 1] = (j + pair // params.padded_joints + 1) % params.joints
            ratios[count] = params.decay * min(x, y) / max(x, y)
            count += 1
        a, b = a + (one[1 + a] == pair), b + (other[1 + b] == pair)
    return path_sum(weights, params.joints, edges, ratios, count)


cdef double _vertex_kernel(PathKernel* params, Doubles left, Doubles right, int64_t at) noexcept nogil:
    """Compare the covariances of a joint, whose products are never negative, but NaN where it is missing."""
    cdef double xx = 0.0, yy = 0.0, xy = 0.0, limit = AT_REST * AT_REST
    cdef int64_t d
    for d in range(at, at + params.covariance):
        xx += left.at[d] * left.at[d]
        yy += right.at[d] * right.at[d]
        xy += left.at[d] * right.at[d]
    if not xy >= 0.0:
        return 0.0
    if params.form == DAMPED:
        return 2.0 * xy / (xx + yy)
    if xx <= limit or yy <= limit:
        return 1.0 if xx <= limit and yy <= limit else 0.0
    return max(0.0, xy / sqrt(xx * yy))
