import numpy as np
import pytest

from mossar_adapters.receiving.steady import LOST, MEMORY, Steady


def steadied(arrivals):
    steady = Steady()
    return np.array([steady.time(float(arrival)) for arrival in arrivals])


def late(count, spread=0.008, seed=7):
    """Seconds by which frames are late: most of them a little, some much."""
    return np.random.default_rng(seed).exponential(spread, count)


def test_even_arrivals_stay_as_they_are():
    even = np.arange(500) / 60
    assert steadied(even) == pytest.approx(even, abs=1e-9)


def test_uneven_arrivals_become_even():
    times = steadied(np.arange(1200) / 60 + late(1200))
    assert np.diff(times[2 * MEMORY :]).std() * 60 < 0.02, "of a frame; as they come it is two thirds of one"
    assert times[-1] == pytest.approx(1199 / 60 + 0.008, abs=0.008), "late by what frames are late on average"


def test_a_lost_frame_and_a_new_rate_are_caught_up_with():
    frames = np.delete(np.arange(600), 300) / 60
    frames = np.append(frames, 10 + np.arange(600) / 30)
    assert np.abs(steadied(frames) - frames)[-300:].max() < 0.001


def test_a_pause_stays_a_pause():
    frames = np.append(np.arange(300) / 60, 8.0 + np.arange(300) / 60)
    times = steadied(frames)
    assert times[300] - times[299] > 3 - LOST
    assert times == pytest.approx(frames, abs=1e-6)


@pytest.mark.parametrize("arrivals", [np.zeros(50), -np.arange(50.0), np.tile([0.0, 0.2], 50)])
def test_times_never_stand_still_or_go_back(arrivals):
    assert (np.diff(steadied(arrivals)) > 0).all()
