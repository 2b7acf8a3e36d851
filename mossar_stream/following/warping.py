"""Warping: a stream's samples aligned with one example, causal, and open at both ends.

Subsequence dynamic time warping (Sakurai, Faloutsos and Yamamuro 2007, "Stream monitoring under the time warping
distance", SPRING) with steps that keep the tempo within 1/2 to 2: a sample comes on by one phase or two, or stays once.
Costs are summed over phases, so that ways of different durations compare.
"""

import numpy as np

from mossar_stream.following.layout import LAYERS
from mossar_stream.jit.decorators import inline_kernel, kernel

NEVER = np.float32(np.inf)
CAME, STAYED = 0, 1  # layers of cells
STAYS = np.float32(0.5)  # weight of a sample that stays


@kernel
def compare(cells, rows, directions, bones):
    """Note the square of the chord between each bone and the example's at each phase, and their mean.

    Args:
        cells: `Cells`.
        rows: (n, 3, lanes) directions of the example.
        directions: (3, lanes) of the sample.
        bones: How many of the lanes are bones.
    """
    parts, distances = cells.parts, cells.distances
    lanes = directions.shape[1]
    share = np.float32(1.0) / np.float32(bones)
    for j in range(distances.size):
        for b in range(lanes):
            x = directions[0, b] - rows[j, 0, b]
            y = directions[1, b] - rows[j, 1, b]
            z = directions[2, b] - rows[j, 2, b]
            parts[j, b] = x * x + y * y + z * z
        total = np.float32(0.0)
        for b in range(bones):
            total += parts[j, b]
        distances[j] = share * total


@kernel
def advance(cells, time):
    """Let every way come on by the sample that was compared.

    Args:
        cells: `Cells`.
        time: s, of the sample.
    """
    costs, distances = cells.costs, cells.distances
    for j in range(distances.size - 1, -1, -1):
        _stay(cells, j)
        if j == 0:
            _begin(cells, time)
            continue
        layer, back, cost = CAME, 1, costs[CAME, j - 1] + distances[j]
        if costs[STAYED, j - 1] + distances[j] < cost:
            layer, cost = STAYED, costs[STAYED, j - 1] + distances[j]
        if j >= 2:
            both = distances[j] + distances[j - 1]
            for other in range(LAYERS):
                if costs[other, j - 2] + both < cost:
                    layer, back, cost = other, 2, costs[other, j - 2] + both
        costs[CAME, j] = cost
        if cost < NEVER:
            _come(cells, j, layer, back)


@inline_kernel
def _stay(cells, j):
    costs, weights, sums, parts = cells.costs, cells.weights, cells.sums, cells.parts
    costs[STAYED, j] = costs[CAME, j] + STAYS * cells.distances[j]
    if not costs[STAYED, j] < NEVER:
        return
    cells.starts[STAYED, j] = cells.starts[CAME, j]
    weights[STAYED, j] = weights[CAME, j] + STAYS
    for b in range(parts.shape[1]):
        sums[STAYED, j, b] = sums[CAME, j, b] + STAYS * parts[j, b]


@inline_kernel
def _begin(cells, time):
    cells.costs[CAME, 0] = cells.distances[0]
    cells.starts[CAME, 0] = time
    cells.weights[CAME, 0] = np.float32(1.0)
    for b in range(cells.parts.shape[1]):
        cells.sums[CAME, 0, b] = cells.parts[0, b]


@inline_kernel
def _come(cells, j, layer, back):
    cells.starts[CAME, j] = cells.starts[layer, j - back]
    cells.weights[CAME, j] = cells.weights[layer, j - back] + np.float32(back)
    sums, parts = cells.sums, cells.parts
    for b in range(parts.shape[1]):
        sums[CAME, j, b] = sums[layer, j - back, b] + parts[j, b]
    if back == 2:
        for b in range(parts.shape[1]):
            sums[CAME, j, b] += parts[j - 1, b]


@kernel
def forget(cells, before):
    """Give up the ways that began before a time, s."""
    for layer in range(LAYERS):
        for j in range(cells.distances.size):
            if cells.starts[layer, j] < before:
                cells.costs[layer, j] = NEVER
