"""Figures: a body as many copies of two solids, a tapered bone and a ball, in numbers that a renderer takes."""

from functools import cache

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton
from mossar_tools.stick_figures import head_of

BONE, JOINT, HEAD = 0.030, 0.042, 0.105  # radii, m
HIDDEN = 1e-5  # scale of missing parts

Floats = NDArray[np.float32]


class Solids(msgspec.Struct, frozen=True):
    """Copies of one solid.

    Args:
        places: (n, 3) m.
        turns: (n, 4) quaternions wxyz.
        sizes: (n, 3) scales.
    """

    places: Floats
    turns: Floats
    sizes: Floats


@cache
def bone_mesh() -> tuple[Floats, NDArray[np.uint32]]:
    """Return vertices and faces of a tapered bone of length 1 along z, of radius 1 where it is thickest."""
    return _turned([(0.0, 0.0), (0.72, 0.03), (1.0, 0.16), (0.62, 0.94), (0.45, 1.0), (0.0, 1.0)], 8)


@cache
def ball_mesh() -> tuple[Floats, NDArray[np.uint32]]:
    """Return vertices and faces of a ball of radius 1."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 8)
    return _turned([(float(np.cos(a)), float(np.sin(a))) for a in angles], 11)


def bones_of(skeleton: Skeleton, joints: Floats) -> Solids:
    """Return a solid for each bone.

    Args:
        skeleton: J joints.
        joints: (J, 3) m, NaN where a joint is missing.
    """
    pairs = np.array(skeleton.bones(), np.intp).reshape(-1, 2)
    start, along = joints[pairs[:, 0]], joints[pairs[:, 1]] - joints[pairs[:, 0]]
    length = np.linalg.norm(along, axis=1)
    shown = np.isfinite(length) & (length > 1e-4)
    sizes = np.full((len(pairs), 3), HIDDEN, np.float32)
    sizes[shown, :2] = np.minimum(BONE, 0.3 * length[shown, None])
    sizes[shown, 2] = length[shown]
    unit = np.where(shown[:, None], along / np.where(shown, length, 1.0)[:, None], (0.0, 0.0, 1.0))
    return Solids(np.nan_to_num(start).astype(np.float32), _turn_from_z(unit), sizes)


def balls_of(skeleton: Skeleton, joints: Floats) -> Solids:
    """Return a ball for each joint, a larger one for the head."""
    radii = np.full(len(skeleton), JOINT, np.float32)
    head = head_of(skeleton)
    if head >= 0:
        radii[head] = HEAD
    elif not skeleton.bones():
        radii[:] = JOINT * 0.8
    radii[~np.isfinite(joints).all(axis=1)] = HIDDEN
    turns = np.tile(np.array([1, 0, 0, 0], np.float32), (len(skeleton), 1))
    return Solids(np.nan_to_num(joints).astype(np.float32), turns, np.repeat(radii[:, None], 3, axis=1))


def joined(parts: list[Solids]) -> Solids:
    """Return several lists of copies as one."""
    return Solids(
        np.concatenate([part.places for part in parts]),
        np.concatenate([part.turns for part in parts]),
        np.concatenate([part.sizes for part in parts]),
    )


def _turn_from_z(unit: NDArray[np.floating]) -> Floats:
    """Return the shortest turns from the z axis to unit vectors (n, 3), as (n, 4) quaternions wxyz."""
    x, y, z = unit.T
    turns = np.stack([1 + z, -y, x, np.zeros_like(z)], axis=1)
    turns[z < -0.9999] = (0.0, 1.0, 0.0, 0.0)
    return np.asarray(turns / np.linalg.norm(turns, axis=1, keepdims=True), np.float32)


def _turned(profile: list[tuple[float, float]], sides: int) -> tuple[Floats, NDArray[np.uint32]]:
    """Return the solid of revolution of (radius, height) pairs, from bottom to top."""
    angles = np.arange(sides) * (2 * np.pi / sides)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rows = [np.column_stack([ring * radius, np.full(sides, height)]) for radius, height in profile]
    faces = []
    for row in range(len(profile) - 1):
        for i in range(sides):
            a, b = row * sides + i, row * sides + (i + 1) % sides
            faces += [(a, b, b + sides), (a, b + sides, a + sides)]
    return np.concatenate(rows).astype(np.float32), np.array(faces, np.uint32)
