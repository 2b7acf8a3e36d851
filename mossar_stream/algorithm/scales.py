"""Scales: how far, how fast and around which pose a performer moves, so that evidence needs no unit and no tempo.

    A  extent of the movements: rms distance of the joints from a slow mean of the pose
    V  usual speed: rms of the speed u
    H  pose in which the performer dwells: mean of the poses, each weighted by 1 / (1 + (u / 0.3 V)²)

u is the rms over the joints of their speed over a tenth of a second. All are leaky sums, with little of a prior.
Metres stand only in that prior.
"""

import numpy as np

from mossar_stream.algorithm.mean_pose import MEAN_TIME, follow_mean, squared_distance, start_mean
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.joint_pages import MEAN_X, REST_X

SCALES_HALF_LIFE, REST_POSE_HALF_LIFE = 20.0, 30.0  # s
PRIOR_EXTENT, PRIOR_SPEED = 0.05, 0.1  # m and m/s, as if seen for one second
PRIOR_DWELT = 2.0  # s, for which the first pose is taken to have been held
SLOW = 0.3  # share of V below which a performer dwells
LEAST_USUAL_SPEED, LEAST_EXTENT = 1e-4, 1e-5  # m/s and m, of those who never move
ORDINARY = 0.25  # s, A / V of ordinary movements
SPEED_OFFSET = 0.1  # V, added to speeds before the logarithm
QUICKEST, SLOWEST = 0.5, 2.0  # limits of the tempo relative to it

SCALES = np.dtype(
    [
        ("speed", "f8"),  # m/s, u of the last frame
        ("speed_weight", "f8"),  # s
        ("squared_speed", "f8"),  # m²/s
        ("spread_weight", "f8"),  # s
        ("spread", "f8"),  # m² s
        ("dwelt", "f8"),  # s, weight of the pose H
    ],
)


@kernel
def start_scales(scales, body, joints):
    """Begin a take with the prior, in the first pose."""
    start_mean(body, joints, MEAN_X)
    start_mean(body, joints, REST_X)
    scales.speed = 0.0
    scales.speed_weight = scales.spread_weight = 1.0
    scales.squared_speed = PRIOR_SPEED**2
    scales.spread = PRIOR_EXTENT**2
    scales.dwelt = PRIOR_DWELT


@inline_kernel
def follow_scales(scales, squares, dt):
    """Take the speed of a frame in.

    Args:
        scales: SCALES.
        squares: m²/s², mean over the joints of their squared speed.
        dt: s since the last frame.
    """
    kept = np.exp2(-dt / SCALES_HALF_LIFE)
    scales.speed = np.sqrt(squares)
    scales.squared_speed = scales.squared_speed * kept + squares * dt
    scales.speed_weight = scales.speed_weight * kept + dt


@inline_kernel
def follow_poses(scales, body, joints, dt):
    """Take a pose in that stands for `dt` seconds.

    Args:
        scales: SCALES.
        body: See joint_pages.py.
        joints: How many can move relative to the centre.
        dt: s.
    """
    ratio = scales.speed / (SLOW * usual_speed(scales))
    dwelling = dt / (1.0 + ratio * ratio)
    scales.dwelt = scales.dwelt * np.exp2(-dt / REST_POSE_HALF_LIFE) + dwelling
    share, toward_rest = np.float32(min(dt / MEAN_TIME, 1.0)), np.float32(dwelling / scales.dwelt)
    squares = squared_distance(body, MEAN_X)
    follow_mean(body, MEAN_X, share)
    follow_mean(body, REST_X, toward_rest)
    kept = np.exp2(-dt / SCALES_HALF_LIFE)
    scales.spread = scales.spread * kept + squares / joints * dt
    scales.spread_weight = scales.spread_weight * kept + dt


@inline_kernel
def usual_speed(scales):
    """Return V, m/s."""
    return max(np.sqrt(scales.squared_speed / scales.speed_weight), LEAST_USUAL_SPEED)


@inline_kernel
def extent(scales):
    """Return A, m."""
    return max(np.sqrt(scales.spread / scales.spread_weight), LEAST_EXTENT)


@inline_kernel
def tempo_of(scales):
    """Return how slow the performer is: A / V relative to ordinary, within limits."""
    return min(max(extent(scales) / usual_speed(scales) / ORDINARY, QUICKEST), SLOWEST)


@kernel
def rest_distance(body, joints):
    """Return the rms distance of the joints from the pose H, m."""
    return np.sqrt(squared_distance(body, REST_X) / joints)
