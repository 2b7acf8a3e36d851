"""Evidence: how likely one move ends and the next one begins at a key frame, for any performer and sensor.

What people call a move ends where the movement changes, or where it stops; data sets differ in which. So both kinds of
evidence are added up, each free of units, to log odds:

    change  merge cost of the positions, and of the log speeds, of the segments on both sides (likelihood.py), in
            seconds of the performer's tempo
    stop    prominence: log of the lower of the two sides' peak speeds to the speed at the key frame
    rest    log of that speed to the performer's usual speed
    home    distance of the pose from the one in which the performer dwells, in the extent of the movements

Peaks that do not rise above the sensor's noise are no evidence. Where movements are repeated, the verdict on repetitions takes
their place (verdicts.py). The strength is log2(1 + e^odds): above 0, rising with the odds, and 1 where they are even.

What is known of the key frame itself stands in the summary of the segment that it ends.
"""

import numpy as np

from mossar_stream.jit.decorators import kernel
from mossar_stream.jit.simd import spread_product
from mossar_stream.similarity.summary import DURATION, SHORTEST

FACTS = 8  # numbers in a summary's own part, from `params.facts` on:
PEAK = 0  # m/s, largest speed u of the segment (scales.py); then, of the key frame that ends it,
SPEED = 1  # m/s, lowest u from the candidate to its confirmation
HOME = 2  # A, distance from the pose in which the performer dwells
EXTENT = 3  # m, A
USUAL_SPEED = 4  # m/s, V
TEMPO = 5  # relative to ordinary
NOISE = 6  # m/s, what the sensor's noise adds to u
JOINTS = 7  # that count and can move relative to the centre

# Chosen on punches, pick and place, gestures and exercises: about what `python -m checks.leave_out SET ...` finds on all
# of them, in the scale of the numbers before.
CHANGE_OF_POSE, CHANGE_OF_SPEED, STOP, REST, AWAY = 3.8, 10.4, 3.4, 0.56, 1.93
EVEN = 3.66  # what evidence must outweigh
MOST_CHANGE = 4.0  # s
POSE_FLOOR = 0.15  # A, standard deviation under which poses are alike
SPEED_FLOOR = 0.1  # variance of log speeds under which they are alike
SPEED_OFFSET = 0.1  # V, added to speeds before the logarithm
LEAST = 0.1  # V, added to the speeds in a prominence
MOST_PROMINENT = 3.0
AXES, ONE = np.int64(3), np.int64(1)  # lines of the positions, and of the log speeds, in a summary
MOST_FACTORS = 24  # variances that are multiplied before a logarithm is taken
LOG_2 = np.log(2.0)
ABOVE_NOISE = 1.0  # times what the noise adds to u, which a peak must reach
CERTAIN = 4.0  # strength of a key frame that ends a repetition


@kernel
def note_peak(slot, facts, speed):
    """Let a summary know a frame's speed u, m/s."""
    slot[facts] = max(slot[facts], speed)


@kernel
def merge_facts(facts, target, other):
    """Give a summary what is known of the later of two segments, and the peak of both.

    Args:
        facts: Where they begin.
        target: Summary of the earlier segment.
        other: Of the later one.
    """
    target[facts] = max(target[facts], other[facts])
    for i in range(facts + SPEED, facts + FACTS):
        target[i] = other[i]


@kernel
def odds_strength(params, left, right, both):
    """Return the strength of the key frame between two segments.

    Args:
        params: Of the likelihood.
        left: Summary of the earlier segment; the key frame ends it.
        right: Of the later one.
        both: Sums of both.
    """
    if left[DURATION] <= SHORTEST or right[DURATION] <= SHORTEST:
        return 0.0
    facts = left[params.facts : params.facts + FACTS]
    peak = min(facts[PEAK], right[params.facts])
    if peak < ABOVE_NOISE * facts[NOISE]:
        return 0.0
    pose, speed = _change(params, left, right, both, (POSE_FLOOR * facts[EXTENT]) ** 2)
    usual = facts[USUAL_SPEED]
    odds = CHANGE_OF_POSE * pose + CHANGE_OF_SPEED * speed - EVEN
    least = LEAST * usual
    odds += STOP * min(MOST_PROMINENT, np.log((peak + least) / (facts[SPEED] + least)))
    odds += REST * np.log((facts[SPEED] + least) / (2.0 * usual))
    odds -= AWAY * facts[HOME]
    return np.logaddexp(0.0, odds) / LOG_2


@kernel
def _change(params, left, right, both, floor):
    """Return what it costs to merge the poses, and the log speeds, of two segments, at the performer's tempo."""
    pose, speed = _terms(params, both, floor)
    pose_left, speed_left = _terms(params, left, floor)
    pose_right, speed_right = _terms(params, right, floor)
    share = 1.0 / (left[params.facts + JOINTS] * left[params.facts + TEMPO])
    most = MOST_CHANGE / left[params.facts + TEMPO]
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
        pose += np.log(spread_product(sums, squares, first, end, AXES, joints, scale, floor))
        first, end = first + AXES * joints, end + AXES * joints
        speed += np.log(spread_product(sums, squares, first, end, ONE, joints, scale, SPEED_FLOOR))
    return duration * pose, duration * speed
