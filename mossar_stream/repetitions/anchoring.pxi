"""Where repetitions begin: at which of the two extremes of a cycle.

A rest says where: the extreme where the movement dwells, that is nearer to the pose in which the take began, and where
limbs are straighter and upright (standing, hanging, arms down: what costs least effort), as people who label recordings
see it, too. What speaks for either is summed over all cycles of a chain, whose neighbours follow without a seam, and
decided for all of them: also for those that were reported before.
"""

cdef double DWELL = 0.3  # how much speaks for an extreme where the movement dwells, and that is nearer to the rest pose
cdef double BOUT_NEAR_REST_POSE = 0.7
cdef double STRAIGHTER = 0.16  # of the length of limbs: more hardly speaks louder
cdef double LEAN = 0.15  # for leaving it as it is
cdef double LONGEST_PAUSE = 1.5  # cycles, within a bout
cdef double SEAM = 0.25  # of a cycle, by which neighbours of a chain may overlap or be apart: more shows that one was found anew


cdef void weigh(Counting* header, Samples* samples, int64_t component, int32_t* cycle, Cycle* row) noexcept nogil:
    """Note what speaks for the begin of a cycle against its other extreme.

    Args:
        header: `Counting`.
        samples: `Samples`.
        component: The one whose turning points these are.
        cycle: (3,) start, far extreme, end.
        row: `Cycle`, in and out.
    """
    cdef int64_t n
    cdef double ends, dwelling, away
    cdef int32_t start, far, end
    cdef float near, distant
    start, far, end = cycle[0], cycle[1], cycle[2]
    n = window_size(header)
    dwelling, away = dwelling_of(header, n, row_of_floats(samples.smooth, component), start, far, end)
    near, distant = rest_pose_distances(samples, start, far)
    row.resting = DWELL * (dwelling - away) / max(dwelling + away, 1e-3)
    row.resting += BOUT_NEAR_REST_POSE * (distant - near) / max(near + distant, 1e-9)
    ends = 0.5 * (_anchoring_straightness(header, samples, start) + _anchoring_straightness(header, samples, end))
    row.straighter = ends - _anchoring_straightness(header, samples, far)


cdef double straightening(Counting* header, Samples* samples, Int32Rows cycles, int64_t count) noexcept nogil:
    """Return how much straighter and more upright limbs are where cycles begin than at their other extreme, from -1 to 1."""
    cdef double total
    cdef int64_t i
    total = 0.0
    for i in range(count):
        total += (
            _anchoring_straightness(header, samples, cycles.at[i])
            - _anchoring_straightness(header, samples, cycles.at[cycles.columns + i])
        )
    return tanh(total / count / STRAIGHTER)


cdef double _anchoring_straightness(Counting* header, Samples* samples, int32_t i) noexcept nogil:
    """Return the mean over a sample of the window and its neighbours."""
    cdef int64_t n, q, count
    cdef double total
    n = window_size(header)
    total, count = 0.0, 0
    for q in range(max(i - 1, 0), min(i + 2, n)):
        total += <double>samples.straight.at[ring_place(header, n, q)]
        count += 1
    return total / count


cdef void turn_chains(Counting* header) noexcept nogil:
    """Decide for each chain of cycles at which extreme they begin; `changed` tells of the first that this changes."""
    cdef int64_t first, count, q, last
    cdef double lean, straighter, resting
    cdef bint turned
    first = 0
    while first < header.cycles:
        last, straighter, resting = first, 0.0, 0.0
        while True:
            straighter += header.cycle[last].straighter
            resting += header.cycle[last].resting
            last += 1
            if last == header.cycles or not _follows(&header.cycle[last - 1], &header.cycle[last]):
                break
        lean = LEAN if header.cycle[first].turned == 0 else -LEAN
        count = last - first
        turned = tanh(straighter / count / STRAIGHTER) + resting / count + lean < 0
        for q in range(first, last):
            if header.cycle[q].turned != <int64_t>turned:
                header.cycle[q].turned = <int64_t>turned
                header.changed = q if header.changed < 0 else min(header.changed, q)
        first = last


cdef bint _follows(Cycle* before, Cycle* cycle) noexcept nogil:
    """Return whether a cycle follows another without a seam."""
    cdef int64_t gap, period
    gap, period = cycle.start - before.end, cycle.end - cycle.start
    return magnitude(gap) < SEAM * period
