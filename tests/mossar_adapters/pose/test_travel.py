"""Travel: pixels for each metre, without any network."""

import numpy as np

from mossar_adapters.pose.landmarks import Landmarks
from mossar_adapters.pose.travel import Travel, pixels_a_metre
from mossar_adapters.pose.types import HIPS


def landmarks(scale, shift=(0.0, 0.0), seed=1):
    world = np.random.default_rng(seed).normal(0, 0.4, (33, 3))
    world -= world[list(HIPS)].mean(0)
    pixels = np.zeros((39, 2))
    pixels[:33] = world[:, :2] * scale + shift
    return Landmarks(pixels, world, np.ones(33))


def test_pixels_a_metre_are_those_of_the_body():
    assert np.isclose(pixels_a_metre(landmarks(180.0, (400, 300))), 180.0)


def test_a_body_in_the_middle_is_straight_ahead():
    x, y, z = Travel().hips(landmarks(200.0, (320, 240)), 0.0, (480, 640))
    assert np.allclose((x, y), 0, atol=1e-9)
    assert z > 0


def test_a_metre_sideways_and_up_is_a_metre():
    travel = Travel()
    first = travel.hips(landmarks(200.0, (320, 240)), 0.0, (480, 640))
    then = travel.hips(landmarks(200.0, (520, 140)), 0.1, (480, 640))
    assert np.allclose(then - first, (1.0, -0.5, 0.0))


def test_half_as_large_is_twice_as_far():
    near = Travel().hips(landmarks(200.0, (320, 240)), 0.0, (480, 640))
    far = Travel().hips(landmarks(100.0, (320, 240)), 0.0, (480, 640))
    assert np.isclose(far[2], 2 * near[2])


def test_joints_all_in_one_place_give_no_nonsense():
    flat = Landmarks(np.zeros((39, 2)), np.zeros((33, 3)), np.zeros(33))
    assert np.isfinite(Travel().hips(flat, 0.0, (480, 640))).all()
