"""Places of the sums of `sums.pxi` in a summary."""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import PADDING


def set_sums(sums: NDArray[np.void], start: int, positions: int, speeds: int, others: int) -> None:
    """Set the places of the sums.

    Args:
        sums: (1,) record.
        start: Of the sums in a summary.
        positions: How many there are of the positions, padded, or 0.
        speeds: Of the log speeds.
        others: Of the other sums.
    """
    sums["start"], sums["dimensions"] = start, positions + speeds + others
    sums["positions"], sums["speeds"] = positions, speeds


def sums_end(sums: NDArray[np.void]) -> int:
    """Return the length of a summary that ends with such sums and their squares, float64 numbers."""
    return -(-int(sums["start"][0] + 2 * sums["dimensions"][0]) // PADDING) * PADDING
