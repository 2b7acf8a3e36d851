"""Holding: a performer's frames in, pose events out."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import POSE_UNCHANGED, PoseReader, pose_memory_bytes, pose_memory_parts
from mossar_stream.errors import SnapshotError
from mossar_stream.moves.moves import Moves
from mossar_stream.moves.parts import parts_of
from mossar_stream.poses.bank import bones_of, make_bank
from mossar_stream.settings import Up
from mossar_stream.skeleton import Skeleton


def holding_of(moves: Moves, skeleton: Skeleton, up: Up, performer: str) -> "Holding | None":
    """Return the `Holding` of the poses among moves; None if there are none."""
    return Holding(moves, skeleton, up, performer) if moves.poses else None


class Holding(PoseReader):
    """The recognition of the poses that one performer holds; all its memory has a fixed size.

    Args:
        moves: Whose poses there are.
        skeleton: The performer's joints.
        up: The axis that points upwards; `auto` is y.
        performer: Name that events carry.

    Raises:
        FrameError: If the performer lacks joints that the poses need.
        MovesError: If nothing can be compared.
    """

    def __init__(self, moves: Moves, skeleton: Skeleton, up: Up, performer: str) -> None:
        self.performer = performer
        poses = moves.poses_and_images(up)
        self.names = tuple(pose.name for pose in poses)
        self.store = make_bank(moves.skeleton, poses, skeleton, moves.facing, up)
        bones = bones_of(moves.skeleton, skeleton)
        self.ends = [skeleton.names[max(0, bones.streamed[bone.end].one)] for bone in bones.bones]
        self.limbs = {
            name: np.array([k for k, bone in enumerate(bones.bones) if bone.limb == i])
            for i, name in enumerate(bones.limbs)
            if any(bone.limb == i for bone in bones.bones)
        }
        self.state = np.zeros(pose_memory_bytes(self.store), np.uint8)
        parts = self._parts(self.state)
        self._state, self.strays = parts["state"], parts["strays"]
        self.begin()

    def _parts(self, memory: NDArray[np.uint8]) -> dict[str, NDArray[Any]]:
        """Return views of the parts of a performer's memory."""
        return parts_of(memory, pose_memory_parts(self.store))

    @property
    def number(self) -> int:
        """Number of the latest pose of the take."""
        return int(self._state["number"][0])

    def count_on_from(self, number: int) -> None:
        """Number poses on from those of another holding of the same take."""
        self._state["number"] = number

    def to_bytes(self) -> bytes:
        """Return the state of the performer, for a snapshot."""
        self._state["happened"] = POSE_UNCHANGED
        return self.state.tobytes()

    def go_on_from(self, content: bytes) -> None:
        """Continue another holding of the same poses.

        Args:
            content: Of its `to_bytes`.

        Raises:
            SnapshotError: If the bytes do not fit, or contradict themselves.
        """
        if len(content) != len(self.state):
            raise SnapshotError(f"the snapshot's held poses have {len(content)} bytes, not {len(self.state)}")
        fresh = np.frombuffer(content, np.uint8).copy()
        if not self._is_sound(self._parts(fresh)):
            raise SnapshotError("the snapshot's state of held poses contradicts itself")
        self.state[:] = fresh

    def _is_sound(self, parts: dict[str, NDArray[Any]]) -> bool:
        """Return whether a holding can have left this memory of a performer."""
        state, poses = parts["state"][0], len(self.names)
        numbers = [parts[name] for name in ("fast", "slow", "strays", "chords")]
        times = [float(state[name]) for name in ("time", "since", "start", "seen")]
        return (
            all(-1 <= int(state[name]) < poses for name in ("near", "active"))
            and 0 <= int(state["latest"]) < poses
            and all(0 <= int(state[name]) < 1 << 60 for name in ("frames", "matched", "rev", "number"))
            and int(state["is_held"]) in (0, 1)
            and int(state["happened"]) == POSE_UNCHANGED
            and not math.isnan(state["due"])
            and all(math.isfinite(time) for time in times)
            and all(bool(np.isfinite(part).all()) for part in (state["facing"], *numbers))
            and bool((parts["strays"] >= 0.0).all())
        )
