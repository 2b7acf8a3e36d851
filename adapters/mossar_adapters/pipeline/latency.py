"""Latency: the time from the arrival of a frame until its event is handed over."""

import threading
from collections import deque

import numpy as np

KEPT = 2048  # latest delays that the quantiles are taken of


class Latency:
    """Quantiles of the latest delays. Any thread may call any method.

    Example:
        >>> delays = Latency()
        >>> for ms in range(1, 101):
        ...     delays.add(ms / 1000)
        >>> delays.quantiles_ms()
        (50.5, 99.01)
    """

    def __init__(self) -> None:
        self._delays: deque[float] = deque(maxlen=KEPT)  # s; a performer seen once holds little
        self._lock = threading.Lock()

    def add(self, seconds: float) -> None:
        """Add a delay, s."""
        with self._lock:
            self._delays.append(seconds)

    def quantiles_ms(self) -> tuple[float, float] | None:
        """Return the median and the 99th percentile in ms, None before the first delay."""
        with self._lock:
            delays = tuple(self._delays)
        if not delays:
            return None
        median, high = np.quantile(delays, (0.5, 0.99)) * 1000
        return round(float(median), 3), round(float(high), 3)
