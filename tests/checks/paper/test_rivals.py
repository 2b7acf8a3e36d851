"""The two methods that the paper compares Mossar with."""

import numpy as np
import pytest

from checks.paper.recursion import Split, accepted, split_tree
from checks.paper.velocity_based import crossings, velocity
from mossar_stream import Settings
from mossar_tools.evaluation.performer import demo_takes


@pytest.fixture(scope="module")
def take():
    return next(demo_takes("demo:?fps=30&seconds=12", seeds=1))


def test_the_velocity_based_method_cuts_where_the_threshold_is_crossed():
    times = np.arange(7.0)
    curve = np.array([0, 1, 3, 1, 1, 2, 2.0])
    assert crossings(times, curve, 1.5).times == [2.0, 3.0, 5.0]
    assert crossings(times, curve, 2.0).times == [2.0, 3.0]  # at the threshold is resting


def test_the_velocity_is_metres_of_path_within_the_window(take):
    times, curve = velocity(take, Settings(window=0.5))
    centred = take.positions - take.positions[:, :1]
    steps = np.linalg.norm(np.diff(centred, axis=0), axis=2).sum(axis=1)
    last = int(np.searchsorted(take.times, 6.0))
    assert times[last] == take.times[last]
    assert curve[last] == pytest.approx(steps[last - 15 : last].sum(), rel=1e-3)


def test_recursion_accepts_nothing_below_what_it_does_not_accept():
    tree = Split(5.0, 0.5, (Split(2.0, 0.2, (Split(1.0, 0.9),)), Split(8.0, 0.4)))
    assert sorted(accepted(tree, 0.3)) == [5.0, 8.0]
    assert sorted(accepted(tree, 0.1)) == [1.0, 2.0, 5.0, 8.0]
    assert list(accepted(tree, 0.6)) == list(accepted(None, 0.0)) == []


def test_recursion_leaves_no_segment_shorter_than_c_min(take):
    settings = Settings(similarity="path_kernel", kernel_form="sum")
    times = sorted(accepted(split_tree(take, settings, 1.0, 4.0), 0.0))
    bounds = [float(take.times[0]), *times, float(take.times[-1])]
    assert len(times) > 3
    assert np.diff(bounds).min() >= 1.0 - 1e-6
