"""Warping: a stream's samples aligned with one example, causal, and open at both ends.

Subsequence dynamic time warping (Sakurai, Faloutsos and Yamamuro 2007, "Stream monitoring under the time
warping distance", SPRING) with steps that keep the tempo within 1/2 to 2: a sample comes on by one phase or
two, or stays once.

A bone costs the square of the chord between its direction and the example's, at most `CAP`: a limb that the
sensor loses must not outweigh all others. Costs are relative to those of a performer who stands in the
example's mean pose. The gain of a way is the movement of the example that is found in the stream: 1 for all
of it, 0 for a performer who stands still in any pose, because the example's differences from its own mean add
up to nothing.
"""

cdef enum:  # layers of cells
    CAME = 0
    STAYED = 1
cdef float CAP = 0.1  # square of a chord: 18 degrees
cdef float UNJUDGED = -1.0  # instead of the square of a chord
cdef double LEAST_SEEN = 2.0 / 3.0  # share of a way in which a bone must be seen to be judged
# Chosen on five people and ten exercises, people left out in turn; all lie on wide plateaus
# (docs/lab-notes/following.md).
cdef float WEIGHT_OF_STAYING = 0.5  # weight of a sample that stays
cdef float STAYING = 0.2  # cost of a step that stays in its phase,
cdef float SKIPPING = 0.05  # and of one that skips a phase


cdef void compare_sample(FollowMemory* known, FollowBank* bank, FollowedExample* example) noexcept nogil:
    """Note how far the sample is from each phase of an example, and how far in its movement's direction.

    Args:
        known: The performer's memory; `distances` and `products` are written.
        bank: The followed examples.
        example: One of its examples.
    """
    cdef float* distances
    cdef float* products
    cdef const float* direction
    cdef const float* mean
    cdef const float* row
    cdef float along, share, cost, gain, x, y, z, product, square
    cdef int64_t count, j, b
    distances, products = known.distances, known.products
    count = example.padded
    for j in range(count):
        distances[j] = 0.0
        products[j] = 0.0
    along = 0.0
    for b in range(bank.head.bones):
        direction = known.directions.at + 3 * b
        mean = means_of_followed(bank, example).at + 3 * b
        row = row_of_floats(plane_of_floats(directions_of_followed(bank, example), b), 0).at
        x, y, z = direction[0], direction[1], direction[2]
        along += x * mean[0] + y * mean[1] + z * mean[2]
        for j in range(count):
            product = x * row[j] + y * row[count + j] + z * row[2 * count + j]
            square = <float>2.0 - <float>2.0 * product
            products[j] += product
            distances[j] += min(CAP, square)
    share = <float>1.0 / <float>bank.head.bones
    cost, gain = share / <float>example.dear, share / <float>example.still
    for j in range(count):
        distances[j] *= cost
        products[j] = gain * (products[j] - along)


cdef void advance_ways(Cells* cells, FollowMemory* known, int64_t sample) noexcept nogil:
    """Advance every way by the sample that was compared, whose number is given."""
    cdef const float* distances
    cdef const float* products
    cdef int32_t* came_firsts
    cdef int32_t* stayed_firsts
    cdef float* came_costs
    cdef float* stayed_costs
    cdef float* came_weights
    cdef float* stayed_weights
    cdef float* came_gains
    cdef float* stayed_gains
    cdef uint8_t* steps
    cdef float distance, cost, gain, both
    cdef int64_t j, layer, back, other, phases, place
    distances, products = known.distances, known.products
    phases = cells.costs.columns
    came_firsts, stayed_firsts = cells.firsts.at, cells.firsts.at + phases
    came_costs, stayed_costs = cells.costs.at, cells.costs.at + phases
    came_weights, stayed_weights = cells.weights.at, cells.weights.at + phases
    came_gains, stayed_gains = cells.gains.at, cells.gains.at + phases
    steps = cells.steps.at + sample % cells.steps.rows * phases
    for j in range(phases - 1, 0, -1):
        distance = distances[j]
        stayed_costs[j] = came_costs[j] + WEIGHT_OF_STAYING * distance + STAYING
        stayed_gains[j] = came_gains[j]
        stayed_weights[j] = came_weights[j] + WEIGHT_OF_STAYING
        stayed_firsts[j] = came_firsts[j]
        layer, back = CAME, 1
        cost = came_costs[j - 1] + distance
        if stayed_costs[j - 1] + distance < cost:
            layer, cost = STAYED, stayed_costs[j - 1] + distance
        if j >= 2:
            both = distance + distances[j - 1] + SKIPPING
            for other in range(LAYERS):
                if cells.costs.at[other * phases + j - 2] + both < cost:
                    layer, back, cost = other, 2, cells.costs.at[other * phases + j - 2] + both
        place = layer * phases + j - back
        gain = cells.gains.at[place] + products[j]
        came_costs[j] = cost
        came_gains[j] = gain + products[j - 1] if back == 2 else gain
        came_weights[j] = cells.weights.at[place] + <float>back
        came_firsts[j] = cells.firsts.at[place]
        steps[j] = <uint8_t>(2 * layer + back - 1)
    stayed_costs[0] = came_costs[0] + WEIGHT_OF_STAYING * distances[0] + STAYING
    stayed_gains[0] = came_gains[0]
    stayed_weights[0] = came_weights[0] + WEIGHT_OF_STAYING
    stayed_firsts[0] = came_firsts[0]
    came_costs[0] = distances[0]
    came_gains[0] = products[0]
    came_weights[0] = 1.0
    came_firsts[0] = <int32_t>sample


