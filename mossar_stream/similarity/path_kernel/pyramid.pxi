"""Pyramid: the Temporal Pyramid Covariance of a segment's joints, from sums that merge (paper 2.2.1).

Layer l of the pyramid cuts the segment into l equal parts; for each part a joint has the 6 upper elements of the
covariance of its coordinates, so that L layers give it a vector of 6 (1 + 2 + … + L) numbers.

With one layer a single bin of sums describes the segment. With more, at most 64 bins of equal length do: powers of
two of 1/256 s on the source's clock, doubled in length when 64 no longer reach. Which bins there are thus follows
from the first and the last time alone, and it does not matter in which order segments were merged. A bin belongs
to the part that its middle lies in: borders of parts are right to 1/64 of the segment's length.

A bin holds the weight (s), for each joint the mean of its coordinates and, as in Chan, Golub and LeVeque (1979),
the weighted sum of products of their deviations from the mean. Raw sums of squares would leave rounding noise on
joints that hardly move, which the cosine of two covariances blows up.

Every function takes the parameters of `kernel.make_params` and summaries as described there.
"""

cdef enum:
    MOST_BINS = 64
cdef double BIN_RATE = 256.0  # Hz, of the shortest bins
cdef double LATEST = 1000000000000.0  # s; clocks are cut off there
cdef enum:
    MOST_LEVELS = 48  # of doubling, after which a bin holds everything
    CLOCK_LEVEL = 0  # log2 of the bins' length, numbers of the first and last one
    CLOCK_FIRST = 1
    CLOCK_LAST = 2
    FIRST_PLACE = 0  # of the bins


cdef void add_moments(PathKernel* params, Doubles summary, FloatRows pose, double time, double weight) noexcept nogil:
    """Add a pose to the bin of its time, before it is added to the summary's duration.

    Args:
        params: Record.
        summary: Summary.
        pose: (4, padded joints), of which 3 rows are coordinates, m.
        time: s, not before that of the poses added so far.
        weight: s, > 0.
    """
    cdef int64_t place, at
    # CHECK call pose[:3].reshape(3 * params.padded_joints)
    # CHECK _mix is called with several kinds of arguments
    place = _pyramid_place(params, summary, time) if params.bins > 1 else FIRST_PLACE
    at = params.bins_at + place * params.bin_size
    _mix(part_of_doubles(summary, at, at + params.bin_size), pose[:3].reshape(3 * params.padded_joints), params.padded_joints, weight)


cdef void rest_in_moments(PathKernel* params, Doubles summary, FloatRows pose, int64_t j) noexcept nogil:
    """Let a joint have rest where it is for as long as a summary lasts."""
    cdef int64_t padded_joints, place, at, d
    padded_joints = params.padded_joints
    for place in range(params.bins):
        at = params.bins_at + place * params.bin_size
        if summary.at[at] > 0.0:
            at += PADDING + j
            for d in range(9):
                summary.at[at + d * padded_joints] = pose.at[d * pose.columns + j] if d < 3 else <float>0.0


cdef int64_t _pyramid_place(PathKernel* params, Doubles summary, double time) noexcept nogil:
    """Return the place of the bin for a time; bins are doubled in length until there is one."""
    cdef Doubles clock
    cdef int64_t number
    # CHECK call of _coarsen: _coarsen(summary, params.clock_at, params.bins_at, params.bin_size, params.padded_joints)
    clock = part_of_doubles(summary, params.clock_at, params.clock_at + 3)
    number = <int64_t>floor(min(max(time, -LATEST), LATEST) * BIN_RATE)
    if summary.at[DURATION] == 0.0:
        clock.at[CLOCK_LEVEL], clock.at[CLOCK_FIRST], clock.at[CLOCK_LAST] = 0.0, number, number
        return FIRST_PLACE
    number = max(number >> <int64_t>clock.at[CLOCK_LEVEL], <int64_t>clock.at[CLOCK_FIRST])
    while number - <int64_t>clock.at[CLOCK_FIRST] >= params.bins:
        _coarsen(summary, params.clock_at, params.bins_at, params.bin_size, params.padded_joints)
        number >>= 1
    clock.at[CLOCK_LAST] = max(clock.at[CLOCK_LAST], number)
    return number - <int64_t>clock.at[CLOCK_FIRST]


cdef void _mix(Doubles own, Doubles means, int64_t padded_joints, double weight) noexcept nogil:
    """Add other means with their weight to a bin: weight, means, and what their difference adds to the products."""
    cdef double share, pull
    cdef Doubles delta, center, products, one, two
    cdef int64_t d, at, a, b, j
    # CHECK np.empty: np.empty(3 * padded_joints)
    own.at[0] += weight
    share = weight / own.at[0]
    pull = (own.at[0] - weight) * share
    delta = np.empty(3 * padded_joints)
    center = part_of_doubles(own, PADDING, PADDING + 3 * padded_joints)
    for d in range(3 * padded_joints):
        delta.at[d] = means.at[d] - center.at[d]
        center.at[d] += share * delta.at[d]
    at = PADDING + 3 * padded_joints
    for a in range(3):
        for b in range(a, 3):
            one = part_of_doubles(delta, a * padded_joints, (a + 1) * padded_joints)
            two = part_of_doubles(delta, b * padded_joints, (b + 1) * padded_joints)
            products = part_of_doubles(own, at, at + padded_joints)
            for j in range(padded_joints):
                products.at[j] += pull * one.at[j] * two.at[j]
            at += padded_joints


