"""Joints that a format writes as (0, 0, 0) when it does not have them."""

import numpy as np
from numpy.typing import NDArray


def without_zeros(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return positions with NaN for every joint that lies exactly at the origin.

    Args:
        positions: (n, J, 3).
    """
    return np.where((positions == 0).all(axis=2)[:, :, None], np.nan, positions)
