import numpy as np
import pytest

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.rates import rate_of_times
from mossar_adapters.files.units import fitted_scale, guessed_scale, height, stated_scale


@pytest.mark.parametrize(
    ("tall", "unit"), [(1.6, "m"), (178, "cm"), (1700, "mm"), (70, "inch"), (120, "cm"), (1.2, "m")]
)
def test_the_unit_that_makes_people_is_taken(tall, unit):
    assert f"unit taken as {unit} " in guessed_scale(ReadOptions(), tall).note


def test_the_word_of_the_user_goes_first():
    options = ReadOptions(unit="mm")
    assert [
        guessed_scale(options, 1.7).metres,
        fitted_scale(options, 1.7).metres,
        stated_scale(options, 1.0).metres,
    ] == [0.001] * 3
    assert guessed_scale(options, 1.7).note is None


def test_without_a_height_metres_are_taken_and_said_so():
    assert guessed_scale(ReadOptions(), 0).metres == 1
    assert "cannot be measured" in guessed_scale(ReadOptions(), 0).note
    assert fitted_scale(ReadOptions(), 0).metres == 1


def test_height_ignores_frames_without_half_of_the_joints():
    positions = np.zeros((3, 4, 3))
    positions[:, 0, 1] = [1.7, 1.7, 500]
    positions[2, 1:] = np.nan
    assert height(positions) == 1.7
    assert height(positions[2:]) == 0


@pytest.mark.parametrize(
    ("times", "fps"),
    [
        (np.arange(10) / 24, 24),
        (np.arange(10) / 23.976, 23.976),
        (np.round(np.arange(100) / 60, 3), 60),
        (np.delete(np.arange(100) / 30, [5, 6, 50]), 30),
        ([0.0], None),
        ([1.0, 1.0], None),
        (np.cumsum(np.geomspace(0.001, 1, 50)), None),
    ],
)
def test_the_nominal_rate_is_found_in_the_times_if_there_is_one(times, fps):
    assert rate_of_times(np.asarray(times)) == (None if fps is None else pytest.approx(fps, rel=1e-3))
