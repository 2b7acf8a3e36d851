"""Matching: pairs of key frames and the true cuts that they hit, one to one."""

import bisect
from collections.abc import Sequence

import msgspec

MARGIN = 1e-6  # s, for the rounding of frame times


class Cut(msgspec.Struct, frozen=True):
    """A true transition.

    Args:
        earliest: Earliest time, s.
        middle: Time, s.
        latest: Latest time, s.
    """

    earliest: float
    middle: float
    latest: float


class Hit(msgspec.Struct, frozen=True):
    """A true cut and the key frame that hits it.

    Args:
        cut: Index of the cut.
        found: Index of the key frame.
        error: Time from the middle of the cut to the key frame, s; negative if the key frame is early.
    """

    cut: int
    found: int
    error: float


def match(found: Sequence[float], cuts: Sequence[Cut], tolerance: float) -> list[Hit]:
    """Return the largest number of hits, one to one, and among such matchings the one with the least error.

    A key frame hits a cut when it lies within [earliest - tolerance, latest + tolerance]. Both lists are in the
    order of time, the cuts by `earliest` as well as by `latest`. Some optimal matching then never crosses.

    Args:
        found: Times of key frames, s, increasing.
        cuts: True cuts.
        tolerance: s.
    """
    # Best matching for each last key frame used so far: (hits, -summed error, the hits as a linked list).
    ways: dict[int, tuple[int, float, _Link]] = {-1: (0, 0.0, None)}
    for c, cut in enumerate(cuts):
        first = bisect.bisect_left(found, cut.earliest - tolerance - MARGIN)
        last = bisect.bisect_right(found, cut.latest + tolerance + MARGIN)
        longer = {}
        for f in range(first, last):
            before = max((way for used, way in ways.items() if used < f), key=_score, default=None)
            if before is not None:
                hit = Hit(c, f, found[f] - cut.middle)
                longer[f] = (before[0] + 1, before[1] - abs(hit.error), (before[2], hit))
        for f, way in longer.items():
            ways[f] = max(ways.get(f, way), way, key=_score)
    return _unwound(max(ways.values(), key=_score)[2])


_Link = tuple["_Link", Hit] | None


def _score(way: tuple[int, float, "_Link"]) -> tuple[int, float]:
    return way[0], way[1]


def _unwound(link: "_Link") -> list[Hit]:
    hits = []
    while link is not None:
        link, hit = link
        hits.append(hit)
    return hits[::-1]
