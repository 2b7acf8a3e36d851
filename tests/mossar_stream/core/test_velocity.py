"""Equation 1 and its smoothing."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from checks.reference.algorithms import velocity_curve
from mossar_stream import Segmenter, Settings


def curve_of(core, steps, times, **settings):
    segmenter = Segmenter(
        core.PAIR,
        Settings(**{"range": "fixed", "range_max": 1.0, "max_speed": 1e4, "max_gap": 5.0, **settings}),
    )
    values = []
    for frame, time in zip(core.hand_steps(steps), times, strict=True):
        segmenter.push(frame, float(time))
        values.append(segmenter.state.value)
    return np.array(values)


def dyadic_steps(seed, count):
    steps = np.random.default_rng(seed).integers(0, 64, count) / 64
    steps[0] = 0
    return steps


@given(
    st.sampled_from([10, 24, 25, 29.97, 30, 50, 59.94, 60, 90, 100, 119.88, 120, 240]), st.floats(0.01, 2.0)
)
def test_at_a_constant_rate_the_window_holds_window_times_fps_displacements(core, fps, window):
    places = window * fps
    near = round(places)
    # Within a microsecond of a whole number of frames the count is that number.
    count = near if abs(places - near) < 1e-6 * fps else math.ceil(places)
    steps = np.r_[0, np.ones(count + 20)] / 64
    curve = curve_of(core, steps, np.arange(len(steps)) / fps, window=window)
    np.testing.assert_array_equal(curve * 64, np.minimum(np.arange(len(steps)), count))


def test_one_second_is_the_papers_window(core):
    steps = dyadic_steps(0, 400)
    curve = curve_of(core, steps, np.arange(400) / 120, window=1.0)
    expected = [steps[max(0, t - 119) : t + 1].sum() for t in range(400)]
    np.testing.assert_array_equal(curve, expected)


@given(st.integers(0, 10**6), st.floats(0.05, 1.5))
def test_with_jitter_the_displacements_of_the_trailing_window_are_summed(core, seed, window):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.001, 0.08, 150))
    steps = dyadic_steps(seed, 150)
    curve = curve_of(core, steps, times, window=window)
    np.testing.assert_array_equal(curve, velocity_curve(steps, times, window))


def test_a_source_far_quicker_than_its_nominal_rate_is_not_cut_short(core):
    segmenter = Segmenter(
        core.PAIR, Settings(window=0.5, range="fixed", range_max=1.0, max_speed=1e4), fps=10.0
    )
    steps = np.r_[0, np.ones(2000)] / 1024
    segmenter.push(core.hand_steps(steps), np.arange(2001) / 2048)
    assert segmenter.state.value == 1.0


@pytest.mark.parametrize("size", [1, 2, 5, 40])
def test_the_moving_average_is_the_mean_of_the_last_velocities(core, size):
    steps, times = dyadic_steps(3, 120), np.arange(120) / 32
    curve = curve_of(core, steps, times, window=0.25, smoothing="moving_average", smoothing_window=size)
    np.testing.assert_allclose(curve, velocity_curve(steps, times, 0.25, size), rtol=1e-12)


def test_ten_million_frames_do_not_drift(core):
    segmenter = Segmenter(
        core.PAIR,
        Settings(level="posture", window=0.25, range_floor=1e3, noise_margin=0.0, max_speed=1e4),
        fps=120.0,
    )
    rng = np.random.default_rng(4)
    chunk = np.zeros((250_000, 2, 3), np.float32)
    chunk[:, 1] = rng.normal(0, 0.03, (250_000, 3))
    moments = np.arange(250_000) / 120
    for turn in range(40):
        segmenter.push(chunk, moments + turn * 250_000 / 120)
    assert segmenter.stats["frames"] == 10_000_000
    assert segmenter.stats["out_of_order"] == 0
    paths = np.linalg.norm(np.diff(chunk[-31:, 1].astype(float), axis=0), axis=1)
    state = segmenter.state
    assert state.value * state.scale == pytest.approx(paths.sum(), rel=1e-6)
    segmenter.push(
        np.repeat(chunk[-1:], 40, axis=0), moments[-1] + 39 * 250_000 / 120 + np.arange(1, 41) / 120
    )
    assert segmenter.state.value == 0
