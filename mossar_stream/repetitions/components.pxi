"""Leading principal components of the posture over the window, by two power iterations per analysis.

The window changes little between two analyses. Two steps of the subspace iteration from the axes of the last analysis are
enough; the first analysis of a movement makes four.
"""

cdef double SWING_ABOVE_NOISE = 2.56 * 1.1  # times the standard deviation of normal noise, with a margin
cdef enum:
    LAST = COMPONENTS - 1
cdef double SHARE = 0.3  # of the standard deviation of the movement, between samples
cdef double LEAST_SWING = 0.03  # of the size of the body, rms over joints: a standing performer may sway as far


cdef int64_t find_components(Counting* header, Samples* samples, CountingScratch* scratch) noexcept nogil:
    """Set axes, scores in the order of time, and the least swing of a cycle, for the samples in the window.

    Args:
        header: `Counting`.
        samples: `Samples`; the iteration begins with the axes of the last analysis.
        scratch: `CountingScratch`.

    Returns:
        Number of samples in the window.
    """
    cdef int64_t n, oldest, _, fine
    cdef bint lost
    n = window_size(header)
    oldest = ring_place(header, n, 0)
    _lay_out(header, samples, n, oldest)
    lost = _begin_axes(samples, n)
    for _ in range(4 if lost else 2):
        _project(samples, n)
        _turn_axes(samples, n)
    _project(samples, n)
    _project_rest_pose(samples)
    scratch.least = max(header.least * sqrt(header.joints), LEAST_SWING * sqrt(header.size))
    scratch.least = max(scratch.least, _noise_swing(header, samples, n))
    fine = max(header.fine - (header.open - n), n - RECENT, 0)
    if n - fine >= LEAST_SAMPLES:
        header.step = SHARE * SHARE * _spread(samples, fine, n)
    return n


cdef void _lay_out(Counting* header, Samples* samples, int64_t n, int64_t oldest) noexcept nogil:
    """Set the coordinates of the window in the order of time, m, and the rest of each row to 0."""
    cdef int64_t k, c, until, i
    cdef float quantum
    cdef Floats rest, row, path
    cdef Shorts ring
    until, quantum = min(n, SAMPLES - oldest), header.quantum
    for k in range(samples.pose.count):
        row = row_of_floats(samples.by_coordinate, k)
        ring = row_of_shorts(samples.ring, k)
        _to_metres(part_of_floats(row, 0, until), part_of_shorts(ring, oldest, oldest + until), quantum)
        _to_metres(part_of_floats(row, until, n), part_of_shorts(ring, 0, n - until), quantum)
        rest = from_floats(row, n)
        for i in range(rest.count):
            rest.at[i] = <float>0.0
    for c in range(3):
        row = row_of_floats(samples.by_coordinate, 3 * header.root + c)
        path = row_of_floats(samples.root, c)
        _components_copy(part_of_floats(row, 0, until), part_of_floats(path, oldest, oldest + until))
        _components_copy(part_of_floats(row, until, n), part_of_floats(path, 0, n - until))


cdef inline void _to_metres(Floats goal, Shorts quanta, float quantum) noexcept nogil:
    cdef int64_t i
    for i in range(goal.count):
        goal.at[i] = <float>quanta.at[i] * quantum


cdef inline void _components_copy(Floats goal, Floats numbers) noexcept nogil:
    cdef int64_t i
    for i in range(goal.count):
        goal.at[i] = numbers.at[i]


cdef double _spread(Samples* samples, int64_t begin, int64_t n) noexcept nogil:
    """Return the sum of the variances of the scores from a sample on, m²."""
    cdef int64_t k, count, i
    cdef double total
    cdef Floats row
    cdef float squares, mean
    total, count = 0.0, n - begin
    for k in range(COMPONENTS):
        row = row_of_floats(samples.scores, k)
        squares = <float>0.0
        mean = <float>0.0
        for i in range(begin, n):
            mean += row.at[i]
            squares += row.at[i] * row.at[i]
        total += squares - <double>squared_float(mean) / count
    return total / count


cdef double _noise_swing(Counting* header, Samples* samples, int64_t n) noexcept nogil:
    """Return the widest swing of the scores of noise alone, from the 10th to the 90th percentile.

    Half of the noise is the root's. It is the same in all J joints and gives its components J times the variance of a
    coordinate's noise. An estimate from n samples of D coordinates adds D / n.
    """
    cdef int64_t size
    cdef double variance
    size = samples.pose.count
    variance = 0.5 * MEDIAN * header.noise / size
    return SWING_ABOVE_NOISE * sqrt((header.joints + 1.0 + <double>size / n) * variance)


cdef bint _begin_axes(Samples* samples, int64_t n) noexcept nogil:
    """Set axes that are zero to the departures from the first sample at four times.

    Axes are zero at the start of a take and while the performer stands still.

    Returns:
        Whether the first axis was zero.
    """
    cdef int64_t begun, k, i, j
    begun = -1
    for k in range(COMPONENTS - 1, -1, -1):
        if _is_zero(row_of_floats(samples.axes, k)):
            begun = k
            i = (k + 1) * (n - 1) // COMPONENTS
            for j in range(samples.pose.count):
                samples.axes.at[k * samples.axes.columns + j] = (
                    samples.by_coordinate.at[j * samples.by_coordinate.columns + i]
                    - samples.by_coordinate.at[j * samples.by_coordinate.columns]
                )
    if begun >= 0:
        _orthonormalise(samples.axes)
    return begun == 0


