"""Scales: the performer's own time, steadiness, and what both make of the tempo that evidence is divided by."""

import numpy as np
import pytest

from mossar_stream import Segmenter, Skeleton
from mossar_stream.core.kernels import (
    LINGERS_LITTLE,
    LINGERS_OFTEN,
    ORDINARY,
    QUICKEST,
    RECORDS,
    SLOW,
    SLOWEST,
    STEADY_SLOWEST,
    tempo_in_force,
)

FPS = 30
SKELETON = Skeleton(("hip", "elbow", "hand"), (-1, 0, 1))
HALF = 0.5 * (LINGERS_LITTLE + LINGERS_OFTEN)  # share of the time, in which steadiness is 0.5


def swung(period, pause=0.0, seconds=60):
    """Return (n, 3, 3) m: an arm that swings out and back in `period` s, and rests for `pause` s at either end."""
    phase = np.arange(seconds * FPS) / FPS % (period + 2 * pause)
    way = np.interp(phase, np.cumsum([0.0, period / 2, pause, period / 2, pause]), [0.0, 1.0, 1.0, 2.0, 2.0])
    positions = np.zeros((len(phase), 3, 3), np.float32)
    positions[:, 1:, 1] = 0.5, 1.0
    positions[:, 1:, 0] = (0.5 - 0.5 * np.cos(np.pi * way))[:, None] * np.array([0.4, 0.6])
    return positions


def scales_after(positions):
    """Return the state and the scales after a recording that is streamed."""
    segmenter = Segmenter(SKELETON, fps=FPS)
    segmenter.push(positions)
    return segmenter.state, segmenter.row.state["scales"]


def tempo(own_time, lingered, follows=True):
    """Return the tempo in force at an own time, s, of performers who linger for such a share of the time."""
    scales = np.zeros(1, RECORDS["Row"]["scales"])
    for name in ("spread_weight", "speed_weight", "squared_speed"):
        scales[name] = 1.0
    scales["spread"], scales["lingered"] = own_time**2, lingered
    return tempo_in_force(scales, follows)


def test_the_own_time_doubles_when_the_same_movement_is_half_as_fast():
    quick, slow = (scales_after(swung(period))[0].own_time for period in (2.0, 4.0))
    assert slow == pytest.approx(2.0 * quick, rel=0.05)


def test_levels_other_than_motion_measure_no_own_time():
    segmenter = Segmenter(SKELETON, fps=FPS)
    segmenter.push(swung(2.0, seconds=2))
    assert segmenter.state.own_time > 0.0
    for level in ("posture", "cluster"):
        other = Segmenter(SKELETON, segmenter.settings.at_level(level), fps=FPS)
        other.push(swung(2.0, seconds=2))
        assert other.state.own_time is None


@pytest.mark.parametrize("slowness", [1.0, 2.0])
def test_the_share_of_time_in_which_a_performer_lingers_is_that_below_the_line_at_any_speed(slowness):
    # A harmonic swing is slower than a share s of its rms speed for 2/π asin(s / √2) of the time.
    _, scales = scales_after(swung(2.0 * slowness))
    expected = 2.0 / np.pi * np.arcsin(SLOW / np.sqrt(2.0))
    assert scales["lingered"] / scales["speed_weight"] == pytest.approx(expected, abs=0.03)
    _, scales = scales_after(swung(2.0 * slowness, pause=1.0 * slowness))
    assert scales["lingered"] / scales["speed_weight"] > 0.5


@pytest.mark.parametrize(
    ("lingered", "expected"),
    [(0.0, 1.5**2), (LINGERS_LITTLE, 1.5**2), (HALF, 1.5**1.5), (LINGERS_OFTEN, 1.5), (1.0, 1.5)],
)
def test_the_slowness_of_steady_performers_counts_twice(lingered, expected):
    assert tempo(1.5 * ORDINARY, lingered) == pytest.approx(expected)
    assert tempo(1.5 * ORDINARY, lingered, follows=False) == pytest.approx(1.5)


@pytest.mark.parametrize("lingered", [0.0, HALF, 1.0])
def test_quick_performers_are_as_quick_however_steady(lingered):
    assert tempo(0.6 * ORDINARY, lingered) == pytest.approx(0.6)
    assert tempo(0.1 * ORDINARY, lingered) == QUICKEST


def test_the_tempo_has_limits_and_that_of_steady_performers_is_higher():
    assert tempo(9.0 * ORDINARY, 1.0) == SLOWEST
    assert tempo(9.0 * ORDINARY, HALF) == pytest.approx(SLOWEST + 0.5 * STEADY_SLOWEST)
    assert tempo(9.0 * ORDINARY, 0.0) == pytest.approx(SLOWEST + STEADY_SLOWEST)
    assert tempo(9.0 * ORDINARY, 0.0, follows=False) == SLOWEST
