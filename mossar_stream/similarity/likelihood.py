"""The parameters of the likelihood; `likelihood.pxi` has the measure."""

import math

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import PATH
from mossar_stream.settings import ResolvedSettings
from mossar_stream.similarity.summary import Traits
from mossar_stream.similarity.sums import set_sums, sums_end

MOST_DISTANCES = 120  # about as many joint pairs as carry information; more only cost time


def set_params(
    params: NDArray[np.void], settings: ResolvedSettings, joints: int, padded_joints: int, center: int
) -> None:
    """Set the parameters.

    Args:
        params: (1,) record, zero.
        settings: Of the segmenter.
        joints: J.
        padded_joints: J, padded to a multiple of `PADDING`.
        center: Index of the root, -1 for the centroid.
    """
    weights, floors = settings.features, settings.variance_floor
    moving = max(1, joints - 1 if center >= 0 else joints)
    half = max(1, joints // 2)
    stride = max(1, round(joints * half / MOST_DISTANCES))
    offsets = math.ceil(half / stride) if weights.distances and joints > 1 else 0
    set_sums(
        params["sums"],
        PATH + padded_joints,
        3 * padded_joints if weights.positions else 0,
        padded_joints if weights.log_speed else 0,
        offsets * padded_joints,
    )
    params["offsets"], params["stride"] = offsets, stride
    params["moving_joints"], params["joints"] = moving, joints
    params["position_weight"] = weights.positions / (3 * moving)
    params["speed_weight"] = weights.log_speed / moving
    params["distance_weight"] = weights.distances / max(1, offsets * joints)
    params["position_floor"], params["speed_floor"] = floors.positions, floors.log_speed
    params["distance_floor"] = floors.distances
    params["short_segment"] = settings.short_segment


def slot_size(params: NDArray[np.void]) -> int:
    """Return the length of a summary, float64 numbers."""
    return sums_end(params["sums"])


def traits() -> Traits:
    """Return the requirements on frames and key frames."""
    return Traits(is_mean=True)


def takes_pose(params: NDArray[np.void]) -> bool:
    """Return whether `add_frame` reads the pose as one array: for distances."""
    return bool(params["offsets"][0])


def are_sound(_params: NDArray[np.void], _slots: NDArray[np.float64]) -> bool:
    """Return whether summaries from outside are valid; none of their numbers is used as an index."""
    return True
