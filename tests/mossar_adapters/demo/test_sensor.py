"""The sensor: noise of the size asked for, time stamps in order, losses."""

import itertools

import numpy as np
import pytest

from mossar_adapters.demo import SKELETON, performance
from mossar_stream import SettingsError

FAR = [i for i, name in enumerate(SKELETON.names) if name.endswith(("Hand", "Foot", "Toes"))]
NEAR = [i for i in range(len(SKELETON)) if i not in FAR]


def errors(**sensor):
    seen = performance(2, seconds=20, **sensor).frames.positions.astype(float)
    return seen - performance(2, seconds=20).frames.positions


@pytest.mark.parametrize("noise", [0.001, 0.01])
def test_white_noise_has_the_standard_deviation_asked_for_on_every_joint_and_axis(noise):
    deviation = errors(noise=noise).std(axis=0)
    np.testing.assert_allclose(deviation, noise, rtol=0.12)


def test_noise_does_not_change_what_the_performer_does():
    assert performance(2, noise=0.01).cuts == performance(2).cuts


def test_kinect_noise_is_larger_at_hands_and_feet_and_when_moving():
    size = np.abs(errors(noise=0.005, noise_kind="kinect"))
    assert np.nanmedian(size[:, FAR]) > 1.5 * np.nanmedian(size[:, NEAR])
    speed = np.linalg.norm(np.diff(performance(2, seconds=20).frames.positions, axis=0), axis=-1) * 60
    fast = np.concatenate([np.zeros((1, len(SKELETON)), bool), speed > 2.0])
    assert np.nanmedian(size[fast]) > 1.5 * np.nanmedian(size[~fast])


def test_kinect_noise_repeats_frames_loses_joints_and_makes_single_joints_jump():
    seen = performance(2, seconds=60, noise=0.005, noise_kind="kinect").frames.positions
    repeated = [np.array_equal(a, b, equal_nan=True) for a, b in itertools.pairwise(seen)]
    assert 0.01 < np.mean(repeated) < 0.03
    missing = np.isnan(seen).any(axis=2)
    assert 0.0 < missing.mean() < 0.005
    assert not missing[:, NEAR].any()
    assert np.nanmax(np.abs(np.diff(seen, axis=0))) > 0.15


def test_jitter_keeps_times_increasing_and_near_the_truth():
    true = performance(2).frames.times
    times = performance(2, jitter=0.004).frames.times
    assert np.diff(times).min() > 0
    assert (times - true).std() == pytest.approx(0.004, rel=0.1)


def test_heavy_jitter_keeps_times_increasing():
    times = performance(2, seconds=20, jitter=0.1, drop=0.2).frames.times
    assert np.diff(times).min() > 0


def test_drop_loses_the_share_asked_for_and_leaves_the_others_as_they_were():
    whole, thinned = performance(2, seconds=60).frames, performance(2, seconds=60, drop=0.1).frames
    assert len(thinned) == pytest.approx(0.9 * len(whole), rel=0.03)
    assert np.diff(thinned.times).min() > 0
    kept = np.isin(whole.times, thinned.times)
    np.testing.assert_array_equal(whole.positions[kept], thinned.positions)


@pytest.mark.parametrize(
    ("option", "value"),
    [("fps", 0), ("fps", 1001), ("noise", -0.1), ("jitter", 1), ("drop", 1.0), ("tempo", float("nan"))],
)
def test_an_impossible_value_is_refused_with_its_range(option, value):
    with pytest.raises(SettingsError, match=rf"{option} must lie in [\d.]+ to [\d.]+, not"):
        performance(**{option: value})


def test_an_unknown_kind_of_noise_is_refused():
    with pytest.raises(SettingsError, match="noise_kind must be white or kinect, not 'pink'"):
        performance(noise_kind="pink")
