"""Sampling: a pose becomes a sample when it differs from the last sample by a share of the movement.

The number of samples in a cycle does not depend on its duration, and a rest has one sample. Joints are relative to the root.
The root keeps its own path, since squats and jumps move it most. Each coordinate is the median of three frames in a row,
which removes a joint that leaps for one frame.
"""

cdef double ROUNDING = 0.003  # frames; s: of timestamps as exact as those since 1970
cdef double STAMP_ROUNDING = 0.0001
cdef double SHORTEST_BONE = 0.03  # m; a shorter bone does not show the pose of a limb
cdef double LEAST_STEP = 0.02  # of the size of the body, rms over joints, between samples
cdef double STAYS = 0.1  # of the square of a step, within which a pose still belongs to the sample
cdef double MEDIAN = 0.45  # variance of the median of three numbers, relative to the variance of each
cdef double STEP_ABOVE_NOISE = 3.0  # times the squared difference of two samples by noise alone
cdef double FOLLOWS = 0.2  # weight of the latest three poses in the estimate of the noise
# Squared bend over squared way: larger in noise (3), smaller in motion.
cdef double TURNS_BACK = 1.5
cdef double RETURNED = 0.25  # of the squared farthest distance, within which a pose has come back
cdef enum:
    RETURNS = 3  # after which the step is made smaller,
cdef double SHARE_OF_SMALL = 0.1  # to this share of that square
cdef double LONGEST_REST = 30.0  # s; after a longer rest the window begins anew


cdef double next_wanted(double origin, double time) noexcept nogil:
    """Return the earliest time of the next frame to process, s, at `MOST_RATE`.

    Args:
        origin: s, of the take.
        time: Of the frame, s.
    """
    return origin + (floor((time - origin) * MOST_RATE + ROUNDING) + 1) / MOST_RATE - STAMP_ROUNDING


cdef inline void take_frame(Counting* header, Samples* samples, float* position, double time) noexcept nogil:
    """Process one frame of a take, if its time has come; no analysis is due before it.

    Args:
        header: `Counting`.
        samples: `Samples`.
        position: (J, 3) float32, m, NaN where missing.
        time: s.
    """
    header.latest = time
    if time >= header.wanted:
        header.wanted = next_wanted(header.origin, time)
        take_pose(header, samples, position, time)


cdef void take_pose(Counting* header, Samples* samples, float* positions, double time) noexcept nogil:
    """Process a frame; a coordinate that is missing, or too far off to be true, keeps its last value.

    Args:
        header: `Counting`.
        samples: `Samples`.
        positions: (J, 3) float32, m, NaN where missing.
        time: s.
    """
    cdef int64_t r, j, k
    cdef Floats pose
    cdef double since
    cdef float x, y, z, share, a, b, c
    r = header.root
    pose = samples.pose
    x, y, z = _sampling_place(positions[3 * r]), _sampling_place(positions[3 * r + 1]), _sampling_place(positions[3 * r + 2])
    if header.unseen > 0:
        _appear(header, samples, positions)
    for j in range(header.joints):
        k = 3 * j
        a = _sampling_place(positions[3 * j]) - x
        b = _sampling_place(positions[3 * j + 1]) - y
        c = _sampling_place(positions[3 * j + 2]) - z
        pose.at[k] = pose.at[k] if isnan(a) else a
        pose.at[k + 1] = pose.at[k + 1] if isnan(b) else b
        pose.at[k + 2] = pose.at[k + 2] if isnan(c) else c
    if header.travels == 1:
        k = 3 * r
        pose.at[k] = pose.at[k] if isnan(x) else x
        pose.at[k + 1] = pose.at[k + 1] if isnan(y) else y
        pose.at[k + 2] = pose.at[k + 2] if isnan(z) else z
    since = time - header.origin
    if header.frames == 0:
        for k in range(pose.count):
            samples.before.at[k] = samples.older.at[k] = pose.at[k]
        header.middle = since
        header.size = _size(header, samples.pose)
        header.quantum = max(SMALLEST_QUANTUM, LEAST_REACH * sqrt(header.size / header.joints) / MOST_QUANTA)
        header.per_quantum = <float>1.0 / header.quantum
        append_sample(header, samples, samples.before)
    else:
        _sampling_follow(header, samples)
    header.middle = since
    header.frames += 1
    if header.frames <= REST_POSE_FRAMES:
        share = <float>(1.0 / header.frames)
        for k in range(pose.count):
            samples.rest_pose.at[k] += <float>0.0 if isnan(pose.at[k]) else share * (pose.at[k] - samples.rest_pose.at[k])


cdef inline float _sampling_place(float coordinate) noexcept nogil:
    """Return a coordinate, m, or NaN if it is no position: its square would outweigh the rest of the pose."""
    return coordinate if abs(coordinate) <= FARTHEST else NAN


cdef void _sampling_follow(Counting* header, Samples* samples) noexcept nogil:
    """Update noise and samples with the newest pose."""
    cdef Floats last, pose, before, older
    cdef float bend, way, moved, middle, apart, a, b, c, low, high, turn, went
    cdef int64_t k
    cdef double least, still, step, noise
    pose = samples.pose
    before = samples.before
    older = samples.older
    last = samples.last
    bend = way = moved = <float>0.0
    for k in range(pose.count):
        a, b, c = older.at[k], before.at[k], pose.at[k]
        low, high = min(a, b), max(a, b)
        middle = max(low, min(high, c))
        older.at[k] = middle
        turn, went = a - b + (c - b), c - a
        apart = middle - last.at[k]
        bend += <float>0.0 if isnan(turn) else turn * turn
        way += <float>0.0 if isnan(went) else went * went
        moved += <float>0.0 if isnan(apart) else apart * apart
    if header.frames > 1:
        noise = bend / 6.0
        if noise < header.noise or bend > TURNS_BACK * way:
            header.noise += FOLLOWS * (noise - header.noise)
    least = LEAST_STEP * LEAST_STEP * header.size
    still = STEP_ABOVE_NOISE * 2.0 * MEDIAN * header.noise
    step = max(header.step, least)
    if moved > still + step:
        append_sample(header, samples, older)
        header.wander, header.returns = 0.0, 0
    else:
        if moved <= still + STAYS * step:
            header.left[(header.open - 1) % SAMPLES] = header.middle
        _wander(header, moved - still, least)
    for k in range(pose.count):
        older.at[k] = before.at[k]
        before.at[k] = pose.at[k]


