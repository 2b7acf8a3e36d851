"""Metrics: scores of key frames against the true cuts (paper 4.2)."""

import math
from collections.abc import Sequence

import msgspec
import numpy as np

from mossar_tools.evaluation.matching import Cut, Hit, match


class Scores(msgspec.Struct, frozen=True):
    """Scores of key frames against the true cuts of one recording, or means over several.

    Args:
        precision: Share of key frames that hit a cut.
        recall: Share of cuts that are hit.
        f1: Their harmonic mean.
        atsr: Accurate temporal segmentation rate (Ruffieux et al. 2013).
        perf: Ruffieux's combination of `f1` and `atsr`.
        key_frames: Key frames per true cut.
        errors: s, from cut to key frame, one for each hit; negative for early key frames.
        delays: s, from cut to the decision about the key frame, one for each hit; empty if not streaming.
    """

    precision: float
    recall: float
    f1: float
    atsr: float
    perf: float
    key_frames: float
    errors: tuple[float, ...] = ()
    delays: tuple[float, ...] = ()


def score(
    found: Sequence[float],
    cuts: Sequence[Cut],
    *,
    tolerance: float,
    duration: float,
    start: float = 0.0,
    decided: Sequence[float] = (),
) -> Scores:
    """Return the scores of key frames.

    A recording without cuts and without key frames has perfect scores.

    Args:
        found: Times of key frames, s, increasing.
        cuts: True cuts, in the order of time.
        tolerance: s.
        duration: Of the recording, s.
        start: Time of the first frame, s.
        decided: Time of the decision about each key frame, s; empty if not streaming.
    """
    hits = match(found, cuts, tolerance)
    precision = _share(len(hits), len(found), empty=not cuts)
    recall = _share(len(hits), len(cuts), empty=not found)
    f1 = _share(2 * len(hits), len(found) + len(cuts), empty=True)
    atsr = segmentation_rate(hits, cuts, start, start + duration)
    return Scores(
        precision=precision,
        recall=recall,
        f1=f1,
        atsr=atsr,
        perf=perf(f1, atsr),
        key_frames=len(found) / max(1, len(cuts)),
        errors=tuple(hit.error for hit in hits),
        delays=tuple(decided[hit.found] - cuts[hit.cut].middle for hit in hits) if decided else (),
    )


def segmentation_rate(hits: Sequence[Hit], cuts: Sequence[Cut], start: float, end: float) -> float:
    """Return ATSR: 1 - the mean over matched segments of (|Δstart| + |Δend|) / true duration.

    A true segment is matched when the cuts at both of its ends are hit; the ends of the recording are always hit.
    The paper does not define two cases: here a segment counts at least 0, and without a matched segment ATSR is 0.

    Args:
        hits: As `match` returns them.
        cuts: True cuts.
        start: Of the recording, s.
        end: Of the recording, s.
    """
    errors = {hit.cut: abs(hit.error) for hit in hits} | {-1: 0.0, len(cuts): 0.0}
    bounds = [start, *(cut.middle for cut in cuts), end]
    rates = []
    for left in range(-1, len(cuts)):
        length = bounds[left + 2] - bounds[left + 1]
        if left in errors and left + 1 in errors and length > 0:
            rates.append(max(0.0, 1.0 - (errors[left] + errors[left + 1]) / length))
    return float(np.mean(rates)) if rates else 0.0


def perf(f1: float, atsr: float) -> float:
    """Return Perf = 5 F1 ATSR / (4 ATSR + F1), which fits the paper's Table 3 to 0.003."""
    return 5 * f1 * atsr / (4 * atsr + f1) if f1 > 0 and atsr > 0 else 0.0


def mean_scores(scores: Sequence[Scores]) -> Scores:
    """Return the mean over recordings; errors and delays are concatenated."""
    fields = ("precision", "recall", "f1", "atsr", "perf", "key_frames")
    means = {name: float(np.mean([getattr(one, name) for one in scores])) for name in fields}
    return Scores(
        **means,
        errors=tuple(error for one in scores for error in one.errors),
        delays=tuple(delay for one in scores for delay in one.delays),
    )


def median(values: Sequence[float]) -> float:
    """Return the median, NaN if there are no values."""
    return float(np.median(values)) if values else math.nan


def _share(part: int, whole: int, *, empty: bool) -> float:
    """Return part / whole; for a whole of 0, 1 if there was nothing to find."""
    return part / whole if whole else float(empty)
