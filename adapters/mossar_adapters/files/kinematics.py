"""Forward kinematics: from joint rotations to joint positions, all frames at once.

The convention is BVH's: a joint sits at its translation in the frame of its parent and turns everything
below it. Loops run over the depth of the skeleton, never over frames.
"""

import functools
from collections.abc import Iterator
from typing import Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray


class MotionChunk(msgspec.Struct, frozen=True):
    """Consecutive frames of a skeleton as local rotations.

    Args:
        rotations: (n, J, 3, 3) float64, of each joint relative to its parent (columns are the turned axes).
        translations: (n, J, 3) float64, metres, of each joint in its parent's frame; that of the root is its
            place in the world. Equals the offsets where a joint only turns.
        times: (n,) float64, seconds.
    """

    rotations: NDArray[np.float64]
    translations: NDArray[np.float64]
    times: NDArray[np.float64]


class MotionChunks(Protocol):
    """One pass over the motion of a recording."""

    def __call__(self) -> Iterator[MotionChunk]:
        """Yield the motion in chunks of a few hundred frames."""


class JointMotion(msgspec.Struct, frozen=True):
    """A recording that has rotations; the position readers are built on it.

    Args:
        names: One per joint.
        parents: Index of each joint's parent, -1 without.
        offsets: (J, 3) float64, metres, rest place of each joint in its parent's frame.
        fps: Rate, Hz.
        frame_count: Number of whole frames.
        chunks: Called for a fresh pass.
        notes: For the user.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: NDArray[np.float64]
    fps: float
    frame_count: int
    chunks: MotionChunks
    notes: tuple[str, ...] = ()


def euler_rotations(angles: NDArray[np.float64], axes: str) -> NDArray[np.float64]:
    """Return the product of rotations about coordinate axes, in the given order from the left.

    Args:
        angles: (..., k) radians.
        axes: k letters of `xyz`; "zxy" gives Rz·Rx·Ry.

    Returns:
        (..., 3, 3) float64.
    """
    product = np.broadcast_to(np.eye(3), (*angles.shape[:-1], 3, 3))
    for k, axis in enumerate(axes):
        product = product @ _axis_rotation(angles[..., k], "xyz".index(axis))
    return product


def _axis_rotation(angle: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    second, third = (axis + 1) % 3, (axis + 2) % 3
    turned = np.zeros((*angle.shape, 3, 3))
    turned[..., axis, axis] = 1.0
    turned[..., second, second] = turned[..., third, third] = np.cos(angle)
    turned[..., third, second] = np.sin(angle)
    turned[..., second, third] = -turned[..., third, second]
    return turned


@functools.lru_cache(maxsize=64)
def joints_by_depth(parents: tuple[int, ...]) -> list[NDArray[np.intp]]:
    """Return the joints that have parents, grouped by their distance from the root, nearest first."""
    depth = [0] * len(parents)
    for joint in range(len(parents)):
        ancestor = parents[joint]
        while ancestor >= 0:
            depth[joint] += 1
            ancestor = parents[ancestor]
    return [
        np.array([joint for joint, d in enumerate(depth) if d == level], dtype=np.intp)
        for level in range(1, max(depth) + 1)
    ]


def world_transforms(
    motion: MotionChunk, parents: tuple[int, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rotations and the positions of the joints in the world.

    Returns:
        (n, J, 3, 3) and (n, J, 3) float64, metres.
    """
    world = motion.rotations.copy()
    positions = motion.translations.copy()
    above = np.array(parents, dtype=np.intp)
    for joints in joints_by_depth(parents):
        turn = world[:, above[joints]]
        step = turn @ motion.translations[:, joints, :, None]
        positions[:, joints] = positions[:, above[joints]] + step[..., 0]
        world[:, joints] = turn @ world[:, joints]
    return world, positions


def joint_positions(motion: MotionChunk, parents: tuple[int, ...]) -> NDArray[np.float64]:
    """Return the positions of the joints in the world.

    Returns:
        (n, J, 3) float64, metres.
    """
    return world_transforms(motion, parents)[1]


def rest_positions(offsets: NDArray[np.float64], parents: tuple[int, ...]) -> NDArray[np.float64]:
    """Return the positions of the joints when none of them turns.

    Returns:
        (1, J, 3) float64, in the unit of the offsets.
    """
    unturned = np.broadcast_to(np.eye(3), (1, len(parents), 3, 3))
    return joint_positions(MotionChunk(unturned, offsets[None], np.zeros(1)), parents)


def quaternions(rotations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rotations as unit quaternions.

    Each is taken from the largest of its four components, which keeps half turns exact.

    Args:
        rotations: (..., 3, 3).

    Returns:
        (..., 4) float64, x y z w, w >= 0.
    """
    m = rotations
    trace = np.trace(m, axis1=-2, axis2=-1)
    squares = np.stack([*(2 * m[..., k, k] - trace for k in range(3)), trace], axis=-1) + 1.0  # 4·component²
    skew = np.stack(
        [m[..., (k + 2) % 3, (k + 1) % 3] - m[..., (k + 1) % 3, (k + 2) % 3] for k in range(3)], -1
    )
    outer = np.empty((*m.shape[:-2], 4, 4))  # 4·component_i·component_j
    outer[..., :3, :3] = m + np.swapaxes(m, -1, -2)
    outer[..., 3, :3] = outer[..., :3, 3] = skew
    outer[..., range(4), range(4)] = squares
    best = np.argmax(squares, axis=-1)
    row = np.take_along_axis(outer, best[..., None, None], axis=-2)[..., 0, :]
    row = row / np.linalg.norm(row, axis=-1, keepdims=True)
    turned: NDArray[np.float64] = row * np.where(row[..., 3:] < 0, -1.0, 1.0)
    return turned
