"""Likelihood: how much better two segments are described apart than together.

Every dimension of the pose (positions relative to the centre, distances between joints, log speeds) gets a
Gaussian per segment. Merging segments a and b costs

    g = Σ_d w_d [ T_ab log(σ²_ab,d + r) - T_a log(σ²_a,d + r) - T_b log(σ²_b,d + r) ]

with T the durations in seconds and r a floor on the variance. The cost weighs evidence by
duration and needs nothing but sums: it is mergeable, and no frame is kept.
"""

# m and m²; joints in one place lie as far apart at least, so that only pairs that do not count have sums of 0.
cdef double LEAST_DISTANCE = 1e-12
cdef float LEAST_SQUARE = 1.0000000195414814e-24
cdef enum:
    MOST_DISTANCES = 120  # about as many joint pairs as carry information; more only cost time

cdef struct Likelihood:
    int64_t start  # where the sums begin in a summary
    int64_t dimensions  # padded, all groups
    int64_t positions  # padded dimensions of each group; 0 if it has no weight
    int64_t speeds
    int64_t offsets  # number of offsets k of the joint pairs (i, i + k mod J)
    int64_t stride  # between those offsets
    double position_weight  # per dimension
    double speed_weight
    double distance_weight
    double position_floor
    double speed_floor
    double distance_floor
    double short  # s, setting short_segment
    int64_t moving_joints
    int64_t joints


cdef void likelihood_write_features(Likelihood* params, Doubles summary, Features features) noexcept nogil:
    """Leave out what is known of a key frame: the likelihood asks for segments only."""


cdef void likelihood_add_frame(Likelihood* params, Doubles summary, SummaryFrame* frame) noexcept nogil:
    """Add one frame to a summary; positions, speeds and paths wait in the body for `flush_sums`.

    Args:
        params: Record of `make_params`.
        summary: Of the segment so far.
        frame: `SummaryFrame`; its pose is looked at for distances only.
    """
    add_features(summary, frame)
    if params.offsets > 0:
        _add_pairs(params, summary, frame.pose, frame.joints, frame.weight)


cdef void likelihood_add_pose(Likelihood* params, Doubles summary, FloatRows pose, int64_t joints, double time, double weight) noexcept nogil:
    """Add a pose alone, or take it out: to the duration and the sums, not to frames and paths.

    Args:
        params: Record of `make_params`.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1); x is NaN where a joint does not count.
        joints: J.
        time: s, of the pose; what matters here is only how long it lasts.
        weight: s that the pose stands for; negative to take it out.
    """
    add_pose_sums(params, summary, pose, weight)
    if params.offsets > 0:
        _add_pairs(params, summary, pose, joints, weight)


cdef void likelihood_add_joint(Likelihood* params, Doubles summary, FloatRows pose, int64_t joints, int64_t j) noexcept nogil:
    """Let a joint have rest where it is for as long as a summary lasts.

    Args:
        params: Record of `make_params`.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1); x is NaN where a joint does not count.
        joints: J.
        j: Which joint.
    """
    cdef int64_t at, row, k, i, other
    cdef float distance, x, y, z
    # CHECK sign (C truncates): (j - k) % joints; (i + k) % joints
    # CHECK loop over (j, (j - k) % joints)
    add_resting_joint(params, summary, pose, j)
    at = params.start + params.positions + params.speeds
    for row in range(params.offsets):
        k = 1 + row * params.stride
        for i in (j, (j - k) % joints):
            other = (i + k) % joints
            x, y, z = pose.at[i] - pose.at[other], pose.at[1 * pose.columns + i] - pose.at[1 * pose.columns + other], pose.at[2 * pose.columns + i] - pose.at[2 * pose.columns + other]
            distance = sqrtf(x * x + y * y + z * z)
            distance = max(distance, <float>LEAST_DISTANCE) if distance >= 0.0 else <float>0.0
            set_constant(params, summary, at + i, distance)
        at += pose.columns


cdef void _add_pairs(Likelihood* params, Doubles summary, FloatRows pose, int64_t joints, double weight) noexcept nogil:
    """Add the distances of the joint pairs (i, i + k mod J), in two runs without a wrap inside."""
    cdef Doubles sums, squares, one, other
    cdef int64_t at, row, k, wrapped
    # CHECK slice pose[:, :joints - k]
    # CHECK slice pose[:, k:joints]
    # CHECK slice pose[:, joints - k:joints]
    # CHECK slice pose[:, :k]
    sums = part_of_doubles(summary, params.start, params.start + params.dimensions)
    squares = part_of_doubles(summary, params.start + params.dimensions, params.start + 2 * params.dimensions)
    at = params.positions + params.speeds
    for row in range(params.offsets):
        k = 1 + row * params.stride
        wrapped = at + joints - k
        one = part_of_doubles(sums, at, wrapped)
        other = part_of_doubles(squares, at, wrapped)
        _add_distances(one, other, SLICE("pose[:, :joints - k]"), SLICE("pose[:, k:joints]"), weight)
        one = part_of_doubles(sums, wrapped, at + joints)
        other = part_of_doubles(squares, wrapped, at + joints)
        _add_distances(one, other, SLICE("pose[:, joints - k:joints]"), SLICE("pose[:, :k]"), weight)
        at += pose.columns


