"""The last seconds of a performer's movement, as templates see it: joints relative to the centre, smoothed, about 30 a second.

A pose has the centre's own place first, then each joint relative to it. Poses nearer than `TICK` to the one kept before
are left out, so that cost and memory do not grow with the sensor's rate.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.moves.points import EARLY, Y_UP, follows, is_hidden, place_points

TICK = 0.024  # s, least time between two poses that are kept: at most 41 Hz
SMOOTHED = 0.15  # s, poses younger than this are averaged
RAW = 8  # poses that may be averaged
RING = 128  # poses, a power of two: 3.1 s at 41 Hz, 4.2 s at 30 Hz

TRACK = np.dtype(
    [
        ("poses", "i8"),  # kept so far; pose n lies in line n % RING
        ("first", "i8"),  # no stretch may begin before this pose: the first one after a gap
        ("time", "f8"),  # s, of the last pose
        ("times", "f8", (RING,)),  # s
        ("path", "f8", (RING,)),  # m, length of the path up to each pose since the gap
        ("speed", "f8", (RING,)),  # m/s, mean over the joints
    ],
)
JOINT = np.dtype(
    [
        ("one", "i8"),  # joint of the stream, -1 for the mean of all joints
        ("other", "i8"),  # another, if the template's joint lies in their middle, else the same
        ("limb", "i8"),  # index into the keys of `limbs.limbs_of`
    ],
)


@kernel
def add_pose(track, poses, positions, bank, time):
    """Keep a frame as a pose.

    A joint that is missing stays where it was. One that was never seen is where it is at the begin of the first example, so
    that a performer whose legs no camera sees is recognised by what it sees.

    Args:
        track: Record of the history.
        poses: (RING + RAW, D) float32 metres: the smoothed poses, then the last ones as they came.
        positions: (J, 3) float32 metres; NaN where a joint is missing.
        bank: `recogniser.Bank`; its joints, (K,) records of `JOINT`, have the centre first.
        time: s.

    Returns:
        Whether the movement goes on; if not, there was a gap, or nothing before.
    """
    number, joints = track.poses, bank.joints
    raw = poses[RING:]
    pose, last = raw[number % RAW], raw[(number + RAW - 1) % RAW]
    if number == 0:
        last = bank.begin
    for d in range(pose.size):
        pose[d] = last[d]
    whole = place_points(pose[: 3 * joints.size].reshape((joints.size, 3)), joints, positions, Y_UP)
    goes_on = follows(number, time, track.time)
    if number == 0 and not whole and is_hidden(joints, 0, positions):
        return False
    if not goes_on:
        track.first = number
    here = number % RING
    track.times[here] = time
    track.path[here] = 0.0
    track.speed[here] = 0.0
    _average(track, poses, raw, number)
    if goes_on:
        _measure_step(track, poses, joints.size, here, (number - 1) % RING)
    track.time = time
    track.poses = number + 1
    return goes_on


@inline_kernel
def _average(track, poses, raw, number):
    """Average the poses since the gap that are younger than `SMOOTHED`, so that a sensor's noise adds little path."""
    pose = poses[number % RING]
    for d in range(pose.size):
        pose[d] = raw[number % RAW, d]
    count = 1
    while count < RAW and number - count >= track.first:
        if not track.times[number % RING] - track.times[(number - count) % RING] < SMOOTHED - EARLY:
            break
        older = raw[(number - count) % RAW]
        for d in range(pose.size):
            pose[d] += older[d]
        count += 1
    share = np.float32(1.0) / np.float32(count)
    for d in range(pose.size):
        pose[d] *= share


@inline_kernel
def _measure_step(track, poses, joints, here, before):
    """Note how far the body moved since the pose before."""
    squares = np.float32(0.0)
    steps = np.float32(0.0)
    for k in range(joints):
        x = poses[here, 3 * k] - poses[before, 3 * k]
        y = poses[here, 3 * k + 1] - poses[before, 3 * k + 1]
        z = poses[here, 3 * k + 2] - poses[before, 3 * k + 2]
        square = x * x + y * y + z * z
        squares += square
        steps += np.sqrt(square)
    track.path[here] = track.path[before] + np.sqrt(np.float64(squares))
    track.speed[here] = steps / (joints * (track.times[here] - track.times[before]))
