"""Cycles between turning points, and the agreement between them.

A cycle goes from one extreme to the other and back. Its description is the posture at the three extremes and where it
passes a quarter, half and three quarters of the way, out and back. Pauses and pace do not change it. Cycles count in runs
of neighbours whose descriptions agree. The agreements of all pairs of a run must reach a sum.
"""

cdef enum:
    SHORTEST_CYCLE = 4  # samples, of a cycle
cdef double LONGEST_RATIO = 2.0  # of the durations of neighbours
cdef double LEAST_AMPLITUDE_RATIO = 0.6
cdef double LEAST_AGREEMENT = 0.26  # of two neighbours
cdef double ENOUGH_AGREEMENT = 0.79  # of a run's pairs together
cdef double STRONG = 0.93  # agreement of one pair that makes clear that a movement repeats
cdef double SAME_POSTURE = 0.3  # of the way between the extremes, most by which poses of the same posture differ
cdef double LONGEST_STOP = 0.5  # cycles, within a movement that goes on
cdef double MUCH = 1.5  # agreement of a run's pairs together that makes the same clear


cdef int64_t cycles_between(Int32Rows turns, int64_t found, int64_t direction, bint first, Int32Rows cycles) noexcept nogil:
    """Write the cycles that begin and end at extremes of one direction.

    Args:
        turns: See `turning_points`.
        found: Number of turning points.
        direction: 1 to begin at maxima, -1 at minima.
        first: Whether the window begins with the take. If not, an extreme at its first sample is only an edge of the window.
        cycles: (3, SAMPLES), out: start, far extreme, end.

    Returns:
        Number of cycles.
    """
    cdef int64_t at, count, k
    at = 0
    if found > 0 and not first and turns.at[0] == 0:
        at = 1
    if at < found and turns.at[turns.columns + at] != direction:
        at += 1
    count = 0
    while at + 2 < found:
        for k in range(3):
            cycles.at[k * cycles.columns + count] = turns.at[at + k]
        count += 1
        at += 2
    return count


cdef double crossing(Floats scores, int64_t start, int64_t end, double share) noexcept nogil:
    """Return the place where a component passes a share of the way between two samples, interpolated."""
    cdef float goal, sign
    cdef int64_t step, i
    goal = scores.at[start] + <float>share * (scores.at[end] - scores.at[start])
    sign = <float>1.0 if scores.at[end] > scores.at[start] else <float>(-1.0)
    step = 1 if end > start else -1
    i = start
    while i != end and (scores.at[i + step] - goal) * sign < 0:
        i += step
    if i == end:
        return <double>end
    return i + step * <double>((goal - scores.at[i]) / (scores.at[i + step] - scores.at[i]))


ctypedef float (*Shape)[COMPONENTS]  # (POSTURES, COMPONENTS), the description of a cycle


cdef void describe(Samples* samples, int64_t component, Int32Rows cycles, int64_t i, Shape shape) noexcept nogil:
    """Write the description of a cycle.

    Args:
        samples: `Samples`.
        component: The component that has the turning points.
        cycles: (3, SAMPLES) start, far extreme, end.
        i: Number of the cycle.
        shape: Out.
    """
    cdef FloatRows smooth
    cdef int64_t k, there, q, back
    cdef float sign, begin, top, goal
    cdef int32_t start, far, end
    smooth = samples.smooth
    start, far, end = cycles.at[i], cycles.at[cycles.columns + i], cycles.at[2 * cycles.columns + i]
    for k in range(COMPONENTS):
        shape[0][k] = smooth.at[k * smooth.columns + start]
        shape[1][k] = smooth.at[k * smooth.columns + far]
        shape[2][k] = smooth.at[k * smooth.columns + end]
    begin, top = smooth.at[component * smooth.columns + start], smooth.at[component * smooth.columns + far]
    sign = <float>1.0 if top > begin else <float>(-1.0)
    there = start
    for q in range(3):
        goal = begin + <float>(0.25 * (q + 1)) * (top - begin)
        while there < far and (smooth.at[component * smooth.columns + (there + 1)] - goal) * sign < 0:
            there += 1
        _write_between(smooth, component, (there, min(there + 1, far)), goal, shape[3 + 2 * q])
    begin, back = smooth.at[component * smooth.columns + end], end
    sign = <float>1.0 if top > begin else <float>(-1.0)
    for q in range(3):
        goal = begin + <float>(0.25 * (q + 1)) * (top - begin)
        while back > far and (smooth.at[component * smooth.columns + (back - 1)] - goal) * sign < 0:
            back -= 1
        _write_between(smooth, component, (back, max(back - 1, far)), goal, shape[4 + 2 * q])