cdef void _add_distances(Doubles sums, Doubles squares, FloatRows one, FloatRows other, double weight) noexcept nogil:
    cdef int64_t i
    cdef float x, y, z, square
    for i in range(sums.count):
        x = one.at[i] - other.at[i]
        y = one.at[1 * one.columns + i] - other.at[1 * other.columns + i]
        z = one.at[2 * one.columns + i] - other.at[2 * other.columns + i]
        square = x * x + y * y + z * z
        # NaN: one of the two does not count.
        square = max(square, LEAST_SQUARE) if square >= 0.0 else <float>0.0
        sums.at[i] += weight * sqrtf(square)
        squares.at[i] += weight * square


cdef void likelihood_merge_into(Likelihood* params, Doubles target, Doubles other) noexcept nogil:
    """Make `target` the summary of both segments, `other` being the later one; sums know no order."""
    # CHECK add_all is called with several kinds of arguments
    add_all(target, other)


cdef void likelihood_close(Likelihood* params, Doubles summary) noexcept nogil:
    """Set a summary's TERM: T Σ_d w_d log(σ²_d + r)."""
    cdef double duration, total
    cdef Doubles sums, squares
    cdef int64_t speeds, distances
    summary.at[TERM] = 0.0
    duration = summary.at[DURATION]
    if duration <= SHORTEST_SEGMENT:
        return
    sums = part_of_doubles(summary, params.start, params.start + params.dimensions)
    squares = part_of_doubles(summary, params.start + params.dimensions, params.start + 2 * params.dimensions)
    speeds, distances = params.positions, params.positions + params.speeds
    total = 0.0
    if speeds > 0:
        total += params.position_weight * _log_sum(part_of_doubles(sums, 0, speeds), part_of_doubles(squares, 0, speeds), duration, params.position_floor)
    if distances > speeds:
        total += params.speed_weight * _log_sum(part_of_doubles(sums, speeds, distances), part_of_doubles(squares, speeds, distances), duration, params.speed_floor)
    if params.offsets > 0:
        total += params.distance_weight * _presence(params, from_doubles(squares, distances)) * _log_sum(from_doubles(sums, distances), from_doubles(squares, distances), duration, params.distance_floor)
    summary.at[TERM] = duration * total


cdef double _presence(Likelihood* params, Doubles squares) noexcept nogil:
    """Return by what to multiply the sum over pairs of joints where some of them do not count.

    Costs are scaled by the share of joints that count when they are used (`rank`, window.py). Of the pairs a smaller
    share counts: m (m - 1) of J (J - 1) where m joints count, of which the root does not move.

    Args:
        params: Record of `make_params`.
        squares: (offsets * padded joints,) m² s, weighted sums of squared distances; 0 for pairs that do not count.
    """
    cdef int64_t counted, i, joints, resting
    cdef double share, present
    counted = 0
    for i in range(squares.count):
        counted += 1 if squares.at[i] > 0.0 else 0
    if counted == 0 or counted == params.offsets * params.joints:
        return 1.0
    joints, resting = params.joints, params.joints - params.moving_joints
    share = <double>counted / (params.offsets * joints)
    present = 0.5 + sqrt(0.25 + share * joints * (joints - 1))
    return (present - resting) / (params.moving_joints * share)


cdef double _log_sum(Doubles sums, Doubles squares, double duration, double floor) noexcept nogil:
    """Σ log(σ² + floor): one logarithm for a product of up to 192 variances, 24 in each of `FACTORS`.

    No such product overflows: a variance lies between the least floor, 1e-12, and 1e10 m². The product of all would;
    the exponents are therefore added up apart.
    """
    cdef double scale, total, mantissa
    cdef int64_t begin, end, exponent
    scale = 1.0 / duration
    total = 0.0
    for begin in range(0, sums.count, 24 * FACTORS):
        end = min(begin + 24 * FACTORS, sums.count)
        mantissa, exponent = variance_product(sums.at, squares.at, begin, end, scale, floor)
        total += log(mantissa) + exponent * LOG_OF_2
    return total


cdef double likelihood_strength(Likelihood* params, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the cost of merging two closed neighbours, >= 0.

    Args:
        params: Record of `make_params`.
        left: Summary of the earlier segment, closed.
        right: Summary of the later one, closed.
        both: Set to the summary of both, closed.
    """
    cdef int64_t d
    for d in range(both.count):
        both.at[d] = left.at[d] + right.at[d]
    likelihood_close(params, both)
    return likelihood_merge_cost(params, left, right, both)


cdef double likelihood_merge_cost(Likelihood* params, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the same where `both` is the summary of both already."""
    cdef double cost
    if not (left.at[DURATION] > SHORTEST_SEGMENT and right.at[DURATION] > SHORTEST_SEGMENT):
        return 0.0
    cost = both.at[TERM] - left.at[TERM] - right.at[TERM]
    if params.short > 0.0:
        cost *= min(1.0, left.at[DURATION] / params.short) * min(1.0, right.at[DURATION] / params.short)
    return max(0.0, cost)


cdef double likelihood_similarity(Likelihood* params, double cost, Doubles left, Doubles right) noexcept nogil:
    """Return 1/(1 + cost), in 0..1."""
    return 1.0 / (1.0 + cost)
