"""Dendrogram: the hierarchy of Algorithm 3 as a tree over time."""

import itertools
from collections.abc import Sequence

import msgspec

from mossar_tools.marks import Mark


class Merge(msgspec.Struct, frozen=True):
    """A merge of two neighbouring parts, when the key frame between them is removed.

    Args:
        left: Middle of the left part, s.
        right: Middle of the right part, s.
        left_height: Strength of the merge that made the left part; 0 for a segment.
        right_height: The same of the right part.
        height: Strength at which the two merge.
        start: Start of the merged part, s.
        end: End of the merged part, s.
    """

    left: float
    right: float
    left_height: float
    right_height: float
    height: float
    start: float
    end: float


class _Part(msgspec.Struct):
    first: int  # number of its first segment
    last: int  # number of its last one
    start: float
    end: float
    middle: float
    height: float


def merges(hierarchy: Sequence[Mark], start: float, end: float) -> list[Merge]:
    """Return the merges of a hierarchy, lowest first.

    Args:
        hierarchy: Key frames in the order of their removal.
        start: Time of the first frame, s.
        end: Time of the last one, s.

    Example:
        >>> key = Mark("30", 1.0, 30, "minimum", 0.1, 0.5, True)
        >>> merges([key], 0.0, 3.0)[0].left, merges([key], 0.0, 3.0)[0].right
        (0.5, 2.0)
    """
    ordered = sorted(hierarchy, key=lambda key: key.frame)
    rank = {key.frame: i for i, key in enumerate(ordered)}
    bounds = [start, *(key.time for key in ordered), end]
    parts = [_Part(i, i, a, b, (a + b) / 2, 0.0) for i, (a, b) in enumerate(itertools.pairwise(bounds))]
    found = []
    for key in hierarchy:
        left, right = parts[rank[key.frame]], parts[rank[key.frame] + 1]
        strength = key.strength or 0.0
        found.append(
            Merge(left.middle, right.middle, left.height, right.height, strength, left.start, right.end)
        )
        middle = (left.middle + right.middle) / 2
        merged = _Part(left.first, right.last, left.start, right.end, middle, strength)
        # Later merges look up only the outermost segments of a part.
        parts[merged.first] = parts[merged.last] = merged
    return found
