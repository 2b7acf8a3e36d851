"""Character figure: a performer drawn in the characters of a terminal."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton

ROWS: Final = 9
COLUMNS: Final = 16
_HEIGHT: Final = 2.2  # m that the rows show
_TURN: Final = np.deg2rad(35)  # of the view about the vertical, so that steps and kicks forward show
_FLOOR: Final = 0.05  # m below the origin that are shown
_BRAILLE: Final = 0x2800
_DOTS: Final = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # of a character, by row and column
_SLOPES: Final = "-\\|/"  # by direction on the screen, from the right downwards, in steps of 45 degrees


def figure(positions: NDArray[Any], skeleton: Skeleton, *, fine: bool) -> list[str]:
    """Return the lines of a picture of a performer, `ROWS` of `COLUMNS` characters.

    Args:
        positions: (J, 3) metres, y up, the floor at 0; NaN where a joint is missing.
        skeleton: Its joints.
        fine: Whether Braille characters may be used; otherwise ASCII.
    """
    across, down = (2, 4) if fine else (1, 1)
    dots = np.zeros((ROWS * down, COLUMNS * across), bool)
    letters = np.full(dots.shape, " ")
    placed = _on_screen(positions, dots.shape)
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0 and np.isfinite(placed[[joint, parent]]).all():
            _draw(dots, letters, placed[parent], placed[joint])
    return _braille(dots) if fine else ["".join(row) for row in letters]


def _on_screen(positions: NDArray[Any], shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return (J, 2) columns and rows of the joints; the body is in the middle."""
    rows, columns = shape
    along = positions[:, 0] * np.cos(_TURN) + positions[:, 2] * np.sin(_TURN)
    seen = along[np.isfinite(along)]
    middle = np.median(seen) if len(seen) else 0.0
    scale = rows / _HEIGHT
    wide = columns / COLUMNS * ROWS / rows * 2  # a character is twice as high as wide
    x = (along - middle) * scale * wide + columns / 2
    y = rows - 1 - (positions[:, 1] + _FLOOR) * scale
    return np.stack([x, y], axis=1)


def _draw(
    dots: NDArray[np.bool_], letters: NDArray[Any], begin: NDArray[np.float64], end: NDArray[np.float64]
) -> None:
    """Draw a bone."""
    way = end - begin
    count = int(np.ceil(np.abs(way).max())) + 1
    points = np.rint(begin + np.linspace(0, 1, count)[:, np.newaxis] * way).astype(int)
    inside = (points >= 0).all(axis=1) & (points < dots.shape[::-1]).all(axis=1)
    columns, rows = points[inside].T
    dots[rows, columns] = True
    eighth = round(float(np.arctan2(way[1], way[0])) / (np.pi / 4)) % 4
    letters[rows, columns] = _SLOPES[eighth]


def _braille(dots: NDArray[np.bool_]) -> list[str]:
    cells = dots.reshape(ROWS, 4, COLUMNS, 2).transpose(0, 2, 1, 3)
    codes = _BRAILLE + (cells * np.array(_DOTS)).sum(axis=(2, 3))
    return ["".join(map(chr, row)) for row in codes.tolist()]
