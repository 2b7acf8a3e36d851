"""Paths: the path kernel's exact sum against a visit of every path, on pairs of neighbouring real segments."""

import time
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from checks.reference import path_kernel as path_reference
from checks.reference.algorithms import localise
from checks.reference.path_kernel import SegmentGraph, segment_graph
from mossar_adapters.files.loaded import LoadedRecording
from mossar_stream import Settings, segment_recording
from mossar_stream.core.kernels import AT_REST, sum_of_paths
from mossar_tools.bench.measurement import Measurement
from mossar_tools.bench.work import Work

EDGES = tuple(range(5, 50, 5))  # N
PAIRS = 40  # pairs of neighbours to compare, at most
VISITED = 100_000  # paths that are visited one by one, at most; the time of more paths is extrapolated
TURNS = 200  # repetitions of a sum that takes microseconds


class Pair(NamedTuple):
    """The weighted common part of two segments' graphs."""

    vertices: NDArray[np.float64]  # (J,)
    edges: NDArray[np.int64]  # (E, 2)
    ratios: NDArray[np.float64]  # (E,)


def measure(work: Work) -> Iterator[Measurement]:
    """Yield both times for each N."""
    segments = [part for whole in work.recordings for part in segments_of(whole)]
    step = max(1, len(segments) // work.some(PAIRS, 2))
    for count in EDGES[:: work.some(1, 8)]:
        work.on_progress(f"paths: N = {count}")
        graphs = [
            (segment_graph(*left, count, 1), segment_graph(*right, count, 1))
            for left, right in segments[::step]
        ]
        yield from _compared(count, [pair_of(left, right) for left, right in graphs])


def _compared(count: int, pairs: Sequence[Pair]) -> Iterator[Measurement]:
    exact = [_exact(pair) for pair in pairs]
    visited, paths = zip(*(_visited(pair) for pair in pairs), strict=True)
    note = f"{len(pairs)} pairs, longest {max(exact):.0f} us"
    yield Measurement("paths", f"N = {count}: exact", "us", tuple(exact), note=note, clock="wall")
    own = sum(number > VISITED for number in paths)
    note = f"{np.median(paths):,.0f} paths, at most {max(paths):,.0f}; longest {max(visited) / 1e6:.3g} s"
    note += f"; {own} pairs extrapolated" if own else ""
    yield Measurement("paths", f"N = {count}: brute force", "us", visited, note=note, clock="wall")


def _exact(pair: Pair) -> float:
    """Return the duration of one exact sum, us."""
    sum_of_paths(*pair, 1)
    began = time.perf_counter()
    sum_of_paths(*pair, 1)
    turns = max(1, min(TURNS, int(2e-3 / max(time.perf_counter() - began, 1e-6))))
    began = time.perf_counter()
    sum_of_paths(*pair, turns)
    return (time.perf_counter() - began) / turns * 1e6


def _visited(pair: Pair) -> tuple[float, float]:
    """Return the duration of a visit of every path, us, and the number of paths."""
    paths = sum_of_paths((pair.vertices > 0).astype(np.float64), pair.edges, np.ones(len(pair.edges)), 1)
    edges = [(int(u), int(v)) for u, v in pair.edges]
    part = len(edges)
    reached = paths
    while reached > VISITED:  # fewer edges, so that it ends
        part -= 1
        reached = sum_of_paths((pair.vertices > 0).astype(np.float64), pair.edges[:part], np.ones(part), 1)
    began = time.perf_counter()
    path_reference.path_sum(pair.vertices.tolist(), edges[:part], pair.ratios[:part].tolist())
    return (time.perf_counter() - began) * 1e6 * paths / reached, paths


def pair_of(left: SegmentGraph, right: SegmentGraph) -> Pair:
    """Return the weights of the path kernel's sum, in the paper's form."""
    weights = [_cosine(x, y) for x, y in zip(left.covariances, right.covariances, strict=True)]
    common = [edge for edge in left.edges if edge in right.edges]
    ratios = [min(left.edges[e], right.edges[e]) / max(left.edges[e], right.edges[e]) for e in common]
    return Pair(np.array(weights), np.array(common, np.int64).reshape(-1, 2), np.array(ratios))


def _cosine(x: NDArray[np.float64], y: NDArray[np.float64]) -> float:
    """Return the paper's vertex kernel; two joints at rest are alike."""
    lengths = float(np.linalg.norm(x)), float(np.linalg.norm(y))
    if min(lengths) <= AT_REST:
        return float(max(lengths) <= AT_REST)
    return max(0.0, float(x @ y) / lengths[0] / lengths[1])


_Segment = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def segments_of(whole: LoadedRecording) -> list[tuple[_Segment, _Segment]]:
    """Return neighbouring segments of a recording, after splitting as in the paper."""
    result = segment_recording(
        whole.positions, whole.fps, whole.skeleton, Settings.build("paper"), times=whole.times
    )
    bounds = [0, *(key.frame for key in result.key_frames), len(whole.times)]
    positions = localise(whole.positions.astype(np.float64), whole.skeleton.root)
    weights = np.diff(whole.times, prepend=whole.times[0])
    parts = [
        (positions[a:b][weights[a:b] > 0], whole.times[a:b][weights[a:b] > 0], weights[a:b][weights[a:b] > 0])
        for a, b in pairwise(bounds)
    ]
    return [(left, right) for left, right in pairwise(parts) if len(left[1]) and len(right[1])]
