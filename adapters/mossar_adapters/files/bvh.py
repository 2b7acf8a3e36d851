"""BVH: hierarchy and joint rotations in text.

Dialects read here: any order of rotations per joint, rotations before positions, position channels on any
joint (they replace its offset), several roots, names with spaces, CRLF, tabs, no final newline, no blank before a
negative number, no or other words for the rate, fewer or more rows than announced. End sites are joints, called after their parent (`Head_End`).
"""

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.assembly import sane_frames, skeleton_of, unique_names
from mossar_adapters.files.body import LEAST_BODY, body_joints, reference_joints
from mossar_adapters.files.bvh_hierarchy import GLUED, BvhJoint, Hierarchy, parse_hierarchy
from mossar_adapters.files.cells import is_number, number, numbers
from mossar_adapters.files.errors import FileError, shown
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
from mossar_stream import Frames, Skeleton, constant_times

_FRAMES = re.compile(r"frames\s*[:=]?\s*(\d{1,12})(?:\.0*)?$", re.IGNORECASE)
_FRAME_TIME = re.compile(r"frame\s*time\s*[:=]?\s*(.*)$", re.IGNORECASE)
_FRAME_RATE = re.compile(r"(?:frame\s*rate|fps)\s*[:=]?\s*([0-9.,]+)\s*(?:hz|fps)?$", re.IGNORECASE)
_SHARE = re.compile(r"1(?:\.0*)?\s*/\s*([0-9.]+)$")  # of a second
_TIME = re.compile(r"([-+]?[0-9.,]+(?:e[-+]?[0-9]+)?)\s*([a-z]*)\.?$", re.IGNORECASE)
_PER_SECOND = frozenset(["hz", "fps"])
_MILLISECONDS = frozenset(["ms", "msec", "msecs", "millisecond", "milliseconds"])
_SECONDS = frozenset(("", *["s", "sec", "secs", "second", "seconds"]))
_LONGEST_HEADER = 100  # characters
SLOWEST = 1.0  # Hz, below which a rate is doubted
SLOWEST_USUAL = 10.0  # Hz: a larger number as frame time, s, is a rate


class _Header(NamedTuple):
    """The lines between MOTION and the first frame."""

    frames: int | None
    step: str  # time between frames as written; empty if it is missing
    line: int  # number of the last line


class OpenedBvh(NamedTuple):
    """A file whose frames have been counted."""

    hierarchy: Hierarchy
    announced: int | None
    step: str  # s, as text
    fps: float
    rows: Rows
    notes: tuple[str, ...]


def read(path: Path, options: ReadOptions) -> Recording:
    """Read joint positions. Two bodies of the same joints are two performers."""
    motion, trees, notes = _read_all(path, options)

    def chunks() -> Iterator[Frames]:
        for chunk in motion.chunks():
            positions = joint_positions(chunk, motion.parents)
            for name, joints in trees.items():
                yield sane_frames(positions[:, joints], chunk.times, performer=name)

    first = _part(motion, next(iter(trees.values())))
    return Recording(
        str(path),
        skeleton_of(path, first.names, first.parents),
        motion.fps,
        chunks,
        (*motion.notes, *notes),
        motion.frame_count * len(trees),
        tuple(trees),
    )


def read_motion(path: Path, options: ReadOptions) -> JointMotion:
    """Read joint rotations, of several performers those of the one that is wanted, or else the first."""
    motion, trees, _ = _read_all(path, options)
    return _part(motion, trees.get(options.performer or "", next(iter(trees.values()))))


def _read_all(path: Path, options: ReadOptions) -> tuple[JointMotion, dict[str, list[int]], tuple[str, ...]]:
    """Return the rotations of all joints, the joints of each performer, and notes about others."""
    hierarchy, announced, _, fps, rows, noted = opened_bvh(path, options)
    names = unique_names([joint.name for joint in hierarchy.joints])
    trees, notes = _performers(names, hierarchy, options.performer)
    scale = _scale(hierarchy, rows, names, next(iter(trees.values())), options)

    def chunks() -> Iterator[MotionChunk]:
        for block in rows.blocks():
            yield motion_chunk(block, rows, hierarchy, fps, scale.metres)

    motion = JointMotion(
        names=names,
        parents=tuple(joint.parent for joint in hierarchy.joints),
        offsets=np.array([joint.offset for joint in hierarchy.joints]) * scale.metres,
        fps=fps,
        frame_count=rows.count,
        chunks=chunks,
        notes=(*cut_note(rows, announced), *noted, *((scale.note,) if scale.note else ())),
    )
    return motion, trees, notes


