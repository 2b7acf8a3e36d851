"""The bank: shown poses as directions of bones, for the joints of one stream."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_stream.errors import MovesError
from mossar_stream.following.bank import directions_of, points_of
from mossar_stream.following.bones import NOWHERE, Bones, shared_bones
from mossar_stream.following.layout import BONE, BONE_BYTES, BONE_POINT, BONE_POINT_BYTES
from mossar_stream.jit.cache import open_cache
from mossar_stream.moves.facing import mean_heading
from mossar_stream.moves.points import UPWARDS
from mossar_stream.moves.pose import Pose
from mossar_stream.moves.rules import Facing
from mossar_stream.poses.layout import POSES_HEAD, POSES_HEAD_BYTES, SHOWN, SHOWN_BYTES, bank_bytes
from mossar_stream.settings import Up
from mossar_stream.skeleton import Skeleton


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
        Bytes: `POSES_HEAD`, then points, bones, shown poses, and their directions.

    Raises:
        FrameError: If the stream lacks joints that the poses need.
        MovesError: If nothing can be compared.
    """
    bones = bones_of(shown, streamed)
    if not bones.bones:
        raise MovesError("no pose can be held: the poses have no bone that the stream has, too")
    open_cache()
    known = facing == "any" and bones.girdles[0] >= 0
    girdles = np.array(bones.girdles if known else (NOWHERE,) * 4, np.int64)
    groups = {limb: place for place, limb in enumerate(dict.fromkeys(bone.limb for bone in bones.bones))}
    axis, sign = UPWARDS[up]
    count = len(bones.bones)
    store = np.zeros(bank_bytes(len(bones.streamed), count, len(poses)), np.uint8)
    head = len(bones.streamed), count, len(groups), len(poses), axis, sign, girdles
    store[:POSES_HEAD_BYTES].view(POSES_HEAD)[0] = head
    begin, end = POSES_HEAD_BYTES, POSES_HEAD_BYTES + len(bones.streamed) * BONE_POINT_BYTES
    store[begin:end].view(BONE_POINT)[:] = [tuple(pair) for pair in bones.streamed]
    begin, end = end, end + count * BONE_BYTES
    store[begin:end].view(BONE)[:] = [(bone.begin, bone.end, groups[bone.limb]) for bone in bones.bones]
    begin, end = end, end + len(poses) * SHOWN_BYTES
    holds = {pose.name: pose.hold for pose in poses}
    store[begin:end].view(SHOWN)[:] = [(list(holds).index(pose.name), holds[pose.name]) for pose in poses]
    rows = store[end:].view(np.float64).reshape(len(poses), count, 3)
    for row, pose in zip(rows, poses, strict=True):
        points = points_of(pose.metres(len(shown))[None], bones.shown, up)
        cosine, sine = mean_heading(np.ascontiguousarray(points, np.float32), girdles)
        row[:] = directions_of(points, bones, cosine, sine)[0]
    return store
