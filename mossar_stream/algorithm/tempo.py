"""Tempo: how slowly a performer moves, so that the level asks as much of slow people as of quick ones.

T = sqrt(S / V): S is the squared distance of the joints from a slow mean of the pose, V their squared speed, both
leaky sums. It is the time in which the performer covers the size of their movements. Costs are divided by T relative
to an ordinary tempo, within limits. S follows the poses that are kept of the last seconds, V every frame.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.simd import page_product, page_sum
from mossar_stream.memory.joint_pages import (
    LINES,
    MEAN_X,
    MEAN_Y,
    MEAN_Z,
    PAGE,
    POSE_X,
    POSE_Y,
    POSE_Z,
    STEP,
    WORK,
    page_of,
    place,
)

ORDINARY = 0.15  # s
SLOWEST, QUICKEST = 4.0, 0.8  # limits of the factor
TIME_CONSTANT = 30.0  # s, of the sums
MEAN_TIME = 5.0  # s, of the mean pose
PRIOR_TIME = 2.0  # s, for which an ordinary performer is taken to have moved before the take
PRIOR_SPEED = 0.5  # m/s

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
    for j in range(joints):
        k = place(j)
        body[k + MEAN_X], body[k + MEAN_Y], body[k + MEAN_Z] = (
            body[k + POSE_X],
            body[k + POSE_Y],
            body[k + POSE_Z],
        )
    tempo.spread = moving * PRIOR_TIME * (PRIOR_SPEED * ORDINARY) ** 2
    tempo.squared_speed = moving * PRIOR_TIME * PRIOR_SPEED**2


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
def follow_mean(tempo, body, dt):
    """Take a pose in that stands for `dt` seconds."""
    share = np.float32(min(dt / MEAN_TIME, 1.0))
    squares = 0.0
    for first in range(0, len(body) // LINES, PAGE):
        page = page_of(body, first)
        _follow_page(page, share)
        squares += page_sum(page, WORK)
    tempo.spread = tempo.spread * _kept(dt) + squares * dt


@inline_kernel
def _kept(dt):
    """Return what is left of a leaky sum after some time."""
    return max(0.0, 1.0 - dt / TIME_CONSTANT)


@inline_kernel
def _follow_page(page, share):
    """Let the means of a page's joints follow, and set the squared distances that they had."""
    for j in range(PAGE):
        x, y, z = (
            page[j + POSE_X] - page[j + MEAN_X],
            page[j + POSE_Y] - page[j + MEAN_Y],
            page[j + POSE_Z] - page[j + MEAN_Z],
        )
        page[j + MEAN_X] += share * x
        page[j + MEAN_Y] += share * y
        page[j + MEAN_Z] += share * z
        page[j + WORK] = x * x + y * y + z * z


@kernel
def pace(tempo):
    """Return the factor that costs are divided by."""
    return min(max(np.sqrt(tempo.spread / tempo.squared_speed) / ORDINARY, QUICKEST), SLOWEST)
