"""Timing: start, end and period of repetitions, from the counted cycles."""

# Intervals between cycles; their median is the period. The median ignores one missed cycle. There are four, because the
# spacing of samples makes intervals of fast movements longer and shorter in turn.
cdef enum:
    INTERVALS = 4
# Cycles without a new one after which a bout is over, besides the time between analyses.
cdef double LONGEST_SILENCE = 1.5
cdef double LEAST_PERIOD = 0.1  # s
cdef double NEARBY = 0.31622776601683794  # of a step, within which a pose still belongs to a sample


cdef void time_cycles(Counting* header, int64_t first) noexcept nogil:
    """Set starts, ends and periods of the remembered repetitions, s.

    Args:
        header: `Counting`.
        first: Place of the first one that may have changed.
    """
    cdef int64_t place
    cdef Cycle* row
    for place in range(first, header.cycles):
        row = &header.cycle[place]
        row.begins, row.ends, row.period = _begin_of(header, place), _end_of(header, place), _period(header, place)
        if place > 0:
            row.begins = max(row.begins, header.cycle[place - 1].ends)
        row.ends = max(row.ends, row.begins + LEAST_PERIOD)


cdef double _period(Counting* header, int64_t place) noexcept nogil:
    """Return the period at a cycle, s: the median of the latest intervals of its bout; NaN for the first cycle.

    While there are too few intervals before it, later ones count, too.
    """
    cdef int64_t begin, end, beyond
    begin = place - min(header.cycle[place].count - 1, INTERVALS, place)
    if begin == place:
        return NAN
    end, beyond = place, min(begin + INTERVALS, header.cycles - 1)
    while end < beyond and header.cycle[end + 1].count > 1:
        end += 1
    return max(0.25 * (_ranked(header, begin, end, 0) + _ranked(header, begin, end, 1)), LEAST_PERIOD)


cdef double _ranked(Counting* header, int64_t begin, int64_t end, int64_t upper) noexcept nogil:
    """Return twice the lower or upper median of the intervals between cycles, s."""
    cdef int64_t count, rank, i, below, k
    cdef double passed, other
    count = end - begin
    rank = (count - 1 + upper) // 2
    for i in range(count):
        passed = _passed(header, begin + i)
        below = 0
        for k in range(count):
            other = _passed(header, begin + k)
            below += other < passed or other == passed and k < i
        if below == rank:
            return passed
    return 0.0


cdef double _passed(Counting* header, int64_t place) noexcept nogil:
    """Return twice the interval to the next cycle, s: that between the half ways out plus that between the half ways back.

    The first cycle of a bout may come out of another posture, and the last one may not be back yet.
    """
    cdef Cycle* one
    cdef Cycle* other
    one = &header.cycle[place]
    other = &header.cycle[place + 1]
    if one.count == 1 and other.returning == 1:
        return 2.0 * (other.turns - one.turns)
    if one.count == 1:
        return 2.0 * (other.back - one.back)
    if other.returning == 1:
        return 2.0 * (other.out - one.out)
    return other.out + other.back - one.out - one.back


cdef double _begin_of(Counting* header, int64_t place) noexcept nogil:
    """Return the start of a repetition, s; within a bout it lies between half way back and half way out again."""
    cdef Cycle* row
    cdef Cycle* before
    cdef double begin, earliest
    row = &header.cycle[place]
    if place > 0 and row.count > 1 and header.cycle[place - 1].turned == row.turned:
        before = &header.cycle[place - 1]
        return _timing_middle(before) if row.turned else 0.5 * (before.back + row.out)
    begin = 2.0 * row.leaves - row.turns if row.turned else max(row.leaves, 2.0 * row.out - row.turns)
    earliest = 0.0 if place == 0 else _own_end(&header.cycle[place - 1])
    return max(begin, earliest)


cdef double _end_of(Counting* header, int64_t place) noexcept nogil:
    """Return the end of a repetition, s."""
    cdef Cycle* row
    cdef Cycle* after
    row = &header.cycle[place]
    if place + 1 < header.cycles and not row.turned:
        after = &header.cycle[place + 1]
        if after.count > 1 and not after.turned:
            return _begin_of(header, place + 1)
    return _own_end(row)


cdef double _own_end(Cycle* row) noexcept nogil:
    """Return the end of a repetition that no other follows, s."""
    # The extreme is arbitrary within a rest: from half way back to the end is as long as from the turn to half way back.
    return _timing_middle(row) if row.turned else min(row.arrives, 2.0 * row.back - row.turns)


cdef double _timing_middle(Cycle* row) noexcept nogil:
    """Return the middle between passing half way out and half way back."""
    return 0.5 * (row.out + row.back)


cdef double time_at(Counting* header, int64_t n, double place) noexcept nogil:
    """Return the time of a place between two samples of the window of n, s since the take began."""
    cdef int64_t below, one
    cdef double share
    below = <int64_t>place if place >= 0.0 else 0  # NaN if a snapshot has NaN scores
    share = place - below
    one = ring_place(header, n, below)
    if share < NEARBY:
        return header.at[one] + share / NEARBY * (header.left[one] - header.at[one])
    share = (share - NEARBY) / (1.0 - NEARBY)
    return (1.0 - share) * header.left[one] + share * header.at[ring_place(header, n, below + 1)]
