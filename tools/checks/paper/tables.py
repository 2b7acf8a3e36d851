"""Paper tables: Tables 2 to 7 of the paper, in form, on our recordings."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from checks.paper.grid import Grid
from mossar_tools.evaluation.metrics import Scores
from mossar_tools.evaluation.report import scores_json

_SCORES = f"{'Perf':>8}{'ATSR':>8}{'F1':>8}{'Recall':>8}{'Precision':>11}"


def paper_tables(
    splitting: Sequence[Grid], remerging: Sequence[Grid], chance: dict[str, Scores]
) -> Iterator[str]:
    """Yield the lines of all tables.

    Args:
        splitting: Velocity-based method and splitting, by group.
        remerging: Li and Leung's method and Mossar, by group.
        chance: Random merging, the best set of each recording, by group.
    """
    yield "Table 2. Averaged best performances of splitting: the best thresholds for each recording"
    yield from _best_each(splitting, {})
    yield ""
    yield "Fig. 11. The best thresholds that are the same for all recordings"
    yield from _best_for_all(splitting)
    yield ""
    yield "Table 3. Averaged best performances after remerging: the best N and L for each recording"
    yield from _best_each(remerging, chance)
    yield ""
    yield "Fig. 12. The best N and L that are the same for all recordings"
    yield from _best_for_all(remerging)
    for title, tables, form in (
        ("Tables 4 and 5. Average Perf over the groups", mean_perf(remerging), ".3f"),
        ("Tables 6 and 7. Total processing time, s", total_seconds(remerging), ".3f"),
    ):
        for method, values in tables.items():
            yield ""
            yield f"{title}: {method}"
            yield from _cells(remerging[0], values, form)


def mean_perf(grids: Sequence[Grid]) -> dict[str, NDArray[np.float64]]:
    """Return by method the mean over the groups of Perf, (rows, columns)."""
    return {name: np.mean([grid.perf() for grid in own], axis=0) for name, own in _by_method(grids).items()}


def total_seconds(grids: Sequence[Grid]) -> dict[str, NDArray[np.float64]]:
    """Return by method the time for all recordings, s, (rows, columns)."""
    return {name: np.sum([grid.seconds for grid in own], axis=0) for name, own in _by_method(grids).items()}


def grids_json(grids: Sequence[Grid]) -> list[dict[str, Any]]:
    """Return all numbers of the grids."""
    return [
        {
            "method": grid.method,
            "group": grid.group,
            grid.first.name: grid.first.values,
            grid.second.name: grid.second.values,
            "perf": grid.perf().tolist(),
            "seconds": grid.seconds.tolist(),
            "best_each": scores_json(grid.best_each()[2]),
            "best_for_all": dict(
                zip((grid.first.name, grid.second.name), grid.best_for_all()[:2], strict=True),
                **scores_json(grid.best_for_all()[2]),
            ),
        }
        for grid in grids
    ]


def _by_method(grids: Sequence[Grid]) -> dict[str, list[Grid]]:
    methods = dict.fromkeys(grid.method for grid in grids)
    return {name: [grid for grid in grids if grid.method == name] for name in methods}


def _best_each(grids: Sequence[Grid], chance: dict[str, Scores]) -> Iterator[str]:
    first, second = grids[0].first, grids[0].second
    yield f"{'group':<22}{'method':<22}{first.name:>15}{second.name:>15}{_SCORES}"
    for grid in sorted(grids, key=lambda grid: grid.group):
        one, two, scores = grid.best_each()
        yield f"{grid.group:<22}{grid.method:<22}{_spread(one):>15}{_spread(two):>15}{_numbers(scores)}"
    for group, scores in sorted(chance.items()):
        yield f"{group:<22}{'random merging':<22}{'-':>15}{'-':>15}{_numbers(scores)}"


def _best_for_all(grids: Sequence[Grid]) -> Iterator[str]:
    yield f"{'group':<22}{'method':<22}{grids[0].first.name:>15}{grids[0].second.name:>15}{_SCORES}"
    for grid in sorted(grids, key=lambda grid: grid.group):
        one, two, scores = grid.best_for_all()
        first, second = f"{one:g} {grid.first.unit}", f"{two:g} {grid.second.unit}"
        yield f"{grid.group:<22}{grid.method:<22}{first:>15}{second:>15}{_numbers(scores)}"


def _cells(like: Grid, values: NDArray[np.float64], form: str) -> Iterator[str]:
    yield (
        f"{like.first.name:>5}"
        + "".join(f"{f'L={value:g}':>10}" for value in like.second.values)
        + f"{'AVG':>10}"
    )
    for value, row in zip(like.first.values, values, strict=True):
        yield f"{value:>5g}" + "".join(f"{cell:>10{form}}" for cell in (*row, row.mean()))
    yield f"{'AVG':>5}" + "".join(f"{cell:>10{form}}" for cell in (*values.mean(axis=0), values.mean()))


def _spread(values: Sequence[float]) -> str:
    return f"{np.mean(values):.2f} ± {np.std(values):.2f}"


def _numbers(scores: Scores) -> str:
    return f"{scores.perf:>8.3f}{scores.atsr:>8.3f}{scores.f1:>8.3f}{scores.recall:>8.3f}{scores.precision:>11.3f}"
