"""Scenes: people side by side, crossing, hidden, and a tracker that cuts, exchanges and reuses their ids."""

import msgspec
import numpy as np
from numpy.typing import NDArray

from checks.people.actors import FPS, Actor
from mossar_stream import Skeleton

SECONDS = 25.0
APART = 1.1  # m between places side by side
PASSING = 0.5  # m between the roots of two who cross, in depth
_WALK = 3.0  # s that a crossing takes
_EDGE = 2.0  # s at the beginning and end without incidents


class Scene(msgspec.Struct):
    """A scene as a tracker saw it.

    Args:
        skeleton: J joints.
        positions: (P, n, J, 3) metres.
        ids: (P, n) the tracker's id of each person in each frame, 0 where it is hidden.
        incidents: Descriptions of the incidents.
        returns: Person and frame of each return from a long absence.
    """

    skeleton: Skeleton
    positions: NDArray[np.float64]
    ids: NDArray[np.intp]
    incidents: list[str]
    returns: list[tuple[int, int]] = []

    @property
    def times(self) -> NDArray[np.float64]:
        """Of the frames, (n,) s."""
        return np.arange(self.ids.shape[1]) / FPS


def short_scene(cast: list[Actor], seed: int) -> Scene:
    """Return two to four people who are hidden for at most 2 s; their ids are cut, swapped and reused."""
    rng = np.random.default_rng(seed)
    people = min(int(rng.integers(2, 5)), len(cast))
    frames = int(SECONDS * FPS)
    crossings = _crossings(people, frames, rng)
    paths = _paths(people, frames, crossings, rng)
    positions, skeleton = _played(cast, people, paths, rng)
    tracker = _Tracker(people, frames, rng)
    for one, other, begin in crossings:
        middle = begin + int(_WALK * FPS / 2) + int(rng.integers(-4, 5))
        match rng.integers(4):
            case 0:
                tracker.swap(one, other, middle)
            case 1:
                tracker.hide(one, middle - int(rng.uniform(0.1, 0.9) * FPS), int(rng.uniform(0.2, 1.9) * FPS))
            case 2:
                tracker.hide(one, middle - int(rng.uniform(0.1, 0.6) * FPS), int(rng.uniform(0.2, 1.4) * FPS))
                tracker.hide(
                    other, middle - int(rng.uniform(0.1, 0.6) * FPS), int(rng.uniform(0.2, 1.4) * FPS)
                )
    for _ in range(int(rng.integers(1, 4))):
        at = int(rng.uniform(_EDGE, SECONDS - 2 * _EDGE) * FPS)
        one, other = (int(p) for p in rng.choice(people, 2, replace=False))
        match rng.integers(3):
            case 0:
                tracker.swap(one, other, at)
            case 1:
                tracker.hide(one, at, int(rng.uniform(0.2, 2.0) * FPS))
            case 2:
                tracker.hide(one, at, 0)
    return Scene(skeleton, positions, tracker.ids(), tracker.incidents)


def long_scene(cast: list[Actor], seed: int, people: int) -> Scene:
    """Return people who all leave for 10 to 20 s and come back in another order, somewhere else."""
    rng = np.random.default_rng(seed)
    frames = int(45 * FPS)
    away = [(int(rng.uniform(12, 14) * FPS), int(rng.uniform(26, 31) * FPS)) for _ in range(people)]
    spots = rng.permutation(people)
    paths = np.zeros((people, frames, 3))
    for person, (left, back) in enumerate(away):
        paths[person, :left, 0] = person * APART
        paths[person, left:, 0] = spots[person] * APART
        paths[person, :, 2] = 3.0 + rng.uniform(-0.3, 0.3)
        paths[person, left:, 2] += rng.uniform(-0.5, 0.5)
        del back
    positions, skeleton = _played(cast, people, paths, rng)
    tracker = _Tracker(people, frames, rng)
    for person, (left, back) in enumerate(away):
        tracker.hide(person, left, back - left)
    return Scene(
        skeleton, positions, tracker.ids(), tracker.incidents, [(p, back) for p, (_, back) in enumerate(away)]
    )


