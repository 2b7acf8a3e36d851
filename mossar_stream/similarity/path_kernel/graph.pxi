"""Segment graph: what the paper's path kernel sees of a segment (paper 2.2.1).

Vertices are the joints, each with its Temporal Pyramid Covariance (`pyramid.py`). Edges are the N joint pairs
whose distance d changes most, by the relative range of joint relative distance

    RRJRD = (max d - min d) / mean d

over the segment. Both follow from sums that merge, so that no frame is kept.

Where the paper is silent: a pair whose distance changes by less than 10 µm, or whose joints lie less than 1 mm apart on
average, is no edge, because what it would say is rounding; a segment may therefore have fewer than N edges. RRJRD is
rounded to 1e-9, and ties go to the earlier pair. So pairs that move alike, as those of mirrored or coinciding joints
do, are chosen alike whatever the order of merges.
"""

cdef double STILL = 1e-05  # m; float32 coordinates some metres from the origin are no finer
cdef double COINCIDENT = 0.001  # m
cdef double PRECISION = 1000000000.0  # steps of RRJRD per 1


cdef void add_distances(PathKernel* params, Doubles summary, FloatRows pose, double weight) noexcept nogil:
    """Add the distances of all joint pairs (i, i + k mod J), k = 1 … J/2, before the summary's duration.

    Rows of equal k over coordinates that are stored twice: contiguous, without index lists, so that it
    vectorises. What stands in the place of padding joints is never read.

    Args:
        params: Record of `kernel.make_params`.
        summary: Summary.
        pose: (4, padded joints), of which 3 rows are coordinates, m; x is NaN where a joint does not count.
        weight: s, > 0.
    """
    cdef DoubleRows twice
    cdef int64_t axis, row, at, d, padded_joints, size, j, k, i
    cdef Doubles far, own, total, low, high, x, y, z
    cdef double dx, dy, dz
    # CHECK np.zeros: np.zeros((3, 2 * padded_joints))
    # CHECK np.empty: np.empty(size)
    padded_joints, size = params.padded_joints, params.pairs
    twice = np.zeros((3, 2 * padded_joints))
    for axis in range(3):
        for j in range(params.joints):
            twice.at[axis * twice.columns + j] = pose.at[axis * pose.columns + j]
            twice.at[axis * twice.columns + (params.joints + j)] = pose.at[axis * pose.columns + j]
    far = np.empty(size)
    for row in range(params.rows):
        k = row + 1
        x = part_of_doubles(row_of_doubles(twice, 0), k, k + padded_joints)
        y = part_of_doubles(row_of_doubles(twice, 1), k, k + padded_joints)
        z = part_of_doubles(row_of_doubles(twice, 2), k, k + padded_joints)
        own = part_of_doubles(far, row * padded_joints, k * padded_joints)
        for i in range(padded_joints):
            dx, dy, dz = x.at[i] - twice.at[i], y.at[i] - twice.at[1 * twice.columns + i], z.at[i] - twice.at[2 * twice.columns + i]
            own.at[i] = sqrt(dx * dx + dy * dy + dz * dz)
    at = params.distances_at
    total = part_of_doubles(summary, at, at + size)
    low = part_of_doubles(summary, at + size, at + 2 * size)
    high = part_of_doubles(summary, at + 2 * size, at + 3 * size)
    if summary.at[DURATION] == 0.0:
        for d in range(size):
            low.at[d] = INFINITY
            high.at[d] = -INFINITY
    for d in range(size):
        total.at[d] += weight * far.at[d]
        low.at[d] = min(low.at[d], far.at[d])
        high.at[d] = max(high.at[d], far.at[d])


cdef void rest_in_distances(PathKernel* params, Doubles summary, FloatRows pose, int64_t j) noexcept nogil:
    """Let the distances of a joint have been as they are for as long as a summary lasts, which is not empty."""
    cdef int64_t row, joints, at, size, k, i, other, pair
    cdef float far, x, y, z
    # CHECK sign (C truncates): (j - k) % joints; (i + k) % joints
    # CHECK loop over (j, (j - k) % joints)
    joints, at, size = params.joints, params.distances_at, params.pairs
    for row in range(params.rows):
        k = row + 1
        for i in (j, (j - k) % joints):
            other = (i + k) % joints
            x, y, z = pose.at[i] - pose.at[other], pose.at[1 * pose.columns + i] - pose.at[1 * pose.columns + other], pose.at[2 * pose.columns + i] - pose.at[2 * pose.columns + other]
            pair = at + row * params.padded_joints + i
            far = sqrtf(x * x + y * y + z * z)
            summary.at[pair] = summary.at[DURATION] * far
            summary.at[pair + size] = summary.at[pair + 2 * size] = far


cdef void merge_distances(PathKernel* params, Doubles target, Doubles other) noexcept nogil:
    """Add the distances of another segment; neither summary is empty."""
    cdef int64_t d, at, size
    at, size = params.distances_at, params.pairs
    for d in range(at, at + size):
        target.at[d] += other.at[d]
    for d in range(at + size, at + 2 * size):
        target.at[d] = min(target.at[d], other.at[d])
    for d in range(at + 2 * size, at + 3 * size):
        target.at[d] = max(target.at[d], other.at[d])


cdef double _relative_range(PathKernel* params, Doubles summary, int64_t pair) noexcept nogil:
    """Return the RRJRD of a pair, 0 if it can be no edge."""
    cdef int64_t at
    cdef double mean, low, high
    at = params.distances_at + pair
    low, high = summary.at[at + params.pairs], summary.at[at + 2 * params.pairs]
    mean = summary.at[at] / summary.at[DURATION]
    if not (high - low >= STILL and mean >= COINCIDENT):  # NaN where one of the two was not seen yet
        return 0.0
    return rint((high - low) / mean * PRECISION) / PRECISION


cdef void set_edges(PathKernel* params, Doubles summary) noexcept nogil:
    """Set the list of edges: their number, then pairs in increasing order, then their RRJRD."""
    cdef Doubles best, ranges
    cdef int64_t row, ties, place, at, count, most, joints, padded_joints, i
    cdef double least, own
    cdef bint tied
    # CHECK sign (C truncates): joints // 2
    # CHECK np.zeros: np.zeros(most)
    # CHECK np.empty: np.empty(params.pairs)
    most, joints, padded_joints = params.edges, params.joints, params.padded_joints
    best = np.zeros(most)  # largest first
    ranges = np.empty(params.pairs)
    for row in range(params.rows):
        # The last row of an even number of joints holds each of its pairs twice.
        for i in range(joints if 2 * (row + 1) < joints else joints // 2):
            own = _relative_range(params, summary, row * padded_joints + i)
            ranges.at[row * padded_joints + i] = own
            if own > best.at[most - 1]:
                place = most - 1
                while place > 0 and best.at[place - 1] < own:
                    best.at[place] = best.at[place - 1]
                    place -= 1
                best.at[place] = own
    least = best.at[most - 1]
    ties = 0
    for place in range(most):
        ties += 1 if best.at[place] == least and least > 0.0 else 0
    at = params.edges_at + 1
    count = 0
    for row in range(params.rows):
        for i in range(joints if 2 * (row + 1) < joints else joints // 2):
            own = ranges.at[row * padded_joints + i]
            tied = own == least and ties > 0
            if own > least or tied:
                ties -= 1 if tied else 0
                summary.at[at + count] = row * padded_joints + i
                summary.at[at + most + count] = own
                count += 1
    summary.at[params.edges_at] = count
