"""Numbers written as text."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.errors import FileError, shown

LARGEST = 1e30  # a larger number is damage, and would overflow when squared

_NOT_A_NUMBER = {"", "nan", "nan(ind)", "null", "none", "na", "n/a", "#n/a", "inf", "infinity"}
_NOT_A_NUMBER |= {"1.#qnan", "1.#ind", "1.#inf"}


def number(cell: str) -> float:
    """Return the number in a cell; NaN for an empty one and the ways to write that there is none.

    Raises:
        ValueError: If the cell holds something else.
    """
    try:
        return float(cell)
    except ValueError:
        plain = cell.strip().strip('"')
        if plain.lower().lstrip("+-") in _NOT_A_NUMBER:
            return float("nan")
        return float(plain.replace(",", "."))


def is_number(cell: str) -> bool:
    """Return whether a cell holds a number, or one of the ways to write that there is none."""
    try:
        number(cell)
    except ValueError:
        return False
    return True


def positive(cell: str | None) -> float | None:
    """Return a number from a heading; None if it is absent or impossible."""
    value = number(cell) if cell and is_number(cell) else 0.0
    return value if 0 < value < 1e9 else None


def numbers(rows: Sequence[Sequence[str]], path: Path, lines: Sequence[int]) -> NDArray[np.float64]:
    """Return rows of cells as numbers, empty cells as NaN.

    Args:
        rows: n rows of equal width.
        path: The file, for messages.
        lines: Line number of each row, for messages.

    Returns:
        (n, width) float64; NaN also where a number is infinite or absurd.

    Raises:
        FileError: If a cell is not a number.
    """
    try:
        return _finite(np.array(rows, dtype=np.float64))
    except ValueError:
        pass  # an empty or an odd cell: one by one
    values = np.empty((len(rows), len(rows[0])))
    for i, row in enumerate(rows):
        for k, cell in enumerate(row):
            try:
                values[i, k] = number(cell)
            except ValueError:
                raise FileError(path, f"{shown(cell)} is not a number", lines[i]) from None
    return _finite(values)


def _finite(values: NDArray[np.float64]) -> NDArray[np.float64]:
    values[~(np.abs(values) < LARGEST)] = np.nan
    return values