cdef void _write_between(
    FloatRows smooth, int64_t component, (int64_t, int64_t) between, float goal, float* posture
) noexcept nogil:
    """Write the posture at which a component has a value, interpolated between two neighbours."""
    cdef float rest
    cdef int64_t k, one, other
    cdef float* scores
    one, other = between
    rest = 0.0
    scores = smooth.at + component * smooth.columns
    if one != other:
        rest = (goal - scores[one]) / (scores[other] - scores[one])
    for k in range(COMPONENTS):
        scores = smooth.at + k * smooth.columns
        posture[k] = scores[one] + rest * (scores[other] - scores[one])


cdef double agreement(CountingScratch* described, int64_t i, int64_t j) noexcept nogil:
    """Return the agreement of two descriptions: 1 if they are the same, 0 if they agree only by chance.

    With a and b the descriptions and m their mean, this is 1 - |a - b|² / (|a - m|² + |b - m|²).
    """
    cdef int64_t q, k
    cdef float squares, spread, product, means
    product, means = <float>0.0, <float>0.0
    for q in range(POSTURES):
        for k in range(COMPONENTS):
            product += described.shapes[i][q][k] * described.shapes[j][q][k]
    for k in range(COMPONENTS):
        means += squared_float(described.totals[i][k] + described.totals[j][k])
    squares = described.totals[i][COMPONENTS] + described.totals[j][COMPONENTS]
    spread = max(squares - means / <float>(2 * POSTURES), <float>1e-9)
    return 1.0 - <double>((squares - <float>2.0 * product) / spread)


cdef double _lasted(Counting* header, int64_t n, Int32Rows cycles, int64_t i) noexcept nogil:
    """Return the duration of a cycle, s, without the stay in its first and last posture."""
    cdef int32_t start = cycles.at[i], end = cycles.at[2 * cycles.columns + i]
    return header.at[ring_place(header, n, end)] - header.left[ring_place(header, n, start)]


cdef bint _pair(Counting* header, int64_t n, Floats scores, Int32Rows cycles, int64_t i) noexcept nogil:
    """Return whether a cycle and the next have similar durations and amplitudes.

    Pauses make a cycle longer in time, and joints that the sensor misplaces make it longer in samples. The durations must be
    similar in time or in samples.
    """
    cdef int64_t one, other
    cdef double a, b
    one = cycles.at[2 * cycles.columns + i] - cycles.at[i]
    other = cycles.at[2 * cycles.columns + (i + 1)] - cycles.at[i + 1]
    if min(one, other) < SHORTEST_CYCLE:
        return False
    if max(one, other) > LONGEST_RATIO * min(one, other):
        a, b = _lasted(header, n, cycles, i), _lasted(header, n, cycles, i + 1)
        if max(a, b) > LONGEST_RATIO * min(a, b) + STAMP_ROUNDING:
            return False
    a = abs(
        scores.at[cycles.at[cycles.columns + i]]
        - 0.5 * (scores.at[cycles.at[i]] + scores.at[cycles.at[2 * cycles.columns + i]])
    )
    b = abs(
        scores.at[cycles.at[cycles.columns + (i + 1)]]
        - 0.5 * (scores.at[cycles.at[i + 1]] + scores.at[cycles.at[2 * cycles.columns + (i + 1)]])
    )
    return min(a, b) >= LEAST_AMPLITUDE_RATIO * max(a, b)


cdef void describe_all(
    Samples* samples, int64_t component, Int32Rows cycles, int64_t count, CountingScratch* described
) noexcept nogil:
    """Describe cycles.

    Args:
        samples: `Samples`.
        component: The component that has the turning points.
        cycles: (3, SAMPLES).
        count: Number of cycles.
        described: `CountingScratch`, out.
    """
    cdef int64_t i, q, k
    cdef float value
    cdef float* totals
    for i in range(count):
        describe(samples, component, cycles, i, described.shapes[i])
        totals = described.totals[i]
        fill_floats(floats(totals, COMPONENTS + 1), 0.0)
        for q in range(POSTURES):
            for k in range(COMPONENTS):
                value = described.shapes[i][q][k]
                totals[k] += value
                totals[COMPONENTS] += value * value
        if i > 0:
            described.alike[i - 1] = agreement(described, i - 1, i)


