"""River drift: river's ADWIN and Page-Hinkley test on the velocity curve."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from checks.peers.peer import Causal, Parameters, Peer


class DriftDetector(Causal):
    """A drift detector of river; a drift is a cut.

    Args:
        fps: Rate, Hz.
        detector: Of river.
        place: `now`, or `window`: the begin of ADWIN's window after it has dropped older samples.
    """

    def __init__(self, fps: float, detector: Any, place: str = "now") -> None:
        self._fps = fps
        self._detector = detector
        self._in_window = place == "window"

    def update(self, sample: NDArray[np.float64], time: float) -> list[float]:
        """See `Detector`."""
        self._detector.update(float(sample[0]))
        if not self._detector.drift_detected:
            return []
        return [time - self._detector.width / self._fps if self._in_window else time]


def _adwin(fps: float, parameters: Parameters) -> DriftDetector:
    from river.drift import ADWIN

    place = str(parameters["place"])
    rest = {name: value for name, value in parameters.items() if name != "place"}
    return DriftDetector(fps, ADWIN(grace_period=5, **rest), place)


def _page_hinkley(fps: float, parameters: Parameters) -> DriftDetector:
    from river.drift import PageHinkley

    seconds = float(parameters["min_seconds"])
    rest = {name: value for name, value in parameters.items() if name != "min_seconds"}
    # The threshold is in units of the curve times seconds, so that it means the same at every rate.
    rest["threshold"] = float(rest["threshold"]) * fps
    return DriftDetector(fps, PageHinkley(min_instances=max(1, round(seconds * fps)), **rest))


ADWIN = Peer(
    "river ADWIN",
    "river",
    "river",
    "curve",
    _adwin,
    {
        "delta": (1e-6, 1e-4, 0.002, 0.05, 0.2, 0.5, 0.9, 0.99),
        "clock": (1, 8, 32, 128),
        "place": ("now", "window"),
    },
    {
        "cluster": {"delta": 1e-4, "clock": 128, "place": "window"},
        "motion": {"delta": 0.99, "clock": 1, "place": "now"},
    },
)
PAGE_HINKLEY = Peer(
    "river Page-Hinkley",
    "river",
    "river",
    "curve",
    _page_hinkley,
    {
        "delta": (0.005, 0.05, 0.2),
        "threshold": (0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2),
        "min_seconds": (0.1, 0.25, 1.0, 2.0, 4.0),
    },
    {
        "cluster": {"delta": 0.05, "threshold": 0.05, "min_seconds": 4.0},
        "motion": {"delta": 0.05, "threshold": 0.02, "min_seconds": 1.0},
    },
)
