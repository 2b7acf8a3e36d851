"""The moves, as seen: each must be what it is called, at a human size and speed."""

import numpy as np
import pytest

from mossar_adapters.demo import SKELETON, performance

FPS = 120.0


class Seen:
    """One move, measured."""

    def __init__(self, move, seed=7):
        self.positions = performance(seed, fps=FPS, moves=[move]).frames.positions.astype(float)

    def joint(self, name):
        return self.positions[:, SKELETON.index(name)]

    def rise(self, name):
        return np.ptp(self.joint(name)[:, 1])

    def top_speed(self, name):
        return np.linalg.norm(np.diff(self.joint(name), axis=0), axis=1).max() * FPS


@pytest.mark.parametrize(("side", "other"), [("left", "right"), ("right", "left")])
def test_punch_thrusts_the_fist_of_its_side_forwards_at_shoulder_height(side, other):
    seen, name = Seen(f"punch_{side}"), side.capitalize()
    fist = seen.joint(f"{name}Hand")
    farthest = fist[:, 2].argmax()
    assert fist[farthest, 2] > 0.5
    assert fist[farthest, 2] > seen.joint(f"{other.capitalize()}Hand")[:, 2].max() + 0.15
    assert fist[farthest, 1] == pytest.approx(seen.joint(f"{name}UpperArm")[farthest, 1], abs=0.15)
    assert 4 < seen.top_speed(f"{name}Hand") < 8


@pytest.mark.parametrize(("side", "other"), [("left", "right"), ("right", "left")])
def test_kick_lifts_the_foot_of_its_side_above_the_belt_and_stands_on_the_other(side, other):
    seen = Seen(f"kick_{side}")
    foot = seen.joint(f"{side.capitalize()}Toes")
    assert foot[:, 1].max() > 0.9
    assert foot[foot[:, 1].argmax(), 2] > 0.7
    assert seen.rise(f"{other.capitalize()}Toes") < 0.01
    assert 3 < seen.top_speed(f"{side.capitalize()}Foot") < 10


def test_jump_crouches_and_leaves_the_floor_with_both_feet():
    seen = Seen("jump")
    lower_foot = np.minimum(seen.joint("LeftToes")[:, 1], seen.joint("RightToes")[:, 1])
    assert 0.15 < lower_foot.max() < 0.5
    assert np.count_nonzero(np.diff((lower_foot > 0.08).astype(int)) == 1) == 3
    assert seen.joint("Hips")[:, 1].min() < 0.75
    assert seen.joint("Hips")[:, 1].max() > 1.05


@pytest.mark.parametrize("side", ["left", "right"])
def test_wave_swings_the_raised_hand_to_and_fro_beside_the_head(side):
    seen = Seen(f"wave_{side}")
    hand = seen.joint(f"{side.capitalize()}Hand")
    raised = hand[:, 1] > seen.joint("Neck")[:, 1]
    assert raised.mean() > 0.5
    heading = np.sign(np.diff(hand[raised, 0]))
    assert 7 <= np.count_nonzero(np.diff(heading)) <= 12


def test_squat_lowers_the_hips_and_comes_up_again_twice():
    seen = Seen("squat")
    hips = seen.joint("Hips")[:, 1]
    assert 0.45 < hips.min() < 0.64
    assert hips[-1] > hips.min() + 0.15
    assert np.count_nonzero(np.diff((hips < 0.7).astype(int)) == 1) == 2
    assert seen.rise("LeftToes") < 0.01


def test_walk_moves_the_whole_body_ahead_at_walking_speed():
    seen = Seen("walk")
    travelled = seen.joint("Hips")[-1] - seen.joint("Hips")[0]
    assert 1.5 < travelled[2] < 3.5
    assert abs(travelled[0]) < 0.01
    assert 0.8 < seen.top_speed("Hips") < 1.6


def test_feet_do_not_slide_while_they_stand():
    for move in ("walk", "turn", "punch", "kick", "squat", "wave"):
        seen = Seen(move)
        for name in ("LeftToes", "RightToes"):
            toes = seen.joint(name)
            standing = toes[:-1, 1] < 0.0205
            step = np.linalg.norm(np.diff(toes[:, [0, 2]], axis=0), axis=1)
            assert step[standing].max() * FPS < 0.35, (move, name)


@pytest.mark.parametrize(("side", "sign"), [("left", 1), ("right", -1)])
def test_turn_faces_another_way_on_the_spot(side, sign):
    seen = Seen(f"turn_{side}")
    across = seen.joint("LeftUpperLeg")[-1] - seen.joint("RightUpperLeg")[-1]
    turned = np.degrees(np.arctan2(-across[2], across[0])) % 360
    assert 40 < (sign * turned) % 360 < 75
    assert np.linalg.norm(seen.joint("Hips")[-1] - seen.joint("Hips")[0]) < 0.01


def test_rest_is_still_but_for_a_breath_of_a_millimetre():
    seen = Seen("rest")
    assert np.ptp(seen.positions, axis=0).max() < 0.0025
    assert seen.top_speed("Head") < 0.003


@pytest.mark.parametrize("move", ["punch", "kick", "jump", "wave", "squat", "walk", "turn"])
@pytest.mark.parametrize("seed", range(4))
def test_moves_are_smooth_stay_above_the_floor_and_are_never_superhuman(move, seed):
    seen = Seen(move, seed)
    assert seen.positions[..., 1].min() > 0.0
    speed = np.linalg.norm(np.diff(seen.positions, axis=0), axis=-1) * FPS
    assert speed.max() < 10
    assert np.abs(np.diff(speed, axis=0)).max() * FPS < 400
