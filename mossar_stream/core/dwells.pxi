"""Dwells: the latest pauses of the performer, so that the end of a repetition lies in the middle of a pause.

A dwell is a stretch of time in which the speed u stays below the share `SLOW` of V (scales.pxi). Gaps of up to `DWELL_GAP` do
not end it. Moments are noted some 20 times a second, so that the middle of a dwell is a frame.
"""

cdef double DWELL_GAP = 0.12  # s above the threshold that do not end a dwell
cdef double MOMENT_SPACING = 0.045  # s between moments
cdef double NEAR_DWELL = 0.3  # s, from a key frame to its dwell
# s; delay of a dwell in the velocity, by its low-pass filter and the window of its speed
cdef double LATE_DWELL = 0.05
cdef enum:
    DWELLS = 8  # remembered
    MOMENTS = 160  # remembered: more than 7 s
    NO_DWELL = -1

cdef struct Moment:
    double time  # s
    int64_t frame


cdef struct Dwells:
    int64_t begun  # dwells of the take
    int64_t noted  # moments of the take
    double begin[8]  # s, of the latest dwells, ring
    double end[8]  # s, so far
    Moment moment[160]  # the latest ones, ring


cdef void start_dwells(Dwells* dwells) noexcept nogil:
    """Begin a take."""
    dwells.begun = dwells.noted = 0


cdef inline void follow_dwells(Dwells* dwells, bint slow, int64_t frame, double time) noexcept nogil:
    """Add a frame.

    Args:
        dwells: DWELLS.
        slow: Whether the speed is below the threshold.
        frame: Its number.
        time: s.
    """
    cdef Moment* moment = &dwells.moment[dwells.noted % MOMENTS]
    cdef int64_t newest
    if dwells.noted == 0 or time - dwells.moment[(dwells.noted - 1) % MOMENTS].time >= MOMENT_SPACING - MARGIN:
        moment.time, moment.frame = time, frame
        dwells.noted += 1
    if not slow:
        return
    if dwells.begun == 0 or time - dwells.end[(dwells.begun - 1) % DWELLS] > DWELL_GAP + MARGIN:
        dwells.begin[dwells.begun % DWELLS] = time
        dwells.begun += 1
    newest = (dwells.begun - 1) % DWELLS
    dwells.end[newest] = time


cdef int64_t dwell_near(Dwells* dwells, double time) noexcept nogil:
    """Return the place of the dwell nearest to a time, s, or `NO_DWELL` if none is near; at a tie, the earlier one."""
    cdef int64_t number, place, best = NO_DWELL
    cdef double off, least = NEAR_DWELL
    for number in range(max(dwells.begun - DWELLS, 0), dwells.begun):
        place = number % DWELLS
        off = max(dwells.begin[place] - time, time - dwells.end[place], 0.0)
        if off < least - MARGIN:
            best, least = place, off
    return best


cdef Moment* middle_of(Dwells* dwells, int64_t dwell) noexcept nogil:
    """Return the moment in the middle of a dwell; at a tie, the earlier one."""
    cdef double time = 0.5 * (dwells.begin[dwell] + dwells.end[dwell]) - LATE_DWELL
    cdef int64_t low = max(dwells.noted - MOMENTS, 0), high = dwells.noted - 1, number
    cdef Moment* before
    cdef Moment* after
    while low < high:  # the first moment that is not before, or the last one
        number = (low + high) // 2
        if dwells.moment[number % MOMENTS].time < time:
            low = number + 1
        else:
            high = number
    after = &dwells.moment[low % MOMENTS]
    if low == max(dwells.noted - MOMENTS, 0):
        return after
    before = &dwells.moment[(low - 1) % MOMENTS]
    return after if abs(after.time - time) < abs(before.time - time) - MARGIN else before