cdef void _merge_bin(Doubles own, Doubles other, int64_t padded_joints) noexcept nogil:
    """Add one bin to another one, which may be empty."""
    cdef int64_t d
    # CHECK _mix is called with several kinds of arguments
    if other.at[0] > 0.0:
        _mix(own, part_of_doubles(other, PADDING, PADDING + 3 * padded_joints), padded_joints, other.at[0])
        for d in range(PADDING + 3 * padded_joints, PADDING + 9 * padded_joints):
            own.at[d] += other.at[d]


cdef void _move_bin(Doubles summary, int64_t bins_at, int64_t size, int64_t padded_joints, int64_t source, int64_t target) noexcept nogil:
    """Add a bin to another one of the same summary and leave it empty."""
    cdef Doubles old, new
    cdef int64_t d
    old = part_of_doubles(summary, bins_at + source * size, bins_at + (source + 1) * size)
    new = part_of_doubles(summary, bins_at + target * size, bins_at + (target + 1) * size)
    _merge_bin(new, old, padded_joints)
    for d in range(size):
        old.at[d] = 0.0


cdef void merge_moments(PathKernel* params, Doubles target, Doubles other) noexcept nogil:
    """Add the bins of a neighbouring segment, earlier or later; neither summary is empty."""
    cdef Doubles mine, theirs
    cdef int64_t shift, ahead, size, number, first, last, place, to, source
    # CHECK call of _coarsen: _coarsen(target, params.clock_at, params.bins_at, params.bin_size, params.padded_joints)
    mine = part_of_doubles(target, params.clock_at, params.clock_at + 3)
    theirs = part_of_doubles(other, params.clock_at, params.clock_at + 3)
    while mine.at[CLOCK_LEVEL] < theirs.at[CLOCK_LEVEL]:
        _coarsen(target, params.clock_at, params.bins_at, params.bin_size, params.padded_joints)
    shift = <int64_t>(mine.at[CLOCK_LEVEL] - theirs.at[CLOCK_LEVEL])
    first, last = <int64_t>theirs.at[CLOCK_FIRST], <int64_t>theirs.at[CLOCK_LAST]
    while max(mine.at[CLOCK_LAST], last >> shift) - min(mine.at[CLOCK_FIRST], first >> shift) >= params.bins:
        _coarsen(target, params.clock_at, params.bins_at, params.bin_size, params.padded_joints)
        shift += 1
    ahead = <int64_t>mine.at[CLOCK_FIRST] - (first >> shift)
    if ahead > 0:
        for place in range(<int64_t>(mine.at[CLOCK_LAST] - mine.at[CLOCK_FIRST]), -1, -1):
            _move_bin(target, params.bins_at, params.bin_size, params.padded_joints, place, place + ahead)
        mine.at[CLOCK_FIRST] = first >> shift
    mine.at[CLOCK_LAST] = max(mine.at[CLOCK_LAST], last >> shift)
    size = params.bin_size
    for number in range(first, last + 1):
        to = params.bins_at + ((number >> shift) - <int64_t>mine.at[CLOCK_FIRST]) * size
        source = params.bins_at + (number - first) * size
        _merge_bin(part_of_doubles(target, to, to + size), part_of_doubles(other, source, source + size), params.padded_joints)


cdef void set_covariances(PathKernel* params, Doubles summary) noexcept nogil:
    """Set the pyramid of every joint; a part without a frame has no covariance, so 0."""
    cdef Doubles whole, clock
    cdef int64_t count, at, layer, padded_joints, size, part, d, place, j, element, start
    cdef double scale, own
    # CHECK sign (C truncates): (2 * place + 1) * layer // (2 * count)
    # CHECK np.empty: np.empty(params.bin_size)
    whole = np.empty(params.bin_size)
    clock = part_of_doubles(summary, params.clock_at, params.clock_at + 3)
    count = <int64_t>(clock.at[CLOCK_LAST] - clock.at[CLOCK_FIRST]) + 1
    padded_joints, size = params.padded_joints, params.bin_size
    at = params.covariances_at
    for layer in range(1, params.layers + 1):
        for part in range(layer):
            for d in range(size):
                whole.at[d] = 0.0
            for place in range(count):
                if (2 * place + 1) * layer // (2 * count) == part:
                    start = params.bins_at + place * size
                    _merge_bin(whole, part_of_doubles(summary, start, start + size), padded_joints)
            scale = 1.0 / whole.at[0] if whole.at[0] > 0.0 else 0.0
            for j in range(params.joints):
                for element in range(6):
                    own = whole.at[PADDING + (3 + element) * padded_joints + j] * scale
                    if element == 0 or element == 3 or element == 5:
                        own += params.diagonal
                    summary.at[at + j * params.covariance + element] = own
            at += 6
