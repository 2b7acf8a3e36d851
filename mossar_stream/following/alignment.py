"""Alignment: a performer's frames in, follow events out."""

from collections.abc import Iterable, Mapping
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import FollowReader, follow_memory_bytes, follow_memory_parts
from mossar_stream.errors import MovesError, SnapshotError
from mossar_stream.following.bank import extents_of, make_bank
from mossar_stream.following.bones import shared_bones
from mossar_stream.following.validation import is_sound
from mossar_stream.moves.moves import Moves, copy_of
from mossar_stream.moves.parts import parts_of
from mossar_stream.settings import Settings
from mossar_stream.skeleton import Skeleton

Follow = bool | tuple[str, ...]  # names of moves; True for all


class FollowState(msgspec.Struct, frozen=True):
    """The performer's place in a followed move; the fields are those of `FollowEvent`.

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
    posture: float


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
    """Return the `Alignment` of those moves that there are; None if there is nothing to follow."""
    if moves is None:
        return None
    names = tuple(name for name in moves.reported if follow is True or (follow and name in follow))
    return Alignment(moves, names, skeleton, settings, performer, store) if names else None


class Alignment(FollowReader):
    """Follows one performer's performances of moves that were shown; all its memory has a fixed size.

    Args:
        moves: The moves with their examples.
        names: Names of the moves to follow.
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
        self.performer = performer
        shown = self.moves
        bones = shared_bones(shown.skeleton, skeleton)
        self.store = make_bank(shown, names, skeleton, settings.up) if store is None else store
        self._places = _places(shown, names)
        self.ends = [skeleton.names[max(0, bones.streamed[bone.end].one)] for bone in bones.bones]
        self.limbs = {
            name: np.array([b for b, bone in enumerate(bones.bones) if bone.limb == i])
            for i, name in enumerate(bones.limbs)
        }
        self.extents = [self.extent(box) for box in extents_of(self.store)]
        self.state = np.zeros(follow_memory_bytes(self.store), np.uint8)
        parts = parts_of(self.state, follow_memory_parts(self.store))
        self._state, self._moves, self._happened = parts["state"], parts["moves"], parts["happened"]
        self.boxes, self.every = parts["boxes"], settings.follow_every
        self.begin()

    def with_upward_axis(self, settings: Settings) -> "Alignment":
        """Return an alignment of the same moves, before any frame, for another axis that points upwards."""
        return Alignment(self.moves, self.names, self._skeleton, settings, self.performer)

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
        return self.counted()

    @property
    def following(self) -> dict[str, FollowState | None]:
        """The performer's place in each followed move at the last frame; None for a move that is not being made."""
        found = {name: self.now(m) for m, name in enumerate(self.names)}
        return {name: None if now is None else self._placed(now) for name, now in found.items()}

    def _placed(self, now: dict[str, Any]) -> FollowState:
        return FollowState(**{**now, "example": self._places[now["example"]]})

    def to_bytes(self) -> bytes:
        """Return the performer's memory, for a snapshot."""
        self._happened[:] = 0
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
        self.set_every(self.every)


def _places(moves: Moves, names: tuple[str, ...]) -> list[int]:
    """Return the place in `Moves.examples_and_images` of each example of a bank."""
    examples = moves.examples_and_images()
    places = [place for place, example in enumerate(examples) if example.name in names]
    return sorted(places, key=lambda place: names.index(examples[place].name))
