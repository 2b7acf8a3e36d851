"""Path kernel: the paper's similarity of two segments, by all paths that their graphs share (paper 2.2.1).

    K = Σ over common simple paths of λ^length · Π vertex kernels · Π edge kernels

over the graphs of `graph.py`; a path is common if all its joints and edges are, a single joint is a path of length
0, and every undirected path counts once. The sum is exact (`path_sum.py`). The edge kernel is the smaller RRJRD
over the larger. Three forms, `kernel_form`:

    damped      vertex kernel 2⟨x,y⟩ / (|x|² + |y|²) on covariances with 1e-4 m² added on the diagonal, λ = 0.1;
                strength sqrt(T_a T_b / (T_a + T_b)) · (1 - K_ab / sqrt(K_aa K_bb)), T durations in s
    normalised  vertex kernel the cosine of the covariances, λ = 1; strength 1 - K_ab / sqrt(K_aa K_bb)
    sum         the same kernels; strength 1 / (1 + K_ab), as the paper compares its raw sums

Where the paper is silent: a joint whose covariance is below 1e-12 m² (a micrometre) does not move; two joints that
do not move are alike (1), one that moves and one that does not are not (0). Poses are weighted by the time they
stand for, and one that stands for no time is left out. A joint that was not seen yet is no vertex (0) and has no edge. A segment that lasts no time says nothing: its strength is
0, as with every measure.

A summary goes on, after the fields of `summary.py`, with what `make_params` lays out: sums, lows and highs of the
distances (`graph.py`), clock and bins of moments (`pyramid.py`), and of a closed segment the covariances of each
joint and the list of edges. TERM is K of the segment with itself.
"""

cdef enum:
    DAMPED = 0
    NORMALISED = 1
    SUM = 2
cdef double DECAY = 0.1  # λ of the damped form
cdef double DIAGONAL = 0.0001  # m², added to the variances in the damped form
cdef double AT_REST = 1e-12  # m², norm of a covariance below which a joint does not move

cdef struct PathKernel:
    int64_t joints
    int64_t padded_joints
    int64_t rows  # offsets k of the joint pairs (i, i + k mod J)
    int64_t pairs  # rows · padded joints
    int64_t edges  # N
    int64_t layers  # L
    int64_t form  # index into FORMS
    double decay  # λ
    double diagonal  # m²
    int64_t bins
    int64_t bin_size
    int64_t covariance  # length of a joint's covariances, 6 s
    int64_t distances_at  # where the parts of a summary begin
    int64_t clock_at
    int64_t bins_at
    int64_t covariances_at
    int64_t edges_at
    int64_t size  # of a summary


cdef void path_kernel_write_features(PathKernel* params, Doubles summary, Features features) noexcept nogil:
    """Leave out what is known of a key frame: the path kernel asks for segments only."""


cdef void path_kernel_add_frame(PathKernel* params, Doubles summary, SummaryFrame* frame) noexcept nogil:
    """Add one frame to a summary.

    Args:
        params: Record of `make_params`.
        summary: Of the segment so far.
        frame: `SummaryFrame`.
    """
    cdef int64_t j
    # CHECK call of _add: _add(params, summary, frame.pose, frame.time, frame.weight)
    summary.at[FRAMES] += 1.0
    summary.at[MOVING_FRAMES] += frame.moving
    for j in range(frame.joints):
        summary.at[PATH + j] += frame.body.at[place(j) + STEP_BEFORE]
    _add(params, summary, frame.pose, frame.time, frame.weight)


cdef void path_kernel_add_pose(PathKernel* params, Doubles summary, FloatRows pose, int64_t joints, double time, double weight) noexcept nogil:
    """Add the pose alone: to the duration and the sums, not to frames and paths."""
    # CHECK call of _add: _add(params, summary, pose, time, weight)
    _add(params, summary, pose, time, weight)


cdef void path_kernel_add_joint(PathKernel* params, Doubles summary, FloatRows pose, int64_t joints, int64_t j) noexcept nogil:
    """Let a joint have rest where it is for as long as a summary lasts."""
    if summary.at[DURATION] > 0.0:
        rest_in_moments(params, summary, pose, j)
        rest_in_distances(params, summary, pose, j)


