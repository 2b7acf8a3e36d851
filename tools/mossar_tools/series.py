"""Series: examples of one move that are shown in sequence, and saved together.

An example that is unlike the others of its name is not kept but shown again. Of the first two examples of a name either
may be the slip: if the third is like the second, the first is dropped.
"""

from pathlib import Path

import msgspec

from mossar_stream import Example, Moves, MovesError, Skeleton
from mossar_tools.explaining import lines_of_oddity
from mossar_tools.moves_file import changing, moves_for
from mossar_tools.taking import Movement


class Shown(msgspec.Struct, frozen=True):
    """The outcome of a movement that was shown.

    Args:
        example: The movement.
        skeleton: Of the example.
        seconds: How long the movement took, s.
        is_kept: Whether it is an example of the series.
        count: Examples of the series so far.
        unlike: Lines about its differences from the others of its name; of one that is kept in spite of it, too.
        is_first_dropped: Whether the first one of the series was dropped, because the last two are alike.
    """

    example: Example
    skeleton: Skeleton
    seconds: float
    is_kept: bool
    count: int
    unlike: tuple[str, ...] = ()
    is_first_dropped: bool = False


class Series:
    """Examples of a move, of which nothing is in the file before `save`.

    Args:
        path: The file of moves, which need not be there; None if it is not named yet.
        skeleton: Of the examples.
        name: Of the move.
        keeps: Whether examples that are unlike the others are kept.

    Raises:
        MossarError: If the file cannot be read, or holds moves of another skeleton.
    """

    def __init__(self, path: Path | None, skeleton: Skeleton, name: str, *, keeps: bool = False) -> None:
        self._skeleton, self._name, self._keeps = skeleton, name, keeps
        self._moves = Moves(skeleton) if path is None else moves_for(path, skeleton)
        self._kept: list[Movement] = []
        self._refused: Movement | None = None

    @property
    def count(self) -> int:
        """Examples of the series so far."""
        return len(self._kept)

    @property
    def has_refused(self) -> bool:
        """Whether the last movement was unlike the others, and may still be kept."""
        return self._refused is not None

    def show(self, movement: Movement) -> Shown:
        """Keep a movement as an example, unless it is unlike the others of its name.

        Raises:
            MovesError: If it cannot be an example.
        """
        unlike = self._unlike(self._moves, movement)
        if not unlike or self._keeps:
            return self._add(movement, unlike)
        before, self._refused = self._refused, movement
        if before is None or not self._is_first_odd(before, movement):
            return self._shown(self._example(movement), movement, unlike, is_kept=False)
        self._moves.remove_example(len(self._moves) - 1)
        self._kept = []
        self._add(before)
        return msgspec.structs.replace(self._add(movement), is_first_dropped=True)

    def keep(self) -> Shown:
        """Keep the last movement although it is unlike the others.

        Raises:
            MovesError: If the last movement was none of these.
        """
        if self._refused is None:
            raise MovesError("there is nothing to keep: the last example was not refused")
        return self._add(self._refused)

    def save(self, path: Path) -> Moves:
        """Write the examples to a file; when this returns they are on the disk.

        Returns:
            All moves of the file.

        Raises:
            MossarError: If they cannot be used with those that are there, or not be written.
        """
        with changing(path, self._skeleton) as moves:
            for movement in self._kept:
                self._add_to(moves, movement)
        return moves

    def _add(self, movement: Movement, unlike: tuple[str, ...] = ()) -> Shown:
        self._add_to(self._moves, movement)
        self._kept.append(movement)
        self._refused = None
        return self._shown(self._moves.examples[-1], movement, unlike, is_kept=True)

    def _add_to(self, moves: Moves, movement: Movement) -> None:
        moves.add(self._name, movement.positions, movement.fps, movement.frames)

    def _shown(
        self, example: Example, movement: Movement, unlike: tuple[str, ...], *, is_kept: bool
    ) -> Shown:
        return Shown(example, self._skeleton, movement.seconds, is_kept, self.count, unlike)

    def _example(self, movement: Movement) -> Example:
        moves = Moves(self._skeleton)
        self._add_to(moves, movement)
        return moves.examples[0]

    def _unlike(self, others: Moves, movement: Movement) -> tuple[str, ...]:
        """Return lines about the differences of a movement from the others of its name."""
        moves = others.copy()
        self._add_to(moves, movement)
        oddity = moves.oddity(len(moves) - 1)
        number = sum(example.name == self._name for example in moves.examples)
        return () if oddity is None else tuple(lines_of_oddity(self._name, number, oddity))

    def _is_first_odd(self, before: Movement, movement: Movement) -> bool:
        """Return whether the only example so far is of this series, and the last two movements are alike."""
        others = sum(example.name == self._name for example in self._moves.examples)
        if self.count != 1 or others != 1:
            return False
        moves = self._moves.copy()
        moves.remove_example(len(moves) - 1)
        self._add_to(moves, before)
        return not self._unlike(moves, movement)
