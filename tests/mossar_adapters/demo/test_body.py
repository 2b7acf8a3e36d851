"""The body: forward kinematics of random poses."""

import numpy as np
import pytest

from mossar_adapters.demo.body import (
    CHANNEL,
    CHANNELS,
    FOOT,
    LOWER_ARM,
    NEUTRAL,
    SHANK,
    SKELETON,
    THIGH,
    UPPER_ARM,
    joint_positions,
    pose,
)


def joint(positions, name):
    return positions[:, SKELETON.index(name)]


def lengths(positions):
    parents, children = np.array(SKELETON.bones()).T
    return np.linalg.norm(positions[:, children] - positions[:, parents], axis=-1)


@pytest.fixture
def standing():
    return joint_positions(pose(NEUTRAL)[None])


def test_has_twenty_one_named_joints_with_the_hips_as_root():
    assert len(SKELETON) == 21
    assert SKELETON.names[SKELETON.root] == "Hips"
    assert {"Head", "LeftHand", "RightToes"} <= set(SKELETON.names)


def test_stands_upright_on_the_floor_facing_z_with_the_left_side_at_positive_x(standing):
    assert joint(standing, "Head")[0, 1] == pytest.approx(1.56, abs=0.03)
    assert standing[0, :, 1].min() == pytest.approx(0.02)
    assert joint(standing, "LeftHand")[0, 0] > 0.1
    assert joint(standing, "LeftToes")[0, 2] > joint(standing, "LeftFoot")[0, 2]


def test_left_and_right_mirror_each_other_at_ease(standing):
    for name in ("UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toes"):
        left, right = joint(standing, f"Left{name}")[0], joint(standing, f"Right{name}")[0]
        np.testing.assert_allclose(left, right * (-1, 1, 1), atol=1e-12)


def test_bone_lengths_are_the_same_in_every_pose_even_out_of_reach(standing):
    rng = np.random.default_rng(5)
    poses = pose(NEUTRAL) + rng.normal(0, 0.5, (500, len(CHANNELS)))
    positions = joint_positions(poses)
    np.testing.assert_allclose(lengths(positions), lengths(standing).repeat(500, axis=0), atol=1e-12)


def test_limb_bones_have_their_lengths(standing):
    length = dict(
        zip([SKELETON.names[child] for _, child in SKELETON.bones()], lengths(standing)[0], strict=True)
    )
    expected = {"LowerArm": UPPER_ARM, "Hand": LOWER_ARM, "LowerLeg": THIGH, "Foot": SHANK}
    for name, metres in {**expected, "Toes": np.linalg.norm(FOOT)}.items():
        assert length[f"Left{name}"] == pytest.approx(metres)
        assert length[f"Right{name}"] == pytest.approx(metres)


def test_toes_stay_where_they_stand_while_the_hips_move():
    poses = np.tile(pose(NEUTRAL), (50, 1))
    poses[:, CHANNEL["hips_y"]] -= np.linspace(0.0, 0.4, 50)
    positions = joint_positions(poses)
    assert np.ptp(joint(positions, "LeftToes"), axis=0).max() < 1e-12


def test_knees_bend_forwards_and_elbows_backwards(standing):
    assert joint(standing, "LeftLowerLeg")[0, 2] > joint(standing, "LeftFoot")[0, 2]
    middle = (joint(standing, "LeftUpperArm")[0, 2] + joint(standing, "LeftHand")[0, 2]) / 2
    assert joint(standing, "LeftLowerArm")[0, 2] < middle
