"""Anchoring: the choice of the extreme of a cycle at which repetitions begin.

Repetitions begin at a rest. It is the extreme where the movement dwells, which is nearer to the pose in which the take
began, and where limbs are straighter and upright: standing, hanging, arms down, the poses of least effort. Annotators of
recordings choose it, too. The evidence is summed over all cycles of a chain, in which neighbours follow without a seam.
The decision holds for the whole chain, with the cycles that were reported before.
"""

cdef double DWELL = 0.3  # weight of the extreme where the movement dwells,
cdef double BOUT_NEAR_REST_POSE = 0.7  # and of the one nearer to the rest pose
cdef double STRAIGHTER = 0.16  # of the length of limbs, where the evidence begins to saturate
cdef double LEAN = 0.15  # hysteresis: weight of the present choice
cdef double LONGEST_PAUSE = 1.5  # cycles, within a bout
cdef double SEAM = 0.25  # of a cycle, gap or overlap from which on two neighbours belong to different chains


cdef void weigh(Counting* header, Samples* samples, int64_t component, int32_t* cycle, Cycle* row) noexcept nogil:
    """Note the evidence for the start of a cycle against its other extreme.

    Args:
        header: `Counting`.
        samples: `Samples`.
        component: The component that has the turning points.
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
    """Return how much straighter and more upright limbs are at the starts of cycles than at the other extremes, from -1 to 1."""
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
    """Return the mean straightness of a sample of the window and its neighbours."""
    cdef int64_t n, q, count
    cdef double total
    n = window_size(header)
    total, count = 0.0, 0
    for q in range(max(i - 1, 0), min(i + 2, n)):
        total += <double>samples.straight.at[ring_place(header, n, q)]
        count += 1
    return total / count


cdef void turn_chains(Counting* header) noexcept nogil:
    """Choose the extreme at which the cycles of each chain begin; `changed` becomes the first cycle that this changes."""
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
