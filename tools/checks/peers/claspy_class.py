"""Claspy ClaSS: claspy's streaming ClaSP (ClaSS) on the velocity curve."""

import numpy as np
from numpy.typing import NDArray

from checks.peers.peer import Causal, Parameters, Peer
from checks.peers.stumpy_floss import stillness


class ClaspDetector(Causal):
    """Streaming ClaSP over a sliding buffer that is at first filled with stillness.

    Args:
        fps: Rate, Hz.
        buffer: Sliding window, s.
        window: Length of the patterns, s.
        validation: `score_threshold` or `significance_test`.
        threshold: Its threshold.
        warm_up: s of stillness before the take.
    """

    def __init__(
        self, fps: float, buffer: float, window: float, validation: str, threshold: float, warm_up: float
    ) -> None:
        from claspy.streaming.segmentation import StreamingClaSPSegmentation

        self._fps = fps
        self._warm_up = round(warm_up * fps)
        self._frames = 0
        self._clasp = StreamingClaSPSegmentation(
            n_timepoints=round(buffer * fps),
            n_warmup=self._warm_up,
            window_size=max(4, round(window * fps)),
            validation=validation,
            threshold=threshold,
            log_cps=True,
        )
        for value in stillness(self._warm_up).tolist():
            self._clasp.update(value)

    def update(self, sample: NDArray[np.float64], time: float) -> list[float]:
        """See `Detector`."""
        before = len(self._clasp.change_points)
        self._clasp.update(float(sample[0]))
        self._frames += 1
        now = self._warm_up + self._frames
        found = self._clasp.change_points[before:]
        return [
            cut
            for place in found
            if (cut := time - (now - place) / self._fps) > time - self._frames / self._fps
        ]


def _clasp(fps: float, parameters: Parameters) -> ClaspDetector:
    given = {name: value if name == "validation" else float(value) for name, value in parameters.items()}
    return ClaspDetector(fps, **given)  # type: ignore[arg-type]


CLASP = Peer(
    "claspy streaming ClaSP",
    "claspy",
    "claspy",
    "curve",
    _clasp,
    {
        "buffer": (10.0,),
        "window": (0.15, 0.3, 0.6),
        "validation": ("score_threshold",),
        "threshold": (0.3, 0.4, 0.5, 0.6, 0.75),
        "warm_up": (3.0,),
    },
    {
        "cluster": {
            "buffer": 10.0,
            "window": 0.3,
            "validation": "score_threshold",
            "threshold": 0.5,
            "warm_up": 3.0,
        },
        "motion": {
            "buffer": 10.0,
            "window": 0.15,
            "validation": "score_threshold",
            "threshold": 0.3,
            "warm_up": 3.0,
        },
    },
)
