"""AMC: rotations of the bones of an ASF skeleton, in text.

A frame is a line with its number and one line per bone. Joints of the recording are the ends of the bones
(the root is its own). The motion of a bone about its own axes C is, in the axes of the world at rest,
C·R·C⁻¹. AMC states no rate: CMU's 120 Hz is taken.
"""

from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.asf import Acclaim, Bone, read_skeleton, skeleton_path
from mossar_adapters.files.assembly import sane_frames, skeleton_of, unique_names
from mossar_adapters.files.cells import is_number, numbers
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.kinematics import JointMotion, MotionChunk, euler_rotations, joint_positions
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.rates import assumed_rate
from mossar_adapters.files.rows import CHUNK
from mossar_adapters.files.text import ends_in_mid_line, numbered_lines
from mossar_adapters.files.units import Scale, guessed_scale, height, stated_scale
from mossar_adapters.source import Recording
from mossar_stream import Frames, constant_times

USUAL_FPS = 120.0
PEOPLE = (0.5, 2.5)  # m; an ASF whose unit makes people larger or smaller means something else by it


class Layout(msgspec.Struct, frozen=True):
    """The meaning of each word of a frame; all frames have the same bones in the same order.

    Args:
        width: Words per frame.
        names: Word index and bone name of each bone line.
        columns: Word index of each number.
        first: Index in `columns` of each bone's first number; -1 for a bone that does not move.
    """

    width: int
    names: tuple[tuple[int, str], ...]
    columns: tuple[int, ...]
    first: tuple[int, ...]


class AmcFile(msgspec.Struct, frozen=True):
    """A recording whose skeleton and layout are known.

    Args:
        path: The file.
        acclaim: Its skeleton.
        layout: Of every frame.
        degrees: Whether its angles are in degrees.
        count: Number of whole frames.
        cut: Whether one more was cut off.
    """

    path: Path
    acclaim: Acclaim
    layout: Layout
    degrees: bool
    count: int
    cut: bool


class AmcBlock(msgspec.Struct, frozen=True):
    """The numbers of consecutive frames.

    Args:
        start: Index of the first frame, from 0.
        lines: Line number of each frame.
        cells: The numbers of each frame, as written.
    """

    start: int
    lines: list[int]
    cells: list[list[str]]


def read(path: Path, options: ReadOptions) -> Recording:
    """Read the positions of the bone ends."""
    skeleton = read_skeleton(skeleton_path(path, options.skeleton))
    motion = read_motion(path, options)
    ends = _ends(motion, len(skeleton.bones))

    def chunks() -> Iterator[Frames]:
        for chunk in motion.chunks():
            yield sane_frames(joint_positions(chunk, motion.parents)[:, ends], chunk.times)

    names = [bone.name for bone in skeleton.bones]
    joints = skeleton_of(path, names, [bone.parent for bone in skeleton.bones])
    return Recording(str(path), joints, motion.fps, chunks, motion.notes, motion.frame_count)


def read_motion(path: Path, options: ReadOptions) -> JointMotion:
    """Read joint rotations; each joint is the beginning of its bone, and bones without children get an end."""
    acclaim = read_skeleton(skeleton_path(path, options.skeleton))
    layout = _layout(path, acclaim)
    degrees = _in_degrees(path, default=acclaim.degrees)
    amc = AmcFile(path, acclaim, layout, degrees, *_count_frames(path, layout))
    fps = options.fps or USUAL_FPS
    names, parents, offsets = _joints(acclaim)
    scale = _scale(amc, options)

    def chunks() -> Iterator[MotionChunk]:
        for block in _blocks(amc):
            yield _motion_chunk(amc, block, fps, scale.metres)

    notes = [scale.note] if scale.note else []
    if options.fps is None:
        notes.append(assumed_rate("an AMC does not state it", USUAL_FPS))
    if amc.cut:
        notes.append(f"the file is cut off in its last frame; {amc.count} frames are whole")
    return JointMotion(names, parents, offsets * scale.metres, fps, amc.count, chunks, tuple(notes))


def _joints(acclaim: Acclaim) -> tuple[tuple[str, ...], tuple[int, ...], NDArray[np.float64]]:
    """Return joints at the beginnings of the bones, followed by the ends of bones without children."""
    bones = acclaim.bones
    leaves = sorted(set(range(1, len(bones))) - {bone.parent for bone in bones})
    names = [bone.name for bone in bones] + [f"{bones[leaf].name}_End" for leaf in leaves]
    parents = [bone.parent for bone in bones] + leaves
    offsets = [np.zeros(3) if parent < 0 else bones[parent].vector for parent in parents]
    return unique_names(names), tuple(parents), np.array(offsets)


def _ends(motion: JointMotion, bones: int) -> NDArray[np.intp]:
    """Return, for each bone, a joint that sits at its end; the root is its own."""
    child = {parent: joint for joint, parent in enumerate(motion.parents)}
    return np.array([0, *(child[bone] for bone in range(1, bones))], dtype=np.intp)


