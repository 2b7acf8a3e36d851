"""Evidence: how likely one move ends and the next one begins at a key frame, for any performer and sensor.

What people call a move ends where the movement changes, or where it stops; data sets differ in which. So both kinds of
evidence are added up, each free of units, to log odds:

    change  merge cost of the positions, and of the log speeds, of the segments on both sides (likelihood.py), in
            seconds of the performer's tempo
    stop    prominence: log of the lower of the two sides' peak speeds to the speed at the key frame
    rest    log of that speed to the performer's usual speed
    rest_distance    distance of the pose from the one in which the performer dwells, in the extent of the movements

Peaks that do not rise above the sensor's noise are no evidence. Where movements are repeated, the label of a candidate takes
their place (repetition_labels.py). The strength is log2(1 + e^odds): above 0, rising with the odds, and 1 where they are even.

What is known of the key frame itself stands in the summary of the segment that it ends.
"""

# A summary's own part begins with the segment's peak speed u, m/s, and `Features` of the key frame that ends it.
cdef enum:
    AT_PEAK = 0
    AT_SPEED = 1
    AT_REST_DISTANCE = 2
    AT_EXTENT = 3
    AT_USUAL_SPEED = 4
    AT_TEMPO = 5
    AT_NOISE = 6
    AT_JOINTS = 7
    FEATURES = -(-(AT_JOINTS + 1) // PADDING) * PADDING  # numbers
    # Fitted to punches, pick and place, gestures and exercises (the labelled sets precog, vmci, gesture_phase and
    # ui_prmd): about what `python -m checks.leave_out SET SET SET SET` chooses on all of them (its row "none"), in the scale
    # of the numbers before. It draws from 0 to LARGEST. docs/accuracy.md has what they reach on sets that were left out.
cdef double WEIGHTS_CHANGE_OF_POSE = 3.8
cdef double WEIGHTS_CHANGE_OF_SPEED = 10.4
cdef double WEIGHTS_STOP = 3.4
cdef double WEIGHTS_REST = 0.56
cdef double WEIGHTS_REST_DISTANCE = 1.93
cdef double WEIGHTS_BIAS = 3.66
cdef double LARGEST_CHANGE_OF_POSE = 6.0
cdef double LARGEST_CHANGE_OF_SPEED = 14.0
cdef double LARGEST_STOP = 6.0
cdef double LARGEST_REST = 2.0
cdef double LARGEST_REST_DISTANCE = 4.0
cdef double LARGEST_BIAS = 6.0
cdef double MOST_CHANGE = 4.0  # s
cdef double POSE_FLOOR = 0.15  # A, standard deviation under which poses are alike
cdef double SPEED_FLOOR = 0.1  # variance of log speeds under which they are alike
cdef double SPEED_FLOOR_OF_ODDS = 0.1  # V, added to the speeds in a prominence
cdef double MOST_PROMINENT = 3.0
cdef enum:
    POSITION_LINES = 3  # lines of the positions, and of the log speeds, in a summary
    SPEED_LINES = 1
    MOST_FACTORS = 24  # variances that are multiplied before a logarithm is taken
cdef double PEAK_ABOVE_NOISE = 1.0  # times what the noise adds to u, which a peak must reach
cdef double CERTAIN = 4.0  # strength of a key frame that ends a repetition

cdef struct Evidence:
    int64_t features  # where peak and features begin in a summary
    int64_t start  # where the sums begin
    int64_t dimensions  # padded
    int64_t positions  # of them
    int64_t speeds


cdef struct Features:  # What is known of a key frame when it is confirmed, for measures that ask for it.
    double speed
    double rest_distance
    double extent
    double usual_speed
    double tempo
    double noise
    int64_t joints


cdef struct Weights:  # What the terms weigh, log odds for each of their units, and what they must outweigh together.
    UNKNOWN_('unk', '?') change_of_pose
    UNKNOWN_('unk', '?') change_of_speed
    UNKNOWN_('unk', '?') stop
    UNKNOWN_('unk', '?') rest
    UNKNOWN_('unk', '?') rest_distance
    UNKNOWN_('unk', '?') bias


cdef void evidence_add_frame(Evidence* params, Doubles summary, SummaryFrame* frame) noexcept nogil:
    """Add one frame, a `SummaryFrame`, to a summary, and to the sums in the body that wait."""
    add_features(summary, frame)
    summary.at[params.features + AT_PEAK] = max(summary.at[params.features + AT_PEAK], frame.speed)


cdef void evidence_add_pose(Evidence* params, Doubles summary, FloatRows pose, int64_t joints, double time, double weight) noexcept nogil:
    """Add a pose alone, or take it out; the peak stays what it was."""
    add_pose_sums(params, summary, pose, weight)


cdef void evidence_add_joint(Evidence* params, Doubles summary, FloatRows pose, int64_t joints, int64_t j) noexcept nogil:
    """Let a joint have rest where it is for as long as a summary lasts."""
    add_resting_joint(params, summary, pose, j)


cdef void evidence_write_features(Evidence* params, Doubles summary, Features features) noexcept nogil:
    """Write `Features` of the key frame that ends a segment into its summary."""
    summary.at[params.features + AT_SPEED] = features.speed
    summary.at[params.features + AT_REST_DISTANCE] = features.rest_distance
    summary.at[params.features + AT_EXTENT] = features.extent
    summary.at[params.features + AT_USUAL_SPEED] = features.usual_speed
    summary.at[params.features + AT_TEMPO] = features.tempo
    summary.at[params.features + AT_NOISE] = features.noise
    summary.at[params.features + AT_JOINTS] = features.joints


cdef void evidence_merge_into(Evidence* params, Doubles target, Doubles other) noexcept nogil:
    """Make `target` the summary of both segments: with the higher peak, and the features of the later one's key frame."""
    cdef int64_t at, i
    # CHECK add_all is called with several kinds of arguments
    at = params.features
    target.at[at + AT_PEAK] = max(target.at[at + AT_PEAK], other.at[at + AT_PEAK])
    for i in range(at + AT_SPEED, at + FEATURES):
        target.at[i] = other.at[i]
    add_all(part_of_doubles(target, 0, at), other)
    add_all(from_doubles(target, params.start), from_doubles(other, params.start))


cdef void evidence_close(Evidence* params, Doubles summary) noexcept nogil:
    """Keep nothing of a closed segment as a whole: what poses are compared with depends on the key frame."""
    summary.at[TERM] = 0.0


cdef double evidence_strength(Evidence* params, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the strength of the key frame between two closed segments; `both` is set to their sums."""
    cdef int64_t d
    for d in range(both.count):
        both.at[d] = left.at[d] + right.at[d]
    return evidence_merge_cost(params, left, right, both)


cdef double evidence_merge_cost(Evidence* params, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the strength of the key frame between two segments.

    Args:
        params: Record of `make_params`.
        left: Summary of the earlier segment; the key frame ends it.
        right: Of the later one.
        both: Sums of both.
    """
    cdef Doubles known
    cdef double peak, usual, odds, least, pose, speed
    # CHECK np.logaddexp
    if left.at[DURATION] <= SHORTEST_SEGMENT or right.at[DURATION] <= SHORTEST_SEGMENT:
        return 0.0
    known = part_of_doubles(left, params.features, params.features + FEATURES)
    peak = min(known.at[AT_PEAK], right.at[params.features + AT_PEAK])
    if peak < PEAK_ABOVE_NOISE * known.at[AT_NOISE]:
        return 0.0
    pose, speed = _evidence_change(params, left, right, both, squared(POSE_FLOOR * known.at[AT_EXTENT]))
    usual = known.at[AT_USUAL_SPEED]
    odds = WEIGHTS_CHANGE_OF_POSE * pose + WEIGHTS_CHANGE_OF_SPEED * speed - WEIGHTS_BIAS
    least = SPEED_FLOOR_OF_ODDS * usual
    odds += WEIGHTS_STOP * min(MOST_PROMINENT, log((peak + least) / (known.at[AT_SPEED] + least)))
    odds += WEIGHTS_REST * log((known.at[AT_SPEED] + least) / (2.0 * usual))
    odds -= WEIGHTS_REST_DISTANCE * known.at[AT_REST_DISTANCE]
    return logaddexp(0.0, odds) / LOG_OF_2


cdef double evidence_similarity(Evidence* params, double cost, Doubles left, Doubles right) noexcept nogil:
    """Return 1/(1 + cost), in 0..1."""
    return 1.0 / (1.0 + cost)


cdef (double, double) _evidence_change(Evidence* params, Doubles left, Doubles right, Doubles both, double floor) noexcept nogil:
    """Return what it costs to merge the poses, and the log speeds, of two segments, at the performer's tempo."""
    cdef double share, most, pose, speed, pose_left, speed_left, pose_right, speed_right
    pose, speed = _terms(params, both, floor)
    pose_left, speed_left = _terms(params, left, floor)
    pose_right, speed_right = _terms(params, right, floor)
    share = 1.0 / (left.at[params.features + AT_JOINTS] * left.at[params.features + AT_TEMPO])
    most = MOST_CHANGE / left.at[params.features + AT_TEMPO]
    return (min(most, (pose - pose_left - pose_right) * share), min(most, (speed - speed_left - speed_right) * share))


cdef (double, double) _terms(Evidence* params, Doubles slot, double floor) noexcept nogil:
    """Return T Σ log(σ² + floor) over the joints, of positions (mean variance of the axes) and of log speeds.

    Args:
        params: Of the likelihood.
        slot: Summary.
        floor: m², under the variance of the positions.
    """
    cdef int64_t joints, first, end
    cdef double pose, speed, duration, scale
    cdef Doubles sums, squares
    duration, scale = slot.at[DURATION], 1.0 / slot.at[DURATION]
    joints = params.speeds  # padded
    sums = from_doubles(slot, params.start)
    squares = from_doubles(slot, params.start + params.dimensions)
    pose = speed = 0.0
    for first in range(0, joints, MOST_FACTORS):  # one logarithm of a product of many variances
        end = min(first + MOST_FACTORS, joints)
        pose += log(spread_product(sums.at, squares.at, first, end, POSITION_LINES, joints, scale, floor))
        first, end = first + POSITION_LINES * joints, end + POSITION_LINES * joints
        speed += log(spread_product(sums.at, squares.at, first, end, SPEED_LINES, joints, scale, SPEED_FLOOR))
    return duration * pose, duration * speed
