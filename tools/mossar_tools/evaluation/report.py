"""Report: tables for people to read and one JSON object for programs."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from mossar_tools.evaluation.chance import RANDOM_CUTS, RANDOM_MERGES
from mossar_tools.evaluation.metrics import Scores, median
from mossar_tools.evaluation.takes import Take
from mossar_tools.evaluation.trial import Row

NOTES = f"""precision, recall, F1, ATSR, Perf: mean over recordings; a key frame hits a cut within the label's tolerance
found: key frames per true cut; error: median distance of hits from the cut, and with its sign (negative: early)
delay: median time from the true cut to the decision about the key frame that hits it, for methods that stream
best for all, best each: the parameter was chosen with the truth in sight, for the group or for each recording
random merging: the best of the nested sets of {RANDOM_MERGES} random orders; random cuts: the best of {RANDOM_CUTS} sets of as many as there are cuts"""

_HEADING = (
    f"{'method':<42}{'chosen':<14}{'precision':>9}{'recall':>8}{'F1':>7}{'ATSR':>7}{'Perf':>7}"
    f"{'found':>7}{'error':>9}{'signed':>9}{'delay':>8}"
)
_NUMBERS = 56  # column of the first number in the heading


def tables(groups: Mapping[str, Sequence[Take]], rows: Mapping[str, Sequence[Row]]) -> Iterator[str]:
    """Yield the lines of one table per group.

    Args:
        groups: Takes by group.
        rows: The scores, by group.
    """
    for group, takes in groups.items():
        cuts = sum(len(take.cuts) for take in takes)
        yield f"{group}: {len(takes)} recordings, {sum(t.duration for t in takes):.0f} s, {cuts} true cuts"
        yield _HEADING
        yield from (_line(row) for row in rows[group])
        yield ""
    yield NOTES


def recording_table(takes: Sequence[Take], row: Row) -> Iterator[str]:
    """Yield the lines of a table of recordings for one method."""
    yield f"{row.method}, by recording"
    yield f"{'recording':<42}{'cuts':<14}" + _HEADING[_NUMBERS:]
    for take, outcome in zip(takes, row.outcomes, strict=True):
        yield f"{take.name[:41]:<42}{len(take.cuts):<14}" + _numbers(outcome.scores)


def as_json(groups: Mapping[str, Sequence[Take]], rows: Mapping[str, Sequence[Row]]) -> dict[str, Any]:
    """Return one object: the mean per group and method; key frames, scores and variant per recording."""
    return {"v": 1, "groups": [_group(name, takes, rows[name]) for name, takes in groups.items()]}


def _group(name: str, takes: Sequence[Take], rows: Sequence[Row]) -> dict[str, Any]:
    return {
        "group": name,
        "recordings": [
            {
                "name": take.name,
                "fps": take.fps,
                "duration_s": take.duration,
                "tolerance_s": take.tolerance,
                "cuts_s": [[cut.earliest, cut.middle, cut.latest] for cut in take.cuts],
            }
            for take in takes
        ],
        "methods": [
            {
                "method": row.method,
                "choice": row.choice,
                "mean": scores_json(row.mean),
                "recordings": [
                    {
                        "name": outcome.take,
                        "variant": outcome.variant,
                        "key_frames_s": outcome.found.times,
                        "took_s": finite(outcome.found.seconds),
                        **scores_json(outcome.scores),
                    }
                    for outcome in row.outcomes
                ],
            }
            for row in rows
        ],
    }


def scores_json(scores: Scores) -> dict[str, float | None]:
    """Return scores by name, None for unknown ones."""
    return {
        "precision": scores.precision,
        "recall": scores.recall,
        "f1": scores.f1,
        "atsr": scores.atsr,
        "perf": scores.perf,
        "key_frames_per_cut": scores.key_frames,
        "median_error_s": finite(median([abs(error) for error in scores.errors])),
        "median_signed_error_s": finite(median(scores.errors)),
        "median_delay_s": finite(median(scores.delays)),
    }


def finite(number: float) -> float | None:
    """Return a number, None for NaN, which JSON does not have."""
    return number if math.isfinite(number) else None


def _line(row: Row) -> str:
    chosen = "" if row.choice == "fixed" else row.choice
    line = f"{row.method:<42}{chosen:<14}{_numbers(row.mean)}"
    return f"{line}  {row.outcomes[0].variant}" if row.choice == "best for all" else line


def _numbers(scores: Scores) -> str:
    error = median([abs(error) for error in scores.errors])
    return (
        f"{scores.precision:>9.3f}{scores.recall:>8.3f}{scores.f1:>7.3f}{scores.atsr:>7.3f}{scores.perf:>7.3f}"
        f"{scores.key_frames:>7.2f}{_time(error, '.2f'):>9}{_time(median(scores.errors), '+.2f'):>9}"
        f"{_time(median(scores.delays), '.2f'):>8}"
    )


def _time(seconds: float, form: str) -> str:
    return f"{seconds:{form}} s" if math.isfinite(seconds) else "-"