cdef double alternation(Int32Rows cycles, int64_t count, CountingScratch* described) noexcept nogil:
    """Return how much better cycles agree with the next but one than with the next; halves of cycles give a high value."""
    cdef double* alike
    cdef int64_t i, triples
    cdef double better
    alike = described.alike
    better, triples = 0.0, 0
    for i in range(count - 2):
        if cycles.at[2 * cycles.columns + i] == cycles.at[i + 1] and cycles.at[2 * cycles.columns + (i + 1)] == cycles.at[i + 2]:
            better += agreement(described, i, i + 2) - 0.5 * (alike[i] + alike[i + 1])
            triples += 1
    return better / triples if triples > 1 else 0.0


cdef void copy_cycles(Int32Rows cycles, int64_t count, Int32Rows goal) noexcept nogil:
    """Copy the first `count` cycles of one (3, SAMPLES) to another."""
    cdef int64_t k, i
    for k in range(3):
        for i in range(count):
            goal.at[k * goal.columns + i] = cycles.at[k * cycles.columns + i]


cdef int64_t join_pairs(Floats scores, Int32Rows cycles, int64_t count, int64_t first, Int32Rows joined) noexcept nogil:
    """Write cycles joined two by two from number `first` on; return the number of joined cycles."""
    cdef int64_t made, i
    cdef bint farther
    cdef int32_t start, one, other
    made, i = 0, first
    while i + 1 < count:
        if cycles.at[2 * cycles.columns + i] != cycles.at[i + 1]:
            i += 1
            continue
        start, one, other = cycles.at[i], cycles.at[cycles.columns + i], cycles.at[cycles.columns + (i + 1)]
        joined.at[made], joined.at[2 * joined.columns + made] = start, cycles.at[2 * cycles.columns + (i + 1)]
        farther = abs(scores.at[one] - scores.at[start]) >= abs(scores.at[other] - scores.at[start])
        joined.at[joined.columns + made] = one if farther else other
        made += 1
        i += 2
    return made


cdef (int64_t, double, bint) keep_alike(
    Counting* header, int64_t n, Floats scores, Int32Rows cycles, int64_t count, double* alike
) noexcept nogil:
    """Keep the cycles of runs that agree enough.

    Args:
        header: `Counting`.
        n: Samples in the window.
        scores: Of the component that has the turning points.
        cycles: (3, SAMPLES), in and out.
        count: Number of cycles.
        alike: Agreement of each with the next.

    Returns:
        The number of cycles kept, the samples that they cover, weighted by their agreement, and whether it is clear that
        a movement repeats.
    """
    cdef int64_t kept, i, j, q, k
    cdef double covered, agreed, strongest
    cdef bint clear
    kept, covered, i, clear = 0, 0.0, 0, False
    while i < count:
        j, agreed, strongest = i, 0.0, 0.0
        while j + 1 < count and _pair(header, n, scores, cycles, j):
            if alike[j] < LEAST_AGREEMENT:
                break
            agreed += alike[j]
            strongest = max(strongest, alike[j])
            j += 1
        if j > i and agreed >= ENOUGH_AGREEMENT:
            clear |= strongest >= STRONG or agreed >= MUCH
            covered += agreed / (j - i) * (cycles.at[2 * cycles.columns + j] - cycles.at[i])
            for q in range(i, j + 1):
                for k in range(3):
                    cycles.at[k * cycles.columns + kept] = cycles.at[k * cycles.columns + q]
                kept += 1
        i = j + 1
    return kept, covered, clear


cdef int64_t duration(Int32Rows cycles, int64_t count) noexcept nogil:
    """Return the sum of the durations of cycles, samples."""
    cdef int64_t total, i
    total = 0
    for i in range(count):
        total += cycles.at[2 * cycles.columns + i] - cycles.at[i]
    return total


cdef double recurring(FloatRows scores, Int32Rows cycles, int64_t count) noexcept nogil:
    """Return the correlation of the posture with the posture one mean cycle later, from -1 to 1, over all cycles."""
    cdef int64_t lag, k, n, i
    cdef int32_t begin
    cdef double product, one, other
    cdef Floats row
    cdef float u, v, uu, vv, uv, a, b
    lag = <int64_t>(<double>duration(cycles, count) / count + 0.5)
    begin, n = cycles.at[0], cycles.at[2 * cycles.columns + (count - 1)] - cycles.at[0] - lag
    if n < 2:
        return 0.0
    product, one, other = 0.0, 1e-18, 1e-18
    for k in range(COMPONENTS):
        row = row_of_floats(scores, k)
        u = v = uu = vv = uv = <float>0.0
        for i in range(begin, begin + n):
            a, b = row.at[i], row.at[i + lag]
            u += a
            v += b
            uu += a * a
            vv += b * b
            uv += a * b
        product += <double>(uv - u * v / <float>n)
        one += <double>(uu - u * u / <float>n)
        other += <double>(vv - v * v / <float>n)
    return product / sqrt(one * other)