cdef void path_kernel_flush_sums(PathKernel* params, Doubles summary, Floats body, int64_t padded_joints) noexcept nogil:
    """Do nothing; every frame went into its summary at once."""


cdef void path_kernel_merge_into(PathKernel* params, Doubles target, Doubles other) noexcept nogil:
    """Make `target` the summary of both segments; neither order nor grouping matters beyond rounding."""
    # CHECK call of _merge: _merge(params, target, other)
    _merge(params, target, other)


cdef void path_kernel_close(PathKernel* params, Doubles summary) noexcept nogil:
    """Set the covariances, the edges and, in TERM, the kernel of the segment with itself."""
    # CHECK call of _close: _close(params, summary)
    _close(params, summary)


cdef double path_kernel_strength(PathKernel* params, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the strength of the key frame between two closed neighbours, >= 0; `both` is left alone."""
    # CHECK call of _strength: _strength(params, left, right)
    return _strength(params, left, right)


cdef double path_kernel_merge_cost(PathKernel* params, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the same; `both` is not looked at."""
    # CHECK call of _strength: _strength(params, left, right)
    return _strength(params, left, right)


cdef double path_kernel_similarity(PathKernel* params, double cost, Doubles left, Doubles right) noexcept nogil:
    """Return what the strength says of the kernel, in 0..1: K_ab / sqrt(K_aa K_bb), or K_ab / (1 + K_ab)."""
    cdef double scale, total
    scale = 1.0
    if params.form == DAMPED:
        total = left.at[DURATION] + right.at[DURATION]
        scale = sqrt(left.at[DURATION] * right.at[DURATION] / total) if total > 0.0 else 0.0
    return max(0.0, 1.0 - cost / scale) if scale > 0.0 else 1.0


cdef double _kernel(PathKernel* params, Doubles left, Doubles right) noexcept nogil:
    """Return K of two closed segments."""
    cdef Doubles weights, ratios
    cdef int64_t j, at, count, a, b, pair, other, joint
    cdef IntRows edges
    cdef double one, two
    # CHECK sign (C truncates): pair % params.padded_joints; pair // params.padded_joints; (joint + pair // params.padded_joints + 1) % params.joints
    # CHECK np.empty: np.empty(params.joints)
    # CHECK np.empty: np.empty((params.edges, 2), np.int64)
    # CHECK np.empty: np.empty(params.edges)
    weights = np.empty(params.joints)
    for j in range(params.joints):
        weights.at[j] = _vertex_kernel(params, left, right, params.covariances_at + j * params.covariance)
    edges = np.empty((params.edges, 2), np.int64)
    ratios = np.empty(params.edges)
    at = params.edges_at
    count = a = b = 0
    while a < left.at[at] and b < right.at[at]:
        pair = <int64_t>left.at[at + 1 + a]
        other = <int64_t>right.at[at + 1 + b]
        if pair == other:
            one, two = left.at[at + 1 + params.edges + a], right.at[at + 1 + params.edges + b]
            joint = pair % params.padded_joints
            edges.at[count * edges.columns + 0] = joint
            edges.at[count * edges.columns + 1] = (joint + pair // params.padded_joints + 1) % params.joints
            ratios.at[count] = params.decay * min(one, two) / max(one, two)
            count += 1
        a += 1 if pair <= other else 0
        b += 1 if other <= pair else 0
    return path_sum(weights, rows_of_ints(edges, 0, count), part_of_doubles(ratios, 0, count))


cdef double _vertex_kernel(PathKernel* params, Doubles left, Doubles right, int64_t at) noexcept nogil:
    """Compare the covariances of a joint; the products of covariances are never negative, but NaN where it is missing."""
    cdef double xx, yy, xy, limit
    cdef int64_t d
    xx = yy = xy = 0.0
    for d in range(at, at + params.covariance):
        xx += left.at[d] * left.at[d]
        yy += right.at[d] * right.at[d]
        xy += left.at[d] * right.at[d]
    if not xy >= 0.0:
        return 0.0
    if params.form == DAMPED:
        return 2.0 * xy / (xx + yy)
    limit = AT_REST * AT_REST
    if xx <= limit or yy <= limit:
        return 1.0 if xx <= limit and yy <= limit else 0.0
    return max(0.0, xy / sqrt(xx * yy))
