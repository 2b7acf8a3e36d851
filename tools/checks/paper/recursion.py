"""Li and Leung's method: segments are split in two where the two parts are least alike (paper 2.2.1, Fig. 4).

Each recursion compares, at every `PRECISION` seconds, an earlier segment that grows from C_min up to C_max with a
later one of C_min. The split with the least similarity is accepted if that is below the minimum similarity, and
only segments longer than 2 C_min are split. The recursion is run down to the end once; each minimum similarity
then takes its part of the tree.
"""

import time
from collections.abc import Iterator, Sequence

import msgspec
import numpy as np

from checks.paper.comparison import Comparison
from mossar_stream import Settings, segment_recording
from mossar_tools.evaluation.detection import Detection, Method, Variants
from mossar_tools.evaluation.takes import Take

PRECISION = 0.1  # s (P)
SHORTEST = (0.5, 1.0, 2.0)  # s (C_min) that there is to choose from
LONGEST = 4.0  # s (C_max)
# Strengths 1 / (1 + K) above which a split is accepted: the minimum similarity of the raw kernel, K.
THRESHOLDS = tuple(np.geomspace(1e-6, 0.5, 41).tolist())


class Split(msgspec.Struct, frozen=True):
    """A place where a segment is split in two.

    Args:
        time: s.
        strength: Strength between the two parts.
        parts: The splits of the two parts.
    """

    time: float
    strength: float
    parts: "tuple[Split, ...]" = ()


def li_and_leung(settings: Settings, sizes: Sequence[float] = SHORTEST) -> Method:
    """Return the method.

    Args:
        settings: Their N and L.
        sizes: C_min, s, to choose from.
    """
    chosen = settings.replace(similarity="path_kernel", kernel_form="sum")

    def run(take: Take) -> Variants:
        variants = {}
        for size in sizes:
            began = time.perf_counter()
            tree = split_tree(take, chosen, size, LONGEST)
            seconds = time.perf_counter() - began
            for threshold in THRESHOLDS:
                times = sorted(accepted(tree, threshold))
                name = f"C_min {size:g} s, K < {1 / threshold - 1:.3g}"
                variants[name] = Detection(times, seconds=seconds)
        return variants

    return Method("Li and Leung (2.2)", ("best for all", "best each"), run)


def split_tree(take: Take, settings: Settings, shortest: float, longest: float) -> Split | None:
    """Return the splits of a whole take, with a minimum similarity that accepts all.

    Args:
        take: The take.
        settings: Of the path kernel.
        shortest: C_min, s.
        longest: C_max, s.
    """
    size = max(1, round(shortest / PRECISION))
    own = settings.replace(level=take.level, location="none").resolved()
    curves = segment_recording(
        take.positions, take.fps, take.skeleton, own, times=take.times, curves=True
    ).curves
    poses, times = np.stack([state.pose for state in curves]), np.array([state.time for state in curves])
    comparison = Comparison(poses, times, own, take.skeleton.root, PRECISION, size)
    return _split(comparison, 0, comparison.pieces, size, max(size, round(longest / PRECISION)))


def _split(comparison: Comparison, first: int, last: int, size: int, longest: int) -> Split | None:
    if last - first <= 2 * size:
        return None
    unlike = comparison.between(first, last, longest)
    best = int(np.argmax(unlike))
    parts = (
        _split(comparison, first, first + best, size, longest),
        _split(comparison, first + best, last, size, longest),
    )
    inner = tuple(part for part in parts if part is not None)
    return Split(float(comparison.starts[first + best]), float(unlike[best]), inner)


def accepted(split: Split | None, threshold: float) -> Iterator[float]:
    """Yield the times of the accepted splits; other parts are not split further."""
    if split is not None and split.strength > threshold:
        yield split.time
        for part in split.parts:
            yield from accepted(part, threshold)
