"""The conventional velocity-based method (paper 2.1): key frames where the velocity crosses a threshold.

The velocity is not normalised, the threshold is in metres of path, summed over the joints, within the window.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Settings, segment_recording
from mossar_tools.evaluation.detection import Detection, Method, Variants
from mossar_tools.evaluation.mossar import at_level_of
from mossar_tools.evaluation.takes import Take

THRESHOLDS = tuple(np.geomspace(0.02, 20.0, 41).round(3).tolist())  # m


def velocity_based(settings: Settings) -> Method:
    """Return the method, on the same curve as Mossar's."""

    def run(take: Take) -> Variants:
        times, curve = velocity(take, settings)
        return {f"{threshold:g} m": crossings(times, curve, threshold) for threshold in THRESHOLDS}

    return Method("velocity-based (2.1)", ("best for all", "best each"), run, online=True)


def velocity(take: Take, settings: Settings) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times (s) and the velocity of equation 1, smoothed by the settings, m, frame by frame."""
    # Evidence measures the speed in another way.
    chosen = at_level_of(take, settings.replace(similarity=settings.similarity or "likelihood")).replace(
        range="running"
    )
    result = segment_recording(take.positions, take.fps, take.skeleton, chosen, times=take.times, curves=True)
    times = np.array([state.time for state in result.curves])
    return times, np.array([state.value * state.scale for state in result.curves])


def crossings(times: NDArray[np.float64], curve: NDArray[np.float64], threshold: float) -> Detection:
    """Return the first frames on the other side of a threshold; a value at the threshold counts as resting."""
    above = curve > threshold
    return Detection(times[1:][above[1:] != above[:-1]].tolist())
