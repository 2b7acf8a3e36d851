"""Tempo: how slowly a performer moves, so that the level asks as much of slow people as of quick ones.

T = sqrt(S / V): S is the joint-mean squared distance from a slow mean of the pose, V the joint-mean squared speed,
both leaky sums. It is the time in which the performer covers the size of their movements. Costs are divided by T
relative to an ordinary tempo, within limits.
"""

import numpy as np

from mossar_stream.body import (
    MEAN_X,
    MEAN_Y,
    MEAN_Z,
    MOVED_X,
    MOVED_Y,
    MOVED_Z,
    PAGE,
    POSE_X,
    POSE_Y,
    POSE_Z,
    SPEED,
    SPREAD,
    page_of,
    place,
)
from mossar_stream.compiled import compiled, inlined

ORDINARY = 0.15  # s
SLOWEST, QUICKEST = 4.0, 0.8  # limits of the factor
TIME_CONSTANT = 30.0  # s, of the sums
MEAN_TIME = 5.0  # s, of the mean pose
PRIOR_TIME = 2.0  # s, for which an ordinary performer is taken to have moved before the take
PRIOR_SPEED = 0.5  # m/s


@compiled
def start_tempo(h, body):
    """Begin a take with the prior."""
    for j in range(h.joints):
        k = place(j)
        body[k + MEAN_X], body[k + MEAN_Y], body[k + MEAN_Z] = (
            body[k + POSE_X],
            body[k + POSE_Y],
            body[k + POSE_Z],
        )
        body[k + SPREAD] = PRIOR_TIME * (PRIOR_SPEED * ORDINARY) ** 2
        body[k + SPEED] = PRIOR_TIME * PRIOR_SPEED**2


@inlined
def follow_tempo(h, body, dt):
    """Take a frame in; the sums are kept by joint and added up when they are needed.

    Args:
        h: Header of the row.
        body: See body.py.
        dt: s since the last frame.
    """
    if dt <= 0.0:
        return
    share, keep = dt * (1.0 / MEAN_TIME), max(0.0, 1.0 - dt * (1.0 / TIME_CONSTANT))
    for first in range(0, h.lanes, PAGE):
        _follow(
            page_of(body, first),
            np.float32(min(share, 1.0)),
            np.float32(keep),
            np.float32(dt),
            np.float32(1.0 / dt),
        )


@inlined
def _follow(page, share, keep, dt, rate):
    """Let the means of a page's joints follow, and add to their sums."""
    for j in range(PAGE):
        x, y, z = (
            page[j + POSE_X] - page[j + MEAN_X],
            page[j + POSE_Y] - page[j + MEAN_Y],
            page[j + POSE_Z] - page[j + MEAN_Z],
        )
        page[j + MEAN_X] += share * x
        page[j + MEAN_Y] += share * y
        page[j + MEAN_Z] += share * z
        page[j + SPREAD] = page[j + SPREAD] * keep + (x * x + y * y + z * z) * dt
        u, v, w = page[j + MOVED_X], page[j + MOVED_Y], page[j + MOVED_Z]
        page[j + SPEED] = page[j + SPEED] * keep + (u * u + v * v + w * w) * rate


@compiled
def pace(h, body):
    """Return the factor that costs are divided by."""
    if h.tempo == 0:
        return 1.0
    spread = speed = 0.0
    for j in range(h.joints):
        if j != h.center:
            spread += body[place(j) + SPREAD]
            speed += body[place(j) + SPEED]
    return min(max(np.sqrt(spread / speed) / ORDINARY, QUICKEST), SLOWEST)
