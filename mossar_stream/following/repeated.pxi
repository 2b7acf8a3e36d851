"""Repeated: the repetitions of a followed move, with the begins and ends of the counter.

The counter (repetitions) finds begins and ends without an example. Here each repetition is aligned with the examples
between its known ends. This separates moves better than ways that are open at both ends. If two in a row are
the move, repetitions that no way has found are done, too, late. Those that ways have found twice are counted once.
"""

# Chosen on five people and ten exercises, people left out in turn (docs/lab-notes/following.md).
cdef double MOST_UNLIKE = 1.65  # mean of two repetitions in a row above which they are not the move
cdef double MORE_UNLIKE = 1.4  # times that, for one of them
cdef double MISSING = 0.7  # by how much a gain of 0 makes a repetition less alike
cdef double STANDS_AFTER = 1.2  # s after its end, when the last repetition was analysed again: then its end stands
cdef double PART = 0.6  # of a repetition, below which a performance is a part of one
cdef double GOES_ON = 2.0  # lengths of a repetition after which the next one is another series
cdef double OTHER_TEMPO = 2.5  # times longer or shorter than an example, beyond which a repetition is not the move
cdef enum:
    SHORTEST_REPETITION = 4  # samples


cdef bint settle_repetition(FollowMemory* known, FollowBank* bank, int64_t m, bint is_last_word) noexcept nogil:
    """Look at the next counted repetition, whether it is move m and was not found.

    Args:
        known: The performer's memory.
        bank: The followed examples.
        m: The move.
        is_last_word: Whether the take ends. Then all that are left are looked at, until one is reported.

    Returns:
        Whether it is reported as done.
    """
    cdef Periods* counted = known.periods
    cdef FollowedMove* move = &known.moves[m]
    cdef int64_t c = 0
    if counted.clear == 0 or known.happened[m] != MOVE_UNCHANGED:
        return False
    while True:
        while c < counted.cycles and _begin_of_repetition(counted, c) + _end_of_repetition(counted, c) <= 2.0 * move.settled:
            c += 1
        if not _stands(known, c, is_last_word):
            return False
        if counted.cycle[c].count == 1:
            move.repeated = 0
        if move.repeated == 0:
            if c + 1 == counted.cycles:
                return False
            if counted.cycle[c + 1].count > 1:
                if not _stands(known, c + 1, is_last_word):
                    return False
                move.repeated = _are_the_move(known, bank, m, c)
        move.settled = _end_of_repetition(counted, c)
        if move.repeated == 1 and _count_once(known, bank, m, c):
            return True
        if not is_last_word:
            return False


cdef inline double _begin_of_repetition(Periods* counted, int64_t c) noexcept nogil:
    """Return the begin of a repetition, s."""
    return counted.origin + counted.cycle[c].begins


cdef inline double _end_of_repetition(Periods* counted, int64_t c) noexcept nogil:
    """Return the end of a repetition, s."""
    return counted.origin + counted.cycle[c].ends


cdef inline bint _stands(FollowMemory* known, int64_t c, bint is_last_word) noexcept nogil:
    """Tell whether there is a repetition c, and its end will not change."""
    cdef Periods* counted = known.periods
    if c + 1 >= counted.cycles:
        return c < counted.cycles and (
            is_last_word or known.state.sampled - _end_of_repetition(counted, c) >= STANDS_AFTER
        )
    return True


cdef bint is_settled(FollowMemory* known, FollowedMove* move) noexcept nogil:
    """Tell whether the best end of a move that is repeated is that of a repetition which is counted, or of a part of one."""
    cdef double begin, end
    if move.repeated == 0:
        return False
    begin, end = time_of_sample(known.state, move.best_first), time_of_sample(known.state, move.best_last)
    if begin + end <= 2.0 * move.settled:
        return True
    return end - begin < PART * move.lasts and begin - move.settled < GOES_ON * move.lasts


cdef bint _are_the_move(FollowMemory* known, FollowBank* bank, int64_t m, int64_t c) noexcept nogil:
    """Tell whether a repetition and the next one are move m."""
    cdef double one, other, most = MORE_UNLIKE * MOST_UNLIKE
    one = _align_repetition(known, bank, m, c)
    if not one < most:
        return False
    other = _align_repetition(known, bank, m, c + 1)
    return other < most and one + other < 2.0 * MOST_UNLIKE and not _is_more_like_another(known, bank, m, c, one)


cdef bint _is_more_like_another(
    FollowMemory* known, FollowBank* bank, int64_t m, int64_t c, double unlike
) noexcept nogil:
    """Tell whether a repetition that is so unlike move m is clearly less unlike another one."""
    cdef int64_t o
    for o in range(bank.head.moves):
        if o != m and _align_repetition(known, bank, o, c) + CLEARLY < unlike:
            return True
    return False


