"""Joint sets that many programs use: names, parents, body centre.

Where a source gives names without a hierarchy, or only a number of joints, the hierarchy is looked up here. The core knows
joints of all these sets by name, too (`mossar_stream.joint_places`): which joint of one set is which of another.
Sets without a joint at the middle of the hips have the centroid as their centre (root -1).
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence

from mossar_stream import MAX_NAME, Skeleton, find_joints, plain_name, trunk_joints, words_of


def _skeleton(table: str, root: str | None) -> Skeleton:
    """Return the skeleton of a table of `joint<parent` words; a joint without parent stands alone."""
    pairs = [word.partition("<") for word in table.split()]
    names = tuple(name for name, _, _ in pairs)
    parents = tuple(names.index(parent) if parent else -1 for _, _, parent in pairs)
    return Skeleton(names, parents, -1 if root is None else names.index(root))


COCO_17 = _skeleton(
    "nose<left_shoulder left_eye<nose right_eye<nose left_ear<left_eye right_ear<right_eye"
    " left_shoulder<left_hip right_shoulder<right_hip left_elbow<left_shoulder right_elbow<right_shoulder"
    " left_wrist<left_elbow right_wrist<right_elbow left_hip right_hip<left_hip"
    " left_knee<left_hip right_knee<right_hip left_ankle<left_knee right_ankle<right_knee",
    root=None,
)
BLAZEPOSE_33 = _skeleton(
    "nose<left_shoulder left_eye_inner<nose left_eye<left_eye_inner left_eye_outer<left_eye"
    " right_eye_inner<nose right_eye<right_eye_inner right_eye_outer<right_eye"
    " left_ear<left_eye_outer right_ear<right_eye_outer mouth_left<nose mouth_right<nose"
    " left_shoulder<left_hip right_shoulder<right_hip left_elbow<left_shoulder right_elbow<right_shoulder"
    " left_wrist<left_elbow right_wrist<right_elbow left_pinky<left_wrist right_pinky<right_wrist"
    " left_index<left_wrist right_index<right_wrist left_thumb<left_wrist right_thumb<right_wrist"
    " left_hip right_hip<left_hip left_knee<left_hip right_knee<right_hip"
    " left_ankle<left_knee right_ankle<right_knee left_heel<left_ankle right_heel<right_ankle"
    " left_foot_index<left_heel right_foot_index<right_heel",
    root=None,
)
BODY_25 = _skeleton(
    "Nose<Neck Neck<MidHip RShoulder<Neck RElbow<RShoulder RWrist<RElbow"
    " LShoulder<Neck LElbow<LShoulder LWrist<LElbow MidHip RHip<MidHip RKnee<RHip RAnkle<RKnee"
    " LHip<MidHip LKnee<LHip LAnkle<LKnee REye<Nose LEye<Nose REar<REye LEar<LEye"
    " LBigToe<LAnkle LSmallToe<LBigToe LHeel<LAnkle RBigToe<RAnkle RSmallToe<RBigToe RHeel<RAnkle",
    root="MidHip",
)
BODY_18 = _skeleton(
    "Nose<Neck Neck RShoulder<Neck RElbow<RShoulder RWrist<RElbow"
    " LShoulder<Neck LElbow<LShoulder LWrist<LElbow RHip<Neck RKnee<RHip RAnkle<RKnee"
    " LHip<Neck LKnee<LHip LAnkle<LKnee REye<Nose LEye<Nose REar<REye LEar<LEye",
    root=None,
)
KINECT_20 = _skeleton(
    "HipCenter Spine<HipCenter ShoulderCenter<Spine Head<ShoulderCenter"
    " ShoulderLeft<ShoulderCenter ElbowLeft<ShoulderLeft WristLeft<ElbowLeft HandLeft<WristLeft"
    " ShoulderRight<ShoulderCenter ElbowRight<ShoulderRight WristRight<ElbowRight HandRight<WristRight"
    " HipLeft<HipCenter KneeLeft<HipLeft AnkleLeft<KneeLeft FootLeft<AnkleLeft"
    " HipRight<HipCenter KneeRight<HipRight AnkleRight<KneeRight FootRight<AnkleRight",
    root="HipCenter",
)
KINECT_25 = _skeleton(
    "SpineBase SpineMid<SpineBase Neck<SpineShoulder Head<Neck"
    " ShoulderLeft<SpineShoulder ElbowLeft<ShoulderLeft WristLeft<ElbowLeft HandLeft<WristLeft"
    " ShoulderRight<SpineShoulder ElbowRight<ShoulderRight WristRight<ElbowRight HandRight<WristRight"
    " HipLeft<SpineBase KneeLeft<HipLeft AnkleLeft<KneeLeft FootLeft<AnkleLeft"
    " HipRight<SpineBase KneeRight<HipRight AnkleRight<KneeRight FootRight<AnkleRight"
    " SpineShoulder<SpineMid HandTipLeft<HandLeft ThumbLeft<HandLeft"
    " HandTipRight<HandRight ThumbRight<HandRight",
    root="SpineBase",
)
NTU_25 = KINECT_25  # recorded with that sensor; same joints, same order
CMU_31 = _skeleton(
    "root lhipjoint<root lfemur<lhipjoint ltibia<lfemur lfoot<ltibia ltoes<lfoot"
    " rhipjoint<root rfemur<rhipjoint rtibia<rfemur rfoot<rtibia rtoes<rfoot"
    " lowerback<root upperback<lowerback thorax<upperback lowerneck<thorax upperneck<lowerneck"
    " head<upperneck lclavicle<thorax lhumerus<lclavicle lradius<lhumerus lwrist<lradius lhand<lwrist"
    " lfingers<lhand lthumb<lwrist rclavicle<thorax rhumerus<rclavicle rradius<rhumerus rwrist<rradius"
    " rhand<rwrist rfingers<rhand rthumb<rwrist",
    root="root",
)
HUMANOID = _skeleton(
    "Hips Spine<Hips Chest<Spine UpperChest<Chest Neck<UpperChest Head<Neck"
    " LeftShoulder<UpperChest LeftUpperArm<LeftShoulder LeftLowerArm<LeftUpperArm LeftHand<LeftLowerArm"
    " RightShoulder<UpperChest RightUpperArm<RightShoulder RightLowerArm<RightUpperArm"
    " RightHand<RightLowerArm LeftUpperLeg<Hips LeftLowerLeg<LeftUpperLeg LeftFoot<LeftLowerLeg"
    " LeftToes<LeftFoot RightUpperLeg<Hips RightLowerLeg<RightUpperLeg RightFoot<RightLowerLeg"
    " RightToes<RightFoot",
    root="Hips",
)
MIXAMO = _skeleton(
    "Hips Spine<Hips Spine1<Spine Spine2<Spine1 Neck<Spine2 Head<Neck"
    " LeftShoulder<Spine2 LeftArm<LeftShoulder LeftForeArm<LeftArm LeftHand<LeftForeArm"
    " RightShoulder<Spine2 RightArm<RightShoulder RightForeArm<RightArm RightHand<RightForeArm"
    " LeftUpLeg<Hips LeftLeg<LeftUpLeg LeftFoot<LeftLeg LeftToeBase<LeftFoot"
    " RightUpLeg<Hips RightLeg<RightUpLeg RightFoot<RightLeg RightToeBase<RightFoot",
    root="Hips",
)
MOTIVE = _skeleton(
    "Hip Ab<Hip Chest<Ab Neck<Chest Head<Neck LShoulder<Chest LUArm<LShoulder LFArm<LUArm LHand<LFArm"
    " RShoulder<Chest RUArm<RShoulder RFArm<RUArm RHand<RFArm LThigh<Hip LShin<LThigh LFoot<LShin LToe<LFoot"
    " RThigh<Hip RShin<RThigh RFoot<RShin RToe<RFoot",
    root="Hip",
)

JOINT_SETS: dict[str, Skeleton] = {
    "coco17": COCO_17,
    "blazepose33": BLAZEPOSE_33,
    "body18": BODY_18,
    "body25": BODY_25,
    "kinect20": KINECT_20,
    "kinect25": KINECT_25,
    "ntu25": NTU_25,
    "cmu31": CMU_31,
    "humanoid": HUMANOID,
    "mixamo": MIXAMO,
    "motive": MOTIVE,
}

# The bones of a humanoid as Acclaim names them: a joint of rotations is where the bone begins, a joint of positions where it
# ends. Order: Hips Spine Chest UpperChest Neck Head, then of one side Shoulder UpperArm LowerArm Hand UpperLeg LowerLeg Foot
# Toes; `-` where it has none.
ACCLAIM_BEGINS = "root lowerback upperback thorax lowerneck head #clavicle #humerus #radius #hand #femur #tibia #foot #toes"
ACCLAIM_ENDS = (
    "root - lowerback upperback thorax upperneck - #clavicle #humerus #radius #hipjoint #femur #tibia #foot"
)

ENOUGH_NAMES = 8  # joints known by name, from which on the others are details
_HAND_WORDS = frozenset(
    ["thumb", "finger", "fingers", "fingertip", "handtip", "index", "middle", "ring", "pinky"]
)
_HEAD_WORDS = frozenset(["eye", "ear", "jaw", "nose", "mouth"])
# Possible parents of a joint, the nearest first; `top` is the uppermost joint of the trunk.
_ABOVE = {
    "neck": "top hips torso",
    "head": "neck top hips torso",
    "collar": "top neck hips torso",
    "shoulder": "collar top neck hips torso",
    "elbow": "shoulder",
    "wrist": "elbow",
    "hand": "wrist elbow",
    "hip": "hips torso",
    "knee": "hip",
    "ankle": "knee",
    "foot": "ankle knee",
}


def with_known_parents(names: Sequence[str]) -> tuple[tuple[int, ...], int]:
    """Return parents and root for named joints.

    The joint set that shares most names is used, if that is at least two thirds of them; spelling of case
    and separators does not matter. Ends (`Head_End`) hang on the joint of their name. If reading each name alone places
    more joints than the set does, its result is used instead; other joints get no parent.

    Args:
        names: As the source spells them.

    Returns:
        One parent per joint (all -1 if no set fits), and the index of the root, -1 for the centroid.
    """
    plain = [plain_name(name) for name in names]
    inner = [name for name in plain if not name.endswith("end")]
    best = max(JOINT_SETS.values(), key=lambda known: len(_shared(inner, known)))
    if 3 * len(_shared(inner, best)) < 2 * len(inner) or not inner:
        return _parents_by_names(names, plain) or ((-1,) * len(plain), _centre(names, plain))
    known = [plain_name(name) for name in best.names]
    place = {name: i for i, name in reversed(list(enumerate(plain)))}
    parents = tuple(
        -1 if place[name] != i else place.get(_parent(name, known, best, place), -1)
        for i, name in enumerate(plain)
    )
    own = _parents_by_names(names, plain) if set(inner) - set(known) else None
    if own is not None and _placed(own[0]) > _placed(parents):
        return own
    return parents, place.get(known[best.root], -1) if best.root >= 0 else -1


def _placed(parents: Sequence[int]) -> int:
    return sum(parent >= 0 for parent in parents)


def _parents_by_names(names: Sequence[str], plain: Sequence[str]) -> tuple[tuple[int, ...], int] | None:
    """Return parents and root of joints that are known by name one by one; None if too few are."""
    found = find_joints(names)
    parents = dict(_hanging(names, found))
    for joint, name in enumerate(plain):
        if name.endswith("end") and joint not in parents and name.removesuffix("end") in plain:
            parents[joint] = plain.index(name.removesuffix("end"))
    if len(found) < ENOUGH_NAMES or 3 * len(parents) < 2 * len(names):
        return None
    root = found.get("hips", found.get("torso", -1))
    return tuple(parents.get(joint, -1) if joint != root else -1 for joint in range(len(names))), root


def _hanging(names: Sequence[str], found: Mapping[str, int]) -> Iterator[tuple[int, int]]:
    """Yield joints that are known by name, or are details of hands and heads, with their parents."""
    trunk = trunk_joints(names)
    root = found.get("hips", found.get("torso", -1))
    yield from _upwards(root, trunk)
    chest = found.get("chest", -1)
    top = chest if chest >= 0 and chest not in trunk else (trunk or [-1])[-1]
    if top not in trunk and top >= 0:
        yield top, (trunk or [root])[-1]
    for slot, joint in found.items():
        side, _, part = slot.rpartition("_")
        if part in _ABOVE:
            wanted = {"top": top, "hips": root, "torso": root, "neck": found.get("neck", -1)}
            own = (wanted.get(a, found.get(f"{side}_{a}" if side else a, -1)) for a in _ABOVE[part].split())
            yield joint, next((above for above in own if above not in (-1, joint)), -1)
        elif joint == root:
            yield joint, -1
    known = set(found.values())
    for joint, name in enumerate(names):
        words = set(words_of(name))
        if joint in known:
            continue
        side = "left" if words & {"left", "l"} else "right" if words & {"right", "r"} else ""
        if words & _HAND_WORDS and side:
            yield joint, found.get(f"{side}_hand", found.get(f"{side}_wrist", -1))
        elif words & _HEAD_WORDS:
            yield joint, found.get("head", -1)
        elif "waist" in words and joint != root:
            yield joint, root


def _upwards(root: int, trunk: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Yield each joint of a trunk, from below, with the one that it hangs on."""
    yield from ((joint, below) for below, joint in itertools.pairwise([root, *trunk]))


