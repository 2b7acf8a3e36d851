"""Grid: methods at all combinations of two thresholds, as in the paper's experiments (4.3).

For each combination and recording the best of the method's sets of key frames counts, by Perf: the user of the
paper chooses the number of key frames interactively.
"""

import time
from collections.abc import Callable, Iterable, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from checks.paper.recursion import LONGEST, SHORTEST, THRESHOLDS, accepted, split_tree
from checks.paper.velocity_based import crossings, velocity
from mossar_stream import Settings
from mossar_tools.evaluation.chance import nested
from mossar_tools.evaluation.detection import Detection
from mossar_tools.evaluation.metrics import Scores, mean_scores
from mossar_tools.evaluation.mossar import split, whole
from mossar_tools.evaluation.takes import Take

# Values that are tried; wSize in seconds, since recordings differ in rate.
SMOOTHING = (0.0, 0.05, 0.1, 0.25, 0.5, 0.75, 1.0)  # s
SHARES = (
    *(k / 100 for k in range(1, 11)),
    *(k / 100 for k in range(12, 31, 2)),
    *(k / 20 for k in range(7, 21)),
)
METRES = tuple(np.geomspace(0.1, 30.0, 34).round(2).tolist())
EDGES = (5, 10, 15, 20, 25, 30, 35, 40)
LAYERS = (1, 3, 5)

Solve = Callable[[Take, float], Iterable[tuple[float, Iterable[Detection]]]]


class Axis(msgspec.Struct, frozen=True):
    """A threshold that is varied.

    Args:
        name: As in the paper.
        values: In the order of the grid.
        unit: Of the values.
    """

    name: str
    values: tuple[float, ...]
    unit: str = ""


class Grid(msgspec.Struct, frozen=True):
    """Scores of a method on a group of takes at all combinations.

    Args:
        method: Name.
        group: The takes' group.
        first: The threshold along the rows.
        second: The threshold along the columns.
        scores: One list of rows for each take.
        seconds: (rows, columns) for all takes together.
    """

    method: str
    group: str
    first: Axis
    second: Axis
    scores: list[list[list[Scores]]]
    seconds: NDArray[np.float64]

    def perf(self) -> NDArray[np.float64]:
        """Return Perf (rows, columns), mean over takes."""
        values = [[[cell.perf for cell in row] for row in take] for take in self.scores]
        return np.mean(np.array(values), axis=0)  # type: ignore[no-any-return]

    def best_each(self) -> tuple[list[float], list[float], Scores]:
        """Return for each take the best values of both thresholds, and the mean of its scores there."""
        chosen = [_best(np.array([[cell.perf for cell in row] for row in take])) for take in self.scores]
        scores = [take[i][j] for take, (i, j) in zip(self.scores, chosen, strict=True)]
        return (
            [self.first.values[i] for i, _ in chosen],
            [self.second.values[j] for _, j in chosen],
            mean_scores(scores),
        )

    def best_for_all(self) -> tuple[float, float, Scores]:
        """Return the one combination that is best for all takes, and its mean scores."""
        i, j = _best(self.perf())
        return self.first.values[i], self.second.values[j], mean_scores([take[i][j] for take in self.scores])


def _best(perf: NDArray[np.float64]) -> tuple[int, int]:
    i, j = np.unravel_index(int(np.argmax(perf)), perf.shape)
    return int(i), int(j)


def velocity_grid(takes: Sequence[Take], settings: Settings, on_progress: Callable[[str], None]) -> Grid:
    """Return the conventional velocity-based method over smoothing and threshold."""

    def solve(take: Take, smoothing: float) -> Iterable[tuple[float, Iterable[Detection]]]:
        times, curve = velocity(take, smoothed(settings, smoothing, take.fps))
        for threshold in METRES:
            began = time.perf_counter()
            found = crossings(times, curve, threshold)
            yield time.perf_counter() - began, [found]

    axes = Axis("wSize", SMOOTHING, "s"), Axis("sigThre", METRES, "m")
    return _grid("Velocity-based", takes, axes, solve, on_progress)


def splitting_grid(takes: Sequence[Take], settings: Settings, on_progress: Callable[[str], None]) -> Grid:
    """Return Mossar's splitting over smoothing and threshold."""

    def solve(take: Take, smoothing: float) -> Iterable[tuple[float, Iterable[Detection]]]:
        for share in SHARES:
            found = split(take, smoothed(settings, smoothing, take.fps).replace(sig_threshold=share))
            yield found.seconds, [found]

    axes = Axis("wSize", SMOOTHING, "s"), Axis("sigThre", SHARES)
    return _grid("Mossar splitting", takes, axes, solve, on_progress)


def remerging_grid(
    name: str, takes: Sequence[Take], settings: Settings, on_progress: Callable[[str], None]
) -> Grid:
    """Return Mossar over N and L; every nested set is one that can be chosen."""

    def solve(take: Take, edges: float) -> Iterable[tuple[float, Iterable[Detection]]]:
        for layers in LAYERS:
            began = time.perf_counter()
            result = whole(take, settings.replace(edges=int(edges), layers=layers))
            seconds = time.perf_counter() - began
            falling = [key.time for key in result.hierarchy]
            yield seconds, nested([key.time for key in result.key_frames], falling).values()

    return _grid(name, takes, (Axis("N", EDGES), Axis("L", LAYERS)), solve, on_progress)


def recursion_grid(takes: Sequence[Take], settings: Settings, on_progress: Callable[[str], None]) -> Grid:
    """Return Li and Leung's method over N and L; C_min and the minimum similarity can be chosen."""

    def solve(take: Take, edges: float) -> Iterable[tuple[float, Iterable[Detection]]]:
        for layers in LAYERS:
            chosen = settings.replace(edges=int(edges), layers=layers, kernel_form="sum")
            began = time.perf_counter()
            trees = [split_tree(take, chosen, size, LONGEST) for size in SHORTEST]
            seconds = time.perf_counter() - began
            sets = {tuple(sorted(accepted(tree, limit))) for tree in trees for limit in THRESHOLDS}
            yield seconds, [Detection(list(times)) for times in sorted(sets)]

    return _grid("Li & Leung", takes, (Axis("N", EDGES), Axis("L", LAYERS)), solve, on_progress)


def smoothed(settings: Settings, seconds: float, fps: float) -> Settings:
    """Return settings with a moving average over so many seconds; wSize 1 is none."""
    frames = max(1, round(seconds * fps))
    kind = "moving_average" if frames > 1 else "none"
    return settings.replace(smoothing=kind, smoothing_window=frames)


def _grid(
    method: str,
    takes: Sequence[Take],
    axes: tuple[Axis, Axis],
    solve: Solve,
    on_progress: Callable[[str], None],
) -> Grid:
    """Return the best result of `solve` by Perf along the second axis, for each value of the first."""
    first, second = axes
    seconds = np.zeros((len(first.values), len(second.values)))
    scores: list[list[list[Scores]]] = []
    for number, take in enumerate(takes, 1):
        rows: list[list[Scores]] = []
        for i, value in enumerate(first.values):
            step = f"{take.name} ({number} of {len(takes)}), {first.name} {value:g}{first.unit}"
            on_progress(f"{method}: {step}")
            row = []
            for j, (took, sets) in enumerate(solve(take, value)):
                seconds[i, j] += took
                row.append(max((found.scores(take) for found in sets), key=lambda one: one.perf))
            rows.append(row)
        scores.append(rows)
    return Grid(method, takes[0].group, first, second, scores, seconds)
