"""Recognition: a performer's frames in, move events out."""

import hashlib
import math
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import MoveReader
from mossar_stream.errors import SnapshotError
from mossar_stream.moves.bank import store_of
from mossar_stream.moves.explaining import REASONS
from mossar_stream.moves.limbs import limbs_of
from mossar_stream.moves.moves import Moves, copy_of
from mossar_stream.moves.recogniser import memory_of, new_memory
from mossar_stream.skeleton import Skeleton


class Recognition(MoveReader):
    """The recognition of the moves of one performer.

    Args:
        moves: Those to recognise, in their present state.
        skeleton: The performer's joints.
        performer: Name that events carry.
        store: The examples described for these joints, if there is one already.

    Raises:
        FrameError: If the performer lacks joints that the examples need.
        TypeError: If `moves` are something else.
    """

    def __init__(
        self, moves: Moves, skeleton: Skeleton, performer: str, store: NDArray[np.uint8] | None = None
    ) -> None:
        self.moves = copy_of(moves)
        self.names = moves.reported
        self.store = moves.store(skeleton) if store is None else store
        self.performer = performer
        self.limbs = tuple(limbs_of(skeleton))
        self._joints = int(store_of(self.store)["head"][0]["joints"])
        self.state = new_memory(self._joints, len(self.names))
        self.explained = moves.explained
        self._state: Any = self.parts()["state"][0]

    def parts(self, memory: NDArray[np.uint8] | None = None) -> dict[str, NDArray[Any]]:
        """Return views of the parts of a memory as large as this performer's, or of this one."""
        return memory_of(self.state if memory is None else memory, self._joints, len(self.names))

    @cached_property
    def moves_text(self) -> bytes:
        """The moves as text, written once."""
        return self.moves.to_json()

    @cached_property
    def digest(self) -> bytes:
        """A digest of these moves."""
        return hashlib.sha256(self.moves_text).digest()

    def follow_on(self, before: "Recognition | None") -> "Recognition":
        """Continue another recognition of the same performer with other moves; return this one.

        The state of the movement stays if the examples have the same joints, and a
        move that is not final yet if it is still among them.
        """
        if before is None:
            return self
        ours, theirs = store_of(self.store), store_of(before.store)
        if all(np.array_equal(ours[name], theirs[name]) for name in ("joints", "limbs")):
            own, known = self.parts(), before.parts()
            for name in ("state", "poses"):
                own[name][:] = known[name]
            for record, field in (("found", "move"), ("before", "move"), ("decision", "leader")):
                move = int(known["state"][0][record][field])
                name = before.names[move] if move >= 0 else ""
                self._state[record][field] = self.names.index(name) if name in self.names else -1
            self._state["nearest"]["open"] = 0
            times = dict(zip(before.names, known["last_times"].tolist(), strict=True))
            own["last_times"][:] = [times.get(name, -math.inf) for name in self.names]
        return self

    @property
    def is_undecided(self) -> bool:
        """Whether a move is confirmed and may still be withdrawn."""
        return int(self._state["found"]["move"]) >= 0

    @property
    def number(self) -> int:
        """Number of the latest move."""
        return int(self._state["found"]["number"])

    def count_on_from(self, number: int) -> None:
        """Number moves on from those of a recognition of other moves."""
        self._state["found"]["number"] = number

    def to_bytes(self) -> bytes:
        """Return the state of the performer, for a snapshot."""
        return self.state.tobytes()

    def go_on_from(self, content: bytes) -> None:
        """Continue another recognition of the same moves and joints.

        Raises:
            SnapshotError: If the bytes do not fit, or contradict themselves.
        """
        if len(content) != len(self.state):
            raise SnapshotError(f"the snapshot's moves have {len(content)} bytes, not {len(self.state)}")
        memory = np.frombuffer(content, np.uint8).copy()
        parts = self.parts(memory)
        if not _is_sound(parts["state"][0], parts["poses"], len(self.names), len(self.limbs)):
            raise SnapshotError("the snapshot's state of moves contradicts itself")
        self.state[:] = memory


def _is_sound(state: Any, positions: NDArray[np.float32], moves: int, limbs: int) -> bool:
    """Return whether recognition can have left this memory of a performer."""
    poses, first = int(state["track"]["poses"]), int(state["track"]["first"])
    marks = [*state["activity"]["starts"].tolist(), int(state["activity"]["low_pose"])]
    decision = state["decision"]
    nearest = state["nearest"]
    found = [state[which] for which in ("found", "before")]
    return (
        0 <= first <= poses < 1 << 60
        and not np.isnan(state["due"])
        and all(-1 <= mark < max(poses, 1) for mark in marks)
        and 0 <= int(decision["from_pose"]) <= poses
        and -1 <= int(decision["leader"]) < max(moves, 1)  # 0 where there are no moves, too
        and all(-1 <= int(one["move"]) < moves and -1 <= int(one["limb"]) < limbs for one in found)
        and all(0 <= int(one["first"]) <= poses and 0 <= int(one["number"]) < 1 << 60 for one in found)
        and all(0 <= int(one["take"]) < 1 << 60 for one in found)
        and bool(np.isfinite(state["track"]["path"]).all() and np.isfinite(state["track"]["speed"]).all())
        and (0 if nearest["open"] else -1) <= int(nearest["move"]) < moves
        and -1 <= int(nearest["second"]) < moves
        and 0 <= int(nearest["kept"]) < len(REASONS)
        and bool(np.isfinite(positions).all())
    )
