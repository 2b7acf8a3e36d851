"""Joints by name: the same joint of another joint set, so that examples of one serve streams of another.

A joint that a set lacks may lie in the middle of two that it has, as the centre of the hips does in pose estimators.
Joints that matter little to a move (spine, neck, hands beside wrists, feet beside ankles) may be missing; others may not.
"""

import re
from typing import NamedTuple

from mossar_stream.errors import FrameError
from mossar_stream.joint_names import SIDES, find_joints, plain_name, words_of
from mossar_stream.skeleton import Skeleton

_MIDDLES = {"hips": ("left_hip", "right_hip"), "chest": ("left_shoulder", "right_shoulder")}
_OPTIONAL = frozenset(
    {"spine", "chest", "neck", "left_hand", "right_hand", "left_foot", "right_foot"},
)
_SLOTS = frozenset(
    ["hips", "spine", "chest", "neck", "head"]
    + [
        f"{side}_{part}"
        for side in SIDES
        for part in ["shoulder", "elbow", "wrist", "hand", "hip", "knee", "ankle", "foot"]
    ]
)
ENOUGH_NAMES = 8  # joints known by name: then the others are details, too
CENTRE = "hips"
MEAN = -1  # in place of a joint: the mean of all


# Pose estimators have many joints in faces and hands, with more noise than information: the wrist stands for its fingers.
_DETAIL = re.compile(
    r".*(pinky|thumb|finger|handtip|index).*|(left|right|l|r)?(eye|ear|mouth|nose)(inner|outer|left|right)?"
)


def details(skeleton: Skeleton) -> int:
    """Return a bit for each of the first 64 joints of a skeleton that is part of a face or of the fingers.

    None if fewer than `ENOUGH_NAMES` joints would be left, as of a glove.

    Example:
        >>> details(Skeleton(("left_wrist", "left_pinky")))
        0
    """
    texts = [name.lower() if name.isascii() else "".join(words_of(name)) for name in skeleton.names]
    plain = [re.sub("[^a-z]", "", text) for text in texts]
    found = [j for j, name in enumerate(plain) if _DETAIL.fullmatch(name) and "foot" not in name]
    if len(plain) - len(found) < ENOUGH_NAMES:
        return 0
    return sum(1 << j for j in found if j < 64)


class Pair(NamedTuple):
    """One joint of a template: the middle of two joints of a skeleton, mostly twice the same."""

    one: int
    other: int


def known_joints(skeleton: Skeleton) -> dict[str, int]:
    """Return the joints of a skeleton that are known by name: slots such as "left_wrist" to indices."""
    return {slot: joint for slot, joint in find_joints(skeleton.names).items() if slot in _SLOTS}


def joint_places(skeleton: Skeleton) -> dict[str, tuple[int, int]]:
    """Return the places of the joints that are known by name, in any joint set.

    Args:
        skeleton: With names of any of the usual conventions.

    Returns:
        Two joints for each of `hips`, `spine`, `chest`, `neck`, `head` and, with "left" or "right" before them, `shoulder`, `elbow`,
        `wrist`, `hand`, `hip`, `knee`, `ankle`, `foot` that is found: it lies in the middle of the two, which are mostly
        the same.

    Example:
        >>> joint_places(Skeleton(("left_hip", "right_hip", "nose"), root=-1))["hips"]
        (0, 1)
    """
    known = known_joints(skeleton)
    places = {slot: (joint, joint) for slot, joint in known.items()}
    for slot, (left, right) in _MIDDLES.items():
        if slot not in places and left in known and right in known:
            places[slot] = known[left], known[right]
    return places


def shared_joints(shown: Skeleton, streamed: Skeleton) -> tuple[list[str], list[Pair], list[Pair]]:
    """Return the joints by which examples of one skeleton are recognised in a stream of another, the centre first.

    Args:
        shown: Skeleton of the examples.
        streamed: Skeleton of the stream.

    Returns:
        Names (slots for known joints), and where to find them in each of the two.

    Raises:
        FrameError: If the stream lacks joints that examples need; it names them.
    """
    ours, theirs = _places(shown), _places(streamed)
    known = len(known_joints(shown)) >= ENOUGH_NAMES
    names, missing = [], []
    for name in _wanted(shown):
        if name in theirs:
            names.append(name)
        elif not (known and (name in _OPTIONAL or name not in _SLOTS)):
            missing.append(name)
    if missing:
        shown_names = [name if name.isprintable() else ascii(name) for name in missing[:20]]
        raise FrameError(f"the moves need joints that the stream does not have: {', '.join(shown_names)}")
    centre = CENTRE if CENTRE in ours and CENTRE in theirs else ""
    names = [centre, *(name for name in names if name != centre)]
    return (
        names,
        [_place(ours, shown, name) for name in names],
        [_place(theirs, streamed, name) for name in names],
    )


def _wanted(skeleton: Skeleton) -> list[str]:
    """Return the names of a skeleton's own joints: slots of known ones, plain names of others."""
    slots = {joint: slot for slot, joint in known_joints(skeleton).items()}
    return [slots.get(joint, _plain(name)) for joint, name in enumerate(skeleton.names)]


def _places(skeleton: Skeleton) -> dict[str, Pair]:
    places = {name: Pair(joint, joint) for joint, name in reversed(list(enumerate(_wanted(skeleton))))}
    return places | {slot: Pair(*pair) for slot, pair in joint_places(skeleton).items()}


def _place(places: dict[str, Pair], skeleton: Skeleton, name: str) -> Pair:
    if name:
        return places[name]
    return Pair(skeleton.root, skeleton.root) if skeleton.root >= 0 else Pair(MEAN, MEAN)


def _plain(name: str) -> str:
    return plain_name(name) or name.lower()
