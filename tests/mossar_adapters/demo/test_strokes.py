"""Strokes and their time laws."""

import numpy as np
import pytest

from mossar_adapters.demo.strokes import (
    GRAVITY,
    Hops,
    Stroke,
    ballistic,
    cruise,
    minimum_jerk,
    shaking,
    there_and_back,
)

SHARE = np.linspace(0.0, 1.0, 4001)


@pytest.mark.parametrize("law", [minimum_jerk, cruise(0.3, 0.2)])
def test_laws_of_going_somewhere_run_from_0_to_1_without_turning_back(law):
    values = law(SHARE)
    assert values[0] == pytest.approx(0.0, abs=1e-12)
    assert values[-1] == pytest.approx(1.0)
    assert np.diff(values).min() > -1e-12


@pytest.mark.parametrize("law", [there_and_back, ballistic, shaking(3), Hops(1.6, 3)])
def test_laws_of_coming_back_start_and_end_at_0(law):
    assert law(SHARE)[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("law", [minimum_jerk, cruise(0.3, 0.2), there_and_back, shaking(3), Hops(1.6, 3)])
def test_motion_starts_and_ends_at_rest_without_jumps_of_speed(law):
    speed = np.diff(law(SHARE)) * (len(SHARE) - 1)
    assert np.abs(speed[[0, -1]]).max() < 0.02
    assert np.abs(np.diff(speed)).max() < 0.02 * np.abs(speed).max()


def test_minimum_jerk_is_fastest_in_the_middle_at_15_eighths_of_the_mean():
    speed = np.diff(minimum_jerk(SHARE)) * (len(SHARE) - 1)
    assert speed.max() == pytest.approx(1.875, rel=1e-4)
    assert SHARE[speed.argmax()] == pytest.approx(0.5, abs=1e-3)


def test_hops_fall_freely_between_every_take_off_and_landing():
    hops = Hops(1.6, 3)
    seconds = np.linspace(0.0, hops.duration, 20001)
    height = hops(seconds / hops.duration)
    fall = np.gradient(np.gradient(height, seconds), seconds)
    for i in range(hops.count):
        off = hops.take_off + i * hops.period
        flying = (seconds > off + 0.01) & (seconds < off + hops.flight - 0.01)
        np.testing.assert_allclose(fall[flying], -GRAVITY, rtol=1e-3)
        assert np.ptp(height[flying]) == pytest.approx(hops.rise, rel=0.15)


@pytest.mark.parametrize(("lasting", "after"), [(True, 2.0), (False, 0.0)])
def test_a_stroke_adds_nothing_before_and_its_amount_or_nothing_after(lasting, after):
    law = minimum_jerk if lasting else there_and_back
    stroke = Stroke(1.0, 0.5, law, np.array([2.0, 0.0]), lasting)
    values = stroke.at(np.array([0.0, 1.0, 1.5, 9.0]))
    np.testing.assert_allclose(values[:, 0], [0.0, 0.0, after, after])
    assert stroke.end == 1.5
