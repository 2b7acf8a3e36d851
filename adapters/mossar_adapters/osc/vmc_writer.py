"""Writer of VMC frames: local transforms of humanoid bones, bundled like those of the reference sender."""

from collections.abc import Mapping
from typing import TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.kinematics import JointMotion, MotionChunk, quaternions, world_transforms
from mossar_adapters.osc.assembly.humanoid import mapped_bones, placed_bones, present_parents, rest_of
from mossar_adapters.osc.assembly.vmc_pose import MIRROR
from mossar_adapters.osc.encode import bundle, encode
from mossar_adapters.osc.profiles.vmc import BONE, OK, ROOT, TIME
from mossar_stream import MossarError, Skeleton

BONES_PER_BUNDLE = 13
_T = TypeVar("_T")
_UNTURNED = (0.0, 0.0, 0.0, 1.0)


class Pose(msgspec.Struct, frozen=True):
    """Local transforms of all frames of a chunk, as VMC has them.

    Args:
        bones: Names.
        transforms: (n, B, 7) left-handed position and quaternion relative to the parent bone.
        roots: (n, 7) those of the whole.
    """

    bones: tuple[str, ...]
    transforms: NDArray[np.float64]
    roots: NDArray[np.float64]


class PositionBones:
    """Bones from joint positions: nothing turns, each stands where it is relative to its parent.

    Args:
        skeleton: Of the positions.

    Raises:
        MossarError: If too few joints are called like those of a humanoid.
    """

    def __init__(self, skeleton: Skeleton) -> None:
        found = _found(placed_bones(skeleton))
        self._bones, self._joints = tuple(found), np.array(list(found.values()), dtype=np.intp)  # (B, 2)
        self._parents = np.array(present_parents(self._bones))

    def pose(self, positions: NDArray[np.floating]) -> Pose:
        """Return the transforms of (n, J, 3) positions; bones without a place, or whose parent has none, are NaN."""
        world = positions[:, self._joints].astype(np.float64).mean(axis=2)
        local = world - np.where((self._parents >= 0)[:, None], world[:, self._parents], 0.0)
        transforms = np.zeros((*local.shape[:2], 7))
        transforms[..., :3], transforms[..., 3:] = local, _UNTURNED
        roots = np.zeros((len(local), 7))
        roots[:, 3:] = _UNTURNED
        return Pose(self._bones, transforms * MIRROR, roots * MIRROR)


class MotionBones:
    """Bones from a recording's rotations.

    Args:
        motion: The recording.
        rotations_only: Whether to send zeros for positions as many avatar programs do; the root then carries
            the way through the room.

    Raises:
        MossarError: If too few joints are called like those of a humanoid.
    """

    def __init__(self, motion: JointMotion, *, rotations_only: bool) -> None:
        found = _found(mapped_bones(motion.names, rotations=True))
        self._bones, self._joints = tuple(found), np.array(list(found.values()), dtype=np.intp)
        self._parents = np.array(present_parents(self._bones))
        self._all_parents = motion.parents
        self._rotations_only = rotations_only
        self._rest_hips = rest_of(motion)["Hips"]

    def pose(self, chunk: MotionChunk) -> Pose:
        """Return the transforms of a chunk."""
        turns, places = world_transforms(chunk, self._all_parents)
        turns, places = turns[:, self._joints], places[:, self._joints]
        hanging = self._parents >= 0
        above = np.where(hanging[:, None, None], np.swapaxes(turns[:, self._parents], -1, -2), np.eye(3))
        steps = places - np.where(hanging[:, None], places[:, self._parents], 0.0)
        transforms = np.empty((*places.shape[:2], 7))
        transforms[..., :3] = (above @ steps[..., None])[..., 0]
        transforms[..., 3:] = quaternions(above @ turns)
        roots = np.zeros((len(places), 7))
        roots[:, 3:] = _UNTURNED
        if self._rotations_only:
            roots[:, :3] = places[:, self._bones.index("Hips")] - self._rest_hips
            transforms[..., :3] = 0.0
        return Pose(self._bones, transforms * MIRROR, roots * MIRROR)


def datagrams(pose: Pose, frame: int, time: float) -> list[bytes]:
    """Return one frame as datagrams: bundles of bones, and a last one with Root, the rest, OK and T."""
    row = pose.transforms[frame]
    present = np.flatnonzero(np.isfinite(row).all(axis=1))
    bones = [encode(BONE, "sfffffff", pose.bones[i], *row[i].tolist()) for i in present]
    whole, rest = divmod(len(bones), BONES_PER_BUNDLE)
    sent = [bundle(bones[i * BONES_PER_BUNDLE : (i + 1) * BONES_PER_BUNDLE]) for i in range(whole)]
    root = encode(ROOT, "sfffffff", "root", *pose.roots[frame].tolist())
    last = [root, *([bundle(bones[-rest:])] if rest else []), encode(OK, "i", 1), encode(TIME, "f", time)]
    return [*sent, bundle(last)]


def _found(bones: Mapping[str, _T]) -> Mapping[str, _T]:
    if not bones:
        raise MossarError("profile vmc needs joints called like those of a humanoid (Hips, LeftUpperArm, …)")
    return bones
