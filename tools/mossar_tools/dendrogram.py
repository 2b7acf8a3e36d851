"""Dendrogram: the hierarchy of Algorithm 3 as a tree over time."""

import itertools
from collections.abc import Sequence

import msgspec

from mossar_stream.recording import KeyFrame


class Merge(msgspec.Struct, frozen=True):
    """Two neighbouring parts become one when the key frame between them falls.

    Args:
        left: Middle of the left part, s.
        right: Middle of the right part, s.
        left_height: Strength at which the left part came to be; 0 for a segment.
        right_height: The same of the right part.
        height: Strength at which the two merge.
        start: Where the merged part begins, s.
        end: Where it ends, s.
    """

    left: float
    right: float
    left_height: float
    right_height: float
    height: float
    start: float
    end: float


class _Part(msgspec.Struct):
    start: float
    end: float
    middle: float
    height: float


def merges(hierarchy: Sequence[KeyFrame], start: float, end: float) -> list[Merge]:
    """Return the merges of a hierarchy, lowest first.

    Args:
        hierarchy: Key frames in the order in which they fall.
        start: Time of the first frame, s.
        end: Time of the last one, s.

    Example:
        >>> key = KeyFrame(30, 1.0, "minimum", 0.1, 0.5)
        >>> merges([key], 0.0, 3.0)[0].left, merges([key], 0.0, 3.0)[0].right
        (0.5, 2.0)
    """
    times = sorted(key.time for key in hierarchy)
    bounds = [start, *times, end]
    by_end = {b: _Part(a, b, (a + b) / 2, 0.0) for a, b in itertools.pairwise(bounds)}
    by_start = {part.start: part for part in by_end.values()}
    found = []
    for key in hierarchy:
        left, right = by_end[key.time], by_start[key.time]
        found.append(
            Merge(left.middle, right.middle, left.height, right.height, key.strength, left.start, right.end)
        )
        merged = _Part(left.start, right.end, (left.middle + right.middle) / 2, key.strength)
        by_start[left.start] = by_end[right.end] = merged
    return found
