"""Bones: what an example and a stream have in common, as directions from joint to joint.

Directions know no lengths, so bodies of other sizes compare; relative to the facing of the hips they know no place
and no heading.
"""

from collections.abc import Sequence
from typing import NamedTuple

from mossar_stream.moves.joints import Pair, shared_joints
from mossar_stream.moves.limbs import limbs_of
from mossar_stream.skeleton import Skeleton

NOWHERE = -1


class Bone(NamedTuple):
    """A bone between two points."""

    begin: int
    end: int
    limb: int  # index into the keys of `limbs_of`, -1 for none


class Bones(NamedTuple):
    """What is compared of an example and a stream."""

    shown: list[Pair]  # where each point is in the example's skeleton, the centre first
    streamed: list[Pair]  # and in the stream's
    bones: list[Bone]
    left: int  # point of the left hip, -1 if the two are not known
    right: int


def shared_bones(shown: Skeleton, streamed: Skeleton) -> Bones:
    """Return the bones that two skeletons share.

    A bone leads from the next ancestor that both have to a joint. A joint without ancestors and without descendants hangs
    on the centre, so that skeletons without a hierarchy are followed, too.

    Args:
        shown: Skeleton of the examples.
        streamed: Skeleton of the stream.

    Raises:
        FrameError: If the stream lacks joints that the examples need, or nothing is left to compare.
    """
    names, ours, theirs = shared_joints(shown, streamed)
    point = {pair.one: k for k, pair in reversed(list(enumerate(ours))) if pair.one == pair.other}
    parents = [_parent(shown, pair, point) for pair in ours]
    with_children = set(parents)
    limbs = list(limbs_of(streamed).values())
    bones = []
    for k in range(1, len(ours)):
        begin = parents[k]
        if begin == NOWHERE and k not in with_children:
            begin = 0
        if begin not in (NOWHERE, k):
            limb = next((i for i, joints in enumerate(limbs) if theirs[k].one in joints), NOWHERE)
            bones.append(Bone(begin, k, limb))
    sides = [names.index(name) if name in names else NOWHERE for name in ("left_hip", "right_hip")]
    left, right = sides if NOWHERE not in sides else (NOWHERE, NOWHERE)
    return Bones(ours, theirs, bones, left, right)


def _parent(skeleton: Skeleton, pair: Pair, point: dict[int, int]) -> int:
    """Return the point of a joint's next ancestor that is a point, -1 if there is none."""
    if pair.one != pair.other or pair.one < 0:
        return NOWHERE
    joint = skeleton.parents[pair.one]
    while joint >= 0 and joint not in point:
        joint = skeleton.parents[joint]
    return point[joint] if joint >= 0 else NOWHERE


def names_of_limbs(streamed: Skeleton, bones: Sequence[Bone]) -> dict[int, str]:
    """Return the names of the limbs that have bones, by index."""
    used = {bone.limb for bone in bones}
    return {i: name for i, name in enumerate(limbs_of(streamed)) if i in used}
