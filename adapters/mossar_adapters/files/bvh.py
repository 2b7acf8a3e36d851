"""BVH: hierarchy and joint rotations in text.

Dialects read here: any order of rotations per joint, rotations before positions, position channels on any
joint (they replace its offset), several roots, names with spaces, CRLF, tabs, no final newline, fewer or
more rows than announced. End sites are joints, called after their parent (`Head_End`).
"""

import re
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.assembly import sane_frames, skeleton_of, unique_names
from mossar_adapters.files.bvh_hierarchy import BvhJoint, Hierarchy, parse_hierarchy
from mossar_adapters.files.cells import numbers
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.kinematics import (
    JointMotion,
    MotionChunk,
    euler_rotations,
    joint_positions,
    rest_positions,
)
from mossar_adapters.files.options import METRES, ReadOptions, plausible_rate
from mossar_adapters.files.rates import rate_of_step
from mossar_adapters.files.rows import Block, Rows, cut_note, survey
from mossar_adapters.files.text import numbered_lines
from mossar_adapters.files.units import ACCLAIM_INCH, Scale, guessed_scale, height
from mossar_adapters.source import Recording
from mossar_stream import Frames, constant_times

_FRAMES = re.compile(r"frames\s*:?\s*(\d{1,12})$", re.IGNORECASE)
_FRAME_TIME = re.compile(r"frame\s+time\s*:?\s*([0-9.,eE+-]+)$", re.IGNORECASE)
_LONGEST_HEADER = 100  # characters


def read(path: Path, options: ReadOptions) -> Recording:
    """Read joint positions."""
    motion = read_motion(path, options)

    def chunks() -> Iterator[Frames]:
        for chunk in motion.chunks():
            yield sane_frames(joint_positions(chunk, motion.parents), chunk.times)

    skeleton = skeleton_of(path, motion.names, motion.parents)
    return Recording(str(path), skeleton, motion.fps, chunks, motion.notes, motion.frame_count)


def read_motion(path: Path, options: ReadOptions) -> JointMotion:
    """Read joint rotations."""
    hierarchy, announced, step, rows = _opened(path, options)
    fps = options.fps or rate_of_step(step)
    names = unique_names([joint.name for joint in hierarchy.joints])
    scale = _scale(hierarchy, rows, names, options)

    def chunks() -> Iterator[MotionChunk]:
        for block in rows.blocks():
            yield _motion_chunk(block, rows, hierarchy, fps, scale.metres)

    return JointMotion(
        names=names,
        parents=tuple(joint.parent for joint in hierarchy.joints),
        offsets=np.array([joint.offset for joint in hierarchy.joints]) * scale.metres,
        fps=fps,
        frame_count=rows.count,
        chunks=chunks,
        notes=(*cut_note(rows, announced), *((scale.note,) if scale.note else ())),
    )


def motion_rows(path: Path, options: ReadOptions) -> tuple[int, str, Rows]:
    """Return the number of the line that says MOTION, the frame time as written, and the rows of channels.

    Raises:
        FileError: If the file cannot be read.
    """
    hierarchy, _, step, rows = _opened(path, options)
    return hierarchy.motion_line, step, rows


def _opened(path: Path, options: ReadOptions) -> tuple[Hierarchy, int, str, Rows]:
    """Return the hierarchy, the announced number of frames, the frame time as written, and the rows."""
    lines = numbered_lines(path)
    hierarchy = parse_hierarchy(path, lines)
    announced, step, last_line = _motion_header(path, lines)
    if options.fps is None and not plausible_rate(rate_of_step(step)):
        raise FileError(path, f"a frame time of {step} s is impossible; set --fps", last_line)
    rows = survey(path, last_line + 1, str.split, hierarchy.width, exact=True)
    rows = msgspec.structs.replace(
        rows, count=min(rows.count, announced), cut=rows.cut and announced > rows.count
    )
    if rows.count == 0:
        raise FileError(path, "the motion has 0 frames", last_line)
    return hierarchy, announced, step, rows


def _motion_header(path: Path, lines: Iterator[tuple[int, str]]) -> tuple[int, str, int]:
    """Return the announced number of frames, the frame time as written and the number of the last line of both."""
    frames, step = None, ""
    line = 0
    for line, text in lines:
        text = text.strip()[:_LONGEST_HEADER]
        if found := _FRAMES.match(text):
            frames = int(found[1])
        elif found := _FRAME_TIME.match(text):
            step = found[1].replace(",", ".")
        elif text and not text.startswith("#"):
            break
        if frames is not None and step:
            return frames, step, line
    raise FileError(path, "MOTION is not followed by 'Frames: N' and 'Frame Time: S'", line or None)


def _scale(hierarchy: Hierarchy, rows: Rows, names: tuple[str, ...], options: ReadOptions) -> Scale:
    chunk = _motion_chunk(next(rows.blocks()), rows, hierarchy, 1.0, 1.0)
    parents = tuple(joint.parent for joint in hierarchy.joints)
    rest = rest_positions(np.array([joint.offset for joint in hierarchy.joints]), parents)
    # People may begin curled up, and rest poses may be folded: the taller of the two is closer to the truth.
    tall = max(height(rest), height(joint_positions(chunk, parents)))
    units = METRES
    if {"lhipjoint", "rhipjoint"} <= {name.lower() for name in names}:
        units = {**METRES, "inch/0.45 (CMU)": ACCLAIM_INCH}  # conversions of CMU recordings keep its unit
    return guessed_scale(options, tall, units)


def _motion_chunk(block: Block, rows: Rows, hierarchy: Hierarchy, fps: float, metres: float) -> MotionChunk:
    values = numbers(block.cells, rows.path, block.lines)  # (n, channels)
    count = len(hierarchy.joints)
    rotations = np.empty((len(values), count, 3, 3))
    translations = np.empty((len(values), count, 3))
    for i, joint in enumerate(hierarchy.joints):
        rotations[:, i] = _joint_rotations(joint, values)
        translations[:, i] = joint.offset
        for k, channel in enumerate(joint.channels):
            if channel.endswith("position"):
                translations[:, i, "xyz".index(channel[0])] = values[:, joint.first_channel + k]
    return MotionChunk(rotations, translations * metres, constant_times(len(values), fps, block.start))


def _joint_rotations(joint: BvhJoint, values: NDArray[np.float64]) -> NDArray[np.float64]:
    turns = [(k, name[0]) for k, name in enumerate(joint.channels) if name.endswith("rotation")]
    columns = [joint.first_channel + k for k, _ in turns]
    angles = np.radians(np.where(np.isfinite(values[:, columns]), values[:, columns], np.nan))
    return euler_rotations(angles, "".join(axis for _, axis in turns))
