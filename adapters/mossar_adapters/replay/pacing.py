"""Pacing: makes frames leave at their own time, for replays and the built-in performer."""

import math
import threading
import time
from typing import Final, Literal

_NAP: Final = 0.05  # s, the longest sleep: interruptions and pauses are noticed after it at the latest
_FINE: Final = 0.02  # s; below it plain sleep, which wakes up more precisely than waiting for an event


class Pacer:
    """Waits for the wall-clock time that belongs to a source time.

    The first `wait_until` returns at once and ties its source time to the present. Deadlines are absolute, so
    that delays do not add up: after a stall the frames that are due leave without waiting.

    Args:
        speed: Source seconds per second, or "max" for no waiting.

    Raises:
        ValueError: If `speed` is neither a positive number nor "max".

    Example:
        >>> pacer = Pacer("max")
        >>> pacer.wait_until(0.0), pacer.wait_until(3600.0)
        (True, True)
    """

    def __init__(self, speed: float | Literal["max"] = 1.0) -> None:
        if speed != "max" and not 0 < speed < math.inf:
            raise ValueError(f"speed must be a positive number or 'max', not {speed!r}")
        self.speed = speed
        # Wall-clock seconds per source second, 0 for "max".
        self._seconds = 0.0 if speed == "max" else 1.0 / speed
        self._lock = threading.Lock()
        self._origin: float | None = None  # monotonic s at source time 0
        self._paused_at: float | None = None  # monotonic s
        self._interrupted = threading.Event()

    def wait_until(self, source_time: float, timeout: float | None = None) -> bool:
        """Wait until `source_time` (s) is due.

        Args:
            source_time: Seconds on the source's clock.
            timeout: Seconds of wall time after which to give up.

        Returns:
            True when it is due; False if the wait was interrupted or timed out.
        """
        give_up = math.inf if timeout is None else time.monotonic() + timeout
        while not self._interrupted.is_set():
            now = time.monotonic()
            left = self._left(source_time, now)
            if left <= 0:
                return True
            if now >= give_up:
                return False
            self._sleep(min(left, give_up - now))
        return False

    def pause(self) -> None:
        """Let nothing become due until `resume`. Any thread may call it."""
        with self._lock:
            if self._paused_at is None:
                self._paused_at = time.monotonic()

    def resume(self) -> None:
        """Continue after `pause`."""
        with self._lock:
            if self._paused_at is not None and self._origin is not None:
                self._origin += time.monotonic() - self._paused_at
            self._paused_at = None

    def interrupt(self) -> None:
        """End the present wait and all later ones. Any thread may call it."""
        self._interrupted.set()

    def _left(self, source_time: float, now: float) -> float:
        with self._lock:
            if self._paused_at is not None:
                return math.inf
            if self._origin is None:
                self._origin = now - source_time * self._seconds
                return 0.0
            return (self._origin + source_time * self._seconds - now) if self._seconds else 0.0

    def _sleep(self, seconds: float) -> None:
        if seconds > _FINE:
            self._interrupted.wait(min(seconds - _FINE / 2, _NAP))
        else:
            time.sleep(seconds)
