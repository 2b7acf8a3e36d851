"""Series: examples of one move that are shown one after the other, and saved together.

An example that is unlike the others of its name is not kept but shown again. Of the first two examples of a name either
may be the slip: if the third is like the second, the first is dropped.
"""

from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import Example, Moves, MovesError, Skeleton
from mossar_tools.explaining import lines_of_oddity
from mossar_tools.moves_file import changing, moves_for


class Shown(msgspec.Struct, frozen=True):
    """What became of a movement that was shown.

    Args:
        example: The movement.
        skeleton: Of the example.
        is_kept: Whether it is an example of the series.
        count: Examples of the series so far.
        unlike: Lines about what it has unlike the others of its name; of one that is kept in spite of it, too.
        is_first_dropped: Whether the first one of the series was dropped, because the last two are alike.
    """

    example: Example
    skeleton: Skeleton
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
        self._kept: list[tuple[NDArray[np.float32], float]] = []  # positions, m, and rates, Hz
        self._refused: tuple[NDArray[np.float32], float] | None = None

    @property
    def count(self) -> int:
        """Examples of the series so far."""
        return len(self._kept)

    @property
    def has_refused(self) -> bool:
        """Whether the last movement was unlike the others, and may still be kept."""
        return self._refused is not None

    def show(self, positions: NDArray[np.float32], fps: float) -> Shown:
        """Keep a movement as an example, unless it is unlike the others of its name.

        Raises:
            MovesError: If it cannot be an example.
        """
        example, unlike = self._compared(self._moves, positions, fps)
        if unlike and not self._keeps:
            before, self._refused = self._refused, (positions, fps)
            if before is None or not self._is_first_odd(before):
                return Shown(example, self._skeleton, False, self.count, unlike)
            self._moves.remove_example(len(self._moves) - 1)
            self._kept = []
            self._add(*before)
            self._add(positions, fps)
            return Shown(example, self._skeleton, True, self.count, is_first_dropped=True)
        self._add(positions, fps)
        return Shown(example, self._skeleton, True, self.count, unlike)

    def keep(self) -> Shown:
        """Keep the last movement although it is unlike the others.

        Raises:
            MovesError: If the last movement was none of these.
        """
        if self._refused is None:
            raise MovesError("there is nothing to keep: the last example was not refused")
        self._add(*self._refused)
        return Shown(self._moves.examples[-1], self._skeleton, True, self.count)

    def save(self, path: Path) -> Moves:
        """Write the examples to a file; when this returns they are on the disk.

        Returns:
            All moves of the file.

        Raises:
            MossarError: If they cannot be used with those that are there, or not be written.
        """
        with changing(path, self._skeleton) as moves:
            for positions, fps in self._kept:
                moves.add(self._name, positions, fps)
        return moves

    def _compared(
        self, others: Moves, positions: NDArray[np.float32], fps: float
    ) -> tuple[Example, tuple[str, ...]]:
        """Return a movement as an example, and lines about what it has unlike others."""
        moves = others.copy()
        moves.add(self._name, positions, fps)
        place = len(moves) - 1
        oddity = moves.oddity(place)
        number = sum(example.name == self._name for example in moves.examples)
        lines = () if oddity is None else tuple(lines_of_oddity(self._name, number, oddity))
        return moves.examples[place], lines

    def _is_first_odd(self, before: tuple[NDArray[np.float32], float]) -> bool:
        """Return whether the only example so far is of this series, and the last two movements are alike."""
        others = sum(example.name == self._name for example in self._moves.examples)
        if self.count != 1 or others != 1 or self._refused is None:
            return False
        moves = self._moves.copy()
        moves.remove_example(len(moves) - 1)
        moves.add(self._name, *before)
        return not self._compared(moves, *self._refused)[1]

    def _add(self, positions: NDArray[np.float32], fps: float) -> None:
        self._moves.add(self._name, positions, fps)
        self._kept.append((positions, fps))
        self._refused = None