cdef bint _count_once(FollowMemory* known, FollowBank* bank, int64_t m, int64_t c) noexcept nogil:
    """Report a repetition of a series that is move m as done, if it is like it and no way has found it."""
    cdef FollowedMove* move = &known.moves[m]
    cdef FollowedMove* found = known.spare
    cdef double begin = _begin_of_repetition(known.periods, c), end = _end_of_repetition(known.periods, c)
    cdef int64_t i, known_already = 0
    for i in range(LATEST_DONE):
        known_already += begin <= move.middles[i] < end
    move.lasts = end - begin
    if known_already > 0:
        move.surplus += known_already - 1
        return False
    if move.surplus > 0:
        move.surplus -= 1
        return False
    if not _align_repetition(known, bank, m, c) < MORE_UNLIKE * MOST_UNLIKE:
        return False
    known.state.number += 1
    move.count += 1
    move.done, move.done_first, move.done_last = found.cost - GAIN_WORTH * found.gain, found.best_first, found.best_last
    found.number, found.rev, found.count = known.state.number, 1, move.count
    found.start, found.time, found.progress = begin, end, 1.0
    write_report(known, bank, m, found, MOVE_DONE)
    note_box(box_of(known, m), ring_of(known, bank.examples[found.example].ring), found.first, found.last)
    known.happened[m] = MOVE_DONE
    known.state.happened = 1
    return True


cdef double _align_repetition(FollowMemory* known, FollowBank* bank, int64_t m, int64_t c) noexcept nogil:
    """Align a repetition with the examples of a move; `spare` gets the numbers of the best of them.

    Returns:
        How unlike the best one it is; infinite if it is not remembered any more, or no bone was seen.
    """
    cdef double unlike, least = INFINITY
    cdef int64_t t, best = -1, last = -1
    for t in range(bank.head.examples):
        if bank.examples[t].move == m:
            unlike, last = _align_with(known, bank, t, c), t
            if unlike < least:
                least, best = unlike, t
    if best != last and best >= 0:
        _align_with(known, bank, best, c)
    return least


cdef double _align_with(FollowMemory* known, FollowBank* bank, int64_t t, int64_t c) noexcept nogil:
    """Align a repetition with an example, both ends known; see `_align_repetition`."""
    cdef FollowedExample* example = &bank.examples[t]
    cdef FollowedMove* found = known.spare
    cdef FollowingState* state = known.state
    cdef double scale = 1.0 / (PERIOD * example.stride)
    cdef int64_t phases = example.phases, size = 3 * bank.head.bones, m = example.move
    cdef int64_t first, last, latest, i, count, came, stayed, place
    cdef Cells cells
    latest = (state.samples - 1) // example.stride
    first = <int64_t>floor((_begin_of_repetition(known.periods, c) - state.begin) * scale + 0.5)
    last = min(<int64_t>floor((_end_of_repetition(known.periods, c) - state.begin) * scale + 0.5), latest)
    if first < max(0, latest - bank.head.ring + 2) or last - first < SHORTEST_REPETITION:
        return INFINITY
    if last - first > OTHER_TEMPO * phases or OTHER_TEMPO * (last - first) < phases:
        return INFINITY
    cells = lay_out_cells(known.scratch, phases)
    for i in range(LAYERS * phases):
        cells.costs.at[i] = INFINITY
    memcpy(known.means.at, known.directions.at, size * sizeof(float))
    for i in range(phases):  # as if its tempo were the example's
        place = in_ring(first + _at_phase(i, last - first, phases), bank.head.ring)
        memcpy(known.directions.at, row_of_ring(known, example.ring, place), size * sizeof(float))
        compare_sample(known, bank, example)
        advance_ways(&cells, known, i)
        if i > 0:
            cells.costs.at[0] = INFINITY  # a way begins with the repetition
    memcpy(known.directions.at, known.means.at, size * sizeof(float))
    came, stayed = phases - 1, 2 * phases - 1
    found.example, found.phase, found.first, found.last = t, phases - 1, 0, phases - 1
    found.layer = STAYED if cells.costs.at[stayed] < cells.costs.at[came] else CAME
    place = stayed if found.layer == STAYED else came
    found.cost = cells.costs.at[place] / cells.weights.at[place]
    found.gain = <double>cells.gains.at[place] / phases
    count = trace(&cells, known.way, found)
    for i in range(count):
        known.way.at[i] = <int32_t>(first + _at_phase(known.way.at[i], last - first, phases))
    found.residual = measure_strays(
        known, bank, example, count, row_of_floats(known.strays, m).at, row_of_floats(known.standing, m).at
    ) / example.dear
    found.first, found.last = first, last
    found.best_first, found.best_last = first * example.stride, last * example.stride
    if is_unjudged(row_of_floats(known.strays, m)):
        return INFINITY
    return found.residual + MISSING * (1.0 - found.gain)


cdef inline int64_t _at_phase(int64_t phase, int64_t samples, int64_t phases) noexcept nogil:
    """Return how many samples after its begin a repetition that takes `samples` is at a phase, if it is even."""
    return (2 * phase * samples + phases - 1) // (2 * (phases - 1))
