"""Player: where in a recording we are, on the wall clock."""

import threading
import time


class Player:
    """A playhead that moves by itself. Any thread may call any method.

    Args:
        start: Begin of the recording, s.
        end: End of it, s; the playhead goes back to the start from there.
        speed: Seconds of the recording per second.
    """

    def __init__(self, start: float, end: float, speed: float = 1.0) -> None:
        self.start = start
        self.end = max(end, start)
        self._speed = speed
        self._paused = False
        self._place = start  # s, at the moment below
        self._since = time.monotonic()  # s
        self._lock = threading.Lock()

    @property
    def place(self) -> float:
        """Time of the playhead, s."""
        with self._lock:
            return self._now()

    @property
    def paused(self) -> bool:
        """Whether it stands still; setting it acts at once."""
        return self._paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        with self._lock:
            self._settle()
            self._paused = paused

    @property
    def speed(self) -> float:
        """Seconds of the recording per second; setting it acts at once."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        with self._lock:
            self._settle()
            self._speed = speed

    def seek(self, place: float) -> None:
        """Put the playhead somewhere, s."""
        with self._lock:
            self._place = min(max(place, self.start), self.end)
            self._since = time.monotonic()

    def _settle(self) -> None:
        self._place, self._since = self._now(), time.monotonic()

    def _now(self) -> float:
        if self._paused or self.end <= self.start:
            return self._place
        gone = self._place - self.start + (time.monotonic() - self._since) * self._speed
        return self.start + gone % (self.end - self.start)
