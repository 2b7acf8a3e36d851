"""Groups: the joints of each limb, and the joint that it hangs on."""

import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.errors import FrameError
from mossar_stream.joint_names import REMEMBERED
from mossar_stream.moves.joints import MEAN, known_joints
from mossar_stream.moves.limbs import limbs_of
from mossar_stream.settings.limb_groups import parse_groups
from mossar_stream.skeleton import Skeleton

_ANCHORS = ("left_shoulder", "right_shoulder", "left_hip", "right_hip")


class Limb(NamedTuple):
    """A limb of a skeleton.

    Args:
        name: The channel of its events.
        joints: Of the performer; first the one that it hangs on (or `MEAN`).
        skeleton: The same joints as a skeleton of their own, rooted in the first one.
    """

    name: str
    joints: tuple[int, ...]
    skeleton: Skeleton


def groups_of(skeleton: Skeleton, wanted: bool | str) -> list[Limb]:
    """Return the limbs of a skeleton.

    Args:
        skeleton: Of the performer.
        wanted: As `Settings.limbs`: True for those known by the joints' names, or else by the hierarchy; a text for
            those that it names; False for none.

    Raises:
        FrameError: If the skeleton lacks a joint that the text names, or nothing of a limb can move.
    """
    return list(_groups(skeleton, wanted)) if wanted else []


@functools.lru_cache(REMEMBERED)  # a performer's are needed several times before its first frame
def _groups(skeleton: Skeleton, wanted: bool | str) -> tuple[Limb, ...]:
    if wanted is True:
        found = (_limb(skeleton, name, joints) for name, joints in limbs_of(skeleton).items())
        return tuple(limb for limb in found if _can_move(limb, skeleton))
    limbs = []
    for name, members in parse_groups(str(wanted)).items():
        limb = _limb(skeleton, name, tuple(sorted({_index(skeleton, name, joint) for joint in members})))
        if not _can_move(limb, skeleton):
            raise FrameError(f"limb {name}: {members[0]!r} hangs on nothing that it could move against")
        limbs.append(limb)
    return tuple(limbs)


def _can_move(limb: Limb, skeleton: Skeleton) -> bool:
    """Return whether a joint of a limb can move against the limb's root; a single joint is its own mean."""
    return len(limb.joints) > 1 and len(skeleton) > 1


def _index(skeleton: Skeleton, limb: str, joint: str) -> int:
    try:
        return skeleton.index(joint)
    except FrameError as error:
        raise FrameError(f"limb {limb}: {error}") from None


def _limb(skeleton: Skeleton, name: str, members: tuple[int, ...]) -> Limb:
    anchor = _hangs_on(skeleton, members)
    rest = tuple(joint for joint in members if joint != anchor)
    own = [MEAN, *rest] if anchor == MEAN else [anchor, *rest]
    place = {joint: k for k, joint in enumerate(own)}
    parents = [-1]
    for joint in rest:
        ancestor = skeleton.parents[joint]
        while ancestor not in place and ancestor >= 0:
            ancestor = skeleton.parents[ancestor]
        parents.append(place.get(ancestor, 0))
    center = "center"
    while center in skeleton.names:
        center += "_"
    names = tuple(center if joint == MEAN else skeleton.names[joint] for joint in own)
    return Limb(name, tuple(own), Skeleton(names, tuple(parents), 0))


def _hangs_on(skeleton: Skeleton, members: tuple[int, ...]) -> int:
    """Return the joint that a limb hangs on: the body's centre, a shoulder or a hip in it, else the joint above its top."""
    if skeleton.root in members:
        return skeleton.root
    known = known_joints(skeleton)
    anchors = [known[slot] for slot in _ANCHORS if known.get(slot) in members]
    if len(anchors) == 1:
        return anchors[0]
    tops = [skeleton.parents[joint] for joint in members if skeleton.parents[joint] not in members]
    return tops[0] if tops[0] >= 0 else skeleton.root


def positions_of(
    limb: Limb, frames: NDArray[np.float32], middles: NDArray[np.float32] | None = None
) -> NDArray[np.float32]:
    """Return the joints of a limb.

    Args:
        limb: The limb.
        frames: (n, J, 3) m, of the performer.
        middles: (n, 3) m, the mean of the performer's joints in each frame, for a limb that hangs on it.

    Returns:
        (n, K, 3) m, contiguous.
    """
    found = frames[:, list(limb.joints)]
    if limb.joints[0] == MEAN:
        found[:, 0] = middles
    return found


def limbs_by_joint(limbs: Sequence[Limb]) -> dict[str, str]:
    """Return the limb of each joint's name; the joint that a limb hangs on belongs to none."""
    return {name: limb.name for limb in limbs for name in limb.skeleton.names[1:]}


def leading_limb(active_joints: Sequence[str], by_joint: dict[str, str]) -> str | None:
    """Return the limb that most of a segment's active joints belong to, the first ones counting most.

    Args:
        active_joints: Names, the longest path first.
        by_joint: See `limbs_by_joint`.

    Example:
        >>> leading_limb(["hand", "foot", "elbow"], {"hand": "arm", "elbow": "arm", "foot": "leg"})
        'arm'
    """
    votes: dict[str, float] = {}
    for place, joint in enumerate(active_joints, 1):
        if joint in by_joint:
            votes[by_joint[joint]] = votes.get(by_joint[joint], 0.0) + 1.0 / place
    return max(votes, key=votes.__getitem__) if votes else None
