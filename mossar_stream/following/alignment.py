"""Alignment: a performer's frames in, follow events out."""

import math
from collections.abc import Container, Iterable, Mapping

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import (
    MOVE_BEGUN,
    MOVE_DONE,
    MOVE_GOES_ON,
    MOVE_LEFT,
    MOVE_UNCHANGED,
    RECORDS,
    address_of_follow_frame,
    begin_following,
    evaluate,
    finish_take,
    follow_memory_bytes,
    follow_memory_parts,
)
from mossar_stream.errors import MovesError, SnapshotError
from mossar_stream.events import Event, FollowEvent, FollowStatus
from mossar_stream.following.bank import bank_of, extents_of, make_bank
from mossar_stream.following.bones import shared_bones
from mossar_stream.following.certainty import certainty
from mossar_stream.following.validation import is_sound
from mossar_stream.moves.moves import Moves, copy_of
from mossar_stream.moves.parts import parts_of
from mossar_stream.settings import Settings
from mossar_stream.skeleton import Skeleton

Follow = bool | tuple[str, ...]  # names of moves; True for all
FOLLOW_STATUS_BY_CODE: dict[int, FollowStatus] = {
    MOVE_BEGUN: "begun",
    MOVE_GOES_ON: "progress",
    MOVE_DONE: "done",
    MOVE_LEFT: "left",
}
FOLLOW_REPORT = RECORDS["FollowReport"]
MOVES_LEAST = 0.2  # extent, as a chord, from which a limb moves in an example
FAIR = 15.0  # degrees of deviation at which the score is a half


class FollowState(msgspec.Struct, frozen=True):
    """Where a performer is in a followed move; the fields are those of `FollowEvent`.

    Args:
        example: Place of the aligned example in `Moves.examples_and_images`.
    """

    example: int
    count: int
    start: float
    time: float
    progress: float
    tempo: float
    certainty: float
    deviation: float
    limbs: dict[str, float]
    joint: str


def checked_follow(follow: Iterable[str] | bool, moves: Moves | None) -> Follow:
    """Return which moves are to be followed, each once.

    Args:
        follow: Names, or True for all; False or none for nothing.
        moves: Those that there are.

    Raises:
        MovesError: If there are no moves, or none of a name.
        TypeError: If `follow` is something else.
    """
    if isinstance(follow, str | bytes) or not isinstance(follow, bool | Iterable):
        raise TypeError(f"follow is a tuple of names of moves, or True for all, not {follow!r}")
    chosen: Follow = follow if isinstance(follow, bool) else tuple(dict.fromkeys(follow))
    if chosen and moves is None:
        raise MovesError("there is nothing to follow without moves; give moves, too")
    known = () if moves is None else moves.reported
    missing = () if isinstance(chosen, bool) else [name for name in chosen if name not in known]
    if missing:
        raise MovesError(
            f"there is no move called {str(missing[0])[:80]!r} to follow; there are {', '.join(known[:40]) or 'none'}"
        )
    return chosen


def alignment_of(
    follow: Follow,
    moves: Moves | None,
    skeleton: Skeleton,
    settings: Settings,
    performer: str,
    store: NDArray[np.uint8] | None = None,
) -> "Alignment | None":
    """Return what follows those moves that there are; None if there is nothing to follow; see `Alignment`."""
    if moves is None:
        return None
    names = tuple(name for name in moves.reported if follow is True or (follow and name in follow))
    return Alignment(moves, names, skeleton, settings, performer, store) if names else None


