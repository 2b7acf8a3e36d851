"""Smoothing: the maker's One-Euro filters, which take the jitter of single pictures off points that stay.

G. Casiez, N. Roussel, D. Vogel, "1 Euro Filter", CHI 2012; the settings are those of pose_landmark_filtering.pbtxt.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

WORLD: Final = (0.1, 40.0)  # Hz, Hz per m/s
PICTURE: Final = (0.05, 80.0)  # Hz, Hz per body size/s
REGION: Final = (0.01, 10.0)  # Hz, Hz per body size/s
_DERIVATIVE: Final = 1.0  # Hz
_LEAST_STEP: Final = 1e-4  # s


class OneEuro:
    """Filters an array of successive values.

    Args:
        cutoff: Least cut-off frequency, Hz.
        beta: By which the cut-off rises, Hz for each unit/s.
    """

    def __init__(self, cutoff: float, beta: float) -> None:
        self._cutoff, self._beta = cutoff, beta
        self._time = 0.0
        self._raw: NDArray[np.float64] | None = None
        self._value = self._slope = np.zeros(0)

    def __call__(self, value: NDArray[np.float64], time: float, scale: float = 1.0) -> NDArray[np.float64]:
        """Return the filtered value.

        Args:
            value: Of any shape, the same each time.
            time: s, later each time.
            scale: Factor of the value's unit before speeds are compared.
        """
        if self._raw is None:
            self._value, self._slope = value, np.zeros_like(value)
        else:
            step = max(time - self._time, _LEAST_STEP)
            slope = (value - self._raw) * scale / step
            self._slope = self._slope + _share(_DERIVATIVE, step) * (slope - self._slope)
            cutoff = self._cutoff + self._beta * np.abs(self._slope)
            self._value = self._value + _share(cutoff, step) * (value - self._value)
        self._raw, self._time = value, time
        return self._value


def _share(cutoff: float | NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Return the share of the new value: that of a low pass of first order."""
    return np.asarray(1.0 / (1.0 + 1.0 / (2 * math.pi * np.asarray(cutoff) * step)))
