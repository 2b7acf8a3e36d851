"""Turning points of one component, with hysteresis: a move back by less than a share of the range is no turn."""

cdef double HYSTERESIS = 0.37  # of the range from the 10th to the 90th percentile
cdef double SWING_REACHED = 0.7  # of the last swing, after which the newest extreme counts as reached


cdef float swing_range(Floats scores, int64_t n, Ints32 counts) noexcept nogil:
    """Return the range from the 10th to the 90th percentile, from a histogram; 0 if a number is infinite.

    NaN is left out: snapshots from outside may hold it, and a histogram has no place for it.

    Args:
        scores: (n,) float32.
        n: Samples.
        counts: (BINS,), out.
    """
    cdef float low, high, width, place
    cdef int64_t i, below, passed, above
    low = high = scores.at[0]
    for i in range(n):
        low = min(low, scores.at[i])
        high = max(high, scores.at[i])
    if not 0.0 < high - low < INFINITY:
        return <float>0.0
    for i in range(counts.count):
        counts.at[i] = 0
    width = (high - low) / <float>BINS
    for i in range(n):
        place = (scores.at[i] - low) / width
        if not isnan(place):
            counts.at[min(<int64_t>place, BINS - 1)] += 1
    below, passed = 0, counts.at[0]
    while passed <= 0.1 * n and below < BINS - 1:
        below += 1
        passed += counts.at[below]
    above, passed = 0, counts.at[BINS - 1]
    while passed <= 0.1 * n and above < BINS - 1:
        above += 1
        passed += counts.at[BINS - 1 - above]
    return width * <float>max(BINS - above - below - 1, 0)


cdef int64_t turning_points(Floats scores, int64_t n, float least, Int32Rows turns) noexcept nogil:
    """Find the samples at which a component turns back by more than `least`.

    Args:
        scores: (n,) float32.
        n: Samples.
        least: Hysteresis, in the unit of the scores.
        turns: (2, SAMPLES), out: sample and direction (1 a maximum, -1 a minimum).

    Returns:
        Number of turning points.
    """
    cdef float lowest, highest, score
    cdef int64_t i, found, direction, low, high
    found, direction, low, high = 0, 0, 0, 0
    lowest = highest = scores.at[0]
    for i in range(n):
        score = scores.at[i]
        if score > highest:
            high, highest = i, score
        if score < lowest:
            low, lowest = i, score
        if direction >= 0 and highest - score > least:
            turns.at[found], turns.at[turns.columns + found] = high, 1
            found, direction, low, lowest = found + 1, -1, i, score
        elif direction <= 0 and score - lowest > least:
            turns.at[found], turns.at[turns.columns + found] = low, -1
            found, direction, high, highest = found + 1, 1, i, score
    return _with_the_last(scores, turns, found, high if direction > 0 else low)


cdef int64_t _with_the_last(Floats scores, Int32Rows turns, int64_t found, int64_t latest) noexcept nogil:
    """Add the newest extreme if its swing is nearly as large as the one before."""
    cdef int32_t last, before
    if found < 2 or found >= SAMPLES:
        return found
    last, before = turns.at[found - 1], turns.at[found - 2]
    if abs(scores.at[latest] - scores.at[last]) <= SWING_REACHED * abs(scores.at[last] - scores.at[before]):
        return found
    turns.at[found], turns.at[turns.columns + found] = latest, -turns.at[turns.columns + (found - 1)]
    return found + 1
