"""Warping: a stream's samples aligned with one example, causal, and open at both ends.

Subsequence dynamic time warping (Sakurai, Faloutsos and Yamamuro 2007, "Stream monitoring under the time warping
distance", SPRING) with steps that keep the tempo within 1/2 to 2: a sample comes on by one phase or two, or stays once.

A bone costs the square of the chord between its direction and the example's, at most `CAP`: a limb that the sensor loses
must not outweigh all others. Costs are relative to those of a performer who stands in the example's mean pose. The gain
of a way is the movement of the example that is found in the stream: 1 for all of it, 0 for a performer who stands still
in any pose, because the example's differences from its own mean add up to nothing.
"""

cdef float NO_PATH = inf
cdef enum:
    CAME = 0  # layers of cells
    STAYED = 1
cdef float CAP = 0.10000000149011612  # square of a chord: 18 degrees
cdef float UNJUDGED = -1.0  # instead of the square of a chord
cdef double LEAST_SEEN = 2.0 / 3.0  # share of a way in which a bone must be seen to be judged
# Chosen on five people and ten exercises, people left out in turn; all lie on wide plateaus (docs/lab-notes/following.md).
cdef float WEIGHT_OF_STAYING = 0.5  # weight of a sample that stays
cdef float STAYING = 0.20000000298023224  # costs of a step that is not from phase to phase
cdef float SKIPPING = 0.05000000074505806


cdef void compare(FollowMemory* known, FloatPlanes rows, FloatRows mean, FollowedExample* example) noexcept nogil:
    """Note how far the sample is from each phase of an example, and how far it lies in the direction of its movement.

    Args:
        known: `Memory`; `distances` and `products` are written.
        rows: (B, 3, padded) directions of the example.
        mean: (B, 3) their means.
        example: FOLLOWED.
    """
    cdef int64_t count, j, b
    cdef float along, two, share, cost, gain, x, y, z, product, square
    cdef FloatRows directions
    cdef Floats distances, products
    directions = known.directions
    distances = known.distances
    products = known.products
    count = example.padded
    for j in range(count):
        distances.at[j] = <float>0.0
        products.at[j] = <float>0.0
    along = <float>0.0
    two = <float>2.0
    for b in range(rows.planes):
        x, y, z = directions.at[b * directions.columns + 0], directions.at[b * directions.columns + 1], directions.at[b * directions.columns + 2]
        along += x * mean.at[b * mean.columns + 0] + y * mean.at[b * mean.columns + 1] + z * mean.at[b * mean.columns + 2]
        for j in range(count):
            product = x * rows.at[(b * rows.rows + 0) * rows.columns + j] + y * rows.at[(b * rows.rows + 1) * rows.columns + j] + z * rows.at[(b * rows.rows + 2) * rows.columns + j]
            square = two - two * product
            products.at[j] += product
            distances.at[j] += min(CAP, square)
    share = <float>1.0 / <float>rows.planes
    cost, gain = share / <float>example.dear, share / <float>example.still
    for j in range(count):
        distances.at[j] *= cost
        products.at[j] = gain * (products.at[j] - along)


cdef void warping_advance(Cells* cells, FollowMemory* known, int64_t sample, int64_t at) noexcept nogil:
    """Let every way come on by the sample that was compared.

    Args:
        cells: `Cells`.
        known: `Memory`.
        sample: Number of the sample.
        at: Line of `steps` to write.
    """
    cdef int64_t j, layer, back, other
    cdef FloatRows costs, gains, weights
    cdef Int32Rows firsts
    cdef ByteRows steps
    cdef Floats distances, products
    cdef float distance, cost, gain, both
    costs = cells.costs
    gains = cells.gains
    weights = cells.weights
    firsts = cells.firsts
    steps = cells.steps
    distances = known.distances
    products = known.products
    for j in range(costs.columns - 1, 0, -1):
        distance = distances.at[j]
        costs.at[STAYED * costs.columns + j] = costs.at[CAME * costs.columns + j] + WEIGHT_OF_STAYING * distance + STAYING
        gains.at[STAYED * gains.columns + j] = gains.at[CAME * gains.columns + j]
        weights.at[STAYED * weights.columns + j] = weights.at[CAME * weights.columns + j] + WEIGHT_OF_STAYING
        firsts.at[STAYED * firsts.columns + j] = firsts.at[CAME * firsts.columns + j]
        layer, back = CAME, 1
        cost = costs.at[CAME * costs.columns + (j - 1)] + distance
        if costs.at[STAYED * costs.columns + (j - 1)] + distance < cost:
            layer, cost = STAYED, costs.at[STAYED * costs.columns + (j - 1)] + distance
        if j >= 2:
            both = distance + distances.at[j - 1] + SKIPPING
            for other in range(LAYERS):
                if costs.at[other * costs.columns + (j - 2)] + both < cost:
                    layer, back, cost = other, 2, costs.at[other * costs.columns + (j - 2)] + both
        costs.at[CAME * costs.columns + j] = cost
        gain = gains.at[layer * gains.columns + (j - back)] + products.at[j]
        gains.at[CAME * gains.columns + j] = gain + products.at[j - 1] if back == 2 else gain
        weights.at[CAME * weights.columns + j] = weights.at[layer * weights.columns + (j - back)] + <float>back
        firsts.at[CAME * firsts.columns + j] = firsts.at[layer * firsts.columns + (j - back)]
        steps.at[at * steps.columns + j] = 2 * layer + back - 1
    costs.at[STAYED * costs.columns + 0] = costs.at[CAME * costs.columns + 0] + WEIGHT_OF_STAYING * distances.at[0] + STAYING
    gains.at[STAYED * gains.columns + 0] = gains.at[CAME * gains.columns + 0]
    weights.at[STAYED * weights.columns + 0] = weights.at[CAME * weights.columns + 0] + WEIGHT_OF_STAYING
    firsts.at[STAYED * firsts.columns + 0] = firsts.at[CAME * firsts.columns + 0]
    costs.at[CAME * costs.columns + 0] = distances.at[0]
    gains.at[CAME * gains.columns + 0] = products.at[0]
    weights.at[CAME * weights.columns + 0] = <float>1.0
    firsts.at[CAME * firsts.columns + 0] = sample


