"""Takes under other conditions: what is played is what is said, and the built-in performer withstands it."""

import numpy as np
import pytest

from checks.conditions import CONDITIONS, RATES, as_recorded, at_half_speed, drawn_out, f1, staying
from mossar_tools.evaluation.performer import demo_takes


@pytest.fixture(scope="module")
def takes():
    return list(demo_takes("demo:?fps=30&seconds=15", 3))


def test_what_is_drawn_out_goes_through_the_same_poses(takes):
    for times in (2, 4):
        played = drawn_out(takes[0], times)
        np.testing.assert_allclose(played.positions[::times], takes[0].positions, atol=1e-6)
        assert played.fps == times * takes[0].fps
        assert len(played.positions) == times * (len(takes[0].positions) - 1) + 1


def test_cuts_are_played_as_slowly_as_the_poses(takes):
    for take in takes:
        assert f1(take, at_half_speed(take)) > 0.3
        assert f1(take, as_recorded(take)) >= 0.4
    assert np.mean([f1(take, as_recorded(take)) for take in takes]) > 0.4


def test_at_higher_rates_key_frames_stay(takes):
    for name in ("twice the rate", "four times the rate"):
        assert staying(takes, RATES[name]) >= 0.97


def test_noise_and_tempo_cost_little(takes):
    reached = {
        name: np.mean([f1(take, change(take)) for take in takes]) for name, change in CONDITIONS.items()
    }
    assert min(reached.values()) >= reached["as recorded"] - 0.25
