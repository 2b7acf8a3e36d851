"""Segment graph: what the paper's path kernel sees of a segment (paper 2.2.1).

Vertices are the joints, each with its Temporal Pyramid Covariance (`pyramid.py`). Edges are the N joint pairs
whose distance d changes most, by the relative range of joint relative distance

    RRJRD = (max d - min d) / mean d

over the segment. Both follow from sums that merge, so that no frame is kept.

Where the paper is silent: a pair whose distance changes by less than 10 µm, or whose joints lie less than 1 mm apart on
average, is no edge, because what it would say is rounding; a segment may therefore have fewer than N edges. RRJRD is
rounded to 1e-9, and ties go to the earlier pair. So pairs that move alike, as those of mirrored or coinciding joints
do, are chosen alike whatever the order of merges.
"""

import numpy as np

from mossar_stream.jit.decorators import kernel
from mossar_stream.similarity.summary import DURATION

STILL = 1e-5  # m; float32 coordinates some metres from the origin are no finer
COINCIDENT = 1e-3  # m
PRECISION = 1e9  # steps of RRJRD per 1


@kernel
def add_distances(params, summary, pose, weight):
    """Add the distances of all joint pairs (i, i + k mod J), k = 1 … J/2, before the summary's duration.

    Rows of equal k over coordinates that are stored twice: contiguous, without index lists, so that it
    vectorises. What stands in the place of padding joints is never read.

    Args:
        params: Record of `kernel.make_params`.
        summary: Summary.
        pose: (4, padded joints), of which 3 rows are coordinates, m; x is NaN where a joint does not count.
        weight: s, > 0.
    """
    padded_joints, size = params.padded_joints, params.pairs
    twice = np.zeros((3, 2 * padded_joints))
    for axis in range(3):
        for j in range(params.joints):
            twice[axis, j] = pose[axis, j]
            twice[axis, params.joints + j] = pose[axis, j]
    far = np.empty(size)
    for row in range(params.rows):
        k = row + 1
        x, y, z = (
            twice[0, k : k + padded_joints],
            twice[1, k : k + padded_joints],
            twice[2, k : k + padded_joints],
        )
        own = far[row * padded_joints : k * padded_joints]
        for i in range(padded_joints):
            dx, dy, dz = x[i] - twice[0, i], y[i] - twice[1, i], z[i] - twice[2, i]
            own[i] = np.sqrt(dx * dx + dy * dy + dz * dz)
    at = params.distances_at
    total, low, high = (
        summary[at : at + size],
        summary[at + size : at + 2 * size],
        summary[at + 2 * size : at + 3 * size],
    )
    if summary[DURATION] == 0.0:
        for d in range(size):
            low[d] = np.inf
            high[d] = -np.inf
    for d in range(size):
        total[d] += weight * far[d]
        low[d] = min(low[d], far[d])
        high[d] = max(high[d], far[d])


@kernel
def rest_in_distances(params, summary, pose, j):
    """Let the distances of a joint have been as they are for as long as a summary lasts, which is not empty."""
    joints, at, size = params.joints, params.distances_at, params.pairs
    for row in range(params.rows):
        k = row + 1
        for i in (j, (j - k) % joints):
            other = (i + k) % joints
            x, y, z = pose[0, i] - pose[0, other], pose[1, i] - pose[1, other], pose[2, i] - pose[2, other]
            pair = at + row * params.padded_joints + i
            far = np.sqrt(x * x + y * y + z * z)
            summary[pair] = summary[DURATION] * far
            summary[pair + size] = summary[pair + 2 * size] = far


@kernel
def merge_distances(params, target, other):
    """Add the distances of another segment; neither summary is empty."""
    at, size = params.distances_at, params.pairs
    for d in range(at, at + size):
        target[d] += other[d]
    for d in range(at + size, at + 2 * size):
        target[d] = min(target[d], other[d])
    for d in range(at + 2 * size, at + 3 * size):
        target[d] = max(target[d], other[d])


@kernel
def _relative_range(params, summary, pair):
    """Return the RRJRD of a pair, 0 if it can be no edge."""
    at = params.distances_at + pair
    low, high = summary[at + params.pairs], summary[at + 2 * params.pairs]
    mean = summary[at] / summary[DURATION]
    if not (high - low >= STILL and mean >= COINCIDENT):  # NaN where one of the two was not seen yet
        return 0.0
    return np.rint((high - low) / mean * PRECISION) / PRECISION


@kernel
def set_edges(params, summary):
    """Set the list of edges: their number, then pairs in increasing order, then their RRJRD."""
    most, joints, padded_joints = params.edges, params.joints, params.padded_joints
    best = np.zeros(most)  # largest first
    ranges = np.empty(params.pairs)
    for row in range(params.rows):
        # The last row of an even number of joints holds each of its pairs twice.
        for i in range(joints if 2 * (row + 1) < joints else joints // 2):
            own = _relative_range(params, summary, row * padded_joints + i)
            ranges[row * padded_joints + i] = own
            if own > best[most - 1]:
                place = most - 1
                while place > 0 and best[place - 1] < own:
                    best[place] = best[place - 1]
                    place -= 1
                best[place] = own
    least = best[most - 1]
    ties = 0
    for place in range(most):
        ties += 1 if best[place] == least and least > 0.0 else 0
    at = params.edges_at + 1
    count = 0
    for row in range(params.rows):
        for i in range(joints if 2 * (row + 1) < joints else joints // 2):
            own = ranges[row * padded_joints + i]
            tied = own == least and ties > 0
            if own > least or tied:
                ties -= 1 if tied else 0
                summary[at + count] = row * padded_joints + i
                summary[at + most + count] = own
                count += 1
    summary[params.edges_at] = count