def _crossings(people: int, frames: int, rng: np.random.Generator) -> list[tuple[int, int, int]]:
    """Return pairs of people who cross, and the first frame of each crossing, in sequence."""
    begins = np.arange(int(_EDGE * FPS), frames - int((_EDGE + _WALK) * FPS), int((_WALK + 1.5) * FPS))
    chosen = sorted(rng.choice(begins, min(int(rng.integers(0, 4)), len(begins)), replace=False))
    return [(*(int(p) for p in rng.choice(people, 2, replace=False)), int(begin)) for begin in chosen]  # type: ignore[misc]


def _paths(
    people: int, frames: int, crossings: list[tuple[int, int, int]], rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the place of each person's root, (P, n, 3), without its height."""
    paths = np.zeros((people, frames, 3))
    paths[:, :, 0] = (np.arange(people) * APART)[:, None] + rng.uniform(-0.1, 0.1, (people, 1))
    paths[:, :, 2] = 3.0 + rng.uniform(-0.2, 0.2, (people, 1))
    walk = np.arange(int(_WALK * FPS)) / (_WALK * FPS)
    share = walk * walk * (3 - 2 * walk)
    for one, other, begin in crossings:
        end = begin + len(share)
        here, there = paths[one, begin].copy(), paths[other, begin].copy()
        aside = np.array([0.0, 0.0, PASSING / 2 + rng.uniform(0, 0.2)]) * np.sin(np.pi * share)[:, None]
        paths[one, begin:end] = here + (there - here) * share[:, None] + aside
        paths[other, begin:end] = there + (here - there) * share[:, None] - aside
        paths[one, end:], paths[other, end:] = there, here
    return paths


def _played(
    cast: list[Actor], people: int, paths: NDArray[np.float64], rng: np.random.Generator
) -> tuple[NDArray[np.float64], Skeleton]:
    """Return the poses of people of a cast on their ways."""
    chosen = [cast[i] for i in rng.choice(len(cast), people, replace=False)]
    frames = paths.shape[1]
    positions = []
    for actor, path in zip(chosen, paths, strict=True):
        motion = actor.positions
        begin = int(rng.integers(len(motion)))
        steps = np.abs((begin + np.arange(frames)) % (2 * len(motion) - 2) - (len(motion) - 1))  # to and fro
        positions.append(motion[steps] + path[:, None])
    return np.array(positions), chosen[0].skeleton


class _Tracker:
    """Gives ids; half of the trackers reuse the lowest free one, the others never do."""

    def __init__(self, people: int, frames: int, rng: np.random.Generator) -> None:
        self.incidents: list[str] = []
        self._shown = np.ones((people, frames), bool)
        self._cuts: set[tuple[int, int]] = set()  # person and frame in which the id is another at once
        self._swaps: list[tuple[int, int, int]] = []  # frame, persons
        self._reuses = bool(rng.integers(2))

    def hide(self, person: int, begin: int, frames: int) -> None:
        self._shown[person, begin : begin + frames] = False
        self._cuts.add((person, begin + frames))
        self.incidents.append(f"{begin / FPS:5.1f} s: {'ABCDEF'[person]} hidden for {frames / FPS:.1f} s")

    def swap(self, one: int, other: int, at: int) -> None:
        self._swaps.append((at, one, other))
        self.incidents.append(f"{at / FPS:5.1f} s: {'ABCDEF'[one]} and {'ABCDEF'[other]} exchanged")

    def ids(self) -> NDArray[np.intp]:
        """Return the ids, 0 where a person is hidden."""
        people, frames = self._shown.shape
        ids = np.zeros((people, frames), np.intp)
        own = [0] * people
        latest = 0
        for i in range(frames):
            gone = {p for p in range(people) if not self._shown[p, i] or (p, i) in self._cuts}
            free = [p for p in range(people) if self._shown[p, i] and (p in gone or not own[p])]
            for p in gone:
                own[p] = 0
            for p in free:
                before = ids[p, i - 1] if i else 0
                lowest = next(n for n in range(1, people + 2) if n not in own and n != before)
                latest += 1
                own[p] = lowest if self._reuses else latest
            for at, one, other in self._swaps:
                if at == i and own[one] and own[other]:
                    own[one], own[other] = own[other], own[one]
            ids[:, i] = [own[p] if self._shown[p, i] else 0 for p in range(people)]
        return ids
