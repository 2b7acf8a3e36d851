"""Segment graph: a segment as the paper's path kernel compares it (paper 2.2.1).

Vertices are the joints, each with its Temporal Pyramid Covariance (`pyramid.pxi`). Edges are the N joint pairs
whose distance d changes most, by the relative range of joint relative distance

    RRJRD = (max d - min d) / mean d

over the segment. Both follow from sums that merge, so that no frame is kept.

Where the paper is silent: a pair whose distance changes by less than 10 µm, or whose joints lie less than 1 mm apart on
average, is no edge, because its range would be rounding; a segment may therefore have fewer than N edges. RRJRD is
rounded to 1e-9, and ties go to the earlier pair. The choice between pairs that move alike, such as those of mirrored or
coinciding joints, therefore does not depend on the order of merges.
"""

cdef enum:
    MOST_EDGES = 64  # a biconnected block of as many edges has no more vertices than a set of 64 bits

cdef double STILL = 1e-5  # m; float32 coordinates some metres from the origin are no finer
cdef double COINCIDENT = 1e-3  # m
cdef double PRECISION = 1e9  # steps of RRJRD per 1


cdef void add_distances(PathKernel* params, Doubles summary, FloatRows pose, double weight) noexcept nogil:
    """Add the distances of all joint pairs (i, i + k mod J), k = 1 … J/2, before the summary's duration.

    Rows of equal k over coordinates that are stored twice: contiguous, without index lists, so that it
    vectorises. The places of padding joints are never read.

    Args:
        params: Of the measure.
        summary: Of the segment.
        pose: (4, padded joints), of which 3 rows are coordinates, m; x is NaN where a joint does not count.
        weight: s, > 0.
    """
    cdef double x[2 * MOST_JOINTS]
    cdef double y[2 * MOST_JOINTS]
    cdef double z[2 * MOST_JOINTS]
    cdef double far[MOST_JOINTS]
    cdef double dx, dy, dz
    cdef double* total = summary.at + params.distances_at
    cdef double* low = total + params.pairs
    cdef double* high = low + params.pairs
    cdef int64_t row, d, i, k, padded_joints = params.padded_joints
    _store_twice(x, pose.at, params)
    _store_twice(y, pose.at + pose.columns, params)
    _store_twice(z, pose.at + 2 * pose.columns, params)
    if summary.at[DURATION] == 0.0:
        for d in range(params.pairs):
            low[d] = INFINITY
            high[d] = -INFINITY
    for row in range(params.rows):
        k = row + 1
        for i in range(padded_joints):
            dx, dy, dz = x[k + i] - x[i], y[k + i] - y[i], z[k + i] - z[i]
            far[i] = sqrt(dx * dx + dy * dy + dz * dz)
        for i in range(padded_joints):
            total[i] += weight * far[i]
            low[i] = min(low[i], far[i])
            high[i] = max(high[i], far[i])
        total, low, high = total + padded_joints, low + padded_joints, high + padded_joints


cdef inline void _store_twice(double* goal, const float* line, PathKernel* params) noexcept nogil:
    """Set (2 * padded joints,) numbers to those of all joints, then those of all joints again, then 0."""
    cdef int64_t j
    for j in range(params.joints):
        goal[j] = goal[params.joints + j] = line[j]
    for j in range(2 * params.joints, 2 * params.padded_joints):
        goal[j] = 0.0


cdef void rest_in_distances(PathKernel* params, Doubles summary, FloatRows pose, int64_t j) noexcept nogil:
    """Add the present distances of a joint to a summary, not empty, as if they had been the same all the time."""
    cdef int64_t row, k, side, i, pair, joints = params.joints
    cdef float far
    for row in range(params.rows):
        k = row + 1
        for side in range(2):  # the pair that begins with the joint, and the one that ends with it
            i = j if side == 0 else (j - k + joints) % joints
            pair = params.distances_at + row * params.padded_joints + i
            far = pose_distance(pose, i, (i + k) % joints)
            summary.at[pair] = summary.at[DURATION] * far
            summary.at[pair + params.pairs] = summary.at[pair + 2 * params.pairs] = far


cdef void merge_distances(PathKernel* params, Doubles target, Doubles other) noexcept nogil:
    """Add the distances of another segment; neither summary is empty."""
    cdef int64_t d, at = params.distances_at, size = params.pairs
    for d in range(at, at + size):
        target.at[d] += other.at[d]
    for d in range(at + size, at + 2 * size):
        target.at[d] = min(target.at[d], other.at[d])
    for d in range(at + 2 * size, at + 3 * size):
        target.at[d] = max(target.at[d], other.at[d])


cdef inline double _relative_range(PathKernel* params, Doubles summary, int64_t pair) noexcept nogil:
    """Return the RRJRD of a pair, 0 if it can be no edge."""
    cdef int64_t at = params.distances_at + pair
    cdef double low = summary.at[at + params.pairs], high = summary.at[at + 2 * params.pairs]
    cdef double mean = summary.at[at] / summary.at[DURATION]
    if not (high - low >= STILL and mean >= COINCIDENT):  # NaN where one of the two was not seen yet
        return 0.0
    return rint((high - low) / mean * PRECISION) / PRECISION


cdef void set_edges(PathKernel* params, Doubles summary) noexcept nogil:
    """Set the list of edges: their number, then pairs in increasing order, then their RRJRD."""
    cdef double ranges[MOST_EDGES]  # the largest so far, in decreasing order; of equal ones the earlier pair first
    cdef int64_t pairs[MOST_EDGES]  # whose they are
    cdef int64_t row, i, pair, rank, count = 0, joints = params.joints
    cdef double own
    cdef double* goal = summary.at + params.edges_at
    for row in range(params.rows):
        # The last row of an even number of joints holds each of its pairs twice.
        for i in range(joints if 2 * (row + 1) < joints else joints // 2):
            pair = row * params.padded_joints + i
            own = _relative_range(params, summary, pair)
            if not own > 0.0 or (count == params.edges and not own > ranges[count - 1]):
                continue
            rank = count if count < params.edges else count - 1
            count = rank + 1
            while rank > 0 and ranges[rank - 1] < own:
                ranges[rank], pairs[rank] = ranges[rank - 1], pairs[rank - 1]
                rank -= 1
            ranges[rank], pairs[rank] = own, pair
    for i in range(1, count):  # by their pairs
        own, pair, rank = ranges[i], pairs[i], i
        while rank > 0 and pairs[rank - 1] > pair:
            ranges[rank], pairs[rank] = ranges[rank - 1], pairs[rank - 1]
            rank -= 1
        ranges[rank], pairs[rank] = own, pair
    goal[0] = count
    for i in range(count):
        goal[1 + i] = pairs[i]
        goal[1 + params.edges + i] = ranges[i]
