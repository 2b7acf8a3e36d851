"""Recordings with rotations as BVH text, to be cut into parts.

A BVH stays as it was written, hierarchy and numbers, so that it fits the rig it was made with. Where joints
above the body are left out, the joint below them is the root and has their motion, too. Other rotations get a hierarchy
in centimetres, all joints turned about z, y and x.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.assembly import unique_names
from mossar_adapters.files.bvh import OpenedBvh, motion_chunk, opened_bvh
from mossar_adapters.files.bvh_hierarchy import BvhJoint
from mossar_adapters.files.kinematics import JointMotion, world_transforms
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.registry import format_of, open_motion
from mossar_adapters.files.text import numbered_lines

_CM = 100.0  # in a metre
_TURNS = "Zrotation Yrotation Xrotation"
_ROOT_CHANNELS = f"6 Xposition Yposition Zposition {_TURNS}"
_UPRIGHT = 1 - 1e-9  # sine of the second angle from which on the first and third turn about the same axis


class BvhText(msgspec.Struct, frozen=True):
    """A recording as BVH, frame by frame.

    Args:
        hierarchy: Lines up to and with MOTION.
        step: Time between frames, s, as written.
        rows: Called for a fresh pass over the frames, a line each.
    """

    hierarchy: tuple[str, ...]
    step: str
    rows: Callable[[], Iterator[str]]

    def part(self, rows: list[str]) -> str:
        """Return a file with these rows."""
        head = [*self.hierarchy, f"Frames: {len(rows)}", f"Frame Time: {self.step}"]
        return "\n".join([*head, *rows, ""])


def bvh_text(path: Path, options: ReadOptions, left_out: Collection[str] = ()) -> BvhText | None:
    """Return a recording as BVH; None if it has no rotations.

    Args:
        path: Path of the file.
        options: How it is read.
        left_out: Joints that are no part of the body. Those of a BVH from the topmost one down to the body are left out.

    Raises:
        FileError: If it cannot be read.
    """
    form = format_of(path)
    if not form.motion:
        return None
    if form.name != "BVH":
        return _converted(open_motion(path, options))
    opened = opened_bvh(path, options)
    root = _below(opened.hierarchy.joints, left_out)
    return _as_written(path, opened, options) if root == 0 else _from(opened, root, options)


def _as_written(path: Path, opened: OpenedBvh, options: ReadOptions) -> BvhText:
    head = [text for number, text in numbered_lines(path) if number <= opened.hierarchy.motion_line]

    def lines() -> Iterator[str]:
        for block in opened.rows.blocks():
            yield from (" ".join(cells) for cells in block.cells)

    return BvhText(tuple(head), _step(opened, options), lines)


def _step(opened: OpenedBvh, options: ReadOptions) -> str:
    return f"{1 / options.fps:.9g}" if options.fps else opened.step


def _below(joints: list[BvhJoint], left_out: Collection[str]) -> int:
    """Return the first joint on which all others hang that are not left out; 0 if there is none."""
    names = unique_names([joint.name for joint in joints])
    root = next((k for k, name in enumerate(names) if name not in left_out), 0)
    chain = [joint.parent for joint in joints[: root + 1]] == list(range(-1, root))
    return root if chain and all(joint.parent >= root for joint in joints[root + 1 :]) else 0


def _from(opened: OpenedBvh, root: int, options: ReadOptions) -> BvhText:
    """Return a BVH from one joint on; where it is and how it is turned is that in the world."""
    joints, rows = opened.hierarchy.joints, opened.rows
    parents = tuple(joint.parent for joint in joints)
    below = sum(len(joint.channels) for joint in joints[root + 1 :])
    children: list[list[int]] = [[] for _ in joints]
    for joint, parent in enumerate(parents[root + 1 :], root + 1):
        children[parent].append(joint)

    def lines() -> Iterator[str]:
        for block in rows.blocks():
            turned, places = world_transforms(motion_chunk(block, rows, opened.hierarchy, 1.0, 1.0), parents)
            own = np.concatenate([places[:, root], np.degrees(zyx_angles(turned[:, root]))], axis=1)
            for values, cells in zip(own.tolist(), block.cells, strict=True):
                yield " ".join([*(f"{value:.9g}" for value in values), *cells[len(cells) - below :]])

    head = ["HIERARCHY", *_written_lines(joints, root, children, 0), "MOTION"]
    return BvhText(tuple(head), _step(opened, options), lines)


def _written_lines(joints: list[BvhJoint], joint: int, children: list[list[int]], depth: int) -> list[str]:
    """Return the lines of a joint, a root at depth 0, and of all below it."""
    own = joints[joint]
    is_end = depth > 0 and not children[joint] and not own.channels
    channels = [f"{name[0].upper()}{name[1:]}" for name in own.channels]
    return _block_lines(
        "End Site" if is_end else f"{'JOINT' if depth else 'ROOT'} {own.name}",
        own.offset if depth else (0.0, 0.0, 0.0),
        None if is_end else f"{len(channels)} {' '.join(channels)}" if depth else _ROOT_CHANNELS,
        [line for child in children[joint] for line in _written_lines(joints, child, children, depth + 1)],
        depth,
    )


def _block_lines(
    heading: str, offset: Iterable[float], channels: str | None, below: list[str], depth: int
) -> list[str]:
    edge = "\t" * depth
    inner = [f"OFFSET {' '.join(f'{value:.9g}' for value in offset)}"]
    inner += [] if channels is None else [f"CHANNELS {channels}"]
    return [
        f"{edge}{heading}",
        f"{edge}{{",
        *(f"{edge}\t{line}" for line in inner),
        *below,
        f"{edge}}}",
    ]


def _converted(motion: JointMotion) -> BvhText:
    children: list[list[int]] = [[] for _ in motion.parents]
    for joint, parent in enumerate(motion.parents):
        if parent >= 0:
            children[parent].append(joint)
    roots = [joint for joint, parent in enumerate(motion.parents) if parent < 0]
    order = [joint for root in roots for joint in _with_those_below(root, children)]
    order = [joint for joint in order if children[joint] or joint in roots]  # ends have no channels
    head = [
        "HIERARCHY",
        *(line for root in roots for line in _joint_lines(motion, root, children, 0)),
        "MOTION",
    ]

    def lines() -> Iterator[str]:
        for chunk in motion.chunks():
            angles = np.degrees(zyx_angles(chunk.rotations))
            for turns, places in zip(angles, _CM * chunk.translations, strict=True):
                numbers = [
                    value for j in order for value in ((*places[j], *turns[j]) if j in roots else turns[j])
                ]
                yield " ".join(f"{value:.9g}" for value in numbers)

    return BvhText(tuple(head), f"{1 / motion.fps:.9g}", lines)


def _with_those_below(joint: int, children: list[list[int]]) -> list[int]:
    """Return a joint and all below it, in the order of the file."""
    return [joint, *(own for child in children[joint] for own in _with_those_below(child, children))]


def _joint_lines(motion: JointMotion, joint: int, children: list[list[int]], depth: int) -> list[str]:
    is_root = motion.parents[joint] < 0
    is_end = not is_root and not children[joint]
    return _block_lines(
        "End Site" if is_end else f"{'ROOT' if is_root else 'JOINT'} {motion.names[joint]}",
        _CM * motion.offsets[joint],
        None if is_end else _ROOT_CHANNELS if is_root else f"3 {_TURNS}",
        [line for child in children[joint] for line in _joint_lines(motion, child, children, depth + 1)],
        depth,
    )


def zyx_angles(rotations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angles about z, y and x whose turns, in this order from the left, make up rotations.

    Args:
        rotations: (..., 3, 3).

    Returns:
        (..., 3) rad. Where y is a quarter turn, z and x turn about the same axis, and x is 0.
    """
    r = rotations
    upright = np.abs(r[..., 2, 0]) > _UPRIGHT
    z = np.where(upright, np.arctan2(-r[..., 0, 1], r[..., 1, 1]), np.arctan2(r[..., 1, 0], r[..., 0, 0]))
    y = np.arcsin(np.clip(-r[..., 2, 0], -1.0, 1.0))
    x = np.where(upright, 0.0, np.arctan2(r[..., 2, 1], r[..., 2, 2]))
    return np.stack([z, y, x], axis=-1)
