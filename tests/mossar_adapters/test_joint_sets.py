import pytest

from mossar_adapters.joint_sets import (
    BODY_18,
    CMU_31,
    COCO_17,
    JOINT_SETS,
    KINECT_20,
    NTU_25,
    by_count,
    openni_parents,
    with_known_parents,
)


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("coco17", 17),
        ("blazepose33", 33),
        ("body25", 25),
        ("body18", 18),
        ("kinect20", 20),
        ("kinect25", 25),
        ("ntu25", 25),
        ("cmu31", 31),
    ],
)
def test_sets_have_the_joints_of_their_name_in_one_tree(name, count):
    known = JOINT_SETS[name]
    assert len(known) == count
    assert known.parents.count(-1) == 1


def test_every_set_finds_itself():
    for known in JOINT_SETS.values():
        assert with_known_parents(known.names) == (known.parents, known.root)


def test_spelling_and_prefixes_do_not_matter():
    names = [f"mixamorig:{name}" for name in ("Hips", "Spine", "Head", "LeftUpLeg", "LeftLeg")]
    assert with_known_parents(names) == ((-1, 0, 1, 0, 3), 0)
    assert (
        with_known_parents([name.replace("_", " ").title() for name in COCO_17.names])[0] == COCO_17.parents
    )


def test_missing_joints_are_bridged_and_ends_hang_on_their_joint():
    names = [name for name in KINECT_20.names if name != "Spine"] + ["Head_End"]
    parents, root = with_known_parents(names)
    assert parents[names.index("ShoulderCenter")] == root == names.index("HipCenter")
    assert parents[-1] == names.index("Head")


def test_unknown_names_have_no_parents_and_the_centroid_as_centre():
    assert with_known_parents(["LFHD", "RFHD", "C7"]) == ((-1, -1, -1), -1)
    assert with_known_parents(["LFHD", "Pelvis", "C7"]) == ((-1, -1, -1), 1)
    assert with_known_parents(["End"]) == ((-1,), -1)


def test_unnamed_poses_are_told_apart_by_their_number():
    assert by_count(17) is COCO_17
    assert by_count(18) is BODY_18
    assert by_count(19) is None
    assert (NTU_25.names[20], CMU_31.names[0]) == ("SpineShoulder", "root")


def test_names_of_other_programs_hang_on_each_other_too():
    names = [
        "pelvis",
        "spine_01",
        "spine_03",
        "neck_01",
        "head",
        "clavicle_l",
        "upperarm_l",
        "lowerarm_l",
        "hand_l",
        "index_01_l",
    ]
    names += ["thigh_l", "calf_l", "foot_l", "ball_l", "eye_l"]
    parents, root = with_known_parents(names)
    assert root == 0
    assert [names[parent] if parent >= 0 else "" for parent in parents] == [
        "", "pelvis", "spine_01", "spine_03", "neck_01", "spine_03", "clavicle_l", "upperarm_l", "lowerarm_l", "hand_l",
        "pelvis", "thigh_l", "calf_l", "foot_l", "head",
    ]  # fmt: skip


@pytest.mark.parametrize("spelling", [str.lower, str.title, str.upper])
def test_sensors_with_openni_are_known_in_any_spelling(spelling):
    names = [
        spelling(name)
        for name in ("torso", "neck", "left_shoulder", "left_elbow", "left_hand", "left_hip", "left_knee")
    ]
    parents, root = openni_parents(names)
    assert (parents, root) == ((-1, 0, 1, 2, 3, 0, 5), 0)


def test_joints_that_the_nearest_set_lacks_hang_where_their_names_say():
    # BVH names of which a set knows all but the chest.
    tree = {
        "Hips": "", "Spine": "Hips", "Chest": "Spine", "Neck": "Chest", "Head": "Neck", "Head_End": "Head",
        "LeftShoulder": "Chest", "LeftArm": "LeftShoulder", "LeftForeArm": "LeftArm", "LeftHand": "LeftForeArm",
        "RightShoulder": "Chest", "RightArm": "RightShoulder", "RightForeArm": "RightArm", "RightHand": "RightForeArm",
        "LeftUpLeg": "Hips", "LeftLeg": "LeftUpLeg", "LeftFoot": "LeftLeg",
        "RightUpLeg": "Hips", "RightLeg": "RightUpLeg", "RightFoot": "RightLeg",
    }  # fmt: skip
    names = list(tree)
    parents, root = with_known_parents(names)
    assert root == 0
    assert {
        name: names[parent] if parent >= 0 else "" for name, parent in zip(names, parents, strict=True)
    } == tree
