"""Frame rates from what files say about time."""

import numpy as np
from numpy.typing import NDArray

REGULAR = 0.02  # largest departure of a step from the median step, as share of it, at a constant rate


def rate_of_step(step: str) -> float:
    """Return the rate that a printed time between frames stands for.

    A whole rate is meant where the printed digits allow it: "0.008333" is 120 Hz, not 120.0048;
    "0.0417083750417" stays 23.976 Hz.

    Args:
        step: Seconds as written in the file.

    Returns:
        Rate in Hz; NaN if there is none.

    Example:
        >>> rate_of_step(".0083333")
        120.0
    """
    try:
        seconds = float(step)
    except ValueError:
        return float("nan")
    if not 1e-9 < seconds < 1e9:
        return float("nan")
    mantissa, _, exponent = step.lower().partition("e")
    resolution = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    whole = max(1, round(1 / seconds))
    if abs(1 / whole - seconds) < min(resolution, 2e-3 * seconds):
        return float(whole)
    return 1 / seconds


def rate_of_times(times: NDArray[np.float64]) -> float | None:
    """Return the rate of frames at these times, or None if they do not come at a constant rate.

    Args:
        times: (n,) seconds.
    """
    steps = np.diff(times)
    if not len(steps) or not (np.isfinite(steps).all() and (steps > 0).all()):
        return None
    step = (times[-1] - times[0]) / len(steps)
    if np.abs(steps - step).max() > REGULAR * step:
        return None
    whole = max(1, round(1 / step))
    return float(whole) if abs(whole * step - 1) < 1e-3 else float(1 / step)
