"""Stumpy FLOSS: stumpy's FLOSS, fast low-cost online semantic segmentation, on the velocity curve."""

import numpy as np
from numpy.typing import NDArray

from checks.peers.peer import Causal, Parameters, Peer

TREMBLE = 1e-3  # m/s, of the stillness before a take, which must not be constant
SEED = 1


def stillness(count: int) -> NDArray[np.float64]:
    """Return stillness before a take, (count,) m/s, so that set-up is over when the take begins."""
    return TREMBLE * np.abs(np.random.default_rng(SEED).standard_normal(count))


class FlossDetector(Causal):
    """FLOSS over a buffer that is at first filled with stillness; a deep minimum of its corrected arc curve is a cut.

    Args:
        fps: Rate, Hz.
        buffer: s.
        subsequence: Length of the patterns, s.
        threshold: Of the corrected arc curve, below which a minimum is a cut.
        least_gap: s between cuts, at least.
        rate: Hz to which frames are thinned out: each costs milliseconds.
    """

    def __init__(
        self, fps: float, buffer: float, subsequence: float, threshold: float, least_gap: float, rate: float
    ) -> None:
        self._thin = max(1, round(fps / rate))
        self._fps, self._threshold, self._least_gap = fps / self._thin, threshold, least_gap
        self._count = round(buffer * self._fps)
        pattern = max(4, round(subsequence * self._fps))
        self._seen = 0
        self._cuts: list[float] = []
        import numba
        from stumpy import floss, stump

        numba.set_num_threads(1)  # its threads would wait for each other longer than they work
        still = stillness(self._count)
        profile = stump(still, m=pattern)
        self._floss = floss(profile, still, m=pattern, L=pattern, excl_factor=1, n_iter=100)

    def update(self, sample: NDArray[np.float64], time: float) -> list[float]:
        """See `Detector`."""
        self._seen += 1
        if (self._seen - 1) % self._thin:
            return []
        self._floss.update(float(sample[0]))
        curve = self._floss.cac_1d_
        place = int(np.argmin(curve))
        if curve[place] >= self._threshold:
            return []
        cut = time - (self._count - 1 - place) / self._fps
        if any(abs(cut - other) < self._least_gap for other in self._cuts):
            return []
        self._cuts.append(cut)
        return [cut]


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
        "subsequence": (0.15, 0.25, 0.5),
        "threshold": (0.45, 0.65, 0.8, 0.9),
        "least_gap": (1.0,),
        "rate": (30.0,),
    },
    {
        "cluster": {"buffer": 5.0, "subsequence": 0.25, "threshold": 0.9, "least_gap": 1.0, "rate": 30.0},
        "motion": {"buffer": 10.0, "subsequence": 0.15, "threshold": 0.8, "least_gap": 1.0, "rate": 30.0},
    },
)
