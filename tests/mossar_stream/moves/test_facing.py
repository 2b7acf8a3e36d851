"""Facing: the twist of the body about the vertical, whatever it does meanwhile."""

import numpy as np
import pytest

from mossar_stream import Skeleton
from mossar_stream.core.kernels import brought_back, facing, smoothed_facing
from mossar_stream.moves.facing import girdles_of

from .conftest import PERSON, STANDING

# The person of these tests has the left side towards -x, so it faces -z.
UPRIGHT = STANDING * [-1.0, 1.0, 1.0]


def turn(axis, degrees):
    a = np.radians(degrees)
    c, s = np.cos(a), np.sin(a)
    return {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


def angle_of(pose, skeleton=PERSON):
    x, z = facing(pose.astype(np.float32), girdles_of(skeleton))
    return np.degrees(np.arctan2(x, z)), np.hypot(x, z)


@pytest.mark.parametrize("degrees", [-170, -90, -30, 0, 30, 90, 179])
def test_the_facing_is_the_turn_about_the_vertical(degrees):
    angle, length = angle_of(UPRIGHT @ turn("y", degrees).T)
    assert angle == pytest.approx(degrees, abs=0.01)
    assert length == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize(("axis", "most"), [("z", 170), ("x", 170)])
def test_cartwheels_and_bows_keep_it(axis, most):
    for lean in range(-most, most + 1, 10):
        angle, length = angle_of(UPRIGHT @ turn(axis, lean).T @ turn("y", 40).T)
        assert angle == pytest.approx(40, abs=0.01)
        assert length == pytest.approx((1 + np.cos(np.radians(lean))) / 2, abs=1e-4)


@pytest.mark.parametrize("missing", ["left_hip", "right_shoulder"])
def test_one_girdle_is_enough(missing):
    pose = UPRIGHT @ turn("y", 60).T
    pose[PERSON.index(missing)] = np.nan
    assert angle_of(pose)[0] == pytest.approx(60, abs=0.01)


def test_without_girdles_there_is_none():
    pose = np.full((15, 3), np.nan)
    assert angle_of(pose)[1] == 0.0
    hand = Skeleton(("wrist", "thumb", "index"), (-1, 0, 0))
    assert angle_of(np.eye(3), hand)[1] == 0.0


def test_a_smoothed_facing_settles_and_stays_where_nothing_is_known():
    held = np.zeros(2)
    times = np.arange(61) / 30
    found = np.tile([1.0, 0.0], (61, 1))
    found[0] = 0.0, 1.0
    found[40:] = 0.0
    smoothed_facing(held, found[:10], times[:10])
    assert held == pytest.approx([1 - np.exp(-1), np.exp(-1)], abs=1e-6)
    smoothed_facing(held, found[9:40], times[9:40])
    last = held.copy()
    assert last[0] > 0.95
    smoothed_facing(held, found[40:], times[40:])
    assert (held == last).all()


def test_what_is_turned_back_is_where_it_was():
    pose = UPRIGHT @ turn("y", 123).T
    x, z = facing(pose.astype(np.float32), girdles_of(PERSON))
    for here, before in zip(pose, UPRIGHT, strict=True):
        assert brought_back(here[0], here[2], x, z) == pytest.approx(before[[0, 2]], abs=1e-5)
    assert brought_back(0.3, 0.4, 0.0, 0.0) == pytest.approx((0.3, 0.4))
