"""The parameters and the weights of the evidence; `evidence.pxi` has the measure."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core import kernels
from mossar_stream.core.kernels import FEATURES, PATH
from mossar_stream.settings import ResolvedSettings
from mossar_stream.similarity.summary import Traits
from mossar_stream.similarity.sums import set_sums, sums_end


class Weights(NamedTuple):
    """Weights of the terms, log odds for each of their units, and the sum that they must exceed."""

    change_of_pose: float
    change_of_speed: float
    stop: float
    rest: float
    rest_distance: float
    bias: float


WEIGHTS = Weights(*kernels.WEIGHTS)
LARGEST = Weights(change_of_pose=6.0, change_of_speed=14.0, stop=6.0, rest=2.0, rest_distance=4.0, bias=6.0)


def set_params(
    params: NDArray[np.void], _settings: ResolvedSettings, _joints: int, padded_joints: int, _center: int
) -> None:
    """Set the parameters.

    Args:
        params: (1,) record, zero.
        padded_joints: J, padded to a multiple of `PADDING`.
    """
    params["features"] = PATH + padded_joints
    set_sums(params["sums"], PATH + padded_joints + FEATURES, 3 * padded_joints, padded_joints, 0)


def slot_size(params: NDArray[np.void]) -> int:
    """Return the length of a summary, float64 numbers."""
    return sums_end(params["sums"])


def traits() -> Traits:
    """Return the requirements on frames and key frames."""
    return Traits(is_filtered=True, is_rms=True, has_features=True)


def takes_pose(_params: NDArray[np.void]) -> bool:
    """Return whether `add_frame` reads the pose as one array: it does not."""
    return False


def are_sound(_params: NDArray[np.void], _slots: NDArray[np.float64]) -> bool:
    """Return whether summaries from outside are valid; none of their numbers is used as an index."""
    return True
