"""Names of joints are read in words, sides and parts, whatever program wrote them."""

import pytest

from mossar_stream import Skeleton, find_joints, trunk_joints, words_of
from mossar_stream.joint_names import counterparts, read_joint_names
from mossar_stream.moves.joints import details
from mossar_stream.moves.limbs import limbs_of
from mossar_stream.steps.feet import feet_of

# One body under the names of many programs, in this order; `{}` is the side as the program writes it.
CENTRE = ("hips", "spine", "chest", "neck", "head")
SIDED = ("collar", "shoulder", "elbow", "wrist", "hip", "knee", "ankle", "foot")
FAMILIES = {
    "unreal": (
        "pelvis spine_01 spine_03 neck_01 head",
        "clavicle_{} upperarm_{} lowerarm_{} hand_{} thigh_{} calf_{} foot_{} ball_{}",
        "l r",
    ),
    "rigify": (
        "DEF-spine DEF-spine.001 DEF-spine.003 DEF-spine.004 DEF-spine.006",
        "DEF-shoulder.{} DEF-upper_arm.{} DEF-forearm.{} DEF-hand.{} DEF-thigh.{} DEF-shin.{} DEF-foot.{} DEF-toe.{}",
        "L R",
    ),
    "vroid": (
        "J_Bip_C_Hips J_Bip_C_Spine J_Bip_C_UpperChest J_Bip_C_Neck J_Bip_C_Head",
        (
            "J_Bip_{0}_Shoulder J_Bip_{0}_UpperArm J_Bip_{0}_LowerArm J_Bip_{0}_Hand J_Bip_{0}_UpperLeg J_Bip_{0}_LowerLeg "
            "J_Bip_{0}_Foot J_Bip_{0}_ToeBase"
        ),
        "L R",
    ),
    "daz": (
        "pelvis abdomenLower chestUpper neckLower head",
        "{}Collar {}ShldrBend {}ForearmBend {}Hand {}ThighBend {}Shin {}Foot {}Toe",
        "l r",
    ),
    "poser": (
        "hip abdomen chest neck head",
        "{}Collar {}Shldr {}ForeArm {}Hand {}Thigh {}Shin {}Foot {}Toe",
        "l r",
    ),
    "deepmotion": (
        "hips_JNT spine_JNT spine2_JNT neck_JNT head_JNT",
        "{}_shoulder_JNT {}_arm_JNT {}_forearm_JNT {}_hand_JNT {}_upleg_JNT {}_leg_JNT {}_foot_JNT {}_toebase_JNT",
        "l r",
    ),
    "mmd": (
        "下半身 上半身 上半身2 首 頭",
        "{}肩 {}腕 {}ひじ {}手首 {}足 {}ひざ {}足首 {}つま先",
        "左 右",
    ),
    "mmd in English": (
        "lower_body upper_body upper_body2 neck head",
        "shoulder_{} arm_{} elbow_{} wrist_{} leg_{} knee_{} ankle_{} toe_{}",
        "L R",
    ),
    "smpl": (
        "Pelvis Spine1 Spine3 Neck Head",
        "{}_Collar {}_Shoulder {}_Elbow {}_Wrist {}_Hip {}_Knee {}_Ankle {}_Foot",
        "L R",
    ),
    "xsens": (
        "Pelvis L5 T8 Neck Head",
        "{}Shoulder {}UpperArm {}ForeArm {}Hand {}UpperLeg {}LowerLeg {}Foot {}Toe",
        "Left Right",
    ),
    "azure": (
        "PELVIS SPINE_NAVEL SPINE_CHEST NECK HEAD",
        "CLAVICLE_{} SHOULDER_{} ELBOW_{} WRIST_{} HIP_{} KNEE_{} ANKLE_{} FOOT_{}",
        "LEFT RIGHT",
    ),
    "character creator": (
        "CC_Base_Pelvis CC_Base_Spine01 CC_Base_Spine02 CC_Base_Neck CC_Base_Head",
        (
            "CC_Base_{0}_Clavicle CC_Base_{0}_Upperarm CC_Base_{0}_Forearm CC_Base_{0}_Hand CC_Base_{0}_Thigh CC_Base_{0}_Calf "
            "CC_Base_{0}_Foot CC_Base_{0}_ToeBase"
        ),
        "L R",
    ),
    "old BVH": (
        "Hips Spine Chest Neck Head",
        "{}Collar {}UpArm {}LowArm {}Hand {}UpLeg {}LowLeg {}Foot {}Toe",
        "Left Right",
    ),
    "Advanced Skeleton": (
        "Root_M Spine1_M Spine3_M Neck_M Head_M",
        "Scapula_{} Shoulder_{} Elbow_{} Wrist_{} Hip_{} Knee_{} Ankle_{} Toes_{}",
        "L R",
    ),
    "Auto-Rig Pro": (
        "root.x spine_01.x spine_03.x neck.x head.x",
        "shoulder.{} arm_stretch.{} forearm_stretch.{} hand.{} thigh_stretch.{} leg_stretch.{} foot.{} toes_01.{}",
        "l r",
    ),
    "mocopi": (
        "root torso_1 torso_7 neck_1 head",
        "{}_shoulder {}_up_arm {}_low_arm {}_hand {}_up_leg {}_low_leg {}_foot {}_toes",
        "l r",
    ),
    "ARKit": (
        "hips_joint spine_1_joint spine_7_joint neck_1_joint head_joint",
        (
            "{}_shoulder_1_joint {}_arm_joint {}_forearm_joint {}_hand_joint {}_upLeg_joint {}_leg_joint {}_foot_joint "
            "{}_toes_joint"
        ),
        "left right",
    ),
    "Motive": (
        "Hip Ab Chest Neck Head",
        "{}Shoulder {}UArm {}FArm {}Hand {}Thigh {}Shin {}Foot {}Toe",
        "L R",
    ),
    "iPi": (
        "Hip LowerSpine Chest Neck Head",
        "{}Clavicle {}Shoulder {}Forearm {}Hand {}Thigh {}Shin {}Foot {}Toe",
        "L R",
    ),
    "a character": (
        "Actor1_Hips Actor1_Spine Actor1_Spine2 Actor1_Neck Actor1_Head",
        (
            "Actor1_{0}Shoulder Actor1_{0}Arm Actor1_{0}ForeArm Actor1_{0}Hand Actor1_{0}UpLeg Actor1_{0}Leg Actor1_{0}Foot "
            "Actor1_{0}ToeBase"
        ),
        "Left Right",
    ),
}
BIPED = (
    *(f"Bip01 {name}" for name in ("Pelvis", "Spine", "Spine1", "Neck", "Head")),
    *(
        f"Bip01 {side} {part}"
        for side in "LR"
        for part in ("Clavicle", "UpperArm", "Forearm", "Hand", "Thigh", "Calf", "Foot", "Toe0")
    ),
)
SLOTS = [*CENTRE, *(f"{side}_{part}" for side in ("left", "right") for part in SIDED)]


