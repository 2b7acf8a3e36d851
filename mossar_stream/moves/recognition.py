"""Recognition: a performer's frames in, move events out."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.errors import SnapshotError
from mossar_stream.events import MoveEvent, MoveStatus
from mossar_stream.moves.limbs import limbs_of
from mossar_stream.moves.moves import Moves
from mossar_stream.moves.recogniser import (
    CONFIRMED,
    FINAL,
    JOINT_BYTES,
    STATE_BYTES,
    STORE,
    STORE_BYTES,
    WITHDRAWN,
    memory_bytes,
    new_memory,
    recognise,
    state_of,
)
from mossar_stream.moves.track import LATE, TICK
from mossar_stream.skeleton import Skeleton

WHOLE_BODY = "body"


class Recognition:
    """What recognises the moves of one performer.

    Args:
        moves: Those to recognise, as they are now.
        skeleton: The performer's joints.
        performer: Name that events carry.
        store: The examples described for these joints, if there is one already.

    Raises:
        FrameError: If the performer lacks joints that the examples need.
    """

    def __init__(
        self, moves: Moves, skeleton: Skeleton, performer: str, store: NDArray[np.uint8] | None = None
    ) -> None:
        self.moves = moves.copy()
        self.names = moves.names
        self.store = moves.store(skeleton) if store is None else store
        self._performer = performer
        self._limbs = tuple(limbs_of(skeleton))
        self._joints = int(self.store[:8].view(np.int64)[0])
        self._memory = new_memory(self._joints)
        self._state: Any = state_of(self._memory)
        self._track: Any = self._state["track"]
        self._latest = -math.inf  # s, of the last pose
        # No frame: the kernel is compiled now, and never while frames come in.
        nobody = np.zeros((0, len(skeleton), 3), np.float32)
        recognise(self._memory, self.store, nobody, np.zeros(0), 0)
        self._see()

    @property
    def bytes_taken(self) -> int:
        """Bytes of a performer, besides the examples that all share."""
        return len(self._memory)

    def follow(self, positions: NDArray[np.float32], times: NDArray[np.float64], begin: int) -> int:
        """Take frames in until there is news; return the number of the frame that brought it, n if none did.

        Args:
            positions: (n, J, 3) m.
            times: (n,) s.
            begin: First frame to take in.
        """
        count = len(times)
        if count == 1 and begin == 0 and -LATE <= times[0] - self._latest < TICK:
            return 1  # no pose is due, as the kernel would say after more time
        stop: int = recognise(self._memory, self.store, positions, times, begin)
        self._see()
        return stop

    def _see(self) -> None:
        """Note when the last pose was."""
        self._latest = float(self._track["time"]) if self._track["poses"] else -math.inf

    def news(self, take: int) -> list[MoveEvent]:
        """Return the events of the frame that `follow` stopped at.

        Args:
            take: Number of the take that is open.
        """
        state = self._state
        happened = int(state["happened"])
        events = []
        if happened & (FINAL | WITHDRAWN):
            events.append(self._event("before", "final" if happened & FINAL else "withdrawn", 2))
        if happened & CONFIRMED:
            state["found"]["take"] = take
            events.append(self._event("found", "confirmed", 1))
        return events

    def end(self) -> list[MoveEvent]:
        """Forget what is going on, as a take ends; return the event of a move that becomes final by that."""
        state = self._state
        events = [self._event("found", "final", 2)] if state["found"]["move"] >= 0 else []
        number = int(state["found"]["number"])
        self._memory[:] = new_memory(self._joints)
        state["found"]["number"] = number
        self._see()
        return events

    def follow_on(self, before: "Recognition | None") -> "Recognition":
        """Go on where another recognition of the same performer was, with other moves; return this one.

        Numbers of moves are counted on. What is known of the movement stays if the examples have the same joints, and a
        move that is not final yet if it is still among them.
        """
        if before is None:
            return self
        memory = np.frombuffer(before.to_bytes(), np.uint8)
        known: Any = state_of(memory)
        if np.array_equal(_joint_records(self.store), _joint_records(before.store)):
            self._memory[:] = memory
            for record, field in (("found", "move"), ("before", "move"), ("decision", "leader")):
                move = int(known[record][field])
                name = before.names[move] if move >= 0 else ""
                self._state[record][field] = self.names.index(name) if name in self.names else -1
            self._see()
        self._state["found"]["number"] = known["found"]["number"]
        return self

    def _event(self, which: str, status: MoveStatus, rev: int) -> MoveEvent:
        found = self._state[which]
        limb = int(found["limb"])
        return MoveEvent(
            performer=self._performer,
            id=f"{self._performer}/move/{int(found['take'])}/{int(found['number'])}",
            rev=rev,
            name=self.names[int(found["move"])],
            status=status,
            take=int(found["take"]),
            start=float(found["start"]),
            end=float(found["end"]),
            score=1.0 / (1.0 + float(found["cost"])),
            limb=self._limbs[limb] if limb >= 0 else WHOLE_BODY,
            decided_time=float(found["time"] if status == "confirmed" else self._state["time"]),
        )

    def to_bytes(self) -> bytes:
        """Return what is remembered of the performer, for a snapshot."""
        return self._memory.tobytes()

    def go_on_from(self, content: bytes) -> None:
        """Go on where another recognition of the same moves and joints was.

        Raises:
            SnapshotError: If the bytes do not fit, or contradict themselves.
        """
        if len(content) != memory_bytes(self._joints):
            raise SnapshotError(
                f"the snapshot's moves have {len(content)} bytes, not {memory_bytes(self._joints)}"
            )
        memory = np.frombuffer(content, np.uint8).copy()
        if not _is_sound(memory, len(self.names), len(self._limbs)):
            raise SnapshotError("the snapshot's state of moves contradicts itself")
        self._memory[:] = memory
        self._see()


def _joint_records(store: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the part of a store that says where the joints of the examples are in the stream."""
    joints = int(store[:STORE_BYTES].view(STORE)[0]["joints"])
    return store[STORE_BYTES : STORE_BYTES + joints * JOINT_BYTES]


def _is_sound(memory: NDArray[np.uint8], moves: int, limbs: int) -> bool:
    """Tell whether a performer's memory is one that recognising could have left."""
    state: Any = state_of(memory)
    poses, first = int(state["track"]["poses"]), int(state["track"]["first"])
    marks = [*state["activity"]["starts"].tolist(), int(state["activity"]["low_pose"])]
    decision = state["decision"]
    found = [state[which] for which in ("found", "before")]
    return (
        0 <= first <= poses < 1 << 60
        and all(-1 <= mark < max(poses, 1) for mark in marks)
        and 0 <= int(decision["from_pose"]) <= poses
        and -1 <= int(decision["leader"]) < moves
        and all(-1 <= int(one["move"]) < moves and -1 <= int(one["limb"]) < limbs for one in found)
        and all(0 <= int(one["first"]) <= poses and 0 <= int(one["number"]) < 1 << 60 for one in found)
        and all(0 <= int(one["take"]) < 1 << 60 for one in found)
        and bool(np.isfinite(state["track"]["path"]).all() and np.isfinite(state["track"]["speed"]).all())
        and bool(np.isfinite(memory[STATE_BYTES:].view(np.float32)).all())
    )