cdef void _wander(Counting* header, double square, double least) noexcept nogil:
    """Make the step smaller if the pose goes out and back several times without a new sample.

    Args:
        header: `Counting`.
        square: m², squared distance from the last sample.
        least: m², the smallest step.
    """
    if square > header.wander:
        header.wander = square
    elif header.wander > 4.0 * least and square < RETURNED * header.wander:
        header.returns += 1
        if header.returns == RETURNS:
            header.step = SHARE_OF_SMALL * header.wander
            header.fine = header.open - 1
            header.returns = 0
        header.wander = 0.0


cdef double _size(Counting* header, Floats pose) noexcept nogil:
    """Return the sum of the squared distances of joints from their centre, m²."""
    cdef int64_t c, n, j, seen
    cdef double total, mean, squares
    cdef float value
    total, n = 0.0, pose.count // 3
    for c in range(3):
        mean, squares, seen = 0.0, 0.0, 0
        for j in range(n):
            value = <float>0.0 if j == header.root else pose.at[3 * j + c]
            if not isnan(value):
                mean += value
                squares += squared_float(value)
                seen += 1
        if seen > 0:
            total += (squares - mean * mean / seen) * n / seen
    return total


cdef void append_sample(Counting* header, Samples* samples, Floats pose) noexcept nogil:
    """Put a pose into the ring, at the time of the middle frame."""
    cdef int64_t place, k, c
    place = header.open % SAMPLES
    if header.open > 0 and header.middle - header.left[(header.open - 1) % SAMPLES] > LONGEST_REST + STAMP_ROUNDING:
        header.first = header.open - 1
    for k in range(pose.count):
        samples.last.at[k] = <float>0.0 if isnan(pose.at[k]) else pose.at[k]
        samples.ring.at[k * samples.ring.columns + place] = _in_quanta(header, samples.last.at[k])
    for c in range(3):
        samples.root.at[c * samples.root.columns + place] = samples.last.at[3 * header.root + c]
    header.at[place] = header.left[place] = header.middle
    samples.straight.at[place] = _sampling_straightness(header, samples.last)
    header.open += 1
    if header.open >= header.analysed + STRIDE:
        header.due = header.latest
    else:
        header.due = min(header.due, header.latest + ANALYSIS_INTERVAL - STAMP_ROUNDING)


cdef inline int16_t _in_quanta(Counting* header, float coordinate) noexcept nogil:
    """Return a coordinate, m, as the nearest multiple of the quantum, clipped to the largest one."""
    return <int16_t>min(max(rintf(coordinate * header.per_quantum), -MOST_QUANTA), MOST_QUANTA)


cdef void _appear(Counting* header, Samples* samples, float* positions) noexcept nogil:
    """Write the first value of a coordinate into all earlier samples, as if it had always been there."""
    cdef int64_t j, c, k, i
    cdef bint own
    cdef float value
    for j in range(header.joints):
        for c in range(3):
            k = 3 * j + c
            own = j == header.root and header.travels == 1
            value = _sampling_place(positions[3 * j + c])
            value -= <float>0.0 if own else _sampling_place(positions[3 * header.root + c])
            if isnan(value) or not isnan(samples.pose.at[k]):
                continue
            header.unseen -= 1
            for i in range(SAMPLES):
                samples.ring.at[k * samples.ring.columns + i] = _in_quanta(header, value)
                if j == header.root:
                    samples.root.at[c * samples.root.columns + i] = value
            samples.rest_pose.at[k] = samples.last.at[k] = samples.before.at[k] = samples.older.at[k] = value


cdef double _sampling_straightness(Counting* header, Floats pose) noexcept nogil:
    """Return the mean straightness of limbs, 0 to 2.

    It is the distance of the ends of two bones plus their difference in height, over the sum of the bones' lengths.
    """
    cdef int64_t k, count
    cdef double total, one, other, ends, above
    total, count = 0.0, 0
    for k in range(header.chains):
        one = _sampling_distance(header, pose, header.chain[k][0], header.chain[k][1])
        other = _sampling_distance(header, pose, header.chain[k][1], header.chain[k][2])
        if min(one, other) >= SHORTEST_BONE:
            ends = _sampling_distance(header, pose, header.chain[k][0], header.chain[k][2])
            above = abs(_height(header, pose, header.chain[k][0]) - _height(header, pose, header.chain[k][2]))
            total += (ends + above) / (one + other)
            count += 1
    return total / count if count > 0 else 0.0


cdef double _height(Counting* header, Floats pose, int64_t i) noexcept nogil:
    """Return the height of a joint above the root, m; y is up."""
    return 0.0 if i == header.root else <double>pose.at[3 * i + 1]


cdef double _sampling_distance(Counting* header, Floats pose, int64_t i, int64_t j) noexcept nogil:
    cdef double total, a, b
    cdef int64_t c
    total = 0.0
    for c in range(3):
        a = 0.0 if i == header.root else <double>pose.at[3 * i + c]
        b = 0.0 if j == header.root else <double>pose.at[3 * j + c]
        total += squared(a - b)
    return sqrt(total)
