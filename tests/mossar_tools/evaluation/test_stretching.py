import msgspec
import numpy as np
import pytest

from mossar_tools.evaluation.stretching import stretched
from mossar_tools.evaluation.takes import load_folder


@pytest.fixture
def take(relabel):
    (found,) = load_folder(relabel(cuts=[30, [60, 66, 75]]))
    return found


@pytest.mark.parametrize("factor", [0.6, 2.0])
def test_a_stretched_take_lasts_so_many_times_as_long_with_its_cuts_and_their_tolerance(take, factor):
    other = stretched(take, factor)
    assert other.duration == pytest.approx(factor * take.duration, abs=1 / take.fps)
    assert other.fps == take.fps
    assert np.allclose(np.diff(other.times), 1 / take.fps)
    assert other.tolerance == pytest.approx(factor * take.tolerance)
    for cut, own in zip(other.cuts, take.cuts, strict=True):
        assert msgspec.structs.astuple(cut) == pytest.approx(
            [factor * t for t in msgspec.structs.astuple(own)]
        )


def test_frames_lie_on_straight_lines_between_those_recorded(take):
    other = stretched(take, 2.0)
    assert np.allclose(other.positions[::2], take.positions[: len(other.positions[::2])], atol=1e-5)
    middle = (take.positions[10] + take.positions[11]) / 2
    assert np.allclose(other.positions[21], middle, atol=1e-5)


def test_a_joint_that_is_missing_is_missing_only_there_and_halfway(take):
    gap = take.positions.copy()
    gap[10, 1] = np.nan
    other = stretched(msgspec.structs.replace(take, positions=gap), 2.0)
    missing = np.flatnonzero(np.isnan(other.positions[:, 1, 0]))
    assert missing.tolist() == [19, 20, 21]


def test_as_recorded_is_the_take_itself(take):
    assert stretched(take, 1.0) is take