cdef void warping_forget(Cells* cells, int64_t before) noexcept nogil:
    """Give up the ways that began before a sample."""
    cdef int64_t layer, j
    for layer in range(LAYERS):
        for j in range(cells.costs.columns):
            if cells.firsts.at[layer * cells.firsts.columns + j] < before:
                cells.costs.at[layer * cells.costs.columns + j] = NO_PATH


cdef int64_t trace(Cells* cells, Int32Rows way, int64_t layer, int64_t phase, int64_t last, int64_t first) noexcept nogil:
    """Write which samples and phases a way brings together, the latest first.

    Args:
        cells: `Cells`.
        way: (2, any) int32.
        layer: Where the way ends.
        phase: The same.
        last: Its last sample, and its first one, counted in phases of the example.
        first: The same.

    Returns:
        How many pairs were written.
    """
    cdef int64_t ring, count, at
    cdef uint8_t step
    # CHECK sign (C truncates): at % ring; step % 2; step // 2
    ring = 2 * cells.costs.columns + LONGER
    count, at = 0, last
    while count < way.columns - 1:
        count = _warping_write(way, count, at, phase)
        if layer == STAYED:
            layer, at = CAME, at - 1
            continue
        if phase == 0 or at <= first:
            break
        step = cells.steps.at[at % ring * cells.steps.columns + phase]
        if step % 2 == 1:
            count = _warping_write(way, count, at, phase - 1)
        phase -= step % 2 + 1
        layer, at = step // 2, at - 1
    return count


cdef inline int64_t _warping_write(Int32Rows way, int64_t count, int64_t at, int64_t phase) noexcept nogil:
    way.at[count], way.at[1 * way.columns + count] = at, phase
    return count + 1


cdef float measure(FollowMemory* known, FloatPlanes rows, (FloatPlanes, ByteRows) samples, int64_t count, Floats strays) noexcept nogil:
    """Note how far each bone strays along a way that was traced, and return the cost without constant differences.

    What a performer's build or the sensor's place changes stays the same from begin to end, and is taken away.

    Args:
        known: `Memory`; the way is in `way`.
        rows: (B, 3, padded) directions of the example.
        samples: (ring, B, 3) directions, and (ring, B) whether each bone was hidden.
        count: Of pairs.
        strays: (B,) gets the mean square of the chord where the bone was seen; `UNJUDGED` if it was hidden for too long.

    Returns:
        Mean over pairs and bones of the square of the chord that is left, each at most `CAP`.
    """
    cdef float share, total, square, seen, is_seen, left, difference
    cdef int64_t b, d, k, line
    cdef FloatRows means
    cdef Int32Rows way
    cdef FloatPlanes ring
    cdef ByteRows hidden
    cdef int32_t phase
    # CHECK sign (C truncates): way[0, k] % ring.shape[0]
    means = known.means
    way = known.way
    ring, hidden = samples
    share = <float>1.0 / <float>count
    total = <float>0.0
    for b in range(strays.count):
        square = seen = <float>0.0
        for d in range(3):
            means.at[b * means.columns + d] = <float>0.0
        for k in range(count):
            line, phase = way.at[k] % ring.planes, way.at[1 * way.columns + k]
            is_seen = <float>(1 - hidden.at[line * hidden.columns + b])
            seen += is_seen
            for d in range(3):
                difference = ring.at[(line * ring.rows + b) * ring.columns + d] - rows.at[(b * rows.rows + d) * rows.columns + phase]
                means.at[b * means.columns + d] += share * difference
                square += is_seen * difference * difference
        strays.at[b] = square * (<float>1.0 / seen) if seen >= LEAST_SEEN * count else UNJUDGED
        for k in range(count):
            line, phase = way.at[k] % ring.planes, way.at[1 * way.columns + k]
            left = <float>0.0
            for d in range(3):
                difference = ring.at[(line * ring.rows + b) * ring.columns + d] - rows.at[(b * rows.rows + d) * rows.columns + phase] - means.at[b * means.columns + d]
                left += difference * difference
            total += min(left, CAP)
    return total * share / <float>strays.count
