"""Recordings with rotations as BVH text, to be cut into parts.

A BVH stays as it was written, hierarchy and numbers, so that it fits the rig it was made with. Other
rotations get a hierarchy in centimetres, all joints turned about z, y and x.
"""

from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.bvh import motion_rows
from mossar_adapters.files.kinematics import JointMotion
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.registry import format_of, open_motion
from mossar_adapters.files.text import numbered_lines

_CM = 100.0  # in a metre
_TURNS = "Zrotation Yrotation Xrotation"
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


def bvh_text(path: Path, options: ReadOptions) -> BvhText | None:
    """Return a recording as BVH; None if it has no rotations.

    Raises:
        FileError: If it cannot be read.
    """
    form = format_of(path)
    if not form.motion:
        return None
    return _as_written(path, options) if form.name == "BVH" else _converted(open_motion(path, options))


def _as_written(path: Path, options: ReadOptions) -> BvhText:
    line, step, rows = motion_rows(path, options)
    head = [text for number, text in numbered_lines(path) if number <= line]

    def lines() -> Iterator[str]:
        for block in rows.blocks():
            yield from (" ".join(cells) for cells in block.cells)

    return BvhText(tuple(head), f"{1 / options.fps:.9g}" if options.fps else step, lines)


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
    heading = f"{'ROOT' if is_root else 'JOINT'} {motion.names[joint]}"
    channels = f"6 Xposition Yposition Zposition {_TURNS}" if is_root else f"3 {_TURNS}"
    inner = [f"OFFSET {' '.join(f'{_CM * value:.9g}' for value in motion.offsets[joint])}"]
    inner += [] if is_end else [f"CHANNELS {channels}"]
    below = [line for child in children[joint] for line in _joint_lines(motion, child, children, depth + 1)]
    edge = "\t" * depth
    return [
        f"{edge}{'End Site' if is_end else heading}",
        f"{edge}{{",
        *(f"{edge}\t{line}" for line in inner),
        *below,
        f"{edge}}}",
    ]


def zyx_angles(rotations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angles about z, y and x whose turns, one after the other from the left, make up rotations.

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
