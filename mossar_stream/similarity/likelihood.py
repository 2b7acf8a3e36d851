"""Likelihood: how much better two segments are described apart than together.

Every dimension of the pose (positions relative to the centre, distances between joints, log speeds) gets a
Gaussian per segment. Merging segments a and b costs

    g = Σ_d w_d [ T_ab log(σ²_ab,d + r) - T_a log(σ²_a,d + r) - T_b log(σ²_b,d + r) ]

with T the durations in seconds and r a floor on the variance. The cost weighs evidence by
duration and needs nothing but sums: it is mergeable, and no frame is kept.
"""

import math

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import kernel
from mossar_stream.jit.simd import FACTORS, variance_product
from mossar_stream.settings import ResolvedSettings
from mossar_stream.similarity import sums
from mossar_stream.similarity.summary import DURATION, PATH, SHORTEST_SEGMENT, TERM, Traits
from mossar_stream.similarity.sums import (
    LOG_OF_2,
    add_all,
    add_features,
    add_pose_sums,
    add_resting_joint,
    set_constant,
)

slot_size, flush_sums = sums.slot_size, sums.flush_sums

# m and m²; joints in one place lie as far apart at least, so that only pairs that do not count have sums of 0.
LEAST_DISTANCE = 1e-12
LEAST_SQUARE = np.float32(LEAST_DISTANCE**2)
MOST_DISTANCES = 120  # about as many joint pairs as carry information; more only cost time

LIKELIHOOD = np.dtype(
    [
        ("start", "i8"),  # where the sums begin in a summary
        ("dimensions", "i8"),  # padded, all groups
        ("positions", "i8"),  # padded dimensions of each group; 0 if it has no weight
        ("speeds", "i8"),
        ("offsets", "i8"),  # number of offsets k of the joint pairs (i, i + k mod J)
        ("stride", "i8"),  # between those offsets
        ("position_weight", "f8"),  # per dimension
        ("speed_weight", "f8"),
        ("distance_weight", "f8"),
        ("position_floor", "f8"),
        ("speed_floor", "f8"),
        ("distance_floor", "f8"),
        ("short", "f8"),  # s, setting short_segment
        ("moving_joints", "i8"),
        ("joints", "i8"),
    ],
)


def make_params(settings: ResolvedSettings, joints: int, padded_joints: int, center: int) -> NDArray[np.void]:
    """Return the parameters of the likelihood as one record, for compiled code.

    Args:
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
    p = np.zeros(1, LIKELIHOOD)
    p["positions"] = 3 * padded_joints if weights.positions else 0
    p["speeds"] = padded_joints if weights.log_speed else 0
    p["offsets"], p["stride"] = offsets, stride
    p["dimensions"] = p["positions"] + p["speeds"] + offsets * padded_joints
    p["start"] = PATH + padded_joints
    p["moving_joints"], p["joints"] = moving, joints
    p["position_weight"] = weights.positions / (3 * moving)
    p["speed_weight"] = weights.log_speed / moving
    p["distance_weight"] = weights.distances / max(1, offsets * joints)
    p["position_floor"], p["speed_floor"] = floors.positions, floors.log_speed
    p["distance_floor"] = floors.distances
    p["short"] = settings.short_segment
    return p


def traits() -> Traits:
    """Return what frames and key frames must be like."""
    return Traits(is_mean=True)


def takes_pose(params: NDArray[np.void]) -> bool:
    """Tell whether `add_frame` looks at the pose as one array: for distances."""
    return bool(params["offsets"][0])


def are_sound(_params: NDArray[np.void], _slots: NDArray[np.float64]) -> bool:
    """Tell whether summaries from outside can be worked on; nothing in these is used as an index."""
    return True


@kernel
def write_features(params, summary, features):
    """Leave out what is known of a key frame: the likelihood asks for segments only."""


@kernel
def add_frame(params, summary, frame):
    """Add one frame to a summary; positions, speeds and paths wait in the body for `flush_sums`.

    Args:
        params: Record of `make_params`.
        summary: Of the segment so far.
        frame: `SummaryFrame`; its pose is looked at for distances only.
    """
    add_features(summary, frame)
    if params.offsets > 0:
        _add_pairs(params, summary, frame.pose, frame.joints, frame.weight)


@kernel
def add_pose(params, summary, pose, joints, time, weight):
    """Add a pose alone, or take it out: to the duration and the sums, not to frames and paths.

    Args:
        params: Record of `make_params`.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1); x is NaN where a joint does not count.
        joints: J.
        time: s, of the pose; what matters here is only how long it lasts.
        weight: s that the pose stands for; negative to take it out.
    """
    add_pose_sums(params, summary, pose, weight)
    if params.offsets > 0:
        _add_pairs(params, summary, pose, joints, weight)


@kernel
def add_joint(params, summary, pose, joints, j):
    """Let a joint have rest where it is for as long as a summary lasts.

    Args:
        params: Record of `make_params`.
        summary: Of the segment.
        pose: (4, padded joints) m relative to the centre (3) and log speed (1); x is NaN where a joint does not count.
        joints: J.
        j: Which joint.
    """
    add_resting_joint(params, summary, pose, j)
    at = params.start + params.positions + params.speeds
    for row in range(params.offsets):
        k = 1 + row * params.stride
        for i in (j, (j - k) % joints):
            other = (i + k) % joints
            x, y, z = pose[0, i] - pose[0, other], pose[1, i] - pose[1, other], pose[2, i] - pose[2, other]
            distance = np.sqrt(x * x + y * y + z * z)
            distance = max(distance, np.float32(LEAST_DISTANCE)) if distance >= 0.0 else np.float32(0.0)
            set_constant(params, summary, at + i, distance)
        at += pose.shape[1]


@kernel
def _add_pairs(params, summary, pose, joints, weight):
    """Add the distances of the joint pairs (i, i + k mod J), in two runs without a wrap inside."""
    sums = summary[params.start : params.start + params.dimensions]
    squares = summary[params.start + params.dimensions : params.start + 2 * params.dimensions]
    at = params.positions + params.speeds
    for row in range(params.offsets):
        k = 1 + row * params.stride
        wrapped = at + joints - k
        one, other = sums[at:wrapped], squares[at:wrapped]
        _add_distances(one, other, pose[:, : joints - k], pose[:, k:joints], weight)
        one, other = sums[wrapped : at + joints], squares[wrapped : at + joints]
        _add_distances(one, other, pose[:, joints - k : joints], pose[:, :k], weight)
        at += pose.shape[1]


@kernel
def _add_distances(sums, squares, one, other, weight):
    for i in range(len(sums)):
        x = one[0, i] - other[0, i]
        y = one[1, i] - other[1, i]
        z = one[2, i] - other[2, i]
        square = x * x + y * y + z * z
        # NaN: one of the two does not count.
        square = max(square, LEAST_SQUARE) if square >= 0.0 else np.float32(0.0)
        sums[i] += weight * np.sqrt(square)
        squares[i] += weight * square


@kernel
def merge_into(params, target, other):
    """Make `target` the summary of both segments, `other` being the later one; sums know no order."""
    add_all(target, other)


@kernel
def close(params, summary):
    """Set a summary's TERM: T Σ_d w_d log(σ²_d + r)."""
    summary[TERM] = 0.0
    duration = summary[DURATION]
    if duration <= SHORTEST_SEGMENT:
        return
    sums = summary[params.start : params.start + params.dimensions]
    squares = summary[params.start + params.dimensions : params.start + 2 * params.dimensions]
    speeds, distances = params.positions, params.positions + params.speeds
    total = 0.0
    if speeds > 0:
        total += params.position_weight * _log_sum(
            sums[:speeds], squares[:speeds], duration, params.position_floor
        )
    if distances > speeds:
        total += params.speed_weight * _log_sum(
            sums[speeds:distances], squares[speeds:distances], duration, params.speed_floor
        )
    if params.offsets > 0:
        total += (
            params.distance_weight
            * _presence(params, squares[distances:])
            * _log_sum(sums[distances:], squares[distances:], duration, params.distance_floor)
        )
    summary[TERM] = duration * total


