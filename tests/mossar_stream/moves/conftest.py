"""What the tests of moves share: a person who rests, and moves hands and feet along curves."""

import numpy as np
import pytest

from mossar_stream import Moves, Skeleton

FPS = 30.0
NAMES = [
    "hips",
    "neck",
    "head",
    "left_shoulder",
    "left_elbow",
    "left_wrist",
    "right_shoulder",
    "right_elbow",
    "right_wrist",
    "left_hip",
    "left_knee",
    "left_ankle",
    "right_hip",
    "right_knee",
    "right_ankle",
]
PARENTS = (-1, 0, 1, 1, 3, 4, 1, 6, 7, 0, 9, 10, 0, 12, 13)
PERSON = Skeleton(tuple(NAMES), PARENTS)
STANDING = np.array(
    [[0, 1, 0], [0, 1.5, 0], [0, 1.7, 0]]
    + [[side * x, y, 0] for side in (-1, 1) for x, y in ((0.2, 1.4), (0.25, 1.15), (0.25, 0.9))]
    + [[side * 0.1, y, 0] for side in (-1, 1) for y in (1.0, 0.5, 0.1)],
    float,
)
# Which joints, and where to: to and fro, or round.
MOVES = {
    "punch_left": ((4, 5), (0.05, 0.4, 0.5), False),
    "punch_right": ((7, 8), (-0.05, 0.4, 0.5), False),
    "circle_left": ((4, 5), (0.4, 0.4, 0.0), True),
    "kick_right": ((13, 14), (0.0, 0.4, 0.6), False),
}


def performed(name, seconds=0.9, size=1.0, seed=0):
    """Return (n, J, 3): one performance from rest to rest, a little different for each seed."""
    joints, way, is_round = MOVES[name]
    rng = np.random.default_rng(seed)
    count = round(seconds * FPS)
    phase = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, count))
    frames = np.repeat(STANDING[None], count, axis=0)
    there = np.sin(np.pi * phase)[:, None] * np.array(way) * size * rng.uniform(0.9, 1.1)
    if is_round:
        angle = 2 * np.pi * phase[:, None]
        there = size * (
            np.sin(angle) * np.array([0.4, 0, 0]) + (1 - np.cos(angle)) * np.array([0, 0.35, 0.1])
        )
    for share, joint in zip((0.6, 1.0), joints, strict=True):
        frames[:, joint] += share * there
    return frames


def session(names, rest=1.5, seed=1):
    """Return positions, times, and for each performance its name, first and last frame."""
    rng = np.random.default_rng(seed)
    parts, truth, at = [np.repeat(STANDING[None], 30, axis=0)], [], 30
    for k, name in enumerate(names):
        shown = performed(name, seconds=rng.uniform(0.75, 1.1), size=rng.uniform(0.9, 1.1), seed=seed + k)
        truth.append((name, at, at + len(shown)))
        pause = np.repeat(STANDING[None], round(rest * FPS), axis=0)
        parts += [shown, pause]
        at += len(shown) + len(pause)
    positions = np.concatenate(parts)
    positions += rng.normal(0, 0.001, positions.shape)
    return positions.astype(np.float32), np.arange(len(positions)) / FPS, truth


@pytest.fixture(scope="session")
def moves():
    found = Moves(PERSON)
    for name in MOVES:
        still = np.repeat(STANDING[None], 20, axis=0)
        found.add(name, np.concatenate([still, performed(name), still]), FPS)
    return found
