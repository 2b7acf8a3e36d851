"""Joints that a format writes as (0, 0, 0) when it does not have them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def without_zeros(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return positions with NaN for every joint that lies exactly at the origin.

    Args:
        positions: (n, J, 3).
    """
    return np.where((positions == 0).all(axis=2)[:, :, None], np.nan, positions)


def without_nobody(positions: NDArray[Any]) -> NDArray[Any]:
    """Return positions with NaN in frames in which all joints, three or more, lie exactly at the origin.

    Args:
        positions: (n, J, 3) of numbers that may be missing.
    """
    nobody = (positions == 0).all(axis=(1, 2))
    if positions.shape[1] < 3 or not nobody.any():
        return positions
    return np.where(nobody[:, None, None], np.nan, positions)
