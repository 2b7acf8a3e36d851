"""Steady times for frames whose arrival is all that is known.

A camera takes its frames evenly; the computers between it and us deliver them unevenly. Frames that arrive late and
then early look like a body that brakes and jumps. A line is therefore laid through the arrivals, by least squares over
those so far and then over about the last `MEMORY` (an expanding and then fading memory, in the words of N. Morrison,
Introduction to Sequential Smoothing and Prediction, 1969), and a frame gets its place on the line.
"""

import copy
from typing import Final

MEMORY: Final = 120  # frames
LOST: Final = 0.25  # s; frames so far from the line are not late: the sender paused, or has another rate now
_LEAST: Final = 1e-4  # s from frame to frame


class Steady:
    """The times of one performer's frames.

    Example:
        >>> steady = Steady()
        >>> late = [0.0, 0.0, 0.02, 0.0, 0.01]  # s
        >>> [round(steady.time(k / 10 + late[k % 5]) - k / 10, 3) for k in range(300)][-5:]
        [0.006, 0.006, 0.006, 0.006, 0.006]
    """

    def __init__(self) -> None:
        self._count = 0  # arrivals that the line goes through, at most MEMORY
        self._place = 0.0  # s, of the latest frame on the line
        self._step = 0.0  # s from frame to frame on the line
        self._latest = float("-inf")  # s, that were given

    def follows(self, arrival: float) -> bool:
        """Return whether the next frame of the line may be one that came at a time, s."""
        return self._count > 1 and abs(arrival - self._place - self._step) <= min(LOST, self._step)

    def copy(self) -> "Steady":
        """Return one with the same line, for another performer of the same camera."""
        return copy.copy(self)

    def time(self, arrival: float) -> float:
        """Return the time of the next frame, later than that of the frame before.

        Args:
            arrival: Time of arrival, s.
        """
        error = arrival - self._place - self._step
        if self._count < 2 or abs(error) > LOST:
            self._begin(arrival)
        else:
            k = self._count = min(self._count + 1, MEMORY)
            self._place += self._step + error * 2 * (2 * k - 1) / (k * (k + 1))
            self._step += error * 6 / (k * (k + 1))
        self._latest = max(self._place, self._latest + _LEAST)
        return self._latest

    def _begin(self, arrival: float) -> None:
        """Lay the line through two arrivals; through one if the other is too far."""
        step = arrival - self._place
        follows = self._count == 1 and abs(step) <= LOST
        self._count, self._place, self._step = (2, arrival, step) if follows else (1, arrival, 0.0)
