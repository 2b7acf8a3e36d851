"""Moves: the examples that a user showed, by the name of the move."""

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.errors import MovesError
from mossar_stream.moves.example import Example, check_name, make_example
from mossar_stream.moves.moves_file import MAX_EXAMPLES, read_moves, write_moves
from mossar_stream.skeleton import Skeleton


class Moves:
    """Named moves, each with one or more examples; what a segmenter recognises in a stream.

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
        self._examples: list[Example] = []
        self._described: tuple[list[Example], NDArray[np.uint8]] | None = None  # for `costs`

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

    def add(self, name: str, positions: ArrayLike, fps: float) -> None:
        """Add an example; it is cut at its onset and its offset.

        Args:
            name: Of the move; 1 to 64 printable characters.
            positions: (n, J, 3), metres: one performance; rest before and after it does no harm.
            fps: Frames per second, Hz.

        Raises:
            MovesError: If the name or the positions cannot be used, nothing moves, or there are too many examples.
        """
        if len(self._examples) >= MAX_EXAMPLES:
            raise MovesError(f"there are {MAX_EXAMPLES} examples already, which is the most")
        skeleton = self.skeleton
        self._examples.append(make_example(name, positions, fps, len(skeleton), skeleton.root))

    @staticmethod
    def check_name(name: str) -> str:
        """Return a name that a move may have.

        Raises:
            MovesError: If it is empty, too long, or has what cannot be printed.
        """
        return check_name(name)

    def remove(self, name: str) -> None:
        """Forget all examples of a move.

        Raises:
            MovesError: If there is none of that name.
        """
        check_name(name)
        if name not in self.names:
            raise MovesError(
                f"there is no move called {name!r}; there are {', '.join(self.names[:40]) or 'none'}"
            )
        self._examples = [example for example in self._examples if example.name != name]

    def copy(self) -> "Moves":
        """Return moves that further examples of these do not change."""
        same = Moves(self.skeleton)
        same._examples = list(self._examples)
        return same

    def remove_example(self, place: int) -> None:
        """Forget one example, counted from 0 in the order of `examples`.

        Raises:
            MovesError: If there is no such example.
        """
        if not 0 <= place < len(self._examples):
            raise MovesError(f"there is no example {place}; there are {len(self._examples)}")
        del self._examples[place]

    def store(self, streamed: Skeleton) -> NDArray[np.uint8]:
        """Return the examples, described for a stream.

        Raises:
            FrameError: If the stream lacks joints that the examples need.
        """
        from mossar_stream.moves.bank import make_store  # noqa: PLC0415 - not before something is recognised

        return make_store(self.skeleton, self._examples, self.names, streamed)

    def costs(self, positions: ArrayLike, fps: float) -> NDArray[np.float64]:
        """Return what it costs to take one movement for each of the examples: what was it? The least says it.

        Args:
            positions: (n, J, 3), metres: one performance; it is cut at its onset and its offset.
            fps: Frames per second, Hz.

        Returns:
            (len(self),) costs, in the order of `examples`; about 0.1 for the same move, above 1 for others.

        Raises:
            MovesError: If the positions cannot be used, nothing moves, or there are no examples.
        """
        from mossar_stream.moves.kinds import costs_of, described  # noqa: PLC0415 - not before it is wanted

        if not self._examples:
            raise MovesError("there are no examples to compare with")
        skeleton = self.skeleton
        movement = make_example("movement", positions, fps, len(skeleton), skeleton.root)
        if self._described is None or self._described[0] != self._examples:
            self._described = list(self._examples), described(skeleton, self._examples)
        return costs_of(skeleton, self._described[1], movement)

    def kinds(self) -> list[list[int]]:
        """Return which examples show the same move, whatever they are called: places in `examples`.

        The largest kind comes first, in each kind the most typical example.
        """
        from mossar_stream.moves.kinds import kinds_of  # noqa: PLC0415 - not before it is wanted

        return kinds_of(self.skeleton, self._examples)

    def to_json(self) -> bytes:
        """Return the moves as JSON text."""
        return write_moves(self.skeleton, self._examples)

    @classmethod
    def from_json(cls, text: bytes) -> "Moves":
        """Return the moves of a JSON text, which may come from anybody.

        Raises:
            MovesError: If it is not of that form, of a newer version, or too large.
        """
        skeleton, examples = read_moves(text)
        moves = cls(skeleton)
        moves._examples = examples
        return moves

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the moves to a file, which is replaced as a whole: nothing is lost whenever the power goes.

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
        if source.exists() and not (
            source.is_file() or source.is_dir()
        ):  # a pipe may never end, nor even begin
            raise MovesError("this is a pipe or a device, not a file of moves")
        with source.open("rb") as file:
            return cls.from_json(file.read(MAX_BYTES + 1))


def copy_of(moves: Moves) -> Moves:
    """Return moves of one's own, to which nobody else adds.

    Raises:
        TypeError: If they are something else, such as the name of a file.
    """
    if not isinstance(moves, Moves):
        raise TypeError(f"moves are a Moves, not {type(moves).__name__}; Moves.load(path) reads a file")
    return moves.copy()
