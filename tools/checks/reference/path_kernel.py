"""The path kernel as the paper states it, on whole arrays and path by path: the oracle of the fast one.

Nothing here is quick or incremental. A segment is all its frames; every path that two graphs share is visited,
"walks in each of which all vertices are distinct" (section 2.2.2), those of length zero included. Where the
paper is silent, this follows `graph.pxi`, `pyramid.pxi` and `kernel.pxi`.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import prod

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import AT_REST, BIN_RATE, COINCIDENT, PRECISION, STILL
from mossar_stream.settings import KernelForm
from mossar_stream.similarity.path_kernel.kernel import DECAY, DIAGONAL, MOST_BINS

Edge = tuple[int, int]


class SegmentGraph(msgspec.Struct, frozen=True):
    """The graph of a segment.

    Args:
        covariances: (J, 6 s) m², Temporal Pyramid Covariance of each joint.
        edges: RRJRD of the chosen joint pairs.
        duration: s.
    """

    covariances: NDArray[np.float64]
    edges: dict[Edge, float]
    duration: float


def simple_paths(vertices: int, edges: Sequence[Edge]) -> Iterator[tuple[int, ...]]:
    """Yield every simple path of an undirected graph once, from its smaller end, single vertices too."""
    neighbours: list[list[int]] = [[] for _ in range(vertices)]
    for u, v in edges:
        neighbours[u].append(v)
        neighbours[v].append(u)

    def extensions(path: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
        if path[0] <= path[-1]:
            yield path
        for vertex in neighbours[path[-1]]:
            if vertex not in path:
                yield from extensions((*path, vertex))

    for start in range(vertices):
        yield from extensions((start,))


def path_sum(vertex_weights: Sequence[float], edges: Sequence[Edge], edge_weights: Sequence[float]) -> float:
    """Sum the products of the weights over all simple paths.

    Args:
        vertex_weights: (V,).
        edges: (E, 2), pairs of different vertices, no pair twice.
        edge_weights: (E,).
    """
    weight = {frozenset(edge): w for edge, w in zip(edges, edge_weights, strict=True)}
    return sum(
        prod(vertex_weights[v] for v in path) * prod(weight[frozenset(step)] for step in pairwise(path))
        for path in simple_paths(len(vertex_weights), edges)
    )


def segment_graph(
    positions: NDArray[np.float64],
    times: NDArray[np.float64],
    weights: NDArray[np.float64],
    edges: int,
    layers: int,
) -> SegmentGraph:
    """Return the graph of a segment.

    Args:
        positions: (n, J, 3) m, relative to the centre.
        times: (n,) s.
        weights: (n,) s that each frame stands for, > 0.
        edges: N.
        layers: L.
    """
    parts = [
        _covariances(positions[part == i], weights[part == i])
        for layer in range(1, layers + 1)
        for part in [_parts(times, layer)]
        for i in range(layer)
    ]
    return SegmentGraph(
        np.concatenate(parts, axis=1), top_edges(positions, weights, edges), float(weights.sum())
    )


def _parts(times: NDArray[np.float64], layer: int) -> NDArray[np.int64]:
    """Return for every frame which of the layer's equal parts it belongs to."""
    bins = np.floor(times * BIN_RATE).astype(np.int64)
    while layer > 1 and bins[-1] - bins[0] >= MOST_BINS:
        bins >>= 1
    bins -= bins[0]
    parts: NDArray[np.int64] = (2 * bins + 1) * layer // (2 * (bins[-1] + 1))
    return parts


def _covariances(positions: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the 6 upper elements of each joint's covariance over some frames, (J, 6) m²; 0 without a frame."""
    if not len(weights):
        return np.zeros((positions.shape[1], 6))
    away = positions - np.average(positions, axis=0, weights=weights)
    rows, columns = np.triu_indices(3)
    products: NDArray[np.float64] = np.average(
        away[:, :, rows] * away[:, :, columns], axis=0, weights=weights
    )
    return products


def top_edges(positions: NDArray[np.float64], weights: NDArray[np.float64], count: int) -> dict[Edge, float]:
    """Return the joint pairs with the largest RRJRD, fewer where fewer distances change."""
    joints = positions.shape[1]
    found: dict[Edge, float] = {}
    for offset in range(1, joints // 2 + 1):
        for i in range(joints if 2 * offset < joints else joints // 2):
            distance = np.linalg.norm(positions[:, i] - positions[:, (i + offset) % joints], axis=1)
            mean, change = np.average(distance, weights=weights), np.ptp(distance)
            if change >= STILL and mean >= COINCIDENT:
                found[i, (i + offset) % joints] = np.rint(change / mean * PRECISION) / PRECISION
    best = sorted(found, key=lambda pair: -found[pair])  # stable: ties go to the earlier pair
    return {pair: found[pair] for pair in best[:count]}


def kernel(a: SegmentGraph, b: SegmentGraph, form: KernelForm) -> float:
    """Return K, by a visit of every common path."""
    decay = DECAY if form == "damped" else 1.0
    vertices = [_vertex_kernel(x, y, form) for x, y in zip(a.covariances, b.covariances, strict=True)]
    common = [pair for pair in a.edges if pair in b.edges]
    ratios = [decay * min(a.edges[e], b.edges[e]) / max(a.edges[e], b.edges[e]) for e in common]
    return path_sum(vertices, common, ratios)


def _vertex_kernel(x: NDArray[np.float64], y: NDArray[np.float64], form: KernelForm) -> float:
    if form == "damped":
        diagonal = np.tile([1.0, 0.0, 0.0, 1.0, 0.0, 1.0], len(x) // 6) * DIAGONAL
        x, y = x + diagonal, y + diagonal
        return float(2.0 * (x @ y) / (x @ x + y @ y))
    lengths = np.linalg.norm(x), np.linalg.norm(y)
    if min(lengths) <= AT_REST:
        return 1.0 if max(lengths) <= AT_REST else 0.0
    return max(0.0, float(x @ y / lengths[0] / lengths[1]))


def strength(a: SegmentGraph, b: SegmentGraph, form: KernelForm) -> float:
    """Return the strength of the key frame between two segments."""
    alike = kernel(a, b, form)
    if form == "sum":
        return 1.0 / (1.0 + alike)
    unlike = max(0.0, 1.0 - alike / float(np.sqrt(kernel(a, a, form) * kernel(b, b, form))))
    if form == "normalised":
        return unlike
    return float(np.sqrt(a.duration * b.duration / (a.duration + b.duration))) * unlike
