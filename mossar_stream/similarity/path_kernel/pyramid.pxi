"""Pyramid: the Temporal Pyramid Covariance of a segment's joints, from sums that merge (paper 2.2.1).

Layer l of the pyramid cuts the segment into l equal parts; for each part a joint has the 6 upper elements of the
covariance of its coordinates, so that L layers give it a vector of 6 (1 + 2 + … + L) numbers.

With one layer a single bin of sums describes the segment. With more, at most 64 bins of equal length do: powers of
two of 1/256 s on the source's clock, doubled in length when 64 no longer reach. The first and the last time alone thus
determine the bins, and the order of merges does not matter. A bin belongs
to the part that its middle lies in: borders of parts are right to 1/64 of the segment's length.

A bin holds the weight (s), for each joint the mean of its coordinates and, as in Chan, Golub and LeVeque (1979),
the weighted sum of products of their deviations from the mean. Raw sums of squares would leave rounding noise on
joints that hardly move, which the cosine of two covariances blows up.

Every function takes the parameters and summaries that `kernel.pxi` describes.
"""

cdef enum:
    MOST_JOINTS = 1024  # of a skeleton
    CLOCK_LEVEL = 0  # log2 of the bins' length, numbers of the first and last one
    CLOCK_FIRST = 1
    CLOCK_LAST = 2

cdef double BIN_RATE = 256.0  # Hz, of the shortest bins
cdef double LATEST = 1e12  # s; clocks are cut off there


cdef struct PathKernel:
    int64_t joints
    int64_t padded_joints
    int64_t rows  # offsets k of the joint pairs (i, i + k mod J)
    int64_t pairs  # rows · padded joints
    int64_t edges  # N
    int64_t layers  # L
    int64_t form  # DAMPED, NORMALISED or SUM
    double decay  # λ
    double diagonal  # m²
    int64_t bins
    int64_t bin_size
    int64_t covariance  # length of a joint's covariances, 6 s
    int64_t distances_at  # begins of the parts of a summary
    int64_t clock_at
    int64_t bins_at
    int64_t covariances_at
    int64_t edges_at
    int64_t size  # of a summary


cdef void add_moments(
    PathKernel* params, Doubles summary, FloatRows pose, double time, double weight
) noexcept nogil:
    """Add a pose to the bin of its time, before it is added to the summary's duration.

    Args:
        params: Of the measure.
        summary: Of the segment.
        pose: (4, padded joints), of which 3 rows are coordinates, m.
        time: s, not before that of the poses added so far.
        weight: s, > 0.
    """
    cdef int64_t d, number = _bin_of(params, summary, time) if params.bins > 1 else 0
    cdef double* own = summary.at + params.bins_at + number * params.bin_size
    cdef double delta[3 * MOST_JOINTS]
    for d in range(3 * params.padded_joints):
        delta[d] = pose.at[d] - own[PADDING + d]
    _mix(own, delta, params.padded_joints, weight)


cdef void rest_in_moments(PathKernel* params, Doubles summary, FloatRows pose, int64_t j) noexcept nogil:
    """Add a joint to a summary as if it had rested at its present place all the time."""
    cdef int64_t number, d
    cdef double* own
    for number in range(params.bins):
        own = summary.at + params.bins_at + number * params.bin_size
        if own[0] > 0.0:
            for d in range(9):
                own[PADDING + j + d * params.padded_joints] = pose.at[d * pose.columns + j] if d < 3 else 0.0


cdef int64_t _bin_of(PathKernel* params, Doubles summary, double time) noexcept nogil:
    """Return the bin of a time; bins are doubled in length until there is one."""
    cdef double* clock = summary.at + params.clock_at
    cdef int64_t number = <int64_t>floor(min(max(time, -LATEST), LATEST) * BIN_RATE)
    if summary.at[DURATION] == 0.0:
        clock[CLOCK_LEVEL], clock[CLOCK_FIRST], clock[CLOCK_LAST] = 0.0, number, number
        return 0
    number = max(number >> <int64_t>clock[CLOCK_LEVEL], <int64_t>clock[CLOCK_FIRST])
    while number - <int64_t>clock[CLOCK_FIRST] >= params.bins:
        _coarsen(params, summary)
        number >>= 1
    clock[CLOCK_LAST] = max(clock[CLOCK_LAST], <double>number)
    return number - <int64_t>clock[CLOCK_FIRST]


cdef void _mix(double* own, double* delta, int64_t padded_joints, double weight) noexcept nogil:
    """Add other means with their weight to a bin: weight, means, and the products of their difference.

    Args:
        own: The bin.
        delta: (3 * padded joints,) m, the other means relative to those of the bin.
        padded_joints: J, padded.
        weight: s.
    """
    cdef int64_t a, b, d, j
    cdef double share, pull
    cdef double* products = own + PADDING + 3 * padded_joints
    own[0] += weight
    share = weight / own[0]
    pull = (own[0] - weight) * share
    for d in range(3 * padded_joints):
        own[PADDING + d] += share * delta[d]
    for a in range(3):
        for b in range(a, 3):
            for j in range(padded_joints):
                products[j] += pull * delta[a * padded_joints + j] * delta[b * padded_joints + j]
            products += padded_joints


