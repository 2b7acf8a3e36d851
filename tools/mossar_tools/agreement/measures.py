"""Measures of agreement between two tiers: boundaries within tolerances, kappa over time, offsets, confusion of names."""

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence

import msgspec
import numpy as np

from mossar_adapters.annotations.tiers import Tier
from mossar_tools.evaluation.matching import Cut, match

TOLERANCES = (0.05, 0.1, 0.25, 0.5)  # s
NOTHING = ""  # the name of unlabelled time

Names = tuple[str, str]


class Agreement(msgspec.Struct, frozen=True):
    """Agreement of two labellings of one recording, or of several.

    Args:
        boundaries: How many each of the two has.
        hits: By tolerance, s: boundaries of both that lie within it, one to one.
        offsets: s from the first's boundary to the second's, one for each hit at the largest tolerance.
        confusion: By the names that both gave: s of stretches, or number of moments.
        moments: Whether the labels are moments.
    """

    boundaries: tuple[int, int]
    hits: dict[float, int]
    offsets: tuple[float, ...]
    confusion: dict[Names, float]
    moments: bool

    def f1(self, tolerance: float) -> float:
        """Return F1 of the boundaries: 2 hits / (both numbers of boundaries); 1 if there are none."""
        total = sum(self.boundaries)
        return 2 * self.hits[tolerance] / total if total else 1.0

    @property
    def kappa(self) -> float | None:
        """Cohen's kappa of the names over time; None of moments, or if both gave one and the same name all the time."""
        whole = sum(self.confusion.values())
        if self.moments or whole <= 0:
            return None
        one, other = _shares(self.confusion, 0), _shares(self.confusion, 1)
        chance = sum(one[name] * other.get(name, 0.0) for name in one)
        same = sum(value for (a, b), value in self.confusion.items() if a == b) / whole
        return (same - chance) / (1 - chance) if chance < 1 - 1e-12 else None

    @property
    def summary(self) -> dict[str, float | int | None]:
        """Values for tables: numbers of boundaries, F1, kappa, and the offsets with their spread, s."""
        offsets = np.array(self.offsets)
        found = bool(len(offsets))
        return {
            "boundaries_a": self.boundaries[0],
            "boundaries_b": self.boundaries[1],
            **{f"f1_{tolerance:g}": self.f1(tolerance) for tolerance in self.hits},
            "kappa": self.kappa,
            "offset_median": float(np.median(offsets)) if found else None,
            "offset_mean": float(offsets.mean()) if found else None,
            "offset_sd": float(offsets.std(ddof=1)) if len(offsets) > 1 else None,
            "offset_abs_90": float(np.quantile(np.abs(offsets), 0.9)) if found else None,
        }


def _shares(confusion: Mapping[Names, float], of: int) -> dict[str, float]:
    totals: dict[str, float] = defaultdict(float)
    for names, value in confusion.items():
        totals[names[of]] += value
    whole = sum(totals.values())
    return {name: value / whole for name, value in totals.items()}


def agreement(one: Tier, other: Tier, tolerances: Sequence[float] = TOLERANCES) -> Agreement:
    """Return the agreement of two tiers.

    Args:
        one: Of the first.
        other: Of the second; both are of moments, or neither is.
        tolerances: s, increasing.
    """
    ours, theirs = boundaries(one), boundaries(other)
    cuts = [Cut(time, time, time) for time in ours]
    hits = {tolerance: len(match(theirs, cuts, tolerance)) for tolerance in tolerances}
    closest = match(theirs, cuts, tolerances[-1])
    moments = one.moments and other.moments
    if moments:
        pairs = [(one.marks[hit.cut].label, other.marks[hit.found].label) for hit in closest]
        both = {hit.cut for hit in closest}, {hit.found for hit in closest}
        pairs += [(mark.label, NOTHING) for i, mark in enumerate(one.marks) if i not in both[0]]
        pairs += [(NOTHING, mark.label) for i, mark in enumerate(other.marks) if i not in both[1]]
        confusion: dict[Names, float] = dict(Counter(pairs))
    else:
        confusion = _overlaps(one, other)
    return Agreement((len(ours), len(theirs)), hits, tuple(hit.error for hit in closest), confusion, moments)


def pooled(parts: Sequence[Agreement]) -> Agreement:
    """Return the agreement over several recordings, each boundary and each second counting the same."""
    confusion: dict[Names, float] = defaultdict(float)
    for part in parts:
        for names, value in part.confusion.items():
            confusion[names] += value
    return Agreement(
        (sum(part.boundaries[0] for part in parts), sum(part.boundaries[1] for part in parts)),
        {tolerance: sum(part.hits[tolerance] for part in parts) for tolerance in parts[0].hits},
        tuple(offset for part in parts for offset in part.offsets),
        dict(confusion),
        all(part.moments for part in parts),
    )


def boundaries(tier: Tier) -> list[float]:
    """Return the times at which something begins or ends, s, each once; of moments each of them."""
    if tier.moments:
        return [mark.start for mark in tier.marks]
    return sorted({time for mark in tier.marks for time in (mark.start, mark.end)})


def _overlaps(one: Tier, other: Tier) -> dict[Names, float]:
    """Return the duration of each pair of names, s, from 0 to the last end."""
    edges = sorted({0.0, *boundaries(one), *boundaries(other)})
    found: dict[Names, float] = defaultdict(float)
    ours, theirs = _names(one, edges), _names(other, edges)
    for begin, end, *names in zip(edges, edges[1:], ours, theirs, strict=False):
        found[names[0], names[1]] += end - begin
    return dict(found)


def _names(tier: Tier, edges: Sequence[float]) -> list[str]:
    """Return the name that a tier gives from each edge to the next; the latest to begin where stretches overlap."""
    starts = np.searchsorted(edges, [mark.start for mark in tier.marks]).tolist()
    ends = np.searchsorted(edges, [mark.end for mark in tier.marks]).tolist()
    names = [NOTHING] * len(edges)
    for mark, start, end in zip(tier.marks, starts, ends, strict=True):
        names[start:end] = [mark.label] * (end - start)
    return names
