"""Gaits: feet that step at known times, slowly, fast, shuffling, on the spot, upstairs, running, backwards, and that only wiggle.

A foot stands, and swings from one place to the next as smoothly as can be. It is off while it is more than 5 mm from its
place, so that the truth is that of a force plate under such a foot, not the mathematical begin of its motion.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton

SKELETON = Skeleton(
    ("head", "hips", "left_ankle", "left_heel", "left_toe", "right_ankle", "right_heel", "right_toe"),
    (1, -1, 1, 2, 2, 1, 5, 5),
    1,
)
FEET = "left=left_ankle,left_heel,left_toe right=right_ankle,right_heel,right_toe"
MOVED = 0.005  # m
FIRST = 1.0  # s, when the left foot leaves the ground for the first time
_POINTS = np.array([[0.0, 0.09, 0.0], [0.0, 0.03, -0.05], [0.0, 0.02, 0.18]])  # of a foot: ankle, heel, toe

Event = tuple[float, str, str]  # s, side, status


class Gait(NamedTuple):
    """The gait of a performer.

    Args:
        cycle: s from one strike of a foot to its next.
        swing: Share of the cycle for which a foot is off.
        stride: m that a foot goes forwards in a cycle.
        lift: m that it is lifted.
        climb: m that it goes upwards in a cycle.
        roll: s before the toe leaves the ground that the heel begins to rise.
    """

    cycle: float
    swing: float
    stride: float
    lift: float
    climb: float = 0.0
    roll: float = 0.12


GAITS = {
    "walking": Gait(1.1, 0.40, 1.3, 0.06),
    "slow": Gait(1.8, 0.35, 0.7, 0.05),
    "fast": Gait(0.85, 0.42, 1.7, 0.07),
    "shuffling": Gait(1.2, 0.35, 0.30, 0.015),
    "on the spot": Gait(1.0, 0.40, 0.0, 0.12),
    "stairs": Gait(1.3, 0.40, 0.6, 0.10, climb=0.34),
    "running": Gait(0.7, 0.66, 2.2, 0.15, roll=0.05),
    "backwards": Gait(1.2, 0.40, -0.9, 0.06),
}


def performed(
    gait: Gait, seconds: float, fps: float, noise: float = 0.0, seed: int = 0
) -> tuple[NDArray[np.float32], NDArray[np.float64], list[Event]]:
    """Return positions (n, J, 3) m with y up, times (n,) s, and the true events of a performer that stands, steps, and stands.

    Args:
        gait: The gait.
        seconds: Duration, s.
        fps: Hz.
        noise: Standard deviation of the sensor's noise, m.
        seed: Of the noise, and of how steps differ.
    """
    random = np.random.default_rng(seed)
    times = np.arange(int(seconds * fps)) / fps
    fine = np.arange(int(seconds * 1000)) / 1000
    positions = np.zeros((len(times), len(SKELETON), 3))
    truth: list[Event] = []
    places = []
    for side, name in enumerate(("left", "right")):
        swings = _swings(gait, seconds, side, random)
        truth += [(time, name, status) for time, status in _moments(gait, swings, fine)]
        place, raised = _path(gait, swings, times)
        places.append(place)
        first = 2 + 3 * side
        feet = place[:, None] + _POINTS + np.array([0.11 - 0.22 * side, 0, 0])
        feet[:, 0, 1] += 0.5 * raised
        feet[:, 1, 1] += raised
        positions[:, first : first + 3] = feet
    centre = (places[0] + places[1]) / 2
    positions[:, 1] = centre + np.array([0, 0.95, 0])
    positions[:, 0] = centre + np.array([0, 1.65, 0])
    positions += random.normal(0, noise, positions.shape) if noise else 0.0
    return positions.astype(np.float32), times, sorted(truth)


def wiggling(seconds: float, fps: float, noise: float, seed: int = 0) -> NDArray[np.float32]:
    """Return (n, J, 3) m of a performer who stands, sways by some cm, and now and then rises a heel or shifts a foot a little."""
    random = np.random.default_rng(seed)
    times = np.arange(int(seconds * fps)) / fps
    positions = np.zeros((len(times), len(SKELETON), 3))
    sway = 0.03 * np.sin(2 * np.pi * 0.35 * times) + 0.015 * np.sin(2 * np.pi * 0.83 * times + 1)
    for side in range(2):
        first = 2 + 3 * side
        positions[:, first : first + 3] = _POINTS + np.array([0.11 - 0.22 * side, 0, 0])
        heels = 0.06 * np.maximum(0, np.sin(2 * np.pi * 0.13 * times + 2 * side)) ** 4
        positions[:, first + 1, 1] += heels
        positions[:, first, 1] += 0.5 * heels
        shift = 0.02 * np.sin(2 * np.pi * 0.21 * times + 3 * side) ** 5
        positions[:, first : first + 3, 0] += shift[:, None]
    positions[:, 1] = [0, 0.95, 0]
    positions[:, 0] = [0, 1.65, 0]
    positions[:, :2, 0] += sway[:, None]
    return (positions + random.normal(0, noise, positions.shape)).astype(np.float32)


def _swings(gait: Gait, seconds: float, side: int, random: np.random.Generator) -> list[tuple[float, float]]:
    """Return begin and end of each swing of a foot, s, every one a little different."""
    begin, found = FIRST + 0.5 * gait.cycle * side, []
    while begin + gait.cycle < seconds - 1.0:
        length = gait.swing * gait.cycle * random.uniform(0.95, 1.05)
        found.append((begin, begin + length))
        begin += gait.cycle
    return found


def _path(
    gait: Gait, swings: list[tuple[float, float]], times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the place of a foot, (n, 3) m, and the height of its heel, (n,) m."""
    place, raised = np.zeros((len(times), 3)), np.zeros(len(times))
    for begin, end in swings:
        share = 0.5 if begin == FIRST else 1.0  # the very first step is half as long as those that follow
        u = np.clip((times - begin) / (end - begin), 0, 1)
        gone = u**3 * (10 - 15 * u + 6 * u * u)
        place += share * gone[:, None] * np.array([0, gait.climb, gait.stride])
        place[:, 1] += gait.lift * 64 * (u * (1 - u)) ** 3
        if gait.roll:
            w = np.clip((times - begin + gait.roll) / (gait.roll + 0.7 * (end - begin)), 0, 1)
            raised += 0.05 * 64 * (w * (1 - w)) ** 3
    return place, raised


def _moments(
    gait: Gait, swings: list[tuple[float, float]], fine: NDArray[np.float64]
) -> list[tuple[float, str]]:
    found = []
    for begin, end in swings:
        own = fine[(fine >= begin) & (fine <= end)]
        place, _ = _path(gait, [(begin, end)], own)
        off = own[np.linalg.norm(place - place[0], axis=1) > MOVED]
        strike = own[np.linalg.norm(place - place[-1], axis=1) > MOVED]
        if len(off) and len(strike):
            found += [(float(off[0]), "off"), (float(strike[-1]), "strike")]
    return found
