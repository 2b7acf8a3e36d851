"""Faults of frames between a performer and the segmentation."""

import random
from collections import Counter

import numpy as np
from numpy.typing import NDArray

_LOSSES, _COPIES, _DELAYS, _GAPS = 0.01, 0.01, 0.01, 0.004  # share of frames at which each fault begins


class Faults:
    """Loses, repeats, delays and damages frames.

    Args:
        rng: Where chance comes from.
    """

    def __init__(self, rng: random.Random) -> None:
        self.injected: Counter[str] = Counter()
        self._rng = rng

    def deliver(
        self, positions: NDArray[np.float32], times: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """Return the arriving frames of a stretch, in the order of arrival.

        Args:
            positions: (n, J, 3) metres; left alone.
            times: (n,) s.
        """
        positions = positions.copy()
        self._hide_joints(positions)
        order = list(range(len(times)))
        order = self._lose(order)
        order = self._repeat(order)
        self._delay(order)
        return positions[order], times[order]

    def clock_jump(self) -> float:
        """Return the jump of the sender's clock, s; mostly 0."""
        if self._rng.random() < 0.9:
            return 0.0
        self.injected["clock jumps"] += 1
        return self._rng.choice((self._rng.uniform(5, 1000), -self._rng.uniform(25, 60)))

    def _count(self, share: float, frames: int) -> int:
        return sum(self._rng.random() < share for _ in range(frames))

    def _hide_joints(self, positions: NDArray[np.float32]) -> None:
        frames, joints = positions.shape[:2]
        for _ in range(self._count(_GAPS, frames)):
            begin, length = self._rng.randrange(frames), self._rng.randint(1, 60)
            hidden = self._rng.sample(range(joints), self._rng.randint(1, joints))
            positions[begin : begin + length, hidden] = np.nan
            self.injected["joints vanished"] += len(hidden)

    def _lose(self, order: list[int]) -> list[int]:
        lost: set[int] = set()
        for _ in range(self._count(_LOSSES, len(order))):
            begin = self._rng.randrange(len(order))
            lost.update(range(begin, begin + self._rng.choice((1, 1, 1, 2, 5, 20))))
        kept = [i for i in order if i not in lost]
        self.injected["frames lost"] += len(order) - len(kept)
        return kept

    def _repeat(self, order: list[int]) -> list[int]:
        twice = {self._rng.randrange(len(order)) for _ in range(self._count(_COPIES, len(order)))}
        self.injected["frames repeated"] += len(twice)
        return [i for place, i in enumerate(order) for _ in range(2 if place in twice else 1)]

    def _delay(self, order: list[int]) -> None:
        for _ in range(self._count(_DELAYS, len(order))):
            place = self._rng.randrange(len(order))
            order.insert(min(len(order), place + self._rng.randint(1, 8)), order.pop(place))
            self.injected["frames out of order"] += 1
