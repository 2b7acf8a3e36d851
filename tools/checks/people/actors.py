"""Actors: the recordings of each person in sequence, without their way over the floor."""

import re
from collections.abc import Iterable
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files import read
from mossar_stream import MossarError, Skeleton

FPS = 30.0
_FADE = 10  # frames from one recording to the next
_PERSON = re.compile(r"_([^_]+)$")  # Seq1_3, m01_s02; U100 is one person


class Actor(msgspec.Struct, frozen=True):
    """Motion of one person at `FPS`.

    Args:
        name: Of the folder and the person.
        skeleton: J joints.
        positions: (n, J, 3) metres, the root above the origin.
    """

    name: str
    skeleton: Skeleton
    positions: NDArray[np.float64]


def read_casts(folders: Iterable[Path]) -> list[list[Actor]]:
    """Return the people of each folder; within a folder all have the same skeleton.

    Raises:
        MossarError: If a folder has no recordings of two people.
    """
    casts = []
    for folder in folders:
        takes: dict[str, list[tuple[Skeleton, NDArray[np.float64]]]] = {}
        for path in sorted(folder.glob("*.npz")):
            found = _PERSON.search(path.stem)
            take = read(path)
            rate = take.fps or FPS
            steps = np.arange(0, len(take.positions), rate / FPS).astype(np.intp)
            motion = _in_place(take.positions[steps].astype(np.float64), take.skeleton)
            takes.setdefault(found[1] if found else path.stem, []).append((take.skeleton, motion))
        if len(takes) < 2:
            raise MossarError(f"{folder}: there are no recordings of two people in it")
        cast = [
            Actor(f"{folder.name}/{name}", parts[0][0], _joined([motion for _, motion in parts]))
            for name, parts in takes.items()
        ]
        casts.append([actor for actor in cast if actor.skeleton == cast[0].skeleton])
    return casts


def _in_place(positions: NDArray[np.float64], skeleton: Skeleton) -> NDArray[np.float64]:
    """Return a motion with the root above the origin."""
    root = positions[:, skeleton.root].copy() if skeleton.root >= 0 else np.nanmean(positions, axis=1)
    root[:, 1] = 0.0
    return positions - root[:, None]


def _joined(parts: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return motions in sequence, each faded into the next."""
    joined = parts[0]
    for after in parts[1:]:
        share = np.linspace(0.0, 1.0, _FADE + 2)[1:-1, None, None]
        faded = joined[-_FADE:] * (1 - share) + after[:_FADE] * share
        joined = np.concatenate([joined[:-_FADE], faded, after[_FADE:]])
    return joined