def names_of(centre, sided, sides):
    return [*centre.split(), *(name.format(side) for side in sides.split() for name in sided.split())]


ALL = {family: names_of(*table) for family, table in FAMILIES.items()} | {"biped": list(BIPED)}
if "rigify" in ALL:  # its spine is known by its numbers, of which there are more
    ALL["rigify"] += ["DEF-spine.002", "DEF-spine.005"]


@pytest.mark.parametrize("family", ALL)
def test_every_joint_of_a_family_is_known(family):
    names = ALL[family]
    assert {slot: names[joint] for slot, joint in find_joints(names).items()} == dict(
        zip(SLOTS, names, strict=False)
    )


@pytest.mark.parametrize("family", ALL)
def test_limbs_feet_and_sides_follow(family):
    names = ALL[family]
    skeleton = Skeleton(tuple(names))
    assert list(limbs_of(skeleton)) == ["trunk", "left_arm", "right_arm", "left_leg", "right_leg"]
    left, right = (names.index(names[SLOTS.index(f"{side}_ankle")]) for side in ("left", "right"))
    assert (left in feet_of(skeleton)["left"], right in feet_of(skeleton)["right"]) == (True, True)
    others = counterparts(names)
    assert [others[others[joint]] for joint in range(len(names))] == list(range(len(names)))
    assert others[left] == right
    assert others[0] == 0


