"""Experiments: everything that the paper's evaluation varies (4.3.1 and 4.3.2)."""

from collections.abc import Callable, Sequence

import msgspec

from checks.paper.grid import (
    Grid,
    recursion_grid,
    remerging_grid,
    splitting_grid,
    velocity_grid,
)
from mossar_stream import Settings
from mossar_tools.evaluation.chance import merged
from mossar_tools.evaluation.metrics import Scores, mean_scores
from mossar_tools.evaluation.takes import Take
from mossar_tools.evaluation.trial import groups_of


class Experiments(msgspec.Struct, frozen=True):
    """What the experiments gave.

    Args:
        splitting: Velocity-based method and splitting, by group, over smoothing and threshold.
        remerging: Li and Leung's method and Mossar, by group, over N and L.
        chance: Random merging, the best set of each recording, by group.
    """

    splitting: list[Grid]
    remerging: list[Grid]
    chance: dict[str, Scores]


def experiments(takes: Sequence[Take], settings: Settings, on_progress: Callable[[str], None]) -> Experiments:
    """Run the experiments.

    Args:
        takes: The recordings.
        settings: Where they start from; the paper's.
        on_progress: Gets what is being done, for a status line.
    """
    groups = groups_of(takes)
    damped = settings.replace(kernel_form="damped")
    splitting, remerging = [], []
    for own in groups.values():
        splitting += [velocity_grid(own, settings, on_progress), splitting_grid(own, settings, on_progress)]
        remerging.append(recursion_grid(own, settings, on_progress))
        remerging.append(remerging_grid("Mossar", own, settings, on_progress))
        remerging.append(remerging_grid("Mossar, damped kernel", own, damped, on_progress))
    chance = {name: mean_scores([_lucky(take, settings) for take in own]) for name, own in groups.items()}
    return Experiments(splitting, remerging, chance)


def _lucky(take: Take, settings: Settings) -> Scores:
    """Return the best scores that random merging reaches."""
    return max((found.scores(take) for found in merged(take, settings).values()), key=lambda one: one.perf)
