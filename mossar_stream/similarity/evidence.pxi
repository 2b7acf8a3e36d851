"""Evidence: the odds that one move ends and the next one begins at a key frame, for any performer and sensor.

According to people, a move ends where the movement changes, or where it stops; data sets differ in which. Both kinds of
evidence are therefore added up, each free of units, to log odds:

    change  merge cost of the positions, and of the log speeds, of the segments on both sides (likelihood.pxi), in
            seconds of the performer's tempo
    stop    prominence: log of the lower of the two sides' peak speeds to the speed at the key frame
    rest    log of that speed to the performer's usual speed
    rest_distance    distance of the pose from the one in which the performer dwells, in the extent of the movements

Peaks that do not rise above the sensor's noise are no evidence. Where movements are repeated, the label of a candidate
takes their place (repetition_labels.pxi). The strength is log2(1 + e^odds): above 0, rising with the odds, and 1 where
they are even.

The features of the key frame itself are in the summary of the segment that it ends.
"""

cdef enum:  # A summary's own part begins with the peak speed and the `Features` of the key frame that ends the segment.
    AT_PEAK = 0  # m/s, of u in the segment
    AT_SPEED = 1
    AT_REST_DISTANCE = 2
    AT_EXTENT = 3
    AT_USUAL_SPEED = 4
    AT_TEMPO = 5
    AT_NOISE = 6
    AT_JOINTS = 7
    FEATURES = 8  # numbers, a multiple of PADDING
    POSITION_LINES = 3  # lines of the positions, and of the log speeds, in a summary
    SPEED_LINES = 1
    MOST_FACTORS = 24  # variances that are multiplied before a logarithm is taken

# Weights of the terms, log odds for each of their units, and the sum that they must exceed (BIAS). Fitted to punches,
# pick and place, gestures and exercises (the labelled sets precog, vmci, gesture_phase and ui_prmd): about the choice of
# `python -m checks.leave_out SET SET SET SET` on all of them (its row "none"), in the scale of the numbers before.
# docs/accuracy.md has the scores on sets that were left out.
cdef double WEIGHTS_CHANGE_OF_POSE = 3.8
cdef double WEIGHTS_CHANGE_OF_SPEED = 10.4
cdef double WEIGHTS_STOP = 3.4
cdef double WEIGHTS_REST = 0.56
cdef double WEIGHTS_REST_DISTANCE = 1.93
cdef double WEIGHTS_BIAS = 3.66

cdef double MOST_CHANGE = 4.0  # s
cdef double POSE_FLOOR = 0.15  # A, standard deviation under which poses are alike
cdef double SPEED_FLOOR = 0.1  # variance of log speeds under which they are alike
cdef double SPEED_FLOOR_OF_ODDS = 0.1  # V, added to the speeds in a prominence
cdef double MOST_PROMINENT = 3.0
cdef double PEAK_ABOVE_NOISE = 1.0  # multiple of the noise in u that a peak must reach
cdef double CERTAIN = 4.0  # strength of a key frame that ends a repetition


cdef struct Evidence:
    int64_t features  # where peak and features begin in a summary
    Sums sums  # positions and log speeds


cdef struct Features:  # Features of a key frame at its confirmation, for measures that need them.
    double speed  # m/s, lowest u from the candidate to its confirmation (u, A and V: see scales.pxi)
    double rest_distance  # A, distance from the pose in which the performer dwells
    double extent  # m, A
    double usual_speed  # m/s, V
    double tempo  # relative to ordinary
    double noise  # m/s, the speed that the sensor's noise adds to u
    int64_t joints  # how many count and can move relative to the centre


cdef void evidence_add_frame(Evidence* params, Doubles summary, SummaryFrame* frame) noexcept nogil:
    """Add one frame to a summary, and to the sums in the body that wait."""
    cdef double* peak = summary.at + params.features + AT_PEAK
    add_features(summary, frame)
    peak[0] = max(peak[0], frame.speed)


cdef void evidence_write_features(Evidence* params, Doubles summary, Features* features) noexcept nogil:
    """Write `Features` of the key frame that ends a segment into its summary."""
    cdef double* known = summary.at + params.features
    known[AT_SPEED] = features.speed
    known[AT_REST_DISTANCE] = features.rest_distance
    known[AT_EXTENT] = features.extent
    known[AT_USUAL_SPEED] = features.usual_speed
    known[AT_TEMPO] = features.tempo
    known[AT_NOISE] = features.noise
    known[AT_JOINTS] = features.joints


