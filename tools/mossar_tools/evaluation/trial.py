"""Trial: every method on every take, with the variants that its rules choose."""

from collections import defaultdict
from collections.abc import Callable, Sequence

import msgspec
import numpy as np

from mossar_tools.evaluation.detection import Choice, Detection, Method
from mossar_tools.evaluation.metrics import Scores, mean_scores
from mossar_tools.evaluation.takes import Take


class Outcome(msgspec.Struct, frozen=True):
    """The scores of a method on a take.

    Args:
        take: Name of the take.
        variant: Name of the chosen variant; empty if there was no choice.
        found: The key frames.
        scores: Their scores against the true cuts.
    """

    take: str
    variant: str
    found: Detection
    scores: Scores


class Row(msgspec.Struct, frozen=True):
    """The scores of a method on a group of takes.

    Args:
        method: Name of the method.
        choice: Rule by which variants were chosen.
        outcomes: One for each take.
        mean: Over the takes.
    """

    method: str
    choice: Choice
    outcomes: list[Outcome]
    mean: Scores


def groups_of(takes: Sequence[Take]) -> dict[str, list[Take]]:
    """Return the takes by group."""
    groups = defaultdict(list)
    for take in takes:
        groups[take.group].append(take)
    return dict(groups)


def trial(
    takes: Sequence[Take], methods: Sequence[Method], on_progress: Callable[[str], None] = lambda _: None
) -> list[Row]:
    """Return the scores of each method on a group of takes.

    Args:
        takes: The takes of one group.
        methods: The methods.
        on_progress: Gets the current step, for a status line.
    """
    rows = []
    for method in methods:
        outcomes = run_all(method, takes, on_progress)
        rows += [_row(method, choice, outcomes) for choice in method.choices]
    return rows


def run_all(
    method: Method, takes: Sequence[Take], on_progress: Callable[[str], None] = lambda _: None
) -> list[dict[str, Outcome]]:
    """Return the outcome of each variant of a method for each take."""
    outcomes = []
    for take in takes:
        on_progress(f"{method.name}: {take.name}")
        outcomes.append(_outcomes(method, take))
    return outcomes


def _outcomes(method: Method, take: Take) -> dict[str, Outcome]:
    """Return the outcome of each variant."""
    return {
        name: Outcome(take.name, name, found, found.scores(take)) for name, found in method.run(take).items()
    }


def _row(method: Method, choice: Choice, outcomes: Sequence[dict[str, Outcome]]) -> Row:
    """Choose a variant by mean F1 (one for all takes) or by F1 (one for each take); at a tie, the first."""
    if choice == "best for all":
        shared = [name for name in outcomes[0] if all(name in own for own in outcomes)]
        best = max(shared, key=lambda name: float(np.mean([own[name].scores.f1 for own in outcomes])))
        chosen = [own[best] for own in outcomes]
    else:
        chosen = [max(own.values(), key=lambda one: one.scores.f1) for own in outcomes]
    return row_of(method, choice, chosen)


def row_of(method: Method, choice: Choice, chosen: list[Outcome]) -> Row:
    """Return the row of a method with one outcome for each take."""
    return Row(method.name, choice, chosen, mean_scores([one.scores for one in chosen]))
