"""Tempo: how slowly a performer moves, so that the level asks as much of slow people as of quick ones.

T = sqrt(S / V): S is the squared distance of the joints from a slow mean of the pose, V their squared speed, both
leaky sums. It is the time in which the performer covers the size of their movements. Costs are divided by T relative
to an ordinary tempo, within limits. S follows the poses that are kept of the last seconds, V every frame.
"""

import numpy as np

from mossar_stream.algorithm.mean_pose import MEAN_TIME, follow_mean, squared_distance, start_mean
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.simd import page_product
from mossar_stream.memory.joint_pages import LINES, MEAN_X, PAGE, STEP, page_of

ORDINARY_PACE = 0.15  # s
SLOWEST_PACE, QUICKEST_PACE = 4.0, 0.8  # limits of the factor
TIME_CONSTANT = 30.0  # s, of the sums
PRIOR_TIME = 2.0  # s, for which an ordinary performer is taken to have moved before the take
PRIOR_PACE_SPEED = 0.5  # m/s

TEMPO = np.dtype(
    [
        ("spread", "f8"),  # m² s, leaky sum of the joints' squared distances from the mean pose
        ("squared_speed", "f8"),  # m²/s, leaky sum of their squared speeds
    ],
)


@kernel
def start_tempo(tempo, joints, moving, body):
    """Begin a take with the prior.

    Args:
        tempo: TEMPO.
        joints: J.
        moving: How many of them can move relative to the centre.
        body: See joint_pages.py.
    """
    start_mean(body, joints, MEAN_X)
    tempo.spread = moving * PRIOR_TIME * (PRIOR_PACE_SPEED * ORDINARY_PACE) ** 2
    tempo.squared_speed = moving * PRIOR_TIME * PRIOR_PACE_SPEED**2


@inline_kernel
def follow_speed(tempo, body, dt):
    """Take the displacements of a frame in.

    Args:
        tempo: TEMPO.
        body: See joint_pages.py.
        dt: s since the last frame.
    """
    if dt <= 0.0:
        return
    squares = 0.0
    for first in range(0, len(body) // LINES, PAGE):
        squares += page_product(page_of(body, first), STEP, STEP)
    tempo.squared_speed = tempo.squared_speed * _kept(dt) + squares / dt


@inline_kernel
def follow_pose(tempo, body, dt):
    """Take a pose in that stands for `dt` seconds."""
    squares = squared_distance(body, MEAN_X)
    follow_mean(body, MEAN_X, np.float32(min(dt / MEAN_TIME, 1.0)))
    tempo.spread = tempo.spread * _kept(dt) + squares * dt


@inline_kernel
def _kept(dt):
    """Return what is left of a leaky sum after some time."""
    return max(0.0, 1.0 - dt / TIME_CONSTANT)


@kernel
def pace(tempo):
    """Return the factor that costs are divided by."""
    return min(max(np.sqrt(tempo.spread / tempo.squared_speed) / ORDINARY_PACE, QUICKEST_PACE), SLOWEST_PACE)
