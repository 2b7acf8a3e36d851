"""The humanoid bones of VMC: hierarchy, a rest skeleton, and their names in other programs.

A bone stands at its joint and turns all joints below it. Positions are right-handed: +y up, +z forward, left is +x.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.kinematics import JointMotion, rest_positions
from mossar_adapters.joint_sets import ACCLAIM_BEGINS, ACCLAIM_ENDS, HUMANOID
from mossar_stream import (
    JointName,
    Skeleton,
    find_joints,
    joint_places,
    plain_name,
    read_joint_names,
    trunk_joints,
)

# Metres from the parent, of a person 1.7 m tall in T-pose; the right side mirrors the left.
_REST = {
    "Hips": (0.0, 0.94, 0.0),
    "Spine": (0.0, 0.08, 0.0),
    "Chest": (0.0, 0.12, 0.0),
    "UpperChest": (0.0, 0.12, 0.0),
    "Neck": (0.0, 0.15, 0.0),
    "Head": (0.0, 0.09, 0.0),
    "LeftShoulder": (0.03, 0.11, 0.0),
    "LeftUpperArm": (0.12, 0.0, 0.0),
    "LeftLowerArm": (0.27, 0.0, 0.0),
    "LeftHand": (0.25, 0.0, 0.0),
    "LeftUpperLeg": (0.09, -0.03, 0.0),
    "LeftLowerLeg": (0.0, -0.41, 0.0),
    "LeftFoot": (0.0, -0.42, 0.0),
    "LeftToes": (0.0, -0.06, 0.13),
}

MIN_BONES = 6
_CENTRE = ("Hips", "Spine", "Chest", "UpperChest", "Neck", "Head")
_SIDE = ("Shoulder", "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toes")
# That are the uppermost of a trunk of two.
_UPPER = frozenset(["upperchest", "chestupper", "spineshoulder", "thorax"])
_LOWER = "lowerback"  # no bone of its own where others are above it
_TRUNK = ("Spine", "Chest", "UpperChest")
_NUMBERED = (("spine", "spine1", "spine2"), ("chest", "chest2", "chest3"))  # each is the next bone
# Joints of bones in the table of names.
_JOINTS = {
    "Shoulder": "collar",
    "UpperArm": "shoulder",
    "LowerArm": "elbow",
    "Hand": "wrist",
    "UpperLeg": "hip",
    "LowerLeg": "knee",
    "Foot": "ankle",
    "Toes": "foot",
}
_SLOTS = {
    "Hips": "hips",
    "Spine": "spine",
    "UpperChest": "chest",
    "Neck": "neck",
    "Head": "head",
    **{
        side + bone: f"{side.lower()}_{_JOINTS[bone]}"
        for side in ("Left", "Right")
        for bone in _SIDE
        if bone != "Shoulder"
    },
}


def bone_name(name: str) -> str | None:
    """Return the humanoid bone of a VMC name, None for fingers, eyes, jaw and others."""
    return _BONES.get(name.lower())


def present_parents(bones: Sequence[str]) -> tuple[int, ...]:
    """Return for each bone the index of its nearest ancestor among them, -1 without."""
    place = {bone: i for i, bone in enumerate(bones)}
    parents = []
    for bone in bones:
        ancestor = HUMANOID.parents[HUMANOID.index(bone)]
        while ancestor >= 0 and HUMANOID.names[ancestor] not in place:
            ancestor = HUMANOID.parents[ancestor]
        parents.append(place[HUMANOID.names[ancestor]] if ancestor >= 0 else -1)
    return tuple(parents)


def rest_skeleton() -> dict[str, NDArray[np.float64]]:
    """Return the rest position of each bone of the built-in skeleton, (3,) metres."""
    offsets = np.array([_rest_offset(bone) for bone in HUMANOID.names])
    return dict(zip(HUMANOID.names, rest_positions(offsets, HUMANOID.parents)[0], strict=True))


def rest_of(motion: JointMotion) -> dict[str, NDArray[np.float64]]:
    """Return the rest positions of the bones that a recording's skeleton has."""
    places = rest_positions(motion.offsets, motion.parents)[0]
    return {bone: places[joint] for bone, joint in mapped_bones(motion.names, rotations=True).items()}


def mapped_bones(names: Sequence[str], *, rotations: bool) -> Mapping[str, int]:
    """Return the joint of each bone, by the names of joints.

    Args:
        names: Of the joints, in any spelling.
        rotations: Whether the joints are those of a file's rotations. Acclaim names bones: a joint of rotations is where the
            bone begins, a joint of positions where it ends.

    Returns:
        Index of the joint for each bone found, parents first; empty if fewer than `MIN_BONES` are found.
    """
    acclaim = _acclaim(ACCLAIM_BEGINS if rotations else ACCLAIM_ENDS, names)
    read = _read(names)
    found = acclaim if len(acclaim) > len(read) or _is_acclaim(names) else read
    return found if len(found) >= MIN_BONES and "Hips" in found else {}


