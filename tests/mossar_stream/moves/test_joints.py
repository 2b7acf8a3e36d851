"""Joints of one set are found in another, and what is missing is named."""

import pytest

from mossar_adapters.joint_sets import (
    BLAZEPOSE_33,
    CMU_31,
    COCO_17,
    HUMANOID,
    KINECT_20,
    KINECT_25,
    MIXAMO,
    MOTIVE,
)
from mossar_stream import FrameError, Skeleton
from mossar_stream.moves.joints import known_joints, shared_joints
from mossar_stream.moves.limbs import limbs_of

MAIN = [
    f"{side}_{part}"
    for side in ("left", "right")
    for part in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")
]


@pytest.mark.parametrize(
    "skeleton", [BLAZEPOSE_33, CMU_31, COCO_17, HUMANOID, KINECT_20, KINECT_25, MIXAMO, MOTIVE]
)
def test_the_main_joints_of_known_sets_are_known(skeleton):
    assert not set(MAIN) - set(known_joints(skeleton))


def test_a_humanoids_shoulder_is_where_its_upper_arm_begins():
    assert HUMANOID.names[known_joints(HUMANOID)["left_shoulder"]] == "LeftUpperArm"


@pytest.mark.parametrize("skeleton", [BLAZEPOSE_33, CMU_31, COCO_17, HUMANOID, KINECT_20, MIXAMO])
def test_kinect_examples_serve_streams_of_other_sets(skeleton):
    names, ours, theirs = shared_joints(KINECT_25, skeleton)
    assert names[0] == "hips"
    assert not set(MAIN) - set(names)
    assert len(names) == len(ours) == len(theirs)


def test_the_centre_may_lie_between_the_hips():
    _, _, theirs = shared_joints(KINECT_25, COCO_17)
    assert [COCO_17.names[joint] for joint in theirs[0]] == ["left_hip", "right_hip"]


def test_missing_joints_are_named():
    upper = COCO_17.select(("nose", "left_shoulder", "right_shoulder", "left_hip", "right_hip", "left_elbow"))
    with pytest.raises(FrameError, match="left_wrist"):
        shared_joints(KINECT_25, upper)
    with pytest.raises(FrameError, match="rod"):
        shared_joints(Skeleton(("a", "rod"), (-1, 0)), Skeleton(("a", "b"), (-1, 0)))


def test_limbs_of_known_sets_and_of_others():
    limbs = limbs_of(KINECT_25)
    assert list(limbs) == ["trunk", "left_arm", "right_arm", "left_leg", "right_leg"]
    assert {"ThumbLeft", "HandTipLeft"} <= {KINECT_25.names[j] for j in limbs["left_arm"]}
    assert limbs_of(Skeleton(("a", "b"), (-1, -1), -1))
    # body is a channel already.
    assert limbs_of(Skeleton(("hip", "body", "tip"), (-1, 0, 1))) == {"body_limb": (1, 2)}


def test_limbs_of_unknown_names_follow_from_the_tree_and_a_stem_is_the_trunk():
    parents = {
        "a": "",
        "b": "a",
        "c": "b",
        "d": "c",
        "e": "c",
        "e1": "e",
        "e2": "e1",
        "f": "c",
        "f1": "f",
        "f2": "f1",
    }
    parents |= {"g": "a", "g1": "g", "h": "a", "h1": "h"}
    names = tuple(parents)
    body = Skeleton(names, tuple(names.index(above) if above else -1 for above in parents.values()))
    assert {limb: "".join(f"{names[j]} " for j in joints) for limb, joints in limbs_of(body).items()} == {
        "trunk": "a b c ",
        "d": "d ",
        "e": "e e1 e2 ",
        "f": "f f1 f2 ",
        "g": "g g1 ",
        "h": "h h1 ",
    }


def test_a_chain_as_long_as_a_skeleton_may_be_has_limbs():
    assert len(limbs_of(Skeleton(tuple(f"x{i}" for i in range(1024)), (-1, *range(1023))))["x1"]) == 1023
