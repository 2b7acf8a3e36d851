"""Experiments: everything that the paper's evaluation varies (4.3.1 and 4.3.2)."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import count

import msgspec

from checks.paper.grid import (
    Grid,
    recursion_grid,
    remerging_grid,
    splitting_grid,
    velocity_grid,
)
from mossar_stream import Settings
from mossar_tools.console import LOGGER
from mossar_tools.evaluation.chance import merged
from mossar_tools.evaluation.metrics import Scores, mean_scores
from mossar_tools.evaluation.takes import Take
from mossar_tools.evaluation.trial import groups_of

Method = Callable[[Sequence[Take], Settings, Callable[[str], None]], Grid]


class Experiments(msgspec.Struct, frozen=True):
    """Results of the experiments.

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
        on_progress: Gets the current step, for a status line. Each finished grid is logged.
    """
    groups = groups_of(takes)
    damped = settings.replace(kernel_form="damped")
    splitters: list[tuple[Method, Settings]] = [(velocity_grid, settings), (splitting_grid, settings)]
    remergers: list[tuple[Method, Settings]] = [
        (recursion_grid, settings),
        (partial(remerging_grid, "Mossar"), settings),
        (partial(remerging_grid, "Mossar, damped kernel"), damped),
    ]
    numbers = count(1)

    def grids(methods: list[tuple[Method, Settings]]) -> Iterator[Grid]:
        for own in groups.values():
            for method, chosen in methods:
                grid = method(own, chosen, on_progress)
                total = len(groups) * (len(splitters) + len(remergers))
                LOGGER.info("%d of %d grids: %s, %s", next(numbers), total, grid.method, grid.group)
                yield grid

    splitting, remerging = list(grids(splitters)), list(grids(remergers))
    chance = {name: mean_scores([_lucky(take, settings) for take in own]) for name, own in groups.items()}
    return Experiments(splitting, remerging, chance)


def _lucky(take: Take, settings: Settings) -> Scores:
    """Return the best scores that random merging reaches."""
    return max((found.scores(take) for found in merged(take, settings).values()), key=lambda one: one.perf)
