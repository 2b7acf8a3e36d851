import numpy as np
import pytest

from checks.paper.grid import Axis, Grid, remerging_grid, smoothed, velocity_grid
from checks.paper.tables import grids_json, mean_perf, paper_tables, total_seconds
from mossar_stream import Settings
from mossar_tools.evaluation.metrics import Scores
from mossar_tools.evaluation.performer import demo_takes


def made(method, group, takes):
    scores = [[[Scores(p, p, p, p, p, 1.0) for p in row] for row in take] for take in takes]
    return Grid(
        method, group, Axis("N", (5, 10)), Axis("L", (1, 3)), scores, np.array([[1.0, 2.0], [3.0, 4.0]])
    )


@pytest.fixture
def grid():
    return made("Mossar", "motion", [[[0.1, 0.9], [0.5, 0.2]], [[0.3, 0.4], [0.8, 0.1]]])


def test_the_best_for_each_take_is_averaged(grid):
    edges, layers, scores = grid.best_each()
    assert (edges, layers) == ([5, 10], [3, 1])
    assert scores.perf == pytest.approx(0.85)


def test_one_combination_is_the_best_for_all(grid):
    edges, layers, scores = grid.best_for_all()
    assert (edges, layers, scores.perf) == (5, 3, pytest.approx(0.65))
    assert np.allclose(grid.perf(), [[0.2, 0.65], [0.65, 0.15]])


def test_tables_average_perf_and_add_time_over_the_groups(grid):
    other = made("Mossar", "cluster", [[[0.4, 0.35], [0.35, 0.85]]])
    assert np.allclose(mean_perf([grid, other])["Mossar"], [[0.3, 0.5], [0.5, 0.5]])
    assert total_seconds([grid, other])["Mossar"].tolist() == [[2, 4], [6, 8]]
    text = "\n".join(paper_tables([grid], [grid, other], {"motion": grid.best_each()[2]}))
    for title in (
        "Table 2",
        "Fig. 11",
        "Table 3",
        "Fig. 12",
        "Tables 4 and 5",
        "Tables 6 and 7",
        "random merging",
    ):
        assert title in text
    assert "7.50 ± 2.50" in text
    assert grids_json([grid])[0]["best_for_all"]["N"] == 5


def test_smoothing_is_in_frames_of_the_recording():
    assert smoothed(Settings(), 0.0, 120).smoothing == "none"
    assert smoothed(Settings(), 0.25, 120).smoothing_window == 30


def test_the_grids_of_a_take_have_all_combinations():
    takes = list(demo_takes("demo:?fps=30&seconds=6", seeds=1))
    settings = Settings.build("paper", {"window": 0.25})
    for grid in (
        velocity_grid(takes, settings, lambda _: None),
        remerging_grid("Mossar", takes, settings, lambda _: None),
    ):
        assert grid.perf().shape == grid.seconds.shape == (len(grid.first.values), len(grid.second.values))
        assert 0 <= grid.perf().min() <= grid.perf().max() <= 1
