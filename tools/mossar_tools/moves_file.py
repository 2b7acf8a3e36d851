"""The user's file of moves: read, added to, and written.

A program that changes it locks it from before it is read until it is written. Otherwise one of two programs that teach
at once would overwrite the other's examples. The lock is a file beside it, because the file itself is replaced.
"""

import contextlib
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import filelock
import numpy as np
from numpy.typing import NDArray

from mossar_stream import Example, Moves, MovesError, Skeleton
from mossar_tools.errors import UsageError
from mossar_tools.explaining import lines_of_oddity

PATIENCE = 10.0  # s, that another program may take to change the file
EVERY = "all"  # for `--follow`: all moves
NAMED = 40  # moves at most in a message

Follow = bool | tuple[str, ...]  # names of moves; True for all


def read_moves(path: str | Path) -> Moves:
    """Return the moves of a file.

    Raises:
        MossarError: If it cannot be read, or is not a file of moves.
    """
    try:
        return Moves.load(path)
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from None
    except MovesError as error:
        raise UsageError(f"{path}: {error}") from None


def check_taught_name(name: str) -> str:
    """Return a name that a move may have which is shown now, and followed by `--follow`.

    Raises:
        MovesError: If it is no name of a move, or `--follow` could not name it.
    """
    if name == EVERY or "," in name:
        raise MovesError(
            f"a move cannot be called {name[:80]!r}: --follow takes names with commas between, or {EVERY}"
        )
    return Moves.check_name(name)


def moves_to_follow(
    path: str | Path | None, names: Sequence[str], *, teaches: bool = False
) -> tuple[Moves | None, Follow]:
    """Return the moves of a file, if there is one, and which of them are followed.

    Args:
        path: The file; None for no moves.
        names: Of the moves to follow, or `all`.
        teaches: Whether moves may be shown later, into a file that need not be there: names may be unknown.

    Raises:
        MossarError: If the file cannot be read, or a move to follow is not in it.
    """
    if names and path is None:
        raise UsageError("--follow needs --moves FILE: the file has the moves that are followed")
    if path is None or (teaches and not Path(path).exists()):
        return None, ()
    moves = read_moves(path)
    missing = [name for name in names if name not in (*moves.reported, EVERY)]
    if missing and not teaches:
        known = ", ".join(moves.reported[:NAMED]) or "none"
        raise UsageError(f"--follow {missing[0][:80]}: {path} has no such move; there are {known}")
    return moves, followed(names, moves)


def followed(names: Sequence[str], moves: Moves) -> Follow:
    """Return the wanted moves to follow that exist so far."""
    return EVERY in names or tuple(name for name in names if name in moves.reported)


def moves_for(path: str | Path, skeleton: Skeleton) -> Moves:
    """Return the moves that a file has so far; none if it is not there.

    Raises:
        UsageError: If they were shown with another skeleton.
    """
    if not Path(path).exists():
        return Moves(skeleton)
    moves = read_moves(path)
    if moves.skeleton != skeleton:
        raise UsageError(
            f"{path} holds moves of another skeleton, with {len(moves.skeleton)} joints; this one has {len(skeleton)}"
        )
    return moves


@contextlib.contextmanager
def changing(path: str | Path, skeleton: Skeleton | None = None) -> Iterator[Moves]:
    """Yield the moves of a file, and replace the file as a whole by the changed moves, unless there is an error.

    Other programs that change the file wait so long.

    Args:
        path: The file.
        skeleton: Of the moves, of a file that need not be there; see `moves_for`.

    Raises:
        MossarError: If it cannot be read, changed or written.
    """
    target = Path(path)
    try:
        with filelock.FileLock(target.with_name(f".{target.name}.lock"), timeout=PATIENCE):
            moves = read_moves(path) if skeleton is None else moves_for(path, skeleton)
            yield moves
            moves.save(path)
    except filelock.Timeout:
        raise UsageError(f"{path}: another program has been changing it for {PATIENCE:g} s") from None
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}") from None


def take_back(path: str | Path, name: str | None = None) -> tuple[Example, int]:
    """Remove the last example from a file.

    Args:
        path: The file.
        name: Of the move; None for whichever was shown last.

    Returns:
        The example, and the number of remaining ones of its name.

    Raises:
        MossarError: If there is none, or the file cannot be read or written.
    """
    with changing(path) as moves:
        places = [i for i, example in enumerate(moves.examples) if name in (None, example.name)]
        if not places:
            of = "" if name is None else f" of {name}"
            raise UsageError(
                f"{path} has no example{of} to take back; there are {', '.join(moves.names[:NAMED]) or 'none'}"
            )
        example = moves.examples[places[-1]]
        moves.remove_example(places[-1])
    return example, sum(one.name == example.name for one in moves.examples)


def take_pose(
    path: str | Path, skeleton: Skeleton, name: str, positions: NDArray[np.float32], fps: float, hold: float
) -> Moves:
    """Add a pose to a file; it is on the disk when this returns.

    Returns:
        All moves of the file.

    Raises:
        MossarError: If it cannot be used or not be written.
    """
    with changing(path, skeleton) as moves:
        moves.add_pose(name, positions, fps, hold)
    return moves


def oddities_of(moves: Moves, places: Iterable[int]) -> list[str]:
    """Return lines about those of some examples that are unlike the others of their name.

    Args:
        moves: With all examples.
        places: Of the examples, in the order of `Moves.examples`.
    """
    lines = []
    for place in places:
        oddity = moves.oddity(place)
        if oddity is not None:
            name = moves.examples[place].name
            number = sum(one.name == name for one in moves.examples[: place + 1])
            lines += lines_of_oddity(name, number, oddity)
    return lines