cdef void forget_ways(Cells* cells, int64_t before) noexcept nogil:
    """Give up the ways that began before a sample."""
    cdef int64_t i
    for i in range(LAYERS * cells.costs.columns):
        if cells.firsts.at[i] < before:
            cells.costs.at[i] = INFINITY


cdef int64_t trace(Cells* cells, Int32Rows way, FollowedMove* move) noexcept nogil:
    """Write which samples and phases the way brings together that a move is followed by, the latest first.

    Args:
        cells: Of its example.
        way: (2, any) gets samples and phases, counted in phases of the example.
        move: It ends in `layer` and `phase`; `first` and `last` are its samples.

    Returns:
        How many pairs were written.
    """
    cdef int64_t count, at, layer, phase, step
    count, at, layer, phase = 0, move.last, move.layer, move.phase
    while count < way.columns - 1:
        count = _write_pair(way, count, at, phase)
        if layer == STAYED:
            layer, at = CAME, at - 1
            continue
        if phase == 0 or at <= move.first:
            break
        step = cells.steps.at[in_ring(at, cells.steps.rows) * cells.steps.columns + phase]
        if step % 2 == 1:
            count = _write_pair(way, count, at, phase - 1)
        phase -= step % 2 + 1
        layer, at = step // 2, at - 1
    return count


cdef inline int64_t _write_pair(Int32Rows way, int64_t count, int64_t at, int64_t phase) noexcept nogil:
    way.at[count], way.at[way.columns + count] = <int32_t>at, <int32_t>phase
    return count + 1


cdef float measure_strays(
    FollowMemory* known, FollowBank* bank, FollowedExample* example, int64_t count, float* strays, float* standing
) noexcept nogil:
    """Note how far each bone strays along a traced way, and return the cost without constant differences.

    A performer's build and the sensor's place cause differences that are the same from begin to end; these are taken away.

    Args:
        known: The performer's memory; the way is in `way`.
        bank: The followed examples.
        example: One of its examples.
        count: Of pairs.
        strays: (B,) gets the mean square of the chord where the bone was seen; `UNJUDGED` if it was hidden
            for too long.
        standing: (B,) gets the square of the mean chord, which is the same from begin to end.

    Returns:
        Mean over pairs and bones of the square of the chord that is left, each at most `CAP`.
    """
    cdef FloatPlanes directions
    cdef const float* sample
    cdef const float* shown
    cdef float* mean
    cdef float share, total, square, seen, is_seen, left, difference
    cdef int64_t b, d, k, bones, line
    directions = directions_of_followed(bank, example)
    bones = bank.head.bones
    share = <float>1.0 / <float>count
    total = 0.0
    for b in range(bones):
        square = seen = 0.0
        mean = known.means.at + 3 * b
        mean[0] = mean[1] = mean[2] = 0.0
        for k in range(count):
            line = in_ring(known.way.at[k], known.hidden.rows)
            sample = row_of_ring(known, example.ring, line) + 3 * b
            shown = _shown_at(directions, b, known.way.at[known.way.columns + k])
            is_seen = <float>(1 - known.hidden.at[(example.ring * known.hidden.rows + line) * bones + b])
            seen += is_seen
            for d in range(3):
                difference = sample[d] - shown[d * directions.columns]
                mean[d] += share * difference
                square += is_seen * difference * difference
        strays[b] = square * (<float>1.0 / seen) if seen >= LEAST_SEEN * count else UNJUDGED
        standing[b] = mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]
        for k in range(count):
            sample = row_of_ring(known, example.ring, in_ring(known.way.at[k], known.hidden.rows)) + 3 * b
            shown = _shown_at(directions, b, known.way.at[known.way.columns + k])
            left = 0.0
            for d in range(3):
                difference = sample[d] - shown[d * directions.columns] - mean[d]
                left += difference * difference
            total += min(left, CAP)
    return total * share / <float>bones


cdef inline const float* _shown_at(FloatPlanes directions, int64_t b, int64_t phase) noexcept nogil:
    """Return where the direction of a bone in a phase begins; its three numbers lie a line apart."""
    return directions.at + b * 3 * directions.columns + phase
