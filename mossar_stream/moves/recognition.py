"""Recognition: a performer's frames in, move events out."""

import hashlib
import math
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.errors import SnapshotError
from mossar_stream.events import Event, MoveEvent, MoveStatus
from mossar_stream.moves.explaining import REASONS, Explanation
from mossar_stream.moves.limbs import limbs_of
from mossar_stream.moves.moves import Moves, copy_of
from mossar_stream.moves.recogniser import (
    CONFIRMED,
    EXPLAINED,
    FINAL,
    JOINT_BYTES,
    LEAD_COUNTED,
    LEAD_WORTH,
    STATE,
    STATE_BYTES,
    STORE,
    STORE_BYTES,
    WITHDRAWN,
    last_times,
    memory_bytes,
    new_memory,
    recognise,
    state_of,
)
from mossar_stream.moves.track import LATE, TICK
from mossar_stream.skeleton import Skeleton

WHOLE_BODY = "body"
HELD = 8  # frames that wait at most until they are taken in together


class Recognition:
    """What recognises the moves of one performer.

    Args:
        moves: Those to recognise, as they are now.
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
        self._performer = performer
        self._limbs = tuple(limbs_of(skeleton))
        self._joints = int(self.store[:8].view(np.int64)[0])
        self._memory = new_memory(self._joints, len(self.names))
        self._explained = moves.explained
        self._state: Any = state_of(self._memory)
        # Views of single numbers, because fields of records take a microsecond each.
        fields = self._memory[:STATE_BYTES].view(STATE)
        self._last_pose, self._poses = fields["track"]["time"], fields["track"]["poses"]
        self._open_move, self._next_look = fields["found"]["move"], fields["decision"]["next_look"]
        self._held = 0  # frames that wait: none of them can bring news
        self._has_news = False  # of the frame that `hold` took in
        self._positions = np.zeros((HELD + 1, len(skeleton), 3), np.float32)
        self._times = np.zeros(HELD + 1)
        self._latest = -math.inf  # s, of the last pose, or of the last frame that is to become one
        self._due = -math.inf  # s, before which no frame can bring news
        # No frame: the kernel is compiled now, and never while frames come in.
        recognise(self._memory, self.store, self._positions, self._times, 0, 0)
        self._see()

    @cached_property
    def moves_text(self) -> bytes:
        """The moves as text, written once."""
        return self.moves.to_json()

    @cached_property
    def digest(self) -> bytes:
        """What tells these moves from others."""
        return hashlib.sha256(self.moves_text).digest()

    @property
    def _explains(self) -> bool:
        return self._explained is not None

    @property
    def bytes_taken(self) -> int:
        """Bytes of a performer, besides the examples that all share."""
        return len(self._memory) + self._positions.nbytes + self._times.nbytes

    def hold(self, position: NDArray[np.float32], time: float) -> bool:
        """Take one frame in; keep it for later if no news can come with it, which is quicker than a kernel's call.

        Args:
            position: (J, 3) or (1, J, 3) m; copied.
            time: s.

        Returns:
            Whether it brings no news; if it does, `follow` says so when it is called with the frame.
        """
        since = time - self._latest
        if 0.0 <= since < TICK:
            return True  # it becomes no pose
        if not TICK <= since <= LATE:
            return False  # time went back or far on, or is none
        held = self._held
        self._positions[held] = position
        self._times[held] = time
        if time < self._due and held < HELD:
            self._latest = time
            self._held = held + 1
            return True
        self._has_news = not self._take_in(held + 1)
        return not self._has_news

    def follow(self, positions: NDArray[np.float32], times: NDArray[np.float64], begin: int) -> int:
        """Take frames in until there is news; return the number of the frame that brought it, n if none did.

        Args:
            positions: (n, J, 3) m.
            times: (n,) s.
            begin: First frame to take in.
        """
        count = len(times)
        if count == 1 and begin == 0:
            return self._follow_one(positions, times)
        self._flush()
        stop: int = recognise(self._memory, self.store, positions, times, begin, count)
        self._see()
        return stop

    def _follow_one(self, positions: NDArray[np.float32], times: NDArray[np.float64]) -> int:
        """Take one frame in with those that wait; return 0 if it brought news."""
        if self._has_news:  # as `hold` has found
            self._has_news = False
            return 0
        if -LATE <= times[0] - self._latest < TICK:
            return 1  # no pose is due, as the kernel would say after more time
        held = self._held
        self._positions[held], self._times[held] = positions[0], times[0]
        return int(self._take_in(held + 1))

    def _take_in(self, count: int) -> bool:
        """Take in the frames that wait, and tell whether the last one brings no news; others cannot."""
        stop: int = recognise(self._memory, self.store, self._positions, self._times, 0, count)
        self._held = 0  # not before: frames that come again become no poses
        self._see()
        return stop == count

    def _flush(self) -> None:
        """Take in the frames that wait."""
        if self._held:
            self._take_in(self._held)

    def _see_nothing(self) -> None:
        """Forget when the last pose was: a take ends."""
        self._has_news = False
        self._latest = self._due = -math.inf

    def _see(self) -> None:
        """Note when the last pose was, and until when nothing can happen."""
        begun = self._poses[0] > 0
        self._latest = float(self._last_pose[0]) if begun else -math.inf
        waits = begun and self._open_move[0] < 0 and not self._explains  # a movement may end at any frame
        self._due = float(self._next_look[0]) if waits else -math.inf

    def news(self, take: int, pending: list[Event], _origin: NDArray[np.float64] | None = None) -> None:
        """Tell of the frame that `follow` stopped at.

        Args:
            take: Number of the take that is open.
            pending: Gets the events.
        """
        state = self._state
        happened = int(state["happened"])
        events: list[MoveEvent] = []
        if happened & CONFIRMED:
            state["found"]["take"] = take
        if happened & (FINAL | WITHDRAWN):
            events.append(self._event("before", "final" if happened & FINAL else "withdrawn", 2))
        if happened & CONFIRMED:
            events.append(self._event("found", "confirmed", 1))
        if happened & EXPLAINED:
            self._explain()
        state["happened"] = 0
        pending += events

    def _explain(self) -> None:
        """Hand over what came nearest in the movement that is over."""
        near = self._state["nearest"]
        if self._explained is None:
            return
        second = int(near["second"])
        lead = float(near["second_cost"]) / float(near["cost"]) if second >= 0 else math.inf
        self._explained(
            Explanation(
                performer=self._performer,
                start=float(near["start"]),
                end=float(near["end"]),
                nearest=self.names[int(near["move"])],
                reason=REASONS[int(near["kept"])],
                cost=float(near["cost"]),
                most=math.exp(float(near["most"]) + LEAD_WORTH * min(math.log(lead), LEAD_COUNTED)),
                lead=lead,
                second=self.names[second] if second >= 0 else "",
                posture=float(near["posture"]),
            )
        )

    def mend(self, take: int, pending: list[Event]) -> None:
        """Go on after an exception; tell of the last frame, if it brought news that were not told; see `news`."""
        self._has_news = False
        self._flush()
        self._see()
        self.news(take, pending)

    def end(self, pending: list[Event]) -> None:
        """Forget what is going on, as a take ends; `pending` gets the event of a move that becomes final by that."""
        self._flush()
        state = self._state
        events = [self._event("found", "final", 2)] if state["found"]["move"] >= 0 else []
        if state["nearest"]["open"]:
            self._explain()
        fresh = new_memory(self._joints, len(self.names))
        state_of(fresh)["found"]["number"] = state["found"]["number"]
        self._see_nothing()
        self._memory[:] = fresh
        pending += events

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
            own, theirs = len(self.names), len(before.names)
            self._memory[: len(self._memory) - 8 * own] = memory[: len(memory) - 8 * theirs]
            for record, field in (("found", "move"), ("before", "move"), ("decision", "leader")):
                move = int(known[record][field])
                name = before.names[move] if move >= 0 else ""
                self._state[record][field] = self.names.index(name) if name in self.names else -1
            self._state["nearest"]["open"] = 0
            times = dict(zip(before.names, last_times(memory, theirs).tolist(), strict=True))
            last_times(self._memory, own)[:] = [times.get(name, -math.inf) for name in self.names]
            self._see()
        self._state["found"]["number"] = known["found"]["number"]
        return self

    def count_on_from(self, content: bytes) -> None:
        """Number moves on from those of a recognition of other moves.

        Args:
            content: Of its `to_bytes`.

        Raises:
            SnapshotError: If the bytes are none.
        """
        number = -1
        if len(content) >= STATE_BYTES:
            number = int(state_of(np.frombuffer(content, np.uint8))["found"]["number"])
        if not 0 <= number < 1 << 60:
            raise SnapshotError("the snapshot's state of moves contradicts itself")
        self._state["found"]["number"] = number

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
        self._flush()
        return self._memory.tobytes()

    def go_back_to(self, content: bytes) -> None:
        """Forget the frames since `to_bytes` returned this."""
        self._memory[:] = np.frombuffer(content, np.uint8)
        self._see()

    def go_on_from(self, content: bytes) -> None:
        """Go on where another recognition of the same moves and joints was.

        Raises:
            SnapshotError: If the bytes do not fit, or contradict themselves.
        """
        wanted = memory_bytes(self._joints, len(self.names))
        if len(content) != wanted:
            raise SnapshotError(f"the snapshot's moves have {len(content)} bytes, not {wanted}")
        memory = np.frombuffer(content, np.uint8).copy()
        if not _is_sound(memory, len(self.names), len(self._limbs)):
            raise SnapshotError("the snapshot's state of moves contradicts itself")
        self._memory[:] = memory
        self._held = 0
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
    nearest = state["nearest"]
    found = [state[which] for which in ("found", "before")]
    numbers = memory[STATE_BYTES : len(memory) - 8 * moves].view(np.float32)
    return (
        0 <= first <= poses < 1 << 60
        and all(-1 <= mark < max(poses, 1) for mark in marks)
        and 0 <= int(decision["from_pose"]) <= poses
        and -1 <= int(decision["leader"]) < moves
        and all(-1 <= int(one["move"]) < moves and -1 <= int(one["limb"]) < limbs for one in found)
        and all(0 <= int(one["first"]) <= poses and 0 <= int(one["number"]) < 1 << 60 for one in found)
        and all(0 <= int(one["take"]) < 1 << 60 for one in found)
        and bool(np.isfinite(state["track"]["path"]).all() and np.isfinite(state["track"]["speed"]).all())
        and (0 if nearest["open"] else -1) <= int(nearest["move"]) < moves
        and -1 <= int(nearest["second"]) < moves
        and 0 <= int(nearest["kept"]) < len(REASONS)
        and bool(np.isfinite(numbers).all())
    )
