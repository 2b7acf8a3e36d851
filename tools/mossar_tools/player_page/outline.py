"""Outline: which joints and bones of a skeleton the page draws, and which it names.

Skeletons of the usual conventions are drawn as one body: trunk, head, arms and legs, without faces and fingers. Others are
drawn bone by bone.
"""

from functools import lru_cache
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton, joint_places

_SIDES: Final = ("left", "right")
_LIMB: Final = (
    ("shoulder", "elbow"),
    ("elbow", "wrist"),
    ("wrist", "hand"),
    ("hip", "knee"),
    ("knee", "ankle"),
    ("ankle", "foot"),
)
_TRUNK: Final = (("hips", "chest"), ("chest", "head"))
_CORNERS: Final = ("left_shoulder", "right_shoulder", "right_hip", "left_hip")
# Names of the ends of bones for people; bones that end elsewhere have more noise than information.
_BACK: Final = "back"
_PARTS: Final = {"elbow": "elbow", "wrist": "hand", "knee": "knee", "ankle": "foot", "chest": _BACK}


class Outline(msgspec.Struct, frozen=True):
    """The drawing of a skeleton of J joints.

    Args:
        places: Two joints for each of the n points; a point lies in the middle of its two.
        bones: Pairs of points.
        parts: Name of the end of each bone; may be empty.
        trunk: Points around the trunk; none for skeletons that are not known.
        head: Point of the head, -1 if there is none.
        joints: Names of the points, by which outlines of two skeletons are compared.
    """

    places: tuple[tuple[int, int], ...]
    bones: tuple[tuple[int, int], ...]
    parts: tuple[str, ...]
    trunk: tuple[int, ...]
    head: int
    joints: tuple[str, ...]

    def points(self, positions: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the points of a pose, (n, D), from its (J, D) positions."""
        pairs = np.array(self.places, np.intp).reshape(-1, 2)
        return np.asarray(positions[pairs].mean(axis=1), np.float32)

    def strays(
        self, body: NDArray[np.float32], example: NDArray[np.float32], other: "Outline"
    ) -> NDArray[np.float32]:
        """Return the angle between each bone and the example's, degrees; NaN where there is nothing to compare.

        Args:
            body: (J, 3) m.
            example: (K, 3) m, the pose to compare with.
            other: Outline of the example's skeleton.
        """
        known = {name: point for point, name in enumerate(other.joints)}
        ours, theirs = self.points(body), np.vstack((other.points(example), np.full((1, 3), np.nan)))
        mine = np.array(self.bones, np.intp).reshape(-1, 2)
        its = np.array([[known.get(self.joints[end], -1) for end in bone] for bone in self.bones], np.intp)
        one, two = (
            ours[mine[:, 1]] - ours[mine[:, 0]],
            np.diff(theirs[its.reshape(-1, 2)], axis=1)[:, 0],
        )
        lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            cosines = (one * two).sum(axis=1) / lengths
        return np.asarray(np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0))), np.float32)

    def drawn(self) -> dict[str, object]:
        """Return the data with which the page draws it; `back` is the bone within the trunk."""
        back = self.parts.index(_BACK) if _BACK in self.parts else -1
        return {"bones": self.bones, "trunk": self.trunk, "head": self.head, "back": back}


@lru_cache(maxsize=64)
def outline_of(skeleton: Skeleton) -> Outline:
    """Return the drawing of a skeleton."""
    places = joint_places(skeleton)
    if not all(corner in places for corner in _CORNERS):
        own = tuple((joint, joint) for joint in range(len(skeleton)))
        bones = tuple((a, b) for a, b in skeleton.bones())
        return Outline(own, bones, ("",) * len(bones), (), -1, skeleton.names)
    names = tuple(places)
    number = {name: point for point, name in enumerate(names)}
    wanted = [
        *_TRUNK,
        *((f"{side}_{start}", f"{side}_{end}") for side in _SIDES for start, end in _LIMB),
    ]
    wanted = [pair for pair in wanted if _differ(places, pair)]
    return Outline(
        tuple(places[name] for name in names),
        tuple((number[start], number[end]) for start, end in wanted),
        tuple(_part(end) for _, end in wanted),
        tuple(number[corner] for corner in _CORNERS),
        number.get("head", -1),
        names,
    )


def _differ(places: dict[str, tuple[int, int]], pair: tuple[str, str]) -> bool:
    """Return whether both ends of a bone are there, at different joints."""
    return all(name in places for name in pair) and places[pair[0]] != places[pair[1]]


def _part(joint: str) -> str:
    """Return the readable name of the end of a bone, as "left knee"."""
    side, _, part = joint.rpartition("_")
    word = _PARTS.get(part, "")
    return f"{side} {word}".strip() if word else ""
