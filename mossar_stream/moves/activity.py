"""Where moves may begin: onsets and significant minima of the recogniser's own speed.

The body's key frames depend on settings that users change; what is recognised must not. So the recogniser follows a
speed of its own (mean over the joints, m/s), in the manner of Algorithm 2: an onset where it rises above a share of
its range, a minimum where it has fallen and risen by a significant share.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.moves.points import EARLY
from mossar_stream.moves.track import RING

STARTS = 4  # of which the last ones are remembered
AVERAGED = 0.12  # s, of speed
ONSET = 0.12  # of the range: faster is moving
SIGNIFICANT = 0.06  # of the range: what a minimum must be lower than its surroundings
HALF_LIFE = 20.0  # s, of the range
LEAST_RANGE = 0.3  # m/s
LOOK_BACK = 15  # poses: so far before an onset a move may have begun

ACTIVITY = np.dtype(
    [
        ("range", "f8"),  # m/s, largest speed, decaying
        ("speed", "f8"),  # m/s, now
        ("moving", "i8"),  # whether speed is above the threshold
        ("rising", "i8"),  # whether a maximum is looked for, else a minimum
        ("top", "f8"),  # m/s, largest speed since the last minimum
        ("low", "f8"),  # m/s, least speed since the last maximum
        ("low_pose", "i8"),  # when that was
        (
            "starts",
            "i8",
            (STARTS,),
        ),  # numbers of poses where moves may have begun, the latest first; -1 for none
    ],
)


@kernel
def start_activity(activity):
    """Forget everything but the range."""
    activity.range = max(activity.range, LEAST_RANGE)
    activity.speed = 0.0
    activity.moving = 0
    activity.rising = 1
    activity.top = 0.0
    activity.low = 0.0
    activity.low_pose = 0
    activity.starts[:] = -1


@kernel
def follow_activity(activity, speeds, times, first, pose):
    """Take in the speed at a pose.

    Args:
        activity: Record.
        speeds: (RING,) m/s.
        times: (RING,) s.
        first: Number of the first pose since the last gap.
        pose: Number of this pose, above `first`.
    """
    seconds = times[pose % RING] - times[(pose - 1) % RING]
    speed = activity.speed = mean_speed(speeds, times, first, pose)
    activity.range = max(activity.range * 0.5 ** (seconds / HALF_LIFE), speed, LEAST_RANGE)
    moving = 1 if speed > ONSET * activity.range else 0
    if moving != activity.moving:
        activity.moving = moving
        if moving:
            _begin(activity, speed, _rise(speeds, times, first, pose))
    elif moving:
        _find_minimum(activity, speed, pose)


@inline_kernel
def mean_speed(speeds, times, first, pose):
    """Return the mean speed over the last `AVERAGED` seconds, m/s."""
    total = 0.0
    count = 0
    while pose - count > first and times[pose % RING] - times[(pose - count) % RING] < AVERAGED - EARLY:
        total += speeds[(pose - count) % RING]
        count += 1
    return total / max(count, 1)


@inline_kernel
def _rise(speeds, times, first, pose):
    """Return where the rise began that led above the threshold."""
    here = pose
    last = mean_speed(speeds, times, first, here)
    while here - 1 > max(first, pose - LOOK_BACK):
        before = mean_speed(speeds, times, first, here - 1)
        if not before < last:
            break
        here -= 1
        last = before
    return here


@inline_kernel
def _begin(activity, speed, pose):
    activity.rising = 1
    activity.top = speed
    _remember(activity, pose)


@inline_kernel
def _find_minimum(activity, speed, pose):
    significant = SIGNIFICANT * activity.range
    if activity.rising == 1:
        activity.top = max(activity.top, speed)
        if speed < activity.top - significant:
            activity.rising = 0
            activity.low = speed
            activity.low_pose = pose
    elif speed < activity.low:
        activity.low = speed
        activity.low_pose = pose
    elif speed > activity.low + significant:
        activity.rising = 1
        activity.top = speed
        _remember(activity, activity.low_pose)


@inline_kernel
def _remember(activity, pose):
    for i in range(STARTS - 1, 0, -1):
        activity.starts[i] = activity.starts[i - 1]
    activity.starts[0] = pose
