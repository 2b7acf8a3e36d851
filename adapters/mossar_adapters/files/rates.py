"""Frame rates from the times in files."""

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.options import plausible_rate

USUAL_FPS = 30.0  # where a file does not state it
JITTER = 0.25  # share of the median step by which most steps may depart from it
_USUAL = (
    10,
    15,
    20,
    24,
    25,
    30,
    48,
    50,
    60,
    72,
    75,
    90,
    100,
    120,
    125,
    144,
    150,
    200,
    240,
    250,
    300,
    500,
    1000,
)
NEARLY_USUAL = 0.03  # share by which a rate measured on a coarse clock may depart from the true one
NEARLY_WHOLE = 5e-4  # a rate nearer than this to a whole one is that one; 23.976 is not 24


def rate_of_step(step: str) -> float:
    """Return the rate that a printed time between frames stands for.

    A usual or at least a whole rate is chosen where the printed digits allow it: "0.008333" is 120 Hz, not
    120.0048, and "0.033" is 30 Hz; "0.0417083750417" stays 23.976 Hz.

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
    usual = min(_USUAL, key=lambda fps: abs(1 / fps - seconds))
    for fps, nearly in ((usual, 0.05), (max(1, round(1 / seconds)), 2e-3)):
        if abs(1 / fps - seconds) < min(resolution, nearly * seconds):
            return float(fps)
    return 1 / seconds


def rate_of_times(times: NDArray[np.float64]) -> float | None:
    """Return the nominal rate of frames at these times, or None if they come too irregularly to have one.

    Args:
        times: (n,) seconds.
    """
    steps = np.diff(times)
    steps = steps[np.isfinite(steps) & (steps > 0)]
    if not len(steps):
        return None
    usual = np.abs(steps - np.median(steps)) <= JITTER * np.median(steps)
    if 2 * usual.sum() < len(steps):
        return None
    step = float(steps[usual].mean())
    whole = max(1, round(1 / step))
    fps = float(whole) if abs(whole * step - 1) < NEARLY_WHOLE else 1 / step
    return fps if plausible_rate(fps) else None


def nearly_usual(fps: float) -> float:
    """Return the usual rate that a measured one is near, Hz; else the measured one.

    Example:
        >>> nearly_usual(29.6), nearly_usual(41.0)
        (30.0, 41.0)
    """
    usual = min(_USUAL, key=lambda rate: abs(rate - fps))
    return float(usual) if abs(usual - fps) <= NEARLY_USUAL * usual else fps


def assumed_rate(why: str, fps: float = USUAL_FPS) -> str:
    """Return the note about a rate that a file does not state."""
    return f"rate taken as {fps:.4g} Hz ({why}); set --fps to change"
