"""The humanoid bones of VMC: hierarchy, a rest skeleton, and what other programs call them.

A bone stands at its joint and turns what hangs on it. Positions are right-handed: +y up, +z forward, left is +x.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.kinematics import JointMotion, rest_positions
from mossar_adapters.joint_sets import (
    ACCLAIM_BEGINS,
    ACCLAIM_ENDS,
    CONVENTIONS,
    HUMANOID,
    HUMANOID_CENTRE,
    HUMANOID_SIDE,
)
from mossar_stream import Skeleton, joint_places

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
_OF_A_SIDE = [
    "UpperArm",
    "shoulder",
    "LowerArm",
    "elbow",
    "Hand",
    "wrist",
    "UpperLeg",
    "hip",
    "LowerLeg",
    "knee",
    "Foot",
    "ankle",
    "Toes",
    "foot",
]
# What moves call the joints where bones stand.
_SLOTS = {
    "Hips": "hips",
    "Spine": "spine",
    "UpperChest": "chest",
    "Neck": "neck",
    "Head": "head",
    **{
        side + bone: f"{side.lower()}_{joint}"
        for side in ("Left", "Right")
        for bone, joint in zip(_OF_A_SIDE[::2], _OF_A_SIDE[1::2], strict=True)
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
    """Return where each bone of the built-in skeleton is at rest, (3,) metres."""
    offsets = np.array([_rest_offset(bone) for bone in HUMANOID.names])
    return dict(zip(HUMANOID.names, rest_positions(offsets, HUMANOID.parents)[0], strict=True))


def rest_of(motion: JointMotion) -> dict[str, NDArray[np.float64]]:
    """Return where the bones of a recording's skeleton are at rest; only those that it has."""
    places = rest_positions(motion.offsets, motion.parents)[0]
    return {bone: places[joint] for bone, joint in mapped_bones(motion.names, rotations=True).items()}


def mapped_bones(names: Sequence[str], *, rotations: bool) -> Mapping[str, int]:
    """Return which joint is which bone: the convention that explains most names.

    Args:
        names: Of the joints, in any spelling.
        rotations: Whether the joints are those of a file's rotations (matters for Acclaim).

    Returns:
        Index of the joint for each bone found, parents first; empty if fewer than `MIN_BONES` are found.
    """
    place = {_plain(name): i for i, name in reversed(list(enumerate(names)))}
    tables = (*CONVENTIONS, ACCLAIM_BEGINS if rotations else ACCLAIM_ENDS)
    found = max((_matches(table, place) for table in tables), key=len)
    return found if len(found) >= MIN_BONES and "Hips" in found else {}


def placed_bones(skeleton: Skeleton) -> Mapping[str, tuple[int, int]]:
    """Return which joints of positions are which bone, by a convention or, as moves do, joint by joint.

    Returns:
        Two joints for each bone found, mostly twice the same: it stands in their middle. Parents first; empty if fewer than
        `MIN_BONES` are found.
    """
    found = mapped_bones(skeleton.names, rotations=False)
    if found:
        return {bone: (joint, joint) for bone, joint in found.items()}
    places = joint_places(skeleton)
    bones = {bone: places[slot] for bone, slot in _SLOTS.items() if slot in places}
    return bones if len(bones) >= MIN_BONES and "Hips" in bones else {}


def _matches(table: str, place: Mapping[str, int]) -> dict[str, int]:
    words = table.split()
    found = {
        bone: place[word]
        for bone, word in zip(HUMANOID_CENTRE, words[: len(HUMANOID_CENTRE)], strict=True)
        if word in place
    }
    for side in ("Left", "Right"):
        for part, word in zip(HUMANOID_SIDE, words[len(HUMANOID_CENTRE) :], strict=True):
            name = word.replace("@", side.lower()).replace("#", side[0].lower())
            if name in place:
                found[side + part] = place[name]
    return found


def _plain(name: str) -> str:
    return "".join(c for c in name.lower().rpartition(":")[2] if c.isalnum())


def _rest_offset(bone: str) -> tuple[float, float, float]:
    if bone.startswith("Right"):
        x, y, z = _REST["Left" + bone.removeprefix("Right")]
        return -x, y, z
    return _REST[bone]


_BONES = {bone.lower(): bone for bone in HUMANOID.names}
