"""Ruptures Window: ruptures' window method, which segments whole signals, put over the last seconds again and again."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from checks.peers.peer import Causal, Parameters, Peer


class WindowDetector(Causal):
    """Segments the last seconds anew at every step, and takes over the change points that are new.

    Args:
        fps: Rate, Hz.
        buffer: s that are segmented.
        step: s between two segmentations.
        width: Of ruptures' window, s.
        penalty: Least decrease of the summed squares by a change point, m².
        rate: Hz to which frames are thinned out.
    """

    def __init__(
        self, fps: float, buffer: float, step: float, width: float, penalty: float, rate: float
    ) -> None:
        self._thin = max(1, round(fps / rate))
        own = fps / self._thin
        self._step = max(1, round(step * own))
        self._width = max(4, round(width * own))
        self._penalty = penalty
        self._kept: deque[tuple[float, NDArray[np.float64]]] = deque(maxlen=max(8, round(buffer * own)))
        self._seen = 0
        self._cuts: list[float] = []
        self._least_gap = width / 2

    def update(self, sample: NDArray[np.float64], time: float) -> list[float]:
        """See `Detector`."""
        self._seen += 1
        if (self._seen - 1) % self._thin:
            return []
        self._kept.append((time, sample))
        enough = len(self._kept) > self._width + 2
        if not enough or (self._seen - 1) // self._thin % self._step:
            return []
        from ruptures import Window

        times, rows = zip(*self._kept, strict=True)
        found = Window(width=self._width, model="l2", jump=1).fit_predict(np.array(rows), pen=self._penalty)
        fresh: list[float] = []
        for place in found[:-1]:
            cut = times[place]
            if all(abs(cut - other) >= self._least_gap for other in self._cuts):
                self._cuts.append(cut)
                fresh.append(cut)
        return fresh


def _window(fps: float, parameters: Parameters) -> WindowDetector:
    return WindowDetector(fps, **{name: float(value) for name, value in parameters.items()})


WINDOW = Peer(
    "ruptures Window, sliding",
    "ruptures",
    "ruptures",
    "poses",
    _window,
    {
        "buffer": (4.0, 10.0),
        "step": (0.25,),
        "width": (0.5, 1.0, 2.0),
        "penalty": (1.0, 4.0, 16.0, 32.0, 64.0),
        "rate": (15.0,),
    },
    {
        "cluster": {"buffer": 10.0, "step": 0.25, "width": 2.0, "penalty": 32.0, "rate": 15.0},
        "motion": {"buffer": 4.0, "step": 0.25, "width": 2.0, "penalty": 1.0, "rate": 15.0},
    },
)
