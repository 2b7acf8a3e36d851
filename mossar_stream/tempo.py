"""Tempo: how slowly a performer moves, so that the level asks as much of slow people as of quick ones.

T = sqrt(S / V): S is the joint-mean squared distance from a slow mean of the pose, V the joint-mean squared speed,
both leaky sums. It is the time in which the performer covers the size of their movements. Costs are divided by T
relative to an ordinary tempo, within limits.
"""

import numpy as np

from mossar_stream.compiled import compiled
from mossar_stream.joints import lane_sum

ORDINARY = 0.15  # s
SLOWEST, QUICKEST = 4.0, 0.8  # limits of the factor
HALF_LIFE = 20.0  # s, of the sums
MEAN_TIME = 5.0  # s, of the mean pose
PRIOR_TIME = 2.0  # s, for which an ordinary performer is taken to have moved before the take
PRIOR_SPEED = 0.5  # m/s


@compiled
def start_tempo(h, mean_pose, pose):
    """Begin a take with the prior."""
    h.tempo_spread = PRIOR_TIME * (PRIOR_SPEED * ORDINARY) ** 2
    h.tempo_speed = PRIOR_TIME * PRIOR_SPEED**2
    for axis in range(3):
        for j in range(h.lanes):
            mean_pose[axis, j] = pose[axis, j]
    h.pace = 1.0


@compiled
def follow_tempo(h, mean_pose, pose, step, work, dt):
    """Take a frame in and set `h.pace`, the factor that costs are divided by.

    Args:
        h: Header of the row.
        mean_pose: (3, lanes) m, slow mean of the pose.
        pose: (4, lanes) m relative to the centre.
        step: (lanes,) m, path of each joint since the last frame.
        work: (lanes,) room to work in.
        dt: s since then.
    """
    if dt <= 0.0:
        return
    keep = np.exp2(-dt / HALF_LIFE)
    follow = dt / (dt + MEAN_TIME)
    for j in range(h.lanes):
        work[j] = 0.0
    for axis in range(3):
        for j in range(h.lanes):
            off = pose[axis, j] - mean_pose[axis, j]
            mean_pose[axis, j] += follow * off
            work[j] += off * off
    spread = lane_sum(work) * (1.0 - follow) ** 2
    for j in range(h.lanes):
        work[j] = step[j] * step[j]
    h.tempo_spread = h.tempo_spread * keep + spread / h.moving_joints * dt
    h.tempo_speed = h.tempo_speed * keep + lane_sum(work) / h.moving_joints / dt
    h.pace = min(max(np.sqrt(h.tempo_spread / h.tempo_speed) / ORDINARY, QUICKEST), SLOWEST)