class Alignment:
    """What follows one performer's performances of moves that were shown; all its memory has a fixed size.

    Args:
        moves: Whose examples there are.
        names: Of the moves to follow.
        skeleton: The performer's joints.
        settings: `follow_every` and `up` are used.
        performer: Name that events carry.
        store: The bank for these joints, if there is one already.

    Raises:
        FrameError: If the performer lacks joints that the examples need.
        MovesError: If an example cannot be followed.
    """

    def __init__(
        self,
        moves: Moves,
        names: tuple[str, ...],
        skeleton: Skeleton,
        settings: Settings,
        performer: str,
        store: NDArray[np.uint8] | None = None,
    ) -> None:
        self.moves = copy_of(moves)
        self.names = names
        self._skeleton = skeleton
        self._settings = settings
        self._performer = performer
        shown = self.moves
        bones = shared_bones(shown.skeleton, skeleton)
        self.store = make_bank(shown, names, skeleton, settings.up) if store is None else store
        self._places = _places(shown, names)
        self._ends = [skeleton.names[max(0, bones.streamed[bone.end].one)] for bone in bones.bones]
        self._limb_names = bones.limbs
        self._limbs = {
            name: np.array([b for b, bone in enumerate(bones.bones) if bone.limb == i])
            for i, name in enumerate(bones.limbs)
        }
        self._examples = bank_of(self.store)["examples"]
        self._extents = [self._extent(box) for box in extents_of(self.store)]
        self.state = np.zeros(follow_memory_bytes(self.store), np.uint8)
        parts = parts_of(self.state, follow_memory_parts(self.store))
        self._state, self._moves, self._happened = parts["state"], parts["moves"], parts["happened"]
        self._reports, self._boxes = parts["reports"], parts["boxes"]
        self.reported: None = None
        self._begin()
        self.address = address_of_follow_frame()

    def _begin(self) -> None:
        """Begin anew, as for a take."""
        begin_following(self.state, self.store)
        self._state["every"] = self._settings.follow_every

    def adopt(self, settings: Settings, take: int, pending: list[Event]) -> "Alignment":
        """Go on with other settings; if another axis points upwards, what is being made is given up.

        Args:
            settings: From now on.
            take: Number of the take that is open.
            pending: Gets the events.

        Returns:
            What follows the frames to come.
        """
        if settings.up == self._settings.up:
            self._settings = settings
            self._state["every"] = settings.follow_every
            return self
        self.decide(take, pending)
        fresh = Alignment(self.moves, self.names, self._skeleton, settings, self._performer)
        fresh.count_on_from(*self.numbers)
        return fresh

    def count_on_from(self, number: int, counts: Mapping[str, int]) -> None:
        """Number performances on from those of another alignment in the same take.

        Args:
            number: Of the latest performance.
            counts: How many are done of each name.
        """
        self._state["number"] = number
        self._moves["count"] = [counts.get(name, 0) for name in self.names]

    @property
    def numbers(self) -> tuple[int, dict[str, int]]:
        """The number of the latest performance, and how many are done of each name, in this take."""
        counts = self._moves["count"].tolist()
        return int(self._state["number"][0]), dict(zip(self.names, counts, strict=True))

    @property
    def following(self) -> dict[str, FollowState | None]:
        """Where the performer is in each followed move at the last frame; None where it is not being made."""
        return {name: self._now(m) if self._moves[m]["active"] else None for m, name in enumerate(self.names)}

    def report(self, take: int, _origin: NDArray[np.float64] | None = None) -> tuple[list[Event], None]:
        """Return the events of the last frame.

        Args:
            take: Number of the take that is open.
        """
        happened = self._happened.tolist()
        return [self._event(m, take, what) for m, what in enumerate(happened) if what != MOVE_UNCHANGED], None

    def decide(self, take: int, pending: list[Event]) -> None:
        """Decide what is being made; `pending` gets the events."""
        self._decide(take, pending, begins=False)

    def end(self, take: int, pending: list[Event]) -> None:
        """Decide everything as a take ends, and begin anew; `pending` gets the events."""
        self._decide(take, pending, begins=True)

    def _decide(self, take: int, pending: list[Event], *, begins: bool) -> None:
        """Decide what is being made, as a whole or not at all."""
        before = self.state.copy()
        try:
            finish_take(self.state, self.store)
            events, _ = self.report(take)
            if begins:
                self._begin()
            self._happened[:] = MOVE_UNCHANGED
        except BaseException:
            self.state[:] = before
            raise
        pending += events

    def _now(self, m: int) -> FollowState:
        evaluate(self.state, self.store, m)
        report, limbs = self._report(m)
        return FollowState(
            example=self._places[int(report["example"])],
            count=int(report["count"]),
            start=report["start"],
            time=report["time"],
            progress=report["progress"],
            tempo=report["tempo"],
            certainty=certainty(report),
            deviation=report["deviation"],
            limbs=limbs,
            joint=self._joint(report),
        )

    def _report(self, m: int) -> tuple[dict[str, float], dict[str, float]]:
        """Return what is reported of a move, and the deviation of each limb that was not hidden for too long."""
        numbers = self._reports[m].tolist()
        names = FOLLOW_REPORT.names or ()
        limbs = zip(self._limb_names, numbers[len(names) :], strict=True)
        return (
            dict(zip(names, numbers[: len(names)], strict=True)),
            {name: angle for name, angle in limbs if not math.isnan(angle)},
        )

    def _joint(self, report: Mapping[str, float]) -> str:
        """Return the joint at the end of the bone that strays farthest."""
        bone = int(report["joint"])
        return self._ends[bone] if bone >= 0 else ""

    def _event(self, m: int, take: int, what: int) -> FollowEvent:
        report, limbs = self._report(m)
        done = what == MOVE_DONE
        deviation = report["deviation"]
        return FollowEvent(
            performer=self._performer,
            id=f"{self._performer}/follow/{take}/{int(report['number'])}",
            rev=int(report["rev"]),
            name=self.names[m],
            status=FOLLOW_STATUS_BY_CODE[what],
            take=take,
            count=int(report["count"]),
            start=report["start"],
            time=report["time"],
            progress=report["progress"],
            tempo=report["tempo"],
            certainty=1.0 if done else 0.0 if what == MOVE_LEFT else certainty(report),
            deviation=deviation,
            limbs=limbs,
            joint=self._joint(report),
            range=self._range(m, limbs) if done else None,
            score=round(1.0 / (1.0 + (deviation / FAIR) ** 2), 3) if done else None,
            decided_time=float(self._state["time"][0]),
        )

    def _range(self, m: int, judged: Container[str]) -> dict[str, float]:
        """Return the extent of each judged limb's path relative to the example's; of limbs that move in the example."""
        went = self._extent(self._boxes[m, 1] - self._boxes[m, 0])
        shown = self._extents[int(self._moves[m]["example"])]
        return {
            name: round(went[name] / far, 3)
            for name, far in shown.items()
            if far >= MOVES_LEAST and name in judged
        }

    def _extent(self, box: NDArray[np.float32]) -> dict[str, float]:
        """Return the extent of each limb's directions, of those of bones, (B, 3)."""
        squares = (box**2).sum(axis=1)
        return {name: math.sqrt(float(squares[own].mean())) for name, own in self._limbs.items()}

    def to_bytes(self) -> bytes:
        """Return what is known of the performer, for a snapshot."""
        self._happened[:] = MOVE_UNCHANGED
        return self.state.tobytes()

    def go_on_from(self, content: bytes) -> None:
        """Go on where another alignment of the same moves and joints was.

        Raises:
            SnapshotError: If the bytes do not fit, or contradict themselves.
        """
        if len(content) != len(self.state):
            raise SnapshotError(
                f"the snapshot's followed moves have {len(content)} bytes, not {len(self.state)}"
            )
        fresh = np.frombuffer(content, np.uint8).copy()
        if not is_sound(fresh, self.store):
            raise SnapshotError("the snapshot's state of followed moves contradicts itself")
        self.state[:] = fresh
        self._state["every"] = self._settings.follow_every


def _places(moves: Moves, names: tuple[str, ...]) -> list[int]:
    """Return the place in `Moves.examples_and_images` of each example of a bank."""
    examples = moves.examples_and_images()
    places = [place for place, example in enumerate(examples) if example.name in names]
    return sorted(places, key=lambda place: names.index(examples[place].name))
