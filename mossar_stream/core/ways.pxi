"""Ways: the latest way out of the pose in which the take began and back, if the way back retraces the way out.

Such a way is a repetition, known before any can be counted. The pose in which the take began is called home here. Exercises go
back through the poses of the way out; punches and gestures do not. Performers who pick and place sometimes do, but they linger
(scales.pxi). Poses are the samples of `repetitions`, without the root's own path; distances are over all joints.
"""

cdef double FAR_FROM_HOME = 0.6  # of the farthest distance so far, which a way must reach
cdef double AT_HOME = 0.3  # of the same, within which the performer is at home
cdef double RETRACED = 0.2  # of a way's farthest distance: largest mean difference between poses of the way out and back
cdef double GOES_ONCE = 0.9  # of the summed rise and fall of distances on a way: twice the farthest distance must reach it
cdef double LEAST_STEADY = 0.4  # least steadiness of a performer whose ways give labels
cdef double LOWEST_LEVEL = 0.4  # of a way's farthest distance, where poses are compared first,
cdef double NEXT_LEVEL = 0.2  # and how much farther out each time again
cdef enum:
    LEVELS = 3

cdef struct Ways:
    int64_t samples  # of the take that were processed
    int64_t home  # the latest of them at home
    int64_t is_out  # whether the performer was far from home since
    double farthest  # m, from home
    double begins  # s, of the latest way that retraces itself; inf if there is none
    double ends  # s
    double leaves  # s, when the next way out begins; inf if it has not yet


cdef void start_ways(Ways* ways) noexcept nogil:
    """Begin a take."""
    ways.samples = ways.home = ways.is_out = 0
    ways.farthest = 0.0
    ways.begins = ways.ends = ways.leaves = INFINITY


cdef inline bint is_way_longer(Ways* ways, Counting* counted) noexcept nogil:
    """Return whether there is a new sample, and nothing is counted yet."""
    return counted.open != ways.samples and counted.clear == 0


cdef void follow_ways(Ways* ways, Counting* counted, Samples* samples) noexcept nogil:
    """Process the newest sample.

    Args:
        ways: Ways.
        counted: `Counting` of the same frames.
        samples: `Samples` of the same frames.
    """
    cdef int64_t newest = counted.open - 1
    cdef double away = _home_distance(counted, samples, newest)
    ways.samples = counted.open
    ways.farthest = max(ways.farthest, away)
    if away <= AT_HOME * ways.farthest:
        if ways.is_out == 1 and _retraces(counted, samples, ways.home, newest):
            ways.begins = counted.origin + counted.left[ways.home % SAMPLES]
            ways.ends = counted.origin + counted.at[newest % SAMPLES]
            ways.leaves = INFINITY
        ways.home, ways.is_out = newest, 0
    elif ways.is_out == 0 and away > FAR_FROM_HOME * ways.farthest:
        ways.is_out = 1
        ways.leaves = min(ways.leaves, counted.origin + counted.left[ways.home % SAMPLES])


cdef inline bint is_on_way(Ways* ways, double time) noexcept nogil:
    """Return whether a time, s, lies within the latest way that retraces itself."""
    return ways.begins + MARGIN < time < ways.ends - MARGIN


cdef inline bint is_after_way(Ways* ways, double time) noexcept nogil:
    """Return whether a time, s, lies between that way and the next one, and no longer after that way than it lasted."""
    return ways.ends - MARGIN <= time < min(ways.leaves, 2.0 * ways.ends - ways.begins) - MARGIN


cdef bint _retraces(Counting* counted, Samples* samples, int64_t begin, int64_t end) noexcept nogil:
    """Return whether a way from one sample to another goes out once, and back through the same poses."""
    cdef double away[SAMPLES]
    cdef double farthest = 0.0, gone = 0.0, apart = 0.0, level
    cdef int64_t i, q, out, back, last = end - begin
    if not 0 < last < SAMPLES:
        return False
    for i in range(last + 1):
        away[i] = _home_distance(counted, samples, begin + i)
        farthest = max(farthest, away[i])
        gone += abs(away[i] - away[i - 1]) if i > 0 else 0.0
    if not 2.0 * farthest >= GOES_ONCE * gone:
        return False
    for q in range(LEVELS):
        level = (LOWEST_LEVEL + q * NEXT_LEVEL) * farthest
        out, back = 0, last
        while out < last and away[out] < level:
            out += 1
        while back > 0 and away[back] < level:
            back -= 1
        apart += _sample_distance(counted, samples, begin + out, begin + back)
    return apart <= LEVELS * RETRACED * farthest


cdef double _home_distance(Counting* counted, Samples* samples, int64_t number) noexcept nogil:
    """Return the distance of a sample from the pose in which the take began, m."""
    cdef double total = 0.0
    cdef int64_t j, k, at = number % SAMPLES
    for j in range(counted.joints):
        if j != counted.root:
            for k in range(3 * j, 3 * j + 3):
                total += squared(samples.ring.at[k * samples.ring.columns + at] * counted.quantum - samples.rest_pose.at[k])
    return sqrt(total)


cdef double _sample_distance(Counting* counted, Samples* samples, int64_t one, int64_t other) noexcept nogil:
    """Return the distance of two samples of the take, m."""
    cdef double total = 0.0
    cdef int64_t j, k
    cdef int16_t* line
    for j in range(counted.joints):
        if j != counted.root:
            for k in range(3 * j, 3 * j + 3):
                line = samples.ring.at + k * samples.ring.columns
                total += squared(line[one % SAMPLES] - line[other % SAMPLES])
    return sqrt(total) * counted.quantum