def _parent(name: str, known: Sequence[str], best: Skeleton, place: Mapping[str, int]) -> str:
    """Return the nearest ancestor of a joint that is present, empty if there is none."""
    if name not in known:
        return name.removesuffix("end") if name.endswith("end") else ""
    ancestor = best.parents[known.index(name)]
    while ancestor >= 0 and known[ancestor] not in place:
        ancestor = best.parents[ancestor]
    return known[ancestor] if ancestor >= 0 else ""


def openni_parents(names: Sequence[str]) -> tuple[tuple[int, ...], int]:
    """Return parents and root of joints with the names of OpenNI's sensors; of other names as `with_known_parents` does."""
    found = find_joints(names)
    if "torso" not in found or "hips" in found:
        return with_known_parents(names)
    parents = dict(_hanging(names, found))
    return tuple(parents.get(joint, -1) for joint in range(len(names))), found["torso"]


def by_count(count: int) -> Skeleton | None:
    """Return the set for unnamed poses of pose estimators, which differ in their number of joints."""
    return {17: COCO_17, 33: BLAZEPOSE_33, 25: BODY_25, 18: BODY_18}.get(count)


def _shared(plain: Sequence[str], known: Skeleton) -> set[str]:
    return set(plain) & {plain_name(name) for name in known.names}


def _centre(names: Sequence[str], plain: Sequence[str]) -> int:
    return find_joints(names).get("hips", plain.index("sacrum") if "sacrum" in plain else -1)


def printable_names(skeleton: Skeleton) -> Skeleton:
    r"""Return a skeleton without names that do something to a terminal: a character that is not printable becomes `_`.

    Names come from files and from the network, and are shown to people.

    Example:
        >>> printable_names(Skeleton(("hip", "\x1b[2Jhand", "_[2Jhand"))).names
        ('hip', '_[2Jhand_', '_[2Jhand')
    """
    if all(name.isprintable() for name in skeleton.names):
        return skeleton
    taken = {name for name in skeleton.names if name.isprintable()}
    names = []
    for name in skeleton.names:
        clean = name
        if not name.isprintable():
            clean = "".join(c if c.isprintable() else "_" for c in name)[: MAX_NAME - 8]
            while clean in taken:
                clean += "_"
            taken.add(clean)
        names.append(clean)
    return Skeleton(tuple(names), skeleton.parents, skeleton.root)