cdef void _merge_bin(double* own, const double* other, int64_t padded_joints) noexcept nogil:
    """Add one bin to another one, which may be empty."""
    cdef double delta[3 * MOST_JOINTS]
    cdef int64_t d, products = PADDING + 3 * padded_joints
    if other[0] > 0.0:
        for d in range(3 * padded_joints):
            delta[d] = other[PADDING + d] - own[PADDING + d]
        _mix(own, delta, padded_joints, other[0])
        add_all(own + products, other + products, 6 * padded_joints)


cdef void _coarsen(PathKernel* params, Doubles summary) noexcept nogil:
    """Double the length of the bins."""
    cdef double* clock = summary.at + params.clock_at
    cdef int64_t number, target, first = <int64_t>clock[CLOCK_FIRST], last = <int64_t>clock[CLOCK_LAST]
    for number in range(first, last + 1):
        target = (number >> 1) - (first >> 1)
        if number - first != target:
            _move_bin(params, summary, number - first, target)
    clock[CLOCK_LEVEL] += 1.0
    clock[CLOCK_FIRST], clock[CLOCK_LAST] = first >> 1, last >> 1


cdef void _move_bin(PathKernel* params, Doubles summary, int64_t source, int64_t target) noexcept nogil:
    """Add a bin to another one of the same summary and leave it empty."""
    cdef double* old = summary.at + params.bins_at + source * params.bin_size
    _merge_bin(summary.at + params.bins_at + target * params.bin_size, old, params.padded_joints)
    memset(old, 0, params.bin_size * sizeof(double))


cdef void merge_moments(PathKernel* params, Doubles target, Doubles other) noexcept nogil:
    """Add the bins of a neighbouring segment, earlier or later; neither summary is empty."""
    cdef double* mine = target.at + params.clock_at
    cdef const double* theirs = other.at + params.clock_at
    cdef int64_t shift, ahead, number, to, size = params.bin_size
    cdef int64_t first = <int64_t>theirs[CLOCK_FIRST], last = <int64_t>theirs[CLOCK_LAST]
    while mine[CLOCK_LEVEL] < theirs[CLOCK_LEVEL]:
        _coarsen(params, target)
    shift = <int64_t>(mine[CLOCK_LEVEL] - theirs[CLOCK_LEVEL])
    while _bins_of_both(mine, first >> shift, last >> shift) > params.bins:
        _coarsen(params, target)
        shift += 1
    ahead = <int64_t>mine[CLOCK_FIRST] - (first >> shift)
    if ahead > 0:
        for number in range(<int64_t>(mine[CLOCK_LAST] - mine[CLOCK_FIRST]), -1, -1):
            _move_bin(params, target, number, number + ahead)
        mine[CLOCK_FIRST] = first >> shift
    mine[CLOCK_LAST] = max(mine[CLOCK_LAST], <double>(last >> shift))
    for number in range(first, last + 1):
        to = (number >> shift) - <int64_t>mine[CLOCK_FIRST]
        _merge_bin(
            target.at + params.bins_at + to * size,
            other.at + params.bins_at + (number - first) * size,
            params.padded_joints,
        )


cdef inline int64_t _bins_of_both(const double* clock, int64_t first, int64_t last) noexcept nogil:
    """Return the number of bins from the earlier of the two first ones to the later of the two last ones."""
    return max(<int64_t>clock[CLOCK_LAST], last) - min(<int64_t>clock[CLOCK_FIRST], first) + 1


cdef void set_covariances(PathKernel* params, Doubles summary) noexcept nogil:
    """Set the pyramid of every joint; a part without a frame has no covariance, so 0."""
    cdef double whole[PADDING + 9 * MOST_JOINTS]
    cdef const double* clock = summary.at + params.clock_at
    cdef int64_t layer, part, number, j, element, padded_joints = params.padded_joints
    cdef int64_t count = <int64_t>(clock[CLOCK_LAST] - clock[CLOCK_FIRST]) + 1
    cdef double scale, own
    cdef double* goal = summary.at + params.covariances_at
    for layer in range(1, params.layers + 1):
        for part in range(layer):
            memset(whole, 0, params.bin_size * sizeof(double))
            for number in range(count):
                if (2 * number + 1) * layer // (2 * count) == part:
                    _merge_bin(whole, summary.at + params.bins_at + number * params.bin_size, padded_joints)
            scale = 1.0 / whole[0] if whole[0] > 0.0 else 0.0
            for j in range(params.joints):
                for element in range(6):
                    own = whole[PADDING + (3 + element) * padded_joints + j] * scale
                    if element == 0 or element == 3 or element == 5:  # a variance
                        own += params.diagonal
                    goal[j * params.covariance + element] = own
            goal += 6
