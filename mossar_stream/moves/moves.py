"""Moves: the examples that a user showed, by the name of the move."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.errors import MovesError
from mossar_stream.moves.example import Example, check_name, make_example
from mossar_stream.moves.explaining import Explanation
from mossar_stream.moves.mirroring import mirrored, mirrored_joints, mirrored_pose, other_side
from mossar_stream.moves.moves_file import MAX_EXAMPLES, read_moves, write_moves
from mossar_stream.moves.oddity import Oddity, oddity_of
from mossar_stream.moves.pose import Pose, make_pose
from mossar_stream.moves.rules import USUAL, Facing, MoveRule, changed_rule, check_facing
from mossar_stream.settings import Up
from mossar_stream.skeleton import Skeleton


class Moves:
    """Named moves, each with one or more examples, for a segmenter to recognise.

    Examples of one joint set serve streams of another that has the same joints. Several segmenters may share one
    `Moves`; each sees the examples that there were when it was built.

    Args:
        skeleton: Of the examples.

    Example:
        >>> import numpy as np
        >>> moves = Moves(Skeleton(("hip", "hand"), (-1, 0)))
        >>> wave = np.zeros((30, 2, 3))
        >>> wave[:, 1, 0] = np.sin(np.linspace(0, 6, 30))
        >>> moves.add("wave", wave, fps=30)
        >>> moves.names
        ('wave',)
        >>> Moves.from_json(moves.to_json()).names
        ('wave',)
    """

    def __init__(self, skeleton: Skeleton) -> None:
        self.skeleton = skeleton
        self.explained: Callable[[Explanation], None] | None = None
        """Gets the nearest move in each movement once all frames of a push are processed; it changes no event and is in no file.

        After an exception in it, the events and other explanations come with the next push.
        """
        self._facing: Facing = "any"
        self._examples: list[Example] = []
        self._rules: dict[str, MoveRule] = {}
        self._poses: list[Pose] = []
        self._described: tuple[tuple[object, ...], NDArray[np.uint8]] | None = None  # for `costs`

    def __len__(self) -> int:
        return len(self._examples)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the moves, in the order in which they were first shown."""
        return tuple(dict.fromkeys(example.name for example in self._examples))

    @property
    def examples(self) -> tuple[Example, ...]:
        """All examples, in the order in which they were shown."""
        return tuple(self._examples)

    @property
    def poses(self) -> tuple[Pose, ...]:
        """The held poses, in the order in which they were shown; each name has one or more."""
        return tuple(self._poses)

    @property
    def facing(self) -> Facing:
        """Whether moves are recognised from any side ("any") or only as they were shown ("as_shown").

        "any" compares the movement relative to the facing of its hips and shoulders; y is up. Without joints called
        hips, moves are recognised as they were shown.
        """
        return self._facing

    @facing.setter
    def facing(self, facing: Facing) -> None:
        self._facing = check_facing(facing)

    @property
    def reported(self) -> tuple[str, ...]:
        """Names that events may have: those of the moves, and those of mirror images."""
        images = [other_side(name) for name in self.names if self.rule(name).mirrored]
        return tuple(dict.fromkeys([*self.names, *images]))

    def rule(self, name: str) -> MoveRule:
        """Return the rule of a move, a pose, or a mirror image."""
        known = {*self.names, *(pose.name for pose in self._poses)}
        if name not in known and other_side(name) in known:
            name = other_side(name)
        return self._rules.get(name, USUAL)

    def set_rule(
        self,
        name: str,
        *,
        strict: float | None = None,
        again: float | None = None,
        mirrored: bool | None = None,
    ) -> None:
        """Change the rule of a move; None keeps a value.

        Args:
            name: Of a move that was shown, or of a pose, which may be mirrored.
            strict: From 0 (the nearest move) to 1 (almost identical movements only); 0.5 by default.
            again: s after the move was confirmed during which it is not confirmed again; 0 by default.
            mirrored: Whether the mirror image is recognised and followed, too; under the other side's name if the name has a side.

        Raises:
            MovesError: If there is no such move or pose, a value is out of range or not of a pose, or the skeleton has no sides
                to be mirrored.
        """
        if not any(pose.name == name for pose in self._poses):
            self._check_known(name)
        elif strict is not None or again is not None:
            raise MovesError(f"{name!r} is a pose; strict and again are of moves")
        rule = changed_rule(self._rules.get(name, USUAL), strict, again, mirrored)
        if rule.mirrored:
            mirrored_joints(self.skeleton)
        self._rules = {key: value for key, value in {**self._rules, name: rule}.items() if value != USUAL}

    def mirror_images(self, up: Up = "y") -> list[Example]:
        """Return the mirror images of the examples of mirrored moves; `up` is the axis that points upwards."""
        return [mirrored(one, self.skeleton, up) for one in self._examples if self.rule(one.name).mirrored]

    def examples_and_images(self, up: Up = "y") -> list[Example]:
        """Return all examples, then the mirror images."""
        return [*self._examples, *self.mirror_images(up)]

    def poses_and_images(self, up: Up = "y") -> list[Pose]:
        """Return all held poses, then the mirror images of mirrored ones."""
        images = [
            mirrored_pose(one, self.skeleton, up) for one in self._poses if self.rule(one.name).mirrored
        ]
        return [*self._poses, *images]

    def add(
        self, name: str, positions: ArrayLike, fps: float, movement: tuple[int, int] | None = None
    ) -> None:
        """Add an example; it is recognised by the part between its onset and its offset, and followed as a whole.

        Args:
            name: Of the move; 1 to 64 printable characters.
            positions: (n, J, 3), metres: one performance; rest before and after it does no harm.
            fps: Frames per second, Hz.
            movement: First and last frame of the movement, which may have pauses; None for the movement around the peak of
                speed, up to the next pauses of half a second.

        Raises:
            MovesError: If the name or the positions cannot be used, nothing moves, or there are too many examples.
        """
        if len(self._examples) >= MAX_EXAMPLES:
            raise MovesError(f"there are {MAX_EXAMPLES} examples already, which is the most")
        if any(pose.name == name for pose in self._poses):
            raise MovesError(f"{name!r} is a pose already; a name is a move or a pose")
        skeleton = self.skeleton
        self._examples.append(make_example(name, positions, fps, len(skeleton), skeleton.root, movement))

    def add_pose(self, name: str, positions: ArrayLike, fps: float = 30.0, hold: float = 1.0) -> None:
        """Add a pose that is held; a `PoseEvent` reports when a performer enters, holds and leaves it.

        Several poses of one name are several ways to hold it: the nearest one counts.

        Args:
            name: Of the pose; 1 to 64 printable characters, not that of a move.
            positions: (J, 3), metres: the pose; or (n, J, 3): frames, whose last part at rest is the pose.
            fps: Rate of these frames, Hz.
            hold: s after which the pose counts as held; the last one of a name is in force.

        Raises:
            MovesError: If the name or the positions cannot be used, nothing is held, or there are too many poses.
        """
        check_name(name)
        if len(self._poses) >= MAX_EXAMPLES:
            raise MovesError(f"there are {MAX_EXAMPLES} poses already, which is the most")
        if name in self.names:
            raise MovesError(f"{name!r} is a move already; a name is a move or a pose")
        self._poses.append(make_pose(name, positions, fps, hold, self.skeleton))

    @staticmethod
    def check_name(name: str) -> str:
        """Return a name that a move may have.

        Raises:
            MovesError: If it is empty, too long, or not printable.
        """
        return check_name(name)

    def remove(self, name: str) -> None:
        """Forget all examples of a move, or a pose.

        Raises:
            MovesError: If there is none of that name.
        """
        if any(pose.name == name for pose in self._poses):
            self._poses = [pose for pose in self._poses if pose.name != name]
            self._rules.pop(name, None)
            return
        self._check_known(name)
        self._examples = [example for example in self._examples if example.name != name]
        self._rules.pop(name, None)

    def _check_known(self, name: str) -> None:
        check_name(name)
        if name not in self.names:
            raise MovesError(
                f"there is no move called {name!r}; there are {', '.join(self.names[:40]) or 'none'}"
            )

    def copy(self) -> "Moves":
        """Return moves that further examples of these do not change."""
        same = Moves(self.skeleton)
        same.explained = self.explained
        same._facing = self._facing
        same._examples = list(self._examples)
        same._rules = dict(self._rules)
        same._poses = list(self._poses)
        return same

    def remove_example(self, place: int) -> None:
        """Forget one example, counted from 0 in the order of `examples`.

        Raises:
            MovesError: If there is no such example.
        """
        self._check_place(place)
        name = self._examples.pop(place).name
        if name not in self.names:
            self._rules.pop(name, None)

    def _check_place(self, place: int) -> None:
        if not 0 <= place < len(self._examples):
            raise MovesError(f"there is no example {place}; there are {len(self._examples)}")

    def store(self, streamed: Skeleton) -> NDArray[np.uint8]:
        """Return the examples, described for a stream.

        Raises:
            FrameError: If the stream lacks joints that the examples need.
        """
        from mossar_stream.moves.bank import make_store  # noqa: PLC0415 - not before something is recognised

        rules = {name: self.rule(name) for name in self.reported}
        return make_store(
            self.skeleton,
            self.examples_and_images(),
            rules,
            streamed,
            self._facing,
            explains=self.explained is not None,
        )

    def costs(self, positions: ArrayLike, fps: float) -> NDArray[np.float64]:
        """Return the cost of one movement against each of the examples; the least one names it.

        Args:
            positions: (n, J, 3), metres: one performance; it is cut at its onset and its offset.
            fps: Frames per second, Hz.

        Returns:
            (len(self),) costs, in the order of `examples`; about 0.1 for the same move, above 1 for others.

        Raises:
            MovesError: If the positions cannot be used, nothing moves, or there are no examples.
        """
        if not self._examples:
            raise MovesError("there are no examples to compare with")
        skeleton = self.skeleton
        return self._compared(make_example("movement", positions, fps, len(skeleton), skeleton.root))[0]

    def oddity(self, place: int) -> Oddity | None:
        """Return the differences of an example from the others of its name: duration, posture or the movement itself.

        Args:
            place: Of the example, in the order of `examples`.

        Returns:
            None if nothing is unlike, or no other example has its name.

        Raises:
            MovesError: If there is no such example.
        """
        self._check_place(place)
        own = self._examples[place]
        costs, postures = self._compared(own)
        same = [i for i, one in enumerate(self._examples) if one.name == own.name and i != place]
        if not same:
            return None
        nearest = min(
            ((one.name, float(costs[i])) for i, one in enumerate(self._examples) if one.name != own.name),
            key=lambda pair: pair[1],
            default=("", np.inf),
        )
        seconds = np.array([one.seconds(len(self.skeleton)) for one in self._examples])
        return oddity_of(float(seconds[place]), seconds[same], postures[same], costs[same], nearest)

    def _compared(self, movement: Example) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (n,) costs and cosines of postures between a movement and all examples; see `kinds.costs_of`."""
        from mossar_stream.moves.kinds import costs_of, described  # noqa: PLC0415 - not before it is wanted

        skeleton = self.skeleton
        key = (self._facing, *self._examples)
        if self._described is None or self._described[0] != key:
            self._described = key, described(skeleton, self._examples, self._facing)
        return costs_of(skeleton, self._described[1], movement)

    def kinds(self) -> list[list[int]]:
        """Return groups of examples that show the same move, whatever their names: places in `examples`.

        The largest kind comes first, in each kind the most typical example.
        """
        from mossar_stream.moves.kinds import kinds_of  # noqa: PLC0415 - not before it is wanted

        return kinds_of(self.skeleton, self._examples, self._facing)

    def to_json(self) -> bytes:
        """Return the moves as JSON text."""
        return write_moves(self.skeleton, self._examples, self._facing, self._rules, self._poses)

    @classmethod
    def from_json(cls, text: bytes) -> "Moves":
        """Return the moves of a JSON text, which may come from an unknown source.

        Raises:
            MovesError: If it is not of that form, of a newer version, or too large.
        """
        content = read_moves(text)
        moves = cls(content.skeleton)
        moves._facing, moves._examples, moves._rules = content.facing, content.examples, content.rules
        moves._poses = content.poses
        return moves

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the moves to a file, which is replaced as a whole: a power cut loses nothing.

        Raises:
            OSError: If it cannot be written.
        """
        target = Path(path)
        draft = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            with draft.open("wb") as file:
                file.write(self.to_json())
                file.flush()
                os.fsync(file.fileno())
            draft.replace(target)
        finally:
            draft.unlink(missing_ok=True)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Moves":
        """Read moves from a file.

        Raises:
            OSError: If it cannot be read.
            MovesError: If it is not a file of moves; see `from_json`.
        """
        from mossar_stream.moves.moves_file import MAX_BYTES  # noqa: PLC0415

        source = Path(path)
        # A pipe may never end, nor even begin.
        if source.exists() and not (source.is_file() or source.is_dir()):
            raise MovesError("this is a pipe or a device, not a file of moves")
        with source.open("rb") as file:
            return cls.from_json(file.read(MAX_BYTES + 1))


def copy_of(moves: Moves) -> Moves:
    """Return a copy of moves, which later additions do not change.

    Raises:
        TypeError: If they are something else, such as the name of a file.
    """
    if not isinstance(moves, Moves):
        raise TypeError(f"moves are a Moves, not {type(moves).__name__}; Moves.load(path) reads a file")
    return moves.copy()
