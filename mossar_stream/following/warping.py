"""Warping: a stream's samples aligned with one example, causal, and open at both ends.

Subsequence dynamic time warping (Sakurai, Faloutsos and Yamamuro 2007, "Stream monitoring under the time warping
distance", SPRING) with steps that keep the tempo within 1/2 to 2: a sample comes on by one phase or two, or stays once.

A bone costs the square of the chord between its direction and the example's, at most `CAP`: a limb that the sensor loses
must not outweigh all others. Costs are relative to those of a performer who stands in the example's mean pose. The gain
of a way is the movement of the example that is found in the stream: 1 for all of it, 0 for a performer who stands still
in any pose, because the example's differences from its own mean add up to nothing.
"""

import numpy as np

from mossar_stream.following.layout import LAYERS, LONGER
from mossar_stream.jit.decorators import inline_kernel, kernel

NO_PATH = np.float32(np.inf)
CAME, STAYED = 0, 1  # layers of cells
CAP = np.float32(0.1)  # square of a chord: 18 degrees
UNJUDGED = np.float32(-1.0)  # instead of the square of a chord
LEAST_SEEN = 2.0 / 3.0  # share of a way in which a bone must be seen to be judged
# Chosen on five people and ten exercises, people left out in turn; all lie on wide plateaus (docs/lab-notes/following.md).
WEIGHT_OF_STAYING = np.float32(0.5)  # weight of a sample that stays
STAYING, SKIPPING = np.float32(0.2), np.float32(0.05)  # costs of a step that is not from phase to phase


@kernel
def compare(known, rows, mean, example):
    """Note how far the sample is from each phase of an example, and how far it lies in the direction of its movement.

    Args:
        known: `Memory`; `distances` and `products` are written.
        rows: (B, 3, padded) directions of the example.
        mean: (B, 3) their means.
        example: FOLLOWED.
    """
    directions, distances, products = known.directions, known.distances, known.products
    count = example.padded
    for j in range(count):
        distances[j] = np.float32(0.0)
        products[j] = np.float32(0.0)
    along = np.float32(0.0)
    two = np.float32(2.0)
    for b in range(rows.shape[0]):
        x, y, z = directions[b, 0], directions[b, 1], directions[b, 2]
        along += x * mean[b, 0] + y * mean[b, 1] + z * mean[b, 2]
        for j in range(count):
            product = x * rows[b, 0, j] + y * rows[b, 1, j] + z * rows[b, 2, j]
            square = two - two * product
            products[j] += product
            distances[j] += min(CAP, square)
    share = np.float32(1.0) / np.float32(rows.shape[0])
    cost, gain = share / np.float32(example.dear), share / np.float32(example.still)
    for j in range(count):
        distances[j] *= cost
        products[j] = gain * (products[j] - along)


@kernel
def advance(cells, known, sample, at):
    """Let every way come on by the sample that was compared.

    Args:
        cells: `Cells`.
        known: `Memory`.
        sample: Number of the sample.
        at: Line of `steps` to write.
    """
    costs, gains, weights, firsts, steps = cells.costs, cells.gains, cells.weights, cells.firsts, cells.steps
    distances, products = known.distances, known.products
    for j in range(costs.shape[1] - 1, 0, -1):
        distance = distances[j]
        costs[STAYED, j] = costs[CAME, j] + WEIGHT_OF_STAYING * distance + STAYING
        gains[STAYED, j] = gains[CAME, j]
        weights[STAYED, j] = weights[CAME, j] + WEIGHT_OF_STAYING
        firsts[STAYED, j] = firsts[CAME, j]
        layer, back = CAME, 1
        cost = costs[CAME, j - 1] + distance
        if costs[STAYED, j - 1] + distance < cost:
            layer, cost = STAYED, costs[STAYED, j - 1] + distance
        if j >= 2:
            both = distance + distances[j - 1] + SKIPPING
            for other in range(LAYERS):
                if costs[other, j - 2] + both < cost:
                    layer, back, cost = other, 2, costs[other, j - 2] + both
        costs[CAME, j] = cost
        gain = gains[layer, j - back] + products[j]
        gains[CAME, j] = gain + products[j - 1] if back == 2 else gain
        weights[CAME, j] = weights[layer, j - back] + np.float32(back)
        firsts[CAME, j] = firsts[layer, j - back]
        steps[at, j] = 2 * layer + back - 1
    costs[STAYED, 0] = costs[CAME, 0] + WEIGHT_OF_STAYING * distances[0] + STAYING
    gains[STAYED, 0] = gains[CAME, 0]
    weights[STAYED, 0] = weights[CAME, 0] + WEIGHT_OF_STAYING
    firsts[STAYED, 0] = firsts[CAME, 0]
    costs[CAME, 0] = distances[0]
    gains[CAME, 0] = products[0]
    weights[CAME, 0] = np.float32(1.0)
    firsts[CAME, 0] = sample


@kernel
def forget(cells, before):
    """Give up the ways that began before a sample."""
    for layer in range(LAYERS):
        for j in range(cells.costs.shape[1]):
            if cells.firsts[layer, j] < before:
                cells.costs[layer, j] = NO_PATH


@kernel
def trace(cells, way, layer, phase, last, first):
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
    ring = 2 * cells.costs.shape[1] + LONGER
    count, at = 0, last
    while count < way.shape[1] - 1:
        count = _write(way, count, at, phase)
        if layer == STAYED:
            layer, at = CAME, at - 1
            continue
        if phase == 0 or at <= first:
            break
        step = cells.steps[at % ring, phase]
        if step % 2 == 1:
            count = _write(way, count, at, phase - 1)
        phase -= step % 2 + 1
        layer, at = step // 2, at - 1
    return count


@inline_kernel
def _write(way, count, at, phase):
    way[0, count], way[1, count] = at, phase
    return count + 1


@kernel
def measure(known, rows, samples, count, strays):
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
    means, way = known.means, known.way
    ring, hidden = samples
    share = np.float32(1.0) / np.float32(count)
    total = np.float32(0.0)
    for b in range(strays.size):
        square = seen = np.float32(0.0)
        for d in range(3):
            means[b, d] = np.float32(0.0)
        for k in range(count):
            line, phase = way[0, k] % ring.shape[0], way[1, k]
            is_seen = np.float32(1 - hidden[line, b])
            seen += is_seen
            for d in range(3):
                difference = ring[line, b, d] - rows[b, d, phase]
                means[b, d] += share * difference
                square += is_seen * difference * difference
        strays[b] = square * (np.float32(1.0) / seen) if seen >= LEAST_SEEN * count else UNJUDGED
        for k in range(count):
            line, phase = way[0, k] % ring.shape[0], way[1, k]
            left = np.float32(0.0)
            for d in range(3):
                difference = ring[line, b, d] - rows[b, d, phase] - means[b, d]
                left += difference * difference
            total += min(left, CAP)
    return total * share / np.float32(strays.size)