@pytest.mark.parametrize(
    ("names", "spine", "chest"),
    [
        ("Hips Spine Spine1 Spine2 Spine3", "Spine", "Spine3"),  # Perception Neuron
        ("Hips Spine1 Spine2 Spine3 Spine4", "Spine1", "Spine4"),  # Rokoko, Captury
        ("Hips LowerBack Spine Spine1", "Spine", "Spine1"),
        ("Hips Spine Spine1 Chest", "Spine", "Chest"),
        ("pelvis spine_01 spine_02 spine_03 spine_04 spine_05", "spine_01", "spine_05"),
        ("root torso_1 torso_2 torso_3 torso_4", "torso_1", "torso_4"),
    ],
)
def test_the_chest_is_the_highest_of_numbered_joints(names, spine, chest):
    found = find_joints(names.split())
    assert (names.split()[found["spine"]], names.split()[found["chest"]]) == (spine, chest)


def test_the_waist_is_the_hips_of_a_sensor_without_them():
    assert find_joints(["JOINT_WAIST", "JOINT_TORSO", "JOINT_NECK", "JOINT_HEAD"])["hips"] == 0
    assert find_joints(["HIP", "WAIST", "CHEST", "HEAD"])["hips"] == 0


def test_sides_that_stand_in_the_first_letter_are_exchanged_with_each_other():
    names = ["lowerback", "lfemur", "rfemur", "lthumb", "rthumb", "LUArm", "RUArm"]
    assert counterparts(names) == [0, 2, 1, 4, 3, 6, 5]


def test_helpers_are_no_joints_of_the_body():
    names = [
        "upperarm_twist_01_l",
        "ik_foot_l",
        "左足ＩＫ",
        "左腕捩",
        "左足D",
        "LeftArmRoll",
        "Head_End",
        "HeadNub",
        "index_01_l",
    ]
    assert find_joints(names) == {}


def test_of_a_bone_in_parts_the_first_is_meant():
    assert find_joints(["DEF-thigh.L.001", "DEF-thigh.L"]) == {"left_hip": 1}
    assert find_joints(["neck_02", "neck_01"]) == {"neck": 1}


def test_markers_on_the_spine_are_none_of_its_bones():
    assert find_joints(["C7", "T8", "T10", "L5", "LFHD"]) == {}
    assert find_joints(["Pelvis", "L5", "T8"]) == {"hips": 0, "spine": 1, "chest": 2}


def test_words_end_where_names_change():
    assert words_of("ns:DEF-upper_arm.L.001") == ("def", "upper", "arm", "l", "001")
    assert words_of("LEFT_UPPER_ARM") == ("left", "upper", "arm")
    assert [name.side for name in read_joint_names(["lfemur", "shoulderleft", "handL", "hand", "ルート"])] == [
        "left", "left", "left", "", ""
    ]  # fmt: skip


def test_a_joint_without_another_side_has_no_counterpart():
    assert counterparts(["hips", "thumb_l", "LeftEye", "RightEye"]) == [0, -1, 3, 2]


def test_fingers_of_other_scripts_are_details():
    names = [*ALL["mmd"], "左親指１", "左人指１"]
    assert details(Skeleton(tuple(names))) == 0b11 << len(ALL["mmd"])


def test_the_trunk_is_ordered_from_below():
    names = ["chestUpper", "Neck", "abdomenLower", "chestLower", "pelvis", "abdomenUpper"]
    assert [names[joint] for joint in trunk_joints(names)] == [
        "abdomenLower",
        "abdomenUpper",
        "chestLower",
        "chestUpper",
    ]
