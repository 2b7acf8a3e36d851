"""The measures, as Python knows them: their parameters and requirements.

A measure is a module with

    set_params(params, settings, joints, padded_joints, center)     its record of parameters, of one element
    slot_size(params)                                               length of a summary
    traits()                                                        requirements on frames and key frames
    takes_pose(params)                                              whether frames are added as one array
    are_sound(params, slots)                                        whether summaries from outside are valid

and its functions on summaries in the core, which `protocol.pxi` chooses from.
"""

from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import DURATION, RECORDS, SHORTEST_SEGMENT
from mossar_stream.settings import ResolvedSettings, SimilarityName
from mossar_stream.similarity import evidence, likelihood
from mossar_stream.similarity.path_kernel import kernel as path_kernel
from mossar_stream.similarity.summary import Traits

# In the order of their kinds in protocol.pxi; the names are those of their records in `Measure`.
MEASURES: dict[SimilarityName, ModuleType] = {
    "evidence": evidence,
    "likelihood": likelihood,
    "path_kernel": path_kernel,
}


def make_params(settings: ResolvedSettings, joints: int, padded_joints: int, center: int) -> NDArray[np.void]:
    """Return the parameters of the measure that the settings name, as a one-element record array."""
    params = np.zeros(1, RECORDS["Measure"])
    params["kind"] = list(MEASURES).index(settings.similarity)
    MEASURES[settings.similarity].set_params(
        params[settings.similarity], settings, joints, padded_joints, center
    )
    return params


def slot_size(settings: ResolvedSettings, params: NDArray[np.void]) -> int:
    """Return the length of a summary, float64 numbers."""
    return MEASURES[settings.similarity].slot_size(params[settings.similarity])  # type: ignore[no-any-return]


def traits(settings: ResolvedSettings) -> Traits:
    """Return the requirements of the measure that the settings name."""
    return MEASURES[settings.similarity].traits()  # type: ignore[no-any-return]


def takes_pose(settings: ResolvedSettings, params: NDArray[np.void]) -> bool:
    """Return whether `add_frame` reads the pose as one array."""
    return MEASURES[settings.similarity].takes_pose(params[settings.similarity])  # type: ignore[no-any-return]


def are_sound(settings: ResolvedSettings, params: NDArray[np.void], slots: NDArray[np.float64]) -> bool:
    """Return whether summaries from outside are valid.

    Durations must be numbers of seconds, except for the rounding when poses are taken out: the core searches the smallest
    cost, and would never find one that is NaN.

    Args:
        settings: They name the measure.
        params: Of `make_params`.
        slots: (n, slot).
    """
    durations = slots[:, DURATION]
    if not (np.isfinite(durations) & (durations > -SHORTEST_SEGMENT)).all():
        return False
    return MEASURES[settings.similarity].are_sound(params[settings.similarity], slots)  # type: ignore[no-any-return]