def _frame_blocks(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield each frame as the number of its first line and its words without the frame number."""
    start, words, inside = 0, list[str](), False
    for line, text in numbered_lines(path):
        row = text.split()
        if not row or row[0][0] in "#:":
            continue
        if len(row) == 1 and row[0].isdecimal():
            if inside:
                yield start, words
            start, words, inside = line, [], True
        elif not inside:
            raise FileError(path, f"{shown(row[0])} stands before the first frame number", line)
        else:
            words += row
    if inside:
        yield start, words


def _in_degrees(path: Path, *, default: bool) -> bool:
    """Return whether the angles are in degrees, by the heading or, without a unit there, by the skeleton."""
    for _, text in numbered_lines(path):
        word = text.strip().lower()
        if word.isdecimal():
            break
        if word in {":degrees", ":radians"}:
            return word == ":degrees"
    return default


def _layout(path: Path, acclaim: Acclaim) -> Layout:
    """Return the layout of the first frame.

    Raises:
        FileError: If there is no frame or its bones are not those of the skeleton.
    """
    start, words = next(_frame_blocks(path), (0, []))
    if not words:
        raise FileError(path, "there is no frame in the file")
    place = {bone.name: i for i, bone in enumerate(acclaim.bones)}
    names: list[tuple[int, str]] = []
    columns: list[int] = []
    first = [-1] * len(acclaim.bones)
    at = 0
    while at < len(words):
        bone = place.get(words[at])
        if bone is None or first[bone] >= 0:
            raise FileError(path, f"{shown(words[at])} is no bone of the skeleton, or comes twice", start)
        names.append((at, words[at]))
        first[bone] = len(columns)
        count = len(acclaim.bones[bone].dofs)
        columns += range(at + 1, at + 1 + count)
        at += 1 + count
    return Layout(at, tuple(names), tuple(columns), tuple(first))


def _count_frames(path: Path, layout: Layout) -> tuple[int, bool]:
    """Return the number of whole frames and whether one more was cut off."""
    count, last = 0, list[str]()
    for _, words in _frame_blocks(path):
        count, last = count + 1, words
    cut = len(last) < layout.width or (ends_in_mid_line(path) and not is_number(last[-1]))
    if count == cut:
        raise FileError(path, "there is no whole frame in the file")
    return count - cut, cut


def _blocks(amc: AmcFile) -> Iterator[AmcBlock]:
    """Yield the whole frames, up to `CHUNK` at a time."""
    done, lines, cells = 0, list[int](), list[list[str]]()
    for line, words in _frame_blocks(amc.path):
        if done + len(cells) == amc.count:
            break
        if len(words) != amc.layout.width or any(words[at] != name for at, name in amc.layout.names):
            raise FileError(amc.path, "the frame has other bones or values than the first one", line)
        lines.append(line)
        cells.append([words[column] for column in amc.layout.columns])
        if len(cells) == CHUNK:
            yield AmcBlock(done, lines, cells)
            done, lines, cells = done + CHUNK, [], []
    if cells:
        yield AmcBlock(done, lines, cells)


def _motion_chunk(amc: AmcFile, block: AmcBlock, fps: float, metres: float) -> MotionChunk:
    values = numbers(block.cells, amc.path, block.lines)
    _, parents, offsets = _joints(amc.acclaim)
    rotations = np.broadcast_to(np.eye(3), (len(values), len(parents), 3, 3)).copy()
    translations = np.broadcast_to(offsets, (len(values), len(parents), 3)).copy()
    axes = amc.acclaim.own_axes()
    for i, bone in enumerate(amc.acclaim.bones):
        first = amc.layout.first[i]
        if first < 0:
            continue
        own = values[:, first : first + len(bone.dofs)]
        rotations[:, i] = axes[i] @ _own_rotations(bone, own, degrees=amc.degrees) @ axes[i].T
        for k, dof in enumerate(bone.dofs):
            if i == 0 and dof[0] == "t":
                translations[:, 0, "xyz".index(dof[1])] = own[:, k]
    return MotionChunk(rotations, translations * metres, constant_times(len(values), fps, block.start))


def _own_rotations(bone: Bone, own: NDArray[np.float64], *, degrees: bool) -> NDArray[np.float64]:
    """Return the turn of a bone about its own axes; its axes are in the order of the turns."""
    column = {dof[1]: k for k, dof in enumerate(bone.dofs) if dof[0] == "r"}
    axes = [axis for axis in bone.axis_order[::-1] if axis in column]
    angles = own[:, [column[axis] for axis in axes]]
    return euler_rotations(np.radians(angles) if degrees else angles, "".join(axes))


def _scale(amc: AmcFile, options: ReadOptions) -> Scale:
    chunk = _motion_chunk(amc, next(_blocks(amc)), USUAL_FPS, 1.0)
    tall = height(joint_positions(chunk, _joints(amc.acclaim)[1]))
    if PEOPLE[0] <= tall * amc.acclaim.metres <= PEOPLE[1]:
        return stated_scale(options, amc.acclaim.metres)
    return guessed_scale(options, tall)
