"""Arcs: stumpy's FLOSS, fast low-cost online semantic segmentation, on the velocity curve."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_tools.bench.peers.peer import Causal, Parameters, Peer

TREMBLE = 1e-3  # m/s, of the stillness before a take, which must not be constant
SEED = 1


class FlossDetector(Causal):
    """FLOSS over a buffer that is at first filled with stillness; a deep minimum of its corrected arc curve is a cut.

    Args:
        fps: Rate, Hz.
        buffer: s.
        subsequence: Length of the patterns, s.
        threshold: Of the corrected arc curve, below which a minimum is a cut.
        apart: s between cuts, at least.
    """

    def __init__(self, fps: float, buffer: float, subsequence: float, threshold: float, apart: float) -> None:
        self._fps, self._threshold, self._apart = fps, threshold, apart
        self._count = round(buffer * fps)
        self._pattern = max(4, round(subsequence * fps))
        self._floss: Any = None
        self._cuts: list[float] = []

    def update(self, sample: NDArray[np.float64], time: float) -> list[float]:
        """See `Detector`."""
        if self._floss is None:
            self._start(float(sample[0]))
        self._floss.update(float(sample[0]))
        curve = self._floss.cac_1d_
        place = int(np.argmin(curve))
        if curve[place] >= self._threshold:
            return []
        cut = time - (self._count - 1 - place) / self._fps
        if any(abs(cut - other) < self._apart for other in self._cuts):
            return []
        self._cuts.append(cut)
        return [cut]

    def _start(self, level: float) -> None:
        from stumpy import floss, stump

        still = level + TREMBLE * np.random.default_rng(SEED).standard_normal(self._count)
        profile = stump(still, m=self._pattern)
        self._floss = floss(profile, still, m=self._pattern, L=self._pattern, excl_factor=1, n_iter=100)


def _floss(fps: float, parameters: Parameters) -> FlossDetector:
    return FlossDetector(fps, **{name: float(value) for name, value in parameters.items()})


FLOSS = Peer(
    "stumpy FLOSS",
    "stumpy",
    "stumpy",
    "curve",
    _floss,
    {
        "buffer": (5.0, 10.0),
        "subsequence": (0.25, 0.5),
        "threshold": (0.25, 0.45, 0.65),
        "apart": (1.0,),
    },
    {},
)
