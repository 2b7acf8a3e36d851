"""Likelihood: the cost of describing two segments together instead of apart.

Every dimension of the pose (positions relative to the centre, distances between joints, log speeds) gets a
Gaussian per segment. Merging segments a and b costs

    g = Σ_d w_d [ T_ab log(σ²_ab,d + r) - T_a log(σ²_a,d + r) - T_b log(σ²_b,d + r) ]

with T the durations in seconds and r a floor on the variance. The cost weighs evidence by
duration and needs nothing but sums: it is mergeable, and no frame is kept.
"""

# m and m²; least distance of joints in one place, so that only pairs that do not count have sums of 0.
cdef float LEAST_DISTANCE = 1e-12
cdef float LEAST_SQUARE = 1e-24

cdef enum:
    MOST_VARIANCES = 192  # that are multiplied before a logarithm is taken


cdef struct Likelihood:
    Sums sums  # positions, log speeds and distances, as far as they have weight
    int64_t offsets  # number of offsets k of the joint pairs (i, i + k mod J)
    int64_t stride  # between those offsets
    double position_weight  # per dimension
    double speed_weight
    double distance_weight
    double position_floor
    double speed_floor
    double distance_floor
    double short_segment  # s, as in the settings
    int64_t moving_joints
    int64_t joints


cdef void likelihood_add_frame(Likelihood* params, Doubles summary, SummaryFrame* frame) noexcept nogil:
    """Add one frame to a summary, and to the waiting sums in the body; its pose is read for distances only."""
    add_features(summary, frame)
    if params.offsets > 0:
        _add_pairs(params, summary, frame.pose, frame.joints, frame.weight)


cdef void likelihood_add_pose(
    Likelihood* params, Doubles summary, FloatRows pose, int64_t joints, double weight
) noexcept nogil:
    """Add a pose alone, or take it out: to the duration and the sums, not to frames and paths.

    Args:
        params: Of the measure.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1); x is NaN where a joint does not count.
        joints: J.
        weight: s that the pose stands for; negative to take it out.
    """
    add_pose_sums(&params.sums, summary, pose, weight)
    if params.offsets > 0:
        _add_pairs(params, summary, pose, joints, weight)


cdef void likelihood_add_joint(
    Likelihood* params, Doubles summary, FloatRows pose, int64_t joints, int64_t j
) noexcept nogil:
    """Add a joint to a summary as if it had rested at its present place all the time.

    Args:
        params: Of the measure.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1); x is NaN where a joint does not count.
        joints: J.
        j: Index of the joint.
    """
    cdef int64_t row, k, side, i, at = params.sums.start + params.sums.positions + params.sums.speeds
    cdef float distance
    add_resting_joint(&params.sums, summary, pose, j)
    for row in range(params.offsets):
        k = 1 + row * params.stride
        for side in range(2):  # the pair that begins with the joint, and the one that ends with it
            i = j if side == 0 else (j - k + joints) % joints
            distance = pose_distance(pose, i, (i + k) % joints)
            distance = max(distance, LEAST_DISTANCE) if distance >= 0.0 else <float>0.0
            set_constant(&params.sums, summary, at + i, distance)
        at += pose.columns


cdef inline float pose_distance(FloatRows pose, int64_t i, int64_t other) noexcept nogil:
    """Return the distance of two joints of a (4, padded joints) pose, m; NaN where one of them does not count."""
    cdef const float* one = pose.at + i
    cdef const float* two = pose.at + other
    cdef float x = one[0] - two[0], y = one[pose.columns] - two[pose.columns]
    cdef float z = one[2 * pose.columns] - two[2 * pose.columns]
    return sqrtf(x * x + y * y + z * z)


cdef void _add_pairs(
    Likelihood* params, Doubles summary, FloatRows pose, int64_t joints, double weight
) noexcept nogil:
    """Add the distances of the joint pairs (i, i + k mod J), in two runs without a wrap inside."""
    cdef int64_t row, k, wrapped
    cdef double* sums = summary.at + params.sums.start + params.sums.positions + params.sums.speeds
    cdef double* squares = sums + params.sums.dimensions
    for row in range(params.offsets):
        k = 1 + row * params.stride
        wrapped = joints - k
        _add_distances(sums, squares, wrapped, pose.at, pose.at + k, pose.columns, weight)
        _add_distances(sums + wrapped, squares + wrapped, k, pose.at + wrapped, pose.at, pose.columns, weight)
        sums, squares = sums + pose.columns, squares + pose.columns