cdef void evidence_merge_into(Evidence* params, Doubles target, Doubles other) noexcept nogil:
    """Make `target` the summary of both segments: the higher peak, and the features of the later one's key frame."""
    cdef int64_t i, at = params.features, start = params.sums.start
    target.at[at + AT_PEAK] = max(target.at[at + AT_PEAK], other.at[at + AT_PEAK])
    for i in range(at + AT_SPEED, at + FEATURES):
        target.at[i] = other.at[i]
    add_all(target.at, other.at, at)
    add_all(target.at + start, other.at + start, target.count - start)


cdef double evidence_strength(Evidence* params, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the strength of the key frame between two closed segments; `both` is set to their sums."""
    cdef int64_t d
    for d in range(both.count):
        both.at[d] = left.at[d] + right.at[d]
    return evidence_merge_cost(params, left, right, both)


cdef double evidence_merge_cost(Evidence* params, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the strength of the key frame between two segments.

    Args:
        params: Of the measure.
        left: Summary of the earlier segment; the key frame ends it.
        right: Of the later one.
        both: Sums of both.
    """
    cdef const double* known = left.at + params.features
    cdef double peak, pose, speed, usual, least, odds, limit = POSE_FLOOR * known[AT_EXTENT]
    if left.at[DURATION] <= SHORTEST_SEGMENT or right.at[DURATION] <= SHORTEST_SEGMENT:
        return 0.0
    peak = min(known[AT_PEAK], right.at[params.features + AT_PEAK])
    if peak < PEAK_ABOVE_NOISE * known[AT_NOISE]:
        return 0.0
    pose, speed = _change(params, left, right, both, limit * limit)
    usual = known[AT_USUAL_SPEED]
    odds = WEIGHTS_CHANGE_OF_POSE * pose + WEIGHTS_CHANGE_OF_SPEED * speed - WEIGHTS_BIAS
    least = SPEED_FLOOR_OF_ODDS * usual
    odds += WEIGHTS_STOP * min(MOST_PROMINENT, log((peak + least) / (known[AT_SPEED] + least)))
    odds += WEIGHTS_REST * log((known[AT_SPEED] + least) / (2.0 * usual))
    odds -= WEIGHTS_REST_DISTANCE * known[AT_REST_DISTANCE]
    return _log_of_one_and_exp(odds) / LOG_OF_2


cdef inline double _log_of_one_and_exp(double odds) noexcept nogil:
    """Return log(1 + e^odds), where e^odds may lie beyond a double."""
    if odds == 0.0:
        return LOG_OF_2
    return odds + log1p(exp(-odds)) if odds > 0.0 else log1p(exp(odds))


cdef (double, double) _change(
    Evidence* params, Doubles left, Doubles right, Doubles both, double floor_of_pose
) noexcept nogil:
    """Return the costs of merging the poses, and the log speeds, of two segments, at the performer's tempo."""
    cdef double pose, pose_left, pose_right, speed, speed_left, speed_right
    cdef double joints = left.at[params.features + AT_JOINTS], tempo = left.at[params.features + AT_TEMPO]
    cdef double share = 1.0 / (joints * tempo), most = MOST_CHANGE / tempo
    pose, speed = _terms(params, both, floor_of_pose)
    pose_left, speed_left = _terms(params, left, floor_of_pose)
    pose_right, speed_right = _terms(params, right, floor_of_pose)
    pose, speed = pose - pose_left - pose_right, speed - speed_left - speed_right
    return min(most, pose * share), min(most, speed * share)


cdef (double, double) _terms(Evidence* params, Doubles slot, double floor_of_pose) noexcept nogil:
    """Return T Σ log(σ² + floor) over the joints, of positions (mean variance of the axes) and of log speeds.

    Args:
        params: Of the measure.
        slot: Summary.
        floor_of_pose: m², under the variance of the positions.
    """
    cdef int64_t end, first = 0, joints = params.sums.speeds  # padded
    cdef double duration = slot.at[DURATION], scale = 1.0 / duration, pose = 0.0, speed = 0.0
    cdef const double* sums = slot.at + params.sums.start
    cdef const double* squares = sums + params.sums.dimensions
    cdef const double* speed_sums = sums + params.sums.positions
    cdef const double* speed_squares = squares + params.sums.positions
    while first < joints:  # one logarithm of a product of many variances
        end = min(first + MOST_FACTORS, joints)
        pose += log(spread_product(sums, squares, first, end, POSITION_LINES, joints, scale, floor_of_pose))
        speed += log(
            spread_product(speed_sums, speed_squares, first, end, SPEED_LINES, joints, scale, SPEED_FLOOR)
        )
        first = end
    return duration * pose, duration * speed
