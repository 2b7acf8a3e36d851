"""Sets: scores of several labelled folders, and of each folder with a strength chosen on the others."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from mossar_stream import Segmenter, Settings
from mossar_tools.evaluation.chance import blind, random_cuts
from mossar_tools.evaluation.detection import FIXED, Detection, Method, Variants
from mossar_tools.evaluation.mossar import found_in, stream
from mossar_tools.evaluation.takes import Take, load_folder
from mossar_tools.evaluation.trial import Row, row_of, run_all, trial

FACTORS = (
    0.35,
    0.5,
    0.7,
    0.85,
    1.0,
    1.2,
    1.4,
    2.0,
    3.0,
)  # of the level's strength: the strengths to choose from
LEFT_OUT = "final, strength chosen on the other sets"


def load_sets(folders: Sequence[Path], on_progress: Callable[[str], None]) -> dict[str, list[Take]]:
    """Return the takes of several folders by the folder's name, and the level where a folder has several.

    Raises:
        LabelError: If a label file cannot be used.
        FileError: If a recording cannot be read.
    """
    sets: dict[str, list[Take]] = {}
    for folder in folders:
        takes = load_folder(folder, on_progress)
        levels = sorted({take.level for take in takes})
        for level in levels:
            name = folder.resolve().name + (f", {level}" if len(levels) > 1 else "")
            sets[name if name not in sets else str(folder)] = [take for take in takes if take.level == level]
    return sets


def set_methods(settings: Settings) -> list[Method]:
    """Return the methods for a set: final key frames, confirmed ones, and chance."""
    return [
        Method("final", FIXED, lambda take: {"": stream(take, settings, "final")}, online=True),
        Method("confirmed", FIXED, lambda take: {"": stream(take, settings, "confirmed")}, online=True),
        Method("a cut every k seconds", ("best for all",), blind),
        random_cuts(),
    ]


def compare_sets(
    sets: Mapping[str, Sequence[Take]],
    settings: Settings,
    on_progress: Callable[[str], None],
    *,
    leave_out: bool,
) -> dict[str, list[Row]]:
    """Return the rows of each set.

    Args:
        sets: Takes by the name of the set.
        settings: Settings of the segmenter; the level is that of each take.
        on_progress: Gets the current step, for a status line.
        leave_out: Whether to add the scores with the strength that is best on the other sets of the level.
    """
    rows = {name: trial(takes, set_methods(settings), on_progress) for name, takes in sets.items()}
    if leave_out:
        for name, row in _left_out(sets, settings, on_progress).items():
            rows[name].insert(1, row)
    return rows


def _left_out(
    sets: Mapping[str, Sequence[Take]], settings: Settings, on_progress: Callable[[str], None]
) -> dict[str, Row]:
    """Return for each set the row with the strength that is best, on average, on the other sets of its level."""
    method = Method(LEFT_OUT, FIXED, lambda take: _at_strengths(take, settings), online=True)
    outcomes = {name: run_all(method, takes, on_progress) for name, takes in sets.items()}
    rows = {}
    for name, takes in sets.items():
        others = [other for other in sets if other != name and sets[other][0].level == takes[0].level]
        if not others:
            continue
        means = {
            factor: np.mean([np.mean([own[factor].scores.f1 for own in outcomes[other]]) for other in others])
            for factor in outcomes[name][0]
        }
        best = max(means, key=lambda factor: float(means[factor]))
        rows[name] = row_of(method, "fixed", [own[best] for own in outcomes[name]])
    return rows


def _at_strengths(take: Take, settings: Settings) -> Variants:
    """Stream a take at strengths around that of its level, with the level's bundle."""
    chosen = settings.replace(level=take.level)
    usual = chosen.strength(take.level)
    found: dict[str, Detection] = {}
    for factor in FACTORS:
        segmenter = Segmenter(take.skeleton, chosen, fps=take.fps)
        segmenter.level = factor * usual
        found[f"{factor:g}"] = found_in(segmenter, take, "final")
    return found
