"""Tables of labels: the events of BIDS, and comma-separated tables with a begin and an end in each row."""

import csv
import re
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mossar_adapters.annotations.tiers import (
    EVENTS,
    FOLLOWED,
    MOVES,
    REPETITIONS,
    SEGMENTS,
    STEPS,
    AnnotationError,
    Mark,
    Tier,
)
from mossar_adapters.table_text import without_guard

_NAMES = ("name", "label", "trial_type", "state")  # columns that may hold the label, the first that is there
# State of `segment --csv`: tier, label.
_OWN = {
    "repetition": (REPETITIONS, "count"),
    "move": (MOVES, "name"),
    "followed": (FOLLOWED, "count"),
}
_NOTHING = {"", "n/a"}


def read_bids(path: Path) -> list[Tier]:
    """Return the tiers of an events.tsv: one for each `trial_type`, labelled with `value`.

    Raises:
        AnnotationError: If it has no onset, or something in it is no number.
    """
    tiers: dict[str, list[Mark]] = defaultdict(list)
    for number, row in _rows(path, "\t", ("onset", "duration")):
        kind = row.get("trial_type") or ""
        kind = "" if kind in _NOTHING else kind
        name = as_written(kind) if kind else EVENTS
        label = row.get("value") if (row.get("value") or "") not in _NOTHING else kind
        start = _number(path, number, row["onset"])
        length = 0.0 if row["duration"] in _NOTHING else _number(path, number, row["duration"])
        tiers[name].append(Mark(start, start + length, label or ""))
    return _tiers(tiers)


def as_written(name: str) -> str:
    """Return the name of a tier of ours, whose spaces other programs have as underscores."""
    name = re.sub(rf"^({SEGMENTS}|{FOLLOWED})_(?=.)", r"\1 ", name.replace("key_frames", "key frames"))
    return re.sub(rf"_({SEGMENTS}|{REPETITIONS})$", r" \1", name)


def read_table(path: Path) -> list[Tier]:
    """Return the tiers of a table with columns `start` and `end`, s on the recording's clock.

    The label is in `name`, `label`, `trial_type` or `state`, the tier in `tier`; without that the tier is `moves`. A table
    of `mossar segment --csv` has its segments, repetitions and moves, those of limbs by their names, and its steps: when
    each foot comes down, and when it leaves the ground.

    Raises:
        AnnotationError: If a column is missing, or something in it is no number.
    """
    tiers: dict[str, list[Mark]] = defaultdict(list)
    for number, row in _rows(path, ",", ("start", "end")):
        if "channel" in row and row.get("state") == "step":
            tiers[STEPS] += _step(path, number, row)
            continue
        start, end = (_number(path, number, row[column]) for column in ("start", "end"))
        name, label = _placed(row)
        tiers[name].append(Mark(start, end, label))
    return _tiers(tiers, on_clock=True)


def _step(path: Path, number: int, row: Mapping[str, str]) -> list[Mark]:
    """Return the moments of a row of a step; its stance is empty if the foot did not leave the ground again."""
    side = (row["channel"] or "").removesuffix("_foot")
    strike = _number(path, number, row["start"])
    marks = [Mark(strike, strike, f"{side} strike")]
    if row.get("stance"):
        off = strike + _number(path, number, row["stance"])
        marks.append(Mark(off, off, f"{side} off"))
    return marks


def _placed(row: Mapping[str, str]) -> tuple[str, str]:
    """Return tier and label of a row."""
    if "channel" in row and "state" in row:
        name, column = _OWN.get(row["state"], (SEGMENTS, "state"))
        if name == FOLLOWED:
            return f"{name} {row.get('name') or ''}", row.get(column) or ""
        limb = row["channel"]
        return (name if limb in {"", "body"} else f"{limb} {name}"), row.get(column) or ""
    label = next((row[column] for column in _NAMES if column in row), "")
    return row.get("tier") or MOVES, (label or "").strip()


def _rows(path: Path, separator: str, needed: tuple[str, ...]) -> list[tuple[int, dict[str, str]]]:
    """Return the rows of a table with the numbers of their lines."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            table = csv.DictReader(
                file, delimiter=separator, quoting=csv.QUOTE_NONE if separator == "\t" else csv.QUOTE_MINIMAL
            )
            missing = [column for column in needed if column not in (table.fieldnames or ())]
            if missing:
                raise AnnotationError(
                    f"{path}: a table of labels has a column {missing[0]}; this one has none"
                )
            return [(table.line_num, _unguarded(row)) for row in table]
    except (UnicodeDecodeError, csv.Error) as error:
        raise AnnotationError(f"{path}: no table: {error}") from None


def _unguarded(row: Mapping[str, Any]) -> dict[str, Any]:
    return {name: without_guard(text) if isinstance(text, str) else text for name, text in row.items()}


def _number(path: Path, line: int, text: str | None) -> float:
    try:
        return float(text or "")
    except ValueError:
        raise AnnotationError(f"{path}, line {line}: {text!r} is no time in seconds") from None


def _tiers(found: Mapping[str, list[Mark]], *, on_clock: bool = False) -> list[Tier]:
    return [
        Tier(name, tuple(sorted(marks)), all(m.start == m.end for m in marks), on_clock)
        for name, marks in found.items()
    ]