def _performers(
    names: tuple[str, ...], hierarchy: Hierarchy, wanted: str | None
) -> tuple[dict[str, list[int]], tuple[str, ...]]:
    """Return the joints of each performer: of each ROOT with a body below it, where there are several."""
    parents = [joint.parent for joint in hierarchy.joints]
    roots = [joint for joint, parent in enumerate(parents) if parent < 0]
    ends = [*roots[1:], len(parents)]
    trees = [list(range(root, end)) for root, end in zip(roots, ends, strict=True)]
    bodies = {f"p{n}": tree for n, tree in enumerate((t for t in trees if len(t) >= LEAST_BODY), 1)}
    if len(bodies) < 2:
        return {"p1": list(range(len(parents)))}, ()
    shapes = {name: [parents[joint] - tree[0] for joint in tree[1:]] for name, tree in bodies.items()}
    first = wanted if wanted in bodies else "p1"
    alike = {name: tree for name, tree in bodies.items() if shapes[name] == shapes[first]}
    ordered = {first: alike.pop(first), **alike}
    others = [
        f"{names[tree[0]]} ({name})" if name in bodies else names[tree[0]]
        for name, tree in [
            *((name, tree) for name, tree in bodies.items() if name not in ordered),
            *(("", tree) for tree in trees if len(tree) < LEAST_BODY),
        ]
    ]
    notes = (f"ROOT {', '.join(others[:8])} left out: other joints than {names[ordered[first][0]]}",)
    return dict(sorted(ordered.items(), key=lambda own: own[0] != first)), notes if others else ()


def _part(motion: JointMotion, joints: list[int]) -> JointMotion:
    """Return some joints of a motion, all that hang on its first one."""
    if len(joints) == len(motion.names):
        return motion
    place = {joint: n for n, joint in enumerate(joints)}

    def chunks() -> Iterator[MotionChunk]:
        for chunk in motion.chunks():
            yield MotionChunk(chunk.rotations[:, joints], chunk.translations[:, joints], chunk.times)

    return msgspec.structs.replace(
        motion,
        names=tuple(motion.names[joint] for joint in joints),
        parents=tuple(place.get(motion.parents[joint], -1) for joint in joints),
        offsets=motion.offsets[joints],
        chunks=chunks,
    )


def opened_bvh(path: Path, options: ReadOptions) -> OpenedBvh:
    """Return the hierarchy, the announced number of frames, time and rate, and the rows.

    Raises:
        FileError: If the file cannot be read.
    """
    lines = numbered_lines(path)
    hierarchy = parse_hierarchy(path, lines)
    header = _motion_header(path, lines)
    fps, notes = (options.fps, ()) if options.fps else _rate(path, header)
    rows = survey(path, header.line + 1, _splitter(hierarchy.width), hierarchy.width, exact=True)
    if header.frames is not None:
        rows = msgspec.structs.replace(
            rows, count=min(rows.count, header.frames), cut=rows.cut and header.frames > rows.count
        )
    if rows.count == 0:
        raise FileError(path, "the motion has 0 frames", header.line)
    is_plain = is_number(header.step) and rate_of_step(header.step) == fps
    step = header.step if is_plain else f"{1 / fps:.9g}"
    return OpenedBvh(hierarchy, header.frames, step, fps, rows, notes)


def _splitter(width: int) -> Callable[[str], list[str]]:
    """Return a function that splits a row into cells, also where a minus sign replaces the blank."""

    def split(text: str) -> list[str]:
        cells = text.split()
        return cells if len(cells) >= width else GLUED.sub(" -", text).split()

    return split


