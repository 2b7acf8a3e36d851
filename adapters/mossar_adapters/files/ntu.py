"""NTU RGB+D `.skeleton`: Kinect v2 bodies in text, 25 joints, metres, 30 frames per second.

The file states its number of frames, each frame its number of bodies, each body its number of joints. Bodies are
performers in the order in which they appear. Joints that are not tracked are missing, inferred ones have
confidence 0.5.
"""

from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np

from mossar_adapters.files.assembly import in_metres, sane_frames, skeleton_of
from mossar_adapters.files.cells import numbers
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.rows import CHUNK
from mossar_adapters.files.text import numbered_lines
from mossar_adapters.files.units import stated_scale
from mossar_adapters.joint_sets import NTU_25
from mossar_adapters.source import Recording
from mossar_stream import Frames

FPS = 30.0
JOINTS = len(NTU_25)
_JOINT_WIDTH = 12  # x y z, depth and colour pixel, quaternion, state
_MAX_BODIES = 64


class Body(msgspec.Struct, frozen=True):
    """One body in one frame.

    Args:
        frame: Index of the frame.
        body: Identifier as written.
        lines: Line number of each joint.
        joints: 25 rows of cells.
    """

    frame: int
    body: str
    lines: list[int]
    joints: list[list[str]]


class Cut(Exception):  # noqa: N818 - it is no error when whole frames came before
    """The file ended in the middle of a frame."""


def read(path: Path, options: ReadOptions) -> Recording:
    """Read all bodies."""
    announced, whole, bodies = _survey(path)
    if not bodies:
        raise FileError(path, "there is no body in the file")
    names = {body: f"p{i + 1}" for i, body in enumerate(bodies)}
    fps = options.fps or FPS
    notes = (f"the file is cut off: {whole} of {announced} frames are there",) if whole < announced else ()

    def chunks() -> Iterator[Frames]:
        gathered: dict[str, list[Body]] = {body: [] for body in bodies}
        for found in _bodies(path, whole):
            waiting = gathered[found.body]
            if len(waiting) == CHUNK or (waiting and found.frame != waiting[-1].frame + 1):
                yield _frames(path, names[found.body], waiting, fps)
                waiting.clear()
            waiting.append(found)
        for body, waiting in gathered.items():
            if waiting:
                yield _frames(path, names[body], waiting, fps)

    skeleton = skeleton_of(path, NTU_25.names, NTU_25.parents, NTU_25.root)
    count = sum(bodies.values())
    recording = Recording(str(path), skeleton, fps, chunks, notes, count, tuple(names.values()))
    return in_metres(recording, stated_scale(options, 1.0))


def _frames(path: Path, name: str, bodies: list[Body], fps: float) -> Frames:
    rows = [cells for body in bodies for cells in body.joints]
    values = numbers(rows, path, [line for body in bodies for line in body.lines])
    values = values.reshape(len(bodies), JOINTS, _JOINT_WIDTH)
    state = values[:, :, -1]
    frames = np.array([body.frame for body in bodies])
    confidence = np.where(state == 2, 1.0, np.where(state == 1, 0.5, 0.0))
    positions = np.where(state[:, :, None] > 0, values[:, :, :3], np.nan)
    return sane_frames(positions, frames / fps, confidence, name, int(frames[0]))


def _survey(path: Path) -> tuple[int, int, dict[str, int]]:
    """Return the announced and the whole frames, and the number of frames of each body in these."""
    lines = numbered_lines(path)
    announced = _count(path, lines, 10**9)
    whole, bodies = 0, dict[str, int]()
    try:
        for whole in range(announced):
            for found in _frame(path, lines, whole):
                bodies[found.body] = bodies.get(found.body, 0) + 1
    except Cut:
        bodies = {}
        for found in _bodies(path, whole):
            bodies[found.body] = bodies.get(found.body, 0) + 1
        return announced, whole, bodies
    return announced, announced, bodies


def _bodies(path: Path, frames: int) -> Iterator[Body]:
    lines = numbered_lines(path)
    _count(path, lines, 10**9)
    for frame in range(frames):
        yield from _frame(path, lines, frame)


def _frame(path: Path, lines: Iterator[tuple[int, str]], frame: int) -> list[Body]:
    """Return the bodies of the next frame.

    Raises:
        Cut: If the file ends within it.
    """
    bodies = []
    for _ in range(_count(path, lines, _MAX_BODIES)):
        line, info = _line(lines)
        words = info.split()
        if not words:
            raise FileError(path, "a body has no identifier", line)
        joints = _count(path, lines, 1000)
        if joints != JOINTS:
            raise FileError(path, f"a body has {joints} joints instead of {JOINTS}", line)
        rows = [_line(lines) for _ in range(JOINTS)]
        cells = [text.split() for _, text in rows]
        for (number, _), row in zip(rows, cells, strict=True):
            if len(row) != _JOINT_WIDTH:
                if next(lines, None) is None:
                    raise Cut
                raise FileError(path, f"a joint has {len(row)} values instead of {_JOINT_WIDTH}", number)
        bodies.append(Body(frame, words[0], [number for number, _ in rows], cells))
    return bodies


def _line(lines: Iterator[tuple[int, str]]) -> tuple[int, str]:
    found = next(lines, None)
    if found is None:
        raise Cut
    return found


def _count(path: Path, lines: Iterator[tuple[int, str]], limit: int) -> int:
    line, text = _line(lines)
    word = text.strip()
    if not word.isdecimal() or len(word) > 9 or int(word) > limit:
        raise FileError(path, f"{shown(word)} is not a count", line)
    return int(word)
