"""The bank: shown poses as directions of bones, for the joints of one stream."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import RECORDS, mean_heading, pose_bank_bytes, pose_bank_parts
from mossar_stream.errors import MovesError
from mossar_stream.following.bank import directions_of, points_of
from mossar_stream.following.bones import NOWHERE, Bones, shared_bones
from mossar_stream.moves.parts import parts_of
from mossar_stream.moves.points import UPWARDS
from mossar_stream.moves.pose import Pose
from mossar_stream.moves.rules import Facing
from mossar_stream.settings import Up
from mossar_stream.skeleton import Skeleton

POSES_HEAD = RECORDS["PosesHead"]


def bones_of(shown: Skeleton, streamed: Skeleton) -> Bones:
    """Return the bones that two skeletons share, without those between a joint and itself, which have no direction."""
    bones = shared_bones(shown, streamed)
    places = bones.streamed
    return bones._replace(bones=[bone for bone in bones.bones if places[bone.begin] != places[bone.end]])


def make_bank(
    shown: Skeleton, poses: Sequence[Pose], streamed: Skeleton, facing: Facing, up: Up
) -> NDArray[np.uint8]:
    """Describe shown poses for a stream.

    Args:
        shown: Skeleton of the poses.
        poses: All of them; names are numbered in the order in which they first come.
        streamed: Skeleton of the stream.
        facing: Whether poses are recognised from any side.
        up: The axis that points upwards; `auto` is y.

    Returns:
        Bytes: `POSES_HEAD`, then points, bones, shown poses, and their directions; see `pose_bank_parts`.

    Raises:
        FrameError: If the stream lacks joints that the poses need.
        MovesError: If nothing can be compared.
    """
    bones = bones_of(shown, streamed)
    if not bones.bones:
        raise MovesError("no pose can be held: the poses have no bone that the stream has, too")
    known = facing == "any" and bones.girdles[0] >= 0
    girdles = np.array(bones.girdles if known else (NOWHERE,) * 4, np.int64)
    groups = {limb: place for place, limb in enumerate(dict.fromkeys(bone.limb for bone in bones.bones))}
    axis, sign = UPWARDS[up]
    count = len(bones.bones)
    store = np.zeros(pose_bank_bytes(len(bones.streamed), count, len(poses)), np.uint8)
    head = len(bones.streamed), count, len(groups), len(poses), axis, sign, girdles
    store[: POSES_HEAD.itemsize].view(POSES_HEAD)[0] = head
    bank = parts_of(store, pose_bank_parts(store))
    bank["points"][:] = [tuple(pair) for pair in bones.streamed]
    bank["bones"][:] = [(bone.begin, bone.end, groups[bone.limb]) for bone in bones.bones]
    holds = {pose.name: pose.hold for pose in poses}
    bank["shown"][:] = [(list(holds).index(pose.name), holds[pose.name]) for pose in poses]
    for row, pose in zip(bank["rows"], poses, strict=True):
        points = points_of(pose.metres(len(shown))[None], bones.shown, up)
        cosine, sine = mean_heading(np.ascontiguousarray(points, np.float32), girdles)
        row[:] = directions_of(points, bones, cosine, sine)[0]
    return store