def _rate(path: Path, header: _Header) -> tuple[float, tuple[str, ...]]:
    """Return the rate that the file states, Hz, and notes where it is doubted.

    Raises:
        FileError: If it states none that is possible.
    """
    if not header.step:
        raise FileError(path, "MOTION has no 'Frame Time'; set --fps", header.line)
    if found := _SHARE.match(header.step):
        header = header._replace(step=f"{found[1]} Hz")
    found = _TIME.match(header.step)
    value, unit = (found[1].replace(",", "."), found[2].lower()) if found else ("nan", "")
    if unit in _SECONDS:
        fps = rate_of_step(value)
    elif unit in _MILLISECONDS and is_number(value):
        fps = rate_of_step(f"{number(value) / 1000:.{3 + len(value.partition('.')[2])}f}")
    else:
        fps = number(value) if unit in _PER_SECOND and is_number(value) else float("nan")
    if not plausible_rate(fps):
        written = shown(header.step) if not is_number(header.step) else f"{header.step} s"
        raise FileError(path, f"a frame time of {written} is impossible; set --fps", header.line)
    if fps >= SLOWEST or unit in _PER_SECOND:
        return fps, ()
    if 1 / fps >= SLOWEST_USUAL:
        rate = 1 / fps
        return rate, (f"a frame time of {header.step} s is taken as {rate:g} Hz; set --fps to change",)
    return fps, (
        f"a frame time of {header.step} s means {fps:.2g} Hz, which is unusual; set --fps to change",
    )


def _motion_header(path: Path, lines: Iterator[tuple[int, str]]) -> _Header:
    """Return the lines between MOTION and the first frame; each may be missing."""
    frames, step, last, line = None, "", None, 0
    for line, text in lines:
        text = text.partition("#")[0].strip()[:_LONGEST_HEADER]
        if found := _FRAMES.match(text):
            frames, last = int(found[1]), line
        elif found := _FRAME_TIME.match(text):
            step, last = found[1].strip().replace(",", "."), line
        elif found := _FRAME_RATE.match(text):
            step, last = f"{found[1]} Hz", line
        elif text:
            if last is None or not is_number(GLUED.sub(" -", text).split()[0]):
                last = None
                break
            return _Header(frames, step, last)
        if frames is not None and step:
            return _Header(frames, step, line)
    if last is None:
        raise FileError(path, "MOTION is not followed by 'Frames: N' and 'Frame Time: S'", line or None)
    return _Header(frames, step, last)


def _scale(
    hierarchy: Hierarchy, rows: Rows, names: tuple[str, ...], tree: list[int], options: ReadOptions
) -> Scale:
    """Return the scale of a performer's joints."""
    chunk = motion_chunk(next(rows.blocks()), rows, hierarchy, 1.0, 1.0)
    parents = tuple(joint.parent for joint in hierarchy.joints)
    rest = rest_positions(np.array([joint.offset for joint in hierarchy.joints]), parents)
    # People may begin curled up, and rest poses may be folded: the taller of the two is closer to the truth.
    rest, positions = rest[:, tree], joint_positions(chunk, parents)[:, tree]
    place = {joint: n for n, joint in enumerate(tree)}
    skeleton = Skeleton(
        tuple(names[joint] for joint in tree), tuple(place.get(parents[joint], -1) for joint in tree)
    )
    joints = body_joints(skeleton, reference_joints(skeleton, positions))
    if len(joints):
        rest, positions = rest[:, joints], positions[:, joints]
    tall = max(height(rest), height(positions))
    units = METRES
    if {"lhipjoint", "rhipjoint"} <= {name.lower() for name in names}:
        units = {**METRES, "inch/0.45 (CMU)": ACCLAIM_INCH}  # conversions of CMU recordings keep its unit
    return guessed_scale(options, tall, units)


def motion_chunk(block: Block, rows: Rows, hierarchy: Hierarchy, fps: float, metres: float) -> MotionChunk:
    """Return rows as rotations and translations; `metres` are those of the file's unit."""
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
