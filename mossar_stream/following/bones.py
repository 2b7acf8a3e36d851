"""Bones: the directions from joint to joint that an example and a stream have in common.

Directions know no lengths, so bodies of other sizes compare; relative to the facing of the hips they know no place
and no heading.
"""

from typing import NamedTuple

from mossar_stream.moves.joints import Pair, shared_joints
from mossar_stream.moves.limbs import limbs_of
from mossar_stream.skeleton import Skeleton

NOWHERE = -1


class Bone(NamedTuple):
    """A bone between two points."""

    begin: int
    end: int
    limb: int  # index into `Bones.limbs`, -1 for none


class Bones(NamedTuple):
    """The bones in which an example and a stream are compared."""

    shown: list[Pair]  # where each point is in the example's skeleton, the centre first
    streamed: list[Pair]  # and in the stream's
    bones: list[Bone]
    limbs: tuple[str, ...]  # that have bones
    # Points of hips and shoulders, left first; -1 for a pair that is not known.
    girdles: tuple[int, int, int, int]


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
    pairs = []
    for k in range(1, len(ours)):
        begin = parents[k]
        if begin == NOWHERE and k not in with_children:
            begin = 0
        if begin not in (NOWHERE, k):
            pairs.append((begin, k))
    limb_of = {joint: name for name, joints in limbs_of(streamed).items() for joint in joints}
    owners = [limb_of.get(theirs[end].one) for _, end in pairs]
    limbs = tuple(name for name in limbs_of(streamed) if name in owners)
    bones = [
        Bone(begin, end, NOWHERE if owner is None else limbs.index(owner))
        for (begin, end), owner in zip(pairs, owners, strict=True)
    ]
    girdles = *_pair("hip", names), *_pair("shoulder", names)
    return Bones(ours, theirs, bones, limbs, girdles)


def _pair(slot: str, names: list[str]) -> tuple[int, int]:
    sides = f"left_{slot}", f"right_{slot}"
    return (names.index(sides[0]), names.index(sides[1])) if set(sides) <= set(names) else (NOWHERE, NOWHERE)


def _parent(skeleton: Skeleton, pair: Pair, point: dict[int, int]) -> int:
    """Return the point of a joint's next ancestor that is a point, -1 if there is none."""
    if pair.one != pair.other or pair.one < 0:
        return NOWHERE
    joint = skeleton.parents[pair.one]
    while joint >= 0 and joint not in point:
        joint = skeleton.parents[joint]
    return point[joint] if joint >= 0 else NOWHERE
