"""Evidence: how likely one move ends and the next one begins at a key frame, for any performer and sensor.

What people call a move ends where the movement changes, or where it stops; data sets differ in which. So both kinds of
evidence are added up, each free of units, to log odds:

    change  merge cost of the positions, and of the log speeds, of the segments on both sides (likelihood.py), in
            seconds of the performer's tempo
    stop    prominence: log of the lower of the two sides' peak speeds to the speed at the key frame
    rest    log of that speed to the performer's usual speed
    rest_distance    distance of the pose from the one in which the performer dwells, in the extent of the movements

Peaks that do not rise above the sensor's noise are no evidence. Where movements are repeated, the label of a candidate takes
their place (repetition_labels.py). The strength is log2(1 + e^odds): above 0, rising with the odds, and 1 where they are even.

What is known of the key frame itself stands in the summary of the segment that it ends.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import kernel
from mossar_stream.jit.simd import spread_product
from mossar_stream.memory.joint_pages import PADDING
from mossar_stream.settings import ResolvedSettings
from mossar_stream.similarity import sums
from mossar_stream.similarity.summary import DURATION, PATH, SHORTEST_SEGMENT, TERM, Traits
from mossar_stream.similarity.sums import LOG_OF_2, add_all, add_features, add_pose_sums, add_resting_joint

# A summary's own part begins with the segment's peak speed u, m/s, and `Features` of the key frame that ends it.
AT_PEAK, AT_SPEED, AT_REST_DISTANCE, AT_EXTENT, AT_USUAL_SPEED, AT_TEMPO, AT_NOISE, AT_JOINTS = range(8)
FEATURES = -(-(AT_JOINTS + 1) // PADDING) * PADDING  # numbers


class Features(NamedTuple):
    """What is known of a key frame when it is confirmed, for measures that ask for it.

    Args:
        speed: m/s, lowest u from the candidate to its confirmation (u, A and V: see scales.py).
        rest_distance: A, distance from the pose in which the performer dwells.
        extent: m, A.
        usual_speed: m/s, V.
        tempo: Relative to ordinary.
        noise: m/s, what the sensor's noise adds to u.
        joints: How many count and can move relative to the centre.
    """

    speed: float
    rest_distance: float
    extent: float
    usual_speed: float
    tempo: float
    noise: float
    joints: int


class Weights(NamedTuple):
    """What the terms weigh, log odds for each of their units, and what they must outweigh together."""

    change_of_pose: float
    change_of_speed: float
    stop: float
    rest: float
    rest_distance: float
    bias: float


# Fitted to punches, pick and place, gestures and exercises (the labelled sets precog, vmci, gesture_phase and
# ui_prmd): about what `python -m checks.leave_out SET SET SET SET` chooses on all of them (its row "none"), in the scale
# of the numbers before. It draws from 0 to LARGEST. docs/accuracy.md has what they reach on sets that were left out.
WEIGHTS = Weights(
    change_of_pose=3.8, change_of_speed=10.4, stop=3.4, rest=0.56, rest_distance=1.93, bias=3.66
)
LARGEST = Weights(change_of_pose=6.0, change_of_speed=14.0, stop=6.0, rest=2.0, rest_distance=4.0, bias=6.0)
MOST_CHANGE = 4.0  # s
POSE_FLOOR = 0.15  # A, standard deviation under which poses are alike
SPEED_FLOOR = 0.1  # variance of log speeds under which they are alike
SPEED_FLOOR_OF_ODDS = 0.1  # V, added to the speeds in a prominence
MOST_PROMINENT = 3.0
POSITION_LINES, SPEED_LINES = (
    np.int64(3),
    np.int64(1),
)  # lines of the positions, and of the log speeds, in a summary
MOST_FACTORS = 24  # variances that are multiplied before a logarithm is taken
PEAK_ABOVE_NOISE = 1.0  # times what the noise adds to u, which a peak must reach
CERTAIN = 4.0  # strength of a key frame that ends a repetition

EVIDENCE = np.dtype(
    [
        ("features", "i8"),  # where peak and features begin in a summary
        ("start", "i8"),  # where the sums begin
        ("dimensions", "i8"),  # padded
        ("positions", "i8"),  # of them
        ("speeds", "i8"),
    ],
)
slot_size, flush_sums = sums.slot_size, sums.flush_sums


def make_params(
    _settings: ResolvedSettings, _joints: int, padded_joints: int, _center: int
) -> NDArray[np.void]:
    """Return the parameters as one record, for compiled code.

    Args:
        padded_joints: J, padded to a multiple of `PADDING`.
    """
    p = np.zeros(1, EVIDENCE)
    p["features"] = PATH + padded_joints
    p["start"] = PATH + padded_joints + FEATURES
    p["positions"], p["speeds"], p["dimensions"] = 3 * padded_joints, padded_joints, 4 * padded_joints
    return p


def traits() -> Traits:
    """Return what frames and key frames must be like."""
    return Traits(is_filtered=True, is_rms=True, has_features=True)


def takes_pose(_params: NDArray[np.void]) -> bool:
    """Tell whether `add_frame` looks at the pose as one array: it does not."""
    return False


def are_sound(_params: NDArray[np.void], _slots: NDArray[np.float64]) -> bool:
    """Tell whether summaries from outside can be worked on; nothing in these is used as an index."""
    return True


@kernel
def add_frame(params, summary, frame):
    """Add one frame, a `SummaryFrame`, to a summary, and to the sums in the body that wait."""
    add_features(summary, frame)
    summary[params.features + AT_PEAK] = max(summary[params.features + AT_PEAK], frame.speed)


@kernel
def add_pose(params, summary, pose, joints, time, weight):
    """Add a pose alone, or take it out; the peak stays what it was."""
    add_pose_sums(params, summary, pose, weight)


@kernel
def add_joint(params, summary, pose, joints, j):
    """Let a joint have rest where it is for as long as a summary lasts."""
    add_resting_joint(params, summary, pose, j)


@kernel
def write_features(params, summary, features):
    """Write `Features` of the key frame that ends a segment into its summary."""
    summary[params.features + AT_SPEED] = features.speed
    summary[params.features + AT_REST_DISTANCE] = features.rest_distance
    summary[params.features + AT_EXTENT] = features.extent
    summary[params.features + AT_USUAL_SPEED] = features.usual_speed
    summary[params.features + AT_TEMPO] = features.tempo
    summary[params.features + AT_NOISE] = features.noise
    summary[params.features + AT_JOINTS] = features.joints


@kernel
def merge_into(params, target, other):
    """Make `target` the summary of both segments: with the higher peak, and the features of the later one's key frame."""
    at = params.features
    target[at + AT_PEAK] = max(target[at + AT_PEAK], other[at + AT_PEAK])
    for i in range(at + AT_SPEED, at + FEATURES):
        target[i] = other[i]
    add_all(target[:at], other)
    add_all(target[params.start :], other[params.start :])


