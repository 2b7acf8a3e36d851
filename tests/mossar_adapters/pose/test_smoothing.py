"""The One-Euro filter: against jitter, with motion."""

import numpy as np

from mossar_adapters.pose.smoothing import WORLD, OneEuro


def test_jitter_of_a_point_that_stays_goes():
    noise = np.random.default_rng(1).normal(0, 0.003, 300)
    filtered = OneEuro(*WORLD)
    smooth = np.array([filtered(np.array(x), k / 30) for k, x in enumerate(noise)])
    assert smooth[100:].std() < 0.5 * noise.std()


def test_a_quick_motion_is_followed():
    filtered = OneEuro(*WORLD)
    way = [filtered(np.array(2.0 * k / 30), k / 30) for k in range(60)]
    assert abs(way[-1] - 2.0 * 59 / 30) < 0.03  # m, at 2 m/s


def test_the_first_value_passes_at_time_zero():
    assert OneEuro(*WORLD)(np.array(5.0), 0.0) == 5.0


def test_a_time_that_repeats_does_no_harm():
    filtered = OneEuro(*WORLD)
    filtered(np.array(0.0), 1.0)
    assert np.isfinite(filtered(np.array(1.0), 1.0))