def _read(names: Sequence[str]) -> dict[str, int]:
    """Return the bones that the one table of names knows."""
    found = find_joints(names)
    centre = {
        "Hips": found.get("hips", found.get("torso")),
        **_trunk(names, found),
        "Head": found.get("head"),
    }
    sided = {
        f"{side}{bone}": found.get(f"{side.lower()}_{_JOINTS[bone]}")
        for side in ("Left", "Right")
        for bone in _SIDE
    }
    read = read_joint_names(names)
    sided = {bone: joint for bone, joint in sided.items() if joint is None or read[joint].part != "hipjoint"}
    return {bone: joint for bone, joint in {**centre, **sided}.items() if joint is not None}


def _trunk(names: Sequence[str], found: Mapping[str, int]) -> dict[str, int | None]:
    """Return the bones between hips and head: three of the trunk at most, and the neck."""
    read, neck = read_joint_names(names), found.get("neck")
    named = {read[joint].part + read[joint].number: joint for joint in trunk_joints(names)}
    if neck is None and "chest" in found and read[found["chest"]].part.startswith("shouldercent"):
        neck = found["chest"]
    elif neck is not None and not _begins_neck(read[neck], named):
        neck = None
    for row in _NUMBERED:
        if row[0] in named and any(name[:-1] == row[0] and name[-1].isdigit() for name in named):
            return {
                **{bone: named.get(name) for bone, name in zip(_TRUNK, row, strict=True)},
                "Neck": neck,
            }
    if len(named) > 1:
        named.pop(_LOWER, None)
    upwards = list(named.items())
    if len(upwards) > 3:
        upwards = [upwards[0], upwards[len(upwards) // 2], upwards[-1]]
    last = upwards[-1][0] if upwards else ""
    bones = (
        _TRUNK if len(upwards) == 3 or not (last in _UPPER or last.endswith("3")) else ("Spine", "UpperChest")
    )
    return {**{bone: joint for bone, (_, joint) in zip(bones, upwards, strict=False)}, "Neck": neck}


def _begins_neck(name: JointName, trunk: Iterable[str]) -> bool:
    """Return whether a neck is the lowest joint of one, as the bone is: Neck1 is above Neck where there is Spine, too."""
    is_second = len(name.number) == 1 and bool({"spine", "chest"} & set(trunk))
    return name.part in ("neck", "necklower", "spine") and not is_second


def _is_acclaim(names: Sequence[str]) -> bool:
    return {"lfemur", "rfemur", "ltibia", "rtibia"} <= {plain_name(name) for name in names}


def placed_bones(skeleton: Skeleton) -> Mapping[str, tuple[int, int]]:
    """Return the joints of each bone in positions; hips and chest may lie between two joints.

    Returns:
        Two joints for each bone found, mostly twice the same: it stands in their middle. Parents first; empty if fewer than
        `MIN_BONES` are found.
    """
    places = joint_places(skeleton)
    bones = {bone: places[slot] for bone, slot in _SLOTS.items() if slot in places}
    found = {bone: (joint, joint) for bone, joint in mapped_bones(skeleton.names, rotations=False).items()}
    if found and not found.keys() & {"Spine", "Chest", "UpperChest"} and "UpperChest" in bones:
        found["UpperChest"] = bones["UpperChest"]  # between the shoulders, as of a body without a trunk
    if found:
        return {bone: found[bone] for bone in HUMANOID.names if bone in found}
    return bones if len(bones) >= MIN_BONES and "Hips" in bones else {}


def _acclaim(table: str, names: Sequence[str]) -> dict[str, int]:
    """Return the bones of a recording that names them as Acclaim does."""
    place = {plain_name(name): i for i, name in reversed(list(enumerate(names)))}
    words = table.split()
    centre, sided = words[: len(_CENTRE)], words[len(_CENTRE) :]
    found = {bone: place[word] for bone, word in zip(_CENTRE, centre, strict=True) if word in place}
    for side in ("Left", "Right"):
        for bone, word in zip(_SIDE, sided, strict=True):
            if (name := word.replace("#", side[0].lower())) in place:
                found[side + bone] = place[name]
    return found


def _rest_offset(bone: str) -> tuple[float, float, float]:
    if bone.startswith("Right"):
        x, y, z = _REST["Left" + bone.removeprefix("Right")]
        return -x, y, z
    return _REST[bone]


_BONES = {bone.lower(): bone for bone in HUMANOID.names}
