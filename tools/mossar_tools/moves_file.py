"""The user's file of moves: read, added to, and written so that what was said to be taken is in it."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Moves, MovesError, Skeleton
from mossar_tools.errors import UsageError


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


def save_moves(moves: Moves, path: str | Path) -> None:
    """Replace the file as a whole.

    Raises:
        UsageError: If it cannot be written.
    """
    try:
        moves.save(path)
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}") from None


def take_example(
    path: str | Path, skeleton: Skeleton, name: str, positions: NDArray[np.float32], fps: float
) -> Moves:
    """Add an example to a file; when this returns it is on the disk, whatever happens afterwards.

    Returns:
        All moves of the file.

    Raises:
        MossarError: If it cannot be used or not be written.
    """
    moves = moves_for(path, skeleton)
    moves.add(name, positions, fps)
    save_moves(moves, path)
    return moves