@kernel
def _presence(params, squares):
    """Return by what to multiply the sum over pairs of joints where some of them do not count.

    Costs are scaled by the share of joints that count when they are used (`rank`, window.py). Of the pairs a smaller
    share counts: m (m - 1) of J (J - 1) where m joints count, of which the root does not move.

    Args:
        params: Record of `make_params`.
        squares: (offsets * padded joints,) m² s, weighted sums of squared distances; 0 for pairs that do not count.
    """
    counted = 0
    for i in range(len(squares)):
        counted += 1 if squares[i] > 0.0 else 0
    if counted == 0 or counted == params.offsets * params.joints:
        return 1.0
    joints, resting = params.joints, params.joints - params.moving_joints
    share = counted / (params.offsets * joints)
    present = 0.5 + np.sqrt(0.25 + share * joints * (joints - 1))
    return (present - resting) / (params.moving_joints * share)


@kernel
def _log_sum(sums, squares, duration, floor):
    """Σ log(σ² + floor): one logarithm for a product of up to 192 variances, 24 in each of `FACTORS`.

    No such product overflows: a variance lies between the least floor, 1e-12, and 1e10 m². The product of all would;
    the exponents are therefore added up apart.
    """
    scale = 1.0 / duration
    total = 0.0
    for begin in range(0, len(sums), 24 * FACTORS):
        end = min(begin + 24 * FACTORS, len(sums))
        mantissa, exponent = variance_product(sums, squares, begin, end, scale, floor)
        total += np.log(mantissa) + exponent * LOG_OF_2
    return total


@kernel
def strength(params, left, right, both):
    """Return the cost of merging two closed neighbours, >= 0.

    Args:
        params: Record of `make_params`.
        left: Summary of the earlier segment, closed.
        right: Summary of the later one, closed.
        both: Set to the summary of both, closed.
    """
    for d in range(len(both)):
        both[d] = left[d] + right[d]
    close(params, both)
    return merge_cost(params, left, right, both)


@kernel
def merge_cost(params, left, right, both):
    """Return the same where `both` is the summary of both already."""
    if not (left[DURATION] > SHORTEST_SEGMENT and right[DURATION] > SHORTEST_SEGMENT):
        return 0.0
    cost = both[TERM] - left[TERM] - right[TERM]
    if params.short > 0.0:
        cost *= min(1.0, left[DURATION] / params.short) * min(1.0, right[DURATION] / params.short)
    return max(0.0, cost)


@kernel
def similarity(params, cost, left, right):
    """Return 1/(1 + cost), in 0..1."""
    return 1.0 / (1.0 + cost)