cdef bint _is_zero(Floats axis) noexcept nogil:
    """Return whether an axis is zero; the loop ends at the first number that is not."""
    cdef int64_t j
    j = 0
    while j < axis.count and axis.at[j] == 0:
        j += 1
    return j == axis.count


cdef void _project(Samples* samples, int64_t n) noexcept nogil:
    """Set the centred scores of the window, and of a pose of zeros."""
    cdef FloatRows scores
    cdef float a, b, c, d, mean
    cdef int64_t i, k
    cdef Floats rest, row
    scores = samples.scores
    weighted_sums(
        scores.at, samples.axes.at, samples.axes.columns,
        samples.by_coordinate.at, samples.by_coordinate.rows, samples.by_coordinate.columns, n,
    )
    a = b = c = d = <float>0.0  # `COMPONENTS` sums side by side
    for i in range(n):
        a += scores.at[i]
        b += scores.at[scores.columns + i]
        c += scores.at[2 * scores.columns + i]
        d += scores.at[3 * scores.columns + i]
    rest = samples.rest_pose_scores
    rest.at[0], rest.at[1], rest.at[2], rest.at[3] = -a, -b, -c, -d
    for k in range(COMPONENTS):
        rest.at[k] /= <float>n
        row = part_of_floats(row_of_floats(scores, k), 0, n)
        mean = rest.at[k]
        for i in range(n):
            row.at[i] += mean


cdef void _project_rest_pose(Samples* samples) noexcept nogil:
    """Turn the scores of a pose of zeros into the scores of the pose `rest_pose`."""
    cdef int64_t j
    cdef FloatRows axes
    cdef Floats rest, scores
    cdef float a, b, c, d
    axes = samples.axes
    rest = samples.rest_pose
    scores = samples.rest_pose_scores
    a, b, c, d = scores.at[0], scores.at[1], scores.at[2], scores.at[3]
    for j in range(rest.count):
        a += axes.at[j] * rest.at[j]
        b += axes.at[axes.columns + j] * rest.at[j]
        c += axes.at[2 * axes.columns + j] * rest.at[j]
        d += axes.at[3 * axes.columns + j] * rest.at[j]
    scores.at[0], scores.at[1], scores.at[2], scores.at[3] = a, b, c, d


cdef void _turn_axes(Samples* samples, int64_t n) noexcept nogil:
    """Multiply the axes by the covariance of the window and make them orthonormal again."""
    line_products(
        samples.axes.at, samples.axes.columns, samples.scores.at,
        samples.by_coordinate.at, samples.by_coordinate.rows, samples.by_coordinate.columns, n,
    )
    _orthonormalise(samples.axes)


cdef void _orthonormalise(FloatRows axes) noexcept nogil:
    """Orthonormalise the axes by Gram and Schmidt; an axis that depends on those before it becomes zero.

    The projection on an axis is subtracted from all later axes before the next one is scaled; their products are
    independent sums.
    """
    cdef int64_t size, k, j
    cdef float scale, a, b, c, square
    cdef Floats axis, one, two, three
    size = axes.columns
    for k in range(COMPONENTS):
        axis = row_of_floats(axes, k)
        square = <float>0.0
        for j in range(size):
            square += axis.at[j] * axis.at[j]
        scale = <float>0.0 if square < <float>1e-12 else <float>1.0 / sqrtf(square)
        for j in range(size):
            axis.at[j] *= scale
        # With fewer than three later axes the last one is taken again: one more sum costs nothing.
        one = row_of_floats(axes, min(k + 1, LAST))
        two = row_of_floats(axes, min(k + 2, LAST))
        three = row_of_floats(axes, LAST)
        a = b = c = <float>0.0
        for j in range(size):
            a += one.at[j] * axis.at[j]
            b += two.at[j] * axis.at[j]
            c += three.at[j] * axis.at[j]
        if k < LAST:
            _take_out(one, axis, a)
        if k + 1 < LAST:
            _take_out(two, axis, b)
        if k + 2 < LAST:
            _take_out(three, axis, c)


cdef inline void _take_out(Floats goal, Floats axis, float product) noexcept nogil:
    cdef int64_t j
    for j in range(goal.count):
        goal.at[j] -= product * axis.at[j]


cdef void smooth_scores(Samples* samples, int64_t n, int64_t width) noexcept nogil:
    """Set `samples.smooth` to the means over a centred window of the scores, shorter at the ends.

    Args:
        samples: `Samples`.
        n: Number of samples, at least `width`.
        width: Samples, odd.
    """
    cdef int64_t half, k, i, apart
    cdef float share, fewer
    cdef Floats row, out
    half = width // 2
    share = <float>1.0 / <float>width
    for k in range(COMPONENTS):
        row = row_of_floats(samples.scores, k)
        out = row_of_floats(samples.smooth, k)
        for i in range(n):
            out.at[i] = row.at[i]
        for apart in range(1, half + 1):
            for i in range(n - apart):
                out.at[i] += row.at[i + apart]
            for i in range(apart, n):
                out.at[i] += row.at[i - apart]
        for i in range(n):
            out.at[i] *= share
        for i in range(half):
            fewer = <float>width / <float>(i + half + 1)
            out.at[i] *= fewer
            out.at[n - 1 - i] *= fewer
