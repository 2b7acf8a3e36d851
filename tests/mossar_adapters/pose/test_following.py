"""The person in pictures: as the maker finds it, travelling, one of several, gone and back."""

import json
from pathlib import Path

import numpy as np
import pytest

from mossar_adapters.joint_sets import BLAZEPOSE_33
from mossar_adapters.pose.following import Estimator
from mossar_adapters.pose.types import HIPS

RATE = 30.0
# World landmarks, mm, of mediapipe 0.10.21 (model_complexity=1, smooth_landmarks=True) in four pictures of the pan.
MAKER = json.loads((Path(__file__).parent / "maker_landmarks.json").read_text())


def about_hips(positions):
    return positions - positions[list(HIPS)].mean(0)


def followed(estimator, pictures, start=0.0):
    return [estimator.estimate(picture, start + k / RATE) for k, picture in enumerate(pictures)]


def test_landmarks_are_the_makers(weights, pan):
    found = followed(Estimator(weights), pan)
    errors = {}
    for number, landmarks in MAKER.items():
        ours = about_hips(found[int(number)][0].positions) * (1, -1, -1)
        errors[int(number)] = np.linalg.norm(ours - about_hips(np.array(landmarks) / 1000.0), axis=1)
    assert np.median(errors[0]) < 0.003  # m; the first picture has no past
    assert all(np.median(error) < 0.030 for error in errors.values())


def test_a_person_stands_upright_in_front_of_the_camera(weights, pan):
    body = Estimator(weights).estimate(pan[0], 0.0)[0]
    joint = dict(zip(BLAZEPOSE_33.names, body.positions, strict=True))
    assert joint["nose"][1] > joint["left_hip"][1] > joint["left_ankle"][1]  # y is up
    assert joint["left_shoulder"][0] > joint["right_shoulder"][0]  # seen from the front, not mirrored
    assert -3.0 < joint["left_hip"][2] < -0.3  # before the camera
    assert body.confidence[BLAZEPOSE_33.index("nose")] > 0.9


def test_hips_travel_with_the_picture(weights, astronaut):
    def at(x):
        picture = np.zeros((512, 1024, 3), np.uint8)
        picture[:, x : x + 512] = astronaut
        return picture

    found = followed(Estimator(weights), [at(8 * k) for k in range(60)])
    hips = np.array([bodies[0].positions[list(HIPS)].mean(0) for bodies in found])
    pixels = np.array([bodies[0].pixels[list(HIPS)].mean(0) for bodies in found])
    assert hips[-1, 0] - hips[0, 0] > 0.5  # m, by 472 pixels
    assert np.corrcoef(hips[:, 0], pixels[:, 0])[0, 1] > 0.99
    assert np.ptp(hips[:, 2]) < 0.5  # and neither nearer nor farther


def test_somebody_who_comes_nearer_comes_nearer(weights, astronaut):
    import cv2

    def at(scale):
        small = cv2.resize(astronaut, None, fx=scale, fy=scale)
        picture = np.zeros((600, 600, 3), np.uint8)
        edge = (600 - len(small)) // 2
        picture[edge : edge + len(small), edge : edge + len(small)] = small
        return picture

    found = followed(Estimator(weights), [at(scale) for scale in np.linspace(0.5, 1.1, 90)])
    far, near = (-found[k][0].positions[list(HIPS)].mean(0)[2] for k in (10, 89))
    assert 1.5 < far / near < 2.6  # 0.57 to 1.1, which the filter follows late


def test_nobody_is_found_in_a_picture_without_anybody(weights, pan):
    rng = np.random.default_rng(3)
    noise = rng.integers(0, 255, pan[0].shape, np.uint8)
    assert followed(Estimator(weights), [np.zeros_like(pan[0]), noise]) == [[], []]


def shapes(seed):
    """Return a picture of ellipses and lines, some like limbs, (360, 640, 3) BGR."""
    import cv2

    rng = np.random.default_rng(seed)
    picture = np.full((360, 640, 3), rng.integers(0, 255, 3), np.uint8)
    for _ in range(25):
        colour, (x, y), size = (
            rng.integers(0, most, 3).tolist()[:n] for most, n in ((255, 3), (360, 2), (110, 2))
        )
        x, size = x * 640 // 360, [10 + side for side in size]
        if rng.integers(2):
            cv2.ellipse(picture, (x, y), size, float(rng.integers(180)), 0, 360, colour, -1)
        else:
            cv2.line(picture, (x, y), (x + size[0], y + size[1]), colour, int(rng.integers(4, 30)))
    return picture


def test_shapes_that_the_detector_takes_for_a_person_are_nobody(weights):
    # Each gave a person while a new one needed no more than one who is followed.
    for seed in (25, 60, 92, 104, 461, 539):
        assert followed(Estimator(weights), [shapes(seed)]) == [[]], seed


def test_a_person_who_goes_and_comes_back_is_found_again(weights, pan):
    empty = np.zeros_like(pan[0])
    found = followed(Estimator(weights), [*pan[:5], *[empty] * 5, *pan[:5]])
    assert [len(bodies) for bodies in found] == [1] * 5 + [0] * 5 + [1] * 5


def test_two_people_keep_their_numbers_while_one_is_hidden(weights, astronaut):
    one, between = astronaut[:, :400], np.zeros((512, 100, 3), np.uint8)
    two = np.hstack([one, between, one])
    hidden = two.copy()
    hidden[:, :400] = 0
    found = followed(Estimator(weights, people=2), [*[two] * 20, *[hidden] * 20, *[two] * 30])
    place = {body.number: body.pixels[0, 0] for body in found[19]}
    assert sorted(place) == [1, 2]
    left = min(place, key=lambda number: place[number])
    assert [body.number for body in found[39]] == [3 - left]
    assert {body.number: body.pixels[0, 0] < 400 for body in found[59]} == {left: True, 3 - left: False}


def test_one_person_is_not_followed_twice(weights, pan):
    found = followed(Estimator(weights, people=4), pan)
    assert all(len(bodies) == 1 and bodies[0].number == 1 for bodies in found)


def test_a_number_of_people_that_cannot_be_is_refused(weights):
    with pytest.raises(ValueError, match="people must be 1 to 4"):
        Estimator(weights, people=5)