cdef inline void _add_distances(
    double* sums, double* squares, int64_t count, const float* one, const float* other, int64_t columns,
    double weight,
) noexcept nogil:
    cdef int64_t i
    cdef float x, y, z, square
    for i in range(count):
        x = one[i] - other[i]
        y = one[columns + i] - other[columns + i]
        z = one[2 * columns + i] - other[2 * columns + i]
        square = x * x + y * y + z * z
        # NaN: one of the two does not count.
        square = max(square, LEAST_SQUARE) if square >= 0.0 else <float>0.0
        sums[i] += weight * sqrtf(square)
        squares[i] += weight * square


cdef void likelihood_close(Likelihood* params, Doubles summary) noexcept nogil:
    """Set a summary's TERM: T Σ_d w_d log(σ²_d + r)."""
    cdef double duration = summary.at[DURATION], total = 0.0
    cdef double* sums = summary.at + params.sums.start
    cdef double* squares = sums + params.sums.dimensions
    cdef int64_t speeds = params.sums.positions, distances = params.sums.positions + params.sums.speeds
    cdef int64_t pairs = params.sums.dimensions - distances
    summary.at[TERM] = 0.0
    if duration <= SHORTEST_SEGMENT:
        return
    if speeds > 0:
        total += params.position_weight * _log_sum(sums, squares, speeds, duration, params.position_floor)
    if distances > speeds:
        total += params.speed_weight * _log_sum(
            sums + speeds, squares + speeds, distances - speeds, duration, params.speed_floor
        )
    if params.offsets > 0:
        total += (
            params.distance_weight
            * _presence(params, squares + distances, pairs)
            * _log_sum(sums + distances, squares + distances, pairs, duration, params.distance_floor)
        )
    summary.at[TERM] = duration * total


cdef double _presence(Likelihood* params, const double* squares, int64_t count) noexcept nogil:
    """Return the factor of the sum over pairs of joints if some of them do not count.

    Costs are scaled by the share of joints that count when they are used (`rank`, window.pxi). Of the pairs a smaller
    share counts: m (m - 1) of J (J - 1) where m joints count, of which the root does not move.

    Args:
        params: Of the measure.
        squares: m² s, weighted sums of squared distances; 0 for pairs that do not count.
        count: Of them; offsets * padded joints.
    """
    cdef int64_t i, counted = 0, joints = params.joints, resting = joints - params.moving_joints
    cdef double share, present
    for i in range(count):
        counted += 1 if squares[i] > 0.0 else 0
    if counted == 0 or counted == params.offsets * joints:
        return 1.0
    share = <double>counted / (params.offsets * joints)
    present = 0.5 + sqrt(0.25 + share * joints * (joints - 1))
    return (present - resting) / (params.moving_joints * share)


cdef double _log_sum(
    const double* sums, const double* squares, int64_t count, double duration, double floor_of_variance
) noexcept nogil:
    """Return Σ log(σ² + floor): one logarithm for a product of up to 192 variances, 24 in each of its 8 places.

    No such product overflows: a variance lies between the least floor, 1e-12, and 1e10 m². The product of all would;
    the exponents are therefore added up apart.
    """
    cdef double mantissa, scale = 1.0 / duration, total = 0.0
    cdef int64_t end, exponent, begin = 0
    while begin < count:
        end = min(begin + MOST_VARIANCES, count)
        mantissa = variance_product(sums, squares, begin, end, scale, floor_of_variance, &exponent)
        total += log(mantissa) + exponent * LOG_OF_2
        begin = end
    return total


cdef double likelihood_strength(Likelihood* params, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the cost of merging two closed neighbours, >= 0.

    Args:
        params: Of the measure.
        left: Summary of the earlier segment, closed.
        right: Summary of the later one, closed.
        both: Set to the summary of both, closed.
    """
    cdef int64_t d
    for d in range(both.count):
        both.at[d] = left.at[d] + right.at[d]
    likelihood_close(params, both)
    return likelihood_merge_cost(params, left, right, both)


cdef double likelihood_merge_cost(
    Likelihood* params, Doubles left, Doubles right, Doubles both
) noexcept nogil:
    """Return the same cost if `both` is already the summary of both."""
    cdef double cost, short_segment = params.short_segment
    if not (left.at[DURATION] > SHORTEST_SEGMENT and right.at[DURATION] > SHORTEST_SEGMENT):
        return 0.0
    cost = both.at[TERM] - left.at[TERM] - right.at[TERM]
    if short_segment > 0.0:
        cost *= min(1.0, left.at[DURATION] / short_segment) * min(1.0, right.at[DURATION] / short_segment)
    return max(0.0, cost)