@kernel
def close(params, summary):
    """Keep nothing of a closed segment as a whole: what poses are compared with depends on the key frame."""
    summary[TERM] = 0.0


@kernel
def strength(params, left, right, both):
    """Return the strength of the key frame between two closed segments; `both` is set to their sums."""
    for d in range(len(both)):
        both[d] = left[d] + right[d]
    return merge_cost(params, left, right, both)


@kernel
def merge_cost(params, left, right, both):
    """Return the strength of the key frame between two segments.

    Args:
        params: Record of `make_params`.
        left: Summary of the earlier segment; the key frame ends it.
        right: Of the later one.
        both: Sums of both.
    """
    if left[DURATION] <= SHORTEST_SEGMENT or right[DURATION] <= SHORTEST_SEGMENT:
        return 0.0
    known = left[params.features : params.features + FEATURES]
    peak = min(known[AT_PEAK], right[params.features + AT_PEAK])
    if peak < PEAK_ABOVE_NOISE * known[AT_NOISE]:
        return 0.0
    pose, speed = _change(params, left, right, both, (POSE_FLOOR * known[AT_EXTENT]) ** 2)
    usual = known[AT_USUAL_SPEED]
    odds = WEIGHTS.change_of_pose * pose + WEIGHTS.change_of_speed * speed - WEIGHTS.bias
    least = SPEED_FLOOR_OF_ODDS * usual
    odds += WEIGHTS.stop * min(MOST_PROMINENT, np.log((peak + least) / (known[AT_SPEED] + least)))
    odds += WEIGHTS.rest * np.log((known[AT_SPEED] + least) / (2.0 * usual))
    odds -= WEIGHTS.rest_distance * known[AT_REST_DISTANCE]
    return np.logaddexp(0.0, odds) / LOG_OF_2


@kernel
def similarity(params, cost, left, right):
    """Return 1/(1 + cost), in 0..1."""
    return 1.0 / (1.0 + cost)


@kernel
def _change(params, left, right, both, floor):
    """Return what it costs to merge the poses, and the log speeds, of two segments, at the performer's tempo."""
    pose, speed = _terms(params, both, floor)
    pose_left, speed_left = _terms(params, left, floor)
    pose_right, speed_right = _terms(params, right, floor)
    share = 1.0 / (left[params.features + AT_JOINTS] * left[params.features + AT_TEMPO])
    most = MOST_CHANGE / left[params.features + AT_TEMPO]
    return min(most, (pose - pose_left - pose_right) * share), min(
        most, (speed - speed_left - speed_right) * share
    )


@kernel
def _terms(params, slot, floor):
    """Return T Σ log(σ² + floor) over the joints, of positions (mean variance of the axes) and of log speeds.

    Args:
        params: Of the likelihood.
        slot: Summary.
        floor: m², under the variance of the positions.
    """
    duration, scale = slot[DURATION], 1.0 / slot[DURATION]
    joints = params.speeds  # padded
    sums, squares = slot[params.start :], slot[params.start + params.dimensions :]
    pose = speed = 0.0
    for first in range(0, joints, MOST_FACTORS):  # one logarithm of a product of many variances
        end = min(first + MOST_FACTORS, joints)
        pose += np.log(spread_product(sums, squares, first, end, POSITION_LINES, joints, scale, floor))
        first, end = first + POSITION_LINES * joints, end + POSITION_LINES * joints
        speed += np.log(spread_product(sums, squares, first, end, SPEED_LINES, joints, scale, SPEED_FLOOR))
    return duration * pose, duration * speed