cdef (double, int64_t) goes_on(
    Counting* header, int64_t n, FloatRows smooth, int32_t* cycle, int64_t step, int64_t last
) noexcept nogil:
    """Return the share of one more cycle after the end of a cycle (step 1) or before its start (-1), and its last sample.

    Args:
        header: `Counting`.
        n: Samples in the window.
        smooth: (COMPONENTS, n) scores.
        cycle: (3,) start, far extreme, end.
        step: 1 or -1.
        last: Last sample to examine.
    """
    cdef int32_t begun, start, far, end, goal
    cdef int64_t there, here, q, one, other, best, place
    cdef double most, lasted, least
    cdef float apart
    start, far, end = cycle[0], cycle[1], cycle[2]
    here, there, goal = (end, start, end) if step == 1 else (start, end, start)
    begun = there
    most = SAME_POSTURE * distance(smooth, start, far)
    lasted = header.at[ring_place(header, n, end)] - header.left[ring_place(header, n, start)]
    while here != last and there != goal:
        one, other = (here, here + 1) if step == 1 else (here - 1, here)
        if (
            header.at[ring_place(header, n, other)] - header.left[ring_place(header, n, one)]
            > LONGEST_STOP * lasted + STAMP_ROUNDING
        ):
            break
        best, least = there, INFINITY
        for q in range(3):
            place = there + q * step
            if (goal - place) * step < 0:
                break
            apart = distance(smooth, here + step, place)
            if apart < least:
                best, least = place, apart
        if least > most:
            break
        here, there = here + step, best
    return (<double>magnitude(there - begun) / (end - start), here)


cdef float distance(FloatRows smooth, int64_t i, int64_t j) noexcept nogil:
    """Return the distance of two samples of the window, m over all joints."""
    cdef float total
    cdef int64_t k
    total = <float>0.0
    for k in range(COMPONENTS):
        total += squared_float(smooth.at[k * smooth.columns + i] - smooth.at[k * smooth.columns + j])
    return sqrtf(total)


cdef (double, double) dwelling_of(
    Counting* header, int64_t n, Floats scores, int32_t start, int32_t far, int32_t end
) noexcept nogil:
    """Return the time that a cycle spends in the quarter where it begins, and in that of its other extreme, s."""
    cdef float sign, near, away, begin, top
    cdef int32_t q
    cdef double dwelling, distant, lasted
    begin, top = scores.at[start], scores.at[far]
    sign = <float>1.0 if top > begin else <float>(-1.0)
    near = sign * (begin + <float>0.25 * (top - begin))
    away = sign * (begin + <float>0.75 * (top - begin))
    dwelling, distant = 0.0, 0.0
    for q in range(start, end):
        lasted = header.at[ring_place(header, n, q + 1)] - header.at[ring_place(header, n, q)]
        dwelling += lasted if sign * scores.at[q] < near else 0.0
        distant += lasted if sign * scores.at[q] > away else 0.0
    return dwelling, distant


cdef double rest_pose_nearness(Samples* samples, Int32Rows cycles, int64_t count) noexcept nogil:
    """Return how much nearer the starts of cycles are to the rest pose than their other extremes, from -1 to 1."""
    cdef int64_t i
    cdef double begin, far
    cdef float near, distant
    begin, far = 0.0, 0.0
    for i in range(count):
        near, distant = rest_pose_distances(samples, cycles.at[i], cycles.at[cycles.columns + i])
        begin, far = begin + near, far + distant
    return (far - begin) / max(begin + far, 1e-9)


cdef (float, float) rest_pose_distances(Samples* samples, int32_t start, int32_t far) noexcept nogil:
    """Return the distances of two samples from the rest pose, m over all joints."""
    cdef float one, other
    cdef int64_t k
    one = other = <float>0.0
    for k in range(COMPONENTS):
        one += squared_float(samples.smooth.at[k * samples.smooth.columns + start] - samples.rest_pose_scores.at[k])
        other += squared_float(samples.smooth.at[k * samples.smooth.columns + far] - samples.rest_pose_scores.at[k])
    return (sqrtf(one), sqrtf(other))
