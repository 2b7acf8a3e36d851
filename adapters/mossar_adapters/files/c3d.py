"""C3D: markers of optical systems; integers or floats of Intel, DEC or SGI machines.

The own reader accepts files that libraries refuse (SGI byte order, odd parameters), and reads in blocks. Gaps
(negative residual, or a marker exactly at the origin) are missing. Numbers of frames and times are those of
the file: a recording trimmed to its frame 50 begins with frame 49 (from 0) at 49/rate; one that begins at
its first frame leaves `first_frame` to be counted.
"""

from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.assembly import in_stated_unit, sane_frames, skeleton_of
from mossar_adapters.files.c3d_parameters import (
    BLOCK,
    C3dHeader,
    Value,
    floats,
    integers,
    read_parameters,
)
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.missing import without_zeros
from mossar_adapters.files.options import ReadOptions, plausible_rate
from mossar_adapters.files.rows import CHUNK
from mossar_adapters.files.subjects import Subject, subjects_of
from mossar_adapters.joint_sets import with_known_parents
from mossar_adapters.source import Recording
from mossar_stream import Frames, Up, constant_times

_READ_SIZE = 16 << 20  # bytes at a time
_UNKNOWN = 65535  # frames: the largest number of 16 bits, also written for more
_UPWARDS: dict[str, Up] = {"+X": "x", "+Y": "y", "+Z": "z", "-X": "-x", "-Y": "-y", "-Z": "-z"}
_MOST = 2**32  # frames; more is damage
_NO_POSITIONS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS", "MODELED_MARKERS_ANGLES")


class Layout(msgspec.Struct, frozen=True):
    """Places of the frames.

    Args:
        machine: Whose byte order.
        points: Per frame.
        integer: Whether values are 2-byte integers, else floats.
        scale: Of integer coordinates.
        frame_size: Bytes, analogue values included.
        start: Byte of the first frame.
        first_frame: Its number, from 0.
        announced: Frames that there should be.
        count: Whole frames in the file.
    """

    machine: int
    points: int
    integer: bool
    scale: float
    frame_size: int
    start: int
    first_frame: int
    announced: int
    count: int


def read(path: Path, options: ReadOptions) -> Recording:
    """Read markers."""
    header, machine, parameters = read_parameters(path)
    layout = layout_of(path, header, machine, parameters)
    fps = options.fps or rate_of(path, header, parameters)
    labels, columns = _markers(path, parameters, layout.points)
    subjects, notes = subjects_of(path, labels, options.performer)
    notes = (*notes, *_unnamed(parameters, layout.points, labels))
    if layout.count < layout.announced:
        notes = (*notes, f"the file is cut off: {layout.count} of {layout.announced} frames are there")

    def chunks() -> Iterator[Frames]:
        for start, positions in _blocks(path, layout):
            for subject in subjects:
                yield _frames(
                    positions[:, [columns[c] for c in subject.columns]], subject, layout, start, fps
                )

    parents, root = with_known_parents(subjects[0].labels)
    skeleton = skeleton_of(path, subjects[0].labels, parents, root)
    performers = tuple(subject.name for subject in subjects)
    recording = Recording(
        str(path),
        skeleton,
        fps,
        chunks,
        notes,
        layout.count * len(subjects),
        performers,
        up=_UPWARDS.get(_text(parameters.get("POINT:Y_SCREEN")).upper(), "auto"),
    )
    return in_stated_unit(recording, options, _text(parameters.get("POINT:UNITS")))


def first_time(path: Path) -> float:
    """Return the time of the first frame on the clock of the file, s; frame 1 is at 0.

    Raises:
        FileError: If the file is damaged.
    """
    header, machine, parameters = read_parameters(path)
    return layout_of(path, header, machine, parameters).first_frame / rate_of(path, header, parameters)


def _frames(
    positions: NDArray[np.float64], subject: Subject, layout: Layout, start: int, fps: float
) -> Frames:
    first = layout.first_frame + start
    times = constant_times(len(positions), fps, first)
    number = first if layout.first_frame > 0 else None
    return sane_frames(positions, times, performer=subject.name, first_frame=number)


def layout_of(path: Path, header: C3dHeader, machine: int, parameters: dict[str, Value]) -> Layout:
    """Return the places of the frames of a file.

    Raises:
        FileError: If the file does not state it, or has no frames.
    """
    points = header.points or _integer(parameters.get("POINT:USED"))
    integer = header.scale > 0
    frame_size = (points * 4 + header.analog) * (2 if integer else 4)
    block = header.data_block if header.data_block > 1 else _integer(parameters.get("POINT:DATA_START"))
    start = (block - 1) * BLOCK
    if points == 0:
        raise FileError(path, "there are no markers in the file")
    if block < 2 or not np.isfinite(header.scale):
        raise FileError(path, "the header does not say where the markers are, or how they are scaled")
    room = max(0, path.stat().st_size - start) // frame_size
    first, announced = _span(header, parameters, room)
    filled = room if _integer(parameters.get("ROTATION:USED")) else _filled(path, start, frame_size)
    begun_again = 0 < announced < filled and (filled - announced) % 65536 == 0
    if announced == _UNKNOWN or begun_again:
        announced = filled
    if announced < 1:
        raise FileError(path, "there are no frames in the file")
    count = min(announced, room)
    if count == 0:
        raise FileError(path, "the file ends before its first whole frame")
    return Layout(machine, points, integer, header.scale, frame_size, start, first, announced, count)


def _span(header: C3dHeader, parameters: dict[str, Value], room: int) -> tuple[int, int]:
    """Return the number of the first frame, from 0, and the number of frames that the file states.

    The 16 bits of the header are too few for long recordings: some programs stop at 65535, some begin again
    at 0, and the true number stands in one of three parameters, or nowhere. Others keep the range of the
    recording that they took a part of.

    Args:
        header: The header.
        parameters: The parameters.
        room: Frames that fit into the file.
    """
    first, last = (_long(parameters.get(f"TRIAL:ACTUAL_{end}_FIELD")) for end in ("START", "END"))
    trial = last - first + 1 if first is not None and last is not None else 0
    frames = _integer(parameters.get("POINT:FRAMES"))
    longest = max(_integer(parameters.get("POINT:LONG_FRAMES")), frames, trial)
    begin = max(0, header.first_frame - 1)
    if header.first_frame <= header.last_frame < _UNKNOWN and not _UNKNOWN < longest <= room:
        count = header.last_frame - header.first_frame + 1
        return begin, frames if 0 < frames <= room < count else count
    if first is not None and trial == longest > 0:
        return max(0, first - 1), trial
    return begin, longest or (_UNKNOWN if header.last_frame == _UNKNOWN else 0)


def _filled(path: Path, start: int, frame_size: int) -> int:
    """Return the number of frames before the zeros that fill the last block."""
    end = path.stat().st_size
    with path.open("rb") as file:
        file.seek(max(start, end - BLOCK))
        end -= len(tail := file.read()) - len(tail.rstrip(b"\0"))
    return -((start - end) // frame_size)


def rate_of(path: Path, header: C3dHeader, parameters: dict[str, Value]) -> float:
    """Return the frames per second.

    Raises:
        FileError: If the file states nothing possible.
    """
    stated = parameters.get("POINT:RATE")
    rates = [float(stated[0])] if isinstance(stated, np.ndarray) and len(stated) else []
    for fps in (*rates, header.rate):
        if plausible_rate(fps):
            return fps
    raise FileError(path, f"a rate of {header.rate} Hz is impossible; set --fps")


def _unnamed(parameters: dict[str, Value], points: int, taken: list[str]) -> tuple[str, ...]:
    """Return a note about points that the tracking left without a name, as `*0`, if named ones are taken."""
    stars = [label for label in _labels(parameters)[:points] if label.startswith("*")]
    if not stars or set(stars) & set(taken) or taken == [f"point{i}" for i in range(points)]:
        return ()
    more = ", ..." if len(stars) > 3 else ""
    word = "points" if len(stars) > 1 else "point"
    return (f"{len(stars)} {word} without a name ({', '.join(stars[:3])}{more}) left out",)


def _labels(parameters: dict[str, Value]) -> list[str]:
    labels: list[str] = []
    for name in ("LABELS", *(f"LABELS{k}" for k in range(2, 300))):
        more = parameters.get(f"POINT:{name}")
        if not isinstance(more, list):
            break
        labels += more
    return labels


def _markers(path: Path, parameters: dict[str, Value], points: int) -> tuple[list[str], list[int]]:
    """Return labels and places of the points that are named markers; of all if none has a name."""
    labels = _labels(parameters)
    computed = {
        label
        for name in _NO_POSITIONS
        for label in parameters.get(f"POINT:{name}", [])
        if isinstance(label, str)
    }
    named = [
        i for i, label in enumerate(labels[:points]) if label and label[0] != "*" and label not in computed
    ]
    if named:
        return [labels[i] for i in named], named
    if points > BLOCK:
        raise FileError(path, f"there are {shown(str(points))} points without names")
    return [f"point{i}" for i in range(points)], list(range(points))


def _blocks(path: Path, layout: Layout) -> Iterator[tuple[int, NDArray[np.float64]]]:
    """Yield the index of the first frame and (n, points, 3), NaN where missing."""
    size = max(1, min(CHUNK, _READ_SIZE // layout.frame_size))
    with path.open("rb") as file:
        file.seek(layout.start)
        for start in range(0, layout.count, size):
            data = file.read(min(size, layout.count - start) * layout.frame_size)
            if len(data) < layout.frame_size:
                return
            yield start, _points(data[: len(data) // layout.frame_size * layout.frame_size], layout)


def _points(data: bytes, layout: Layout) -> NDArray[np.float64]:
    with np.errstate(all="ignore"):
        if layout.integer:
            values = integers(data, layout.machine).astype(np.float64)
        else:
            values = floats(data, layout.machine)
        rows = values.reshape(len(data) // layout.frame_size, -1)[:, : layout.points * 4]
        points = rows.reshape(len(rows), layout.points, 4)
        valid = (points[:, :, 3] >= 0)[:, :, None]
        positions = np.where(valid, points[:, :, :3] * (layout.scale if layout.integer else 1.0), np.nan)
    return without_zeros(positions)


def _text(value: Value | None) -> str:
    return value[0] if isinstance(value, list) and value else ""


def _integer(value: Value | None) -> int:
    """Return an unsigned integer, 0 if it is not one."""
    if not isinstance(value, np.ndarray) or not len(value) or not abs(value[0]) < _MOST:
        return 0
    number = int(value[0])
    return number + 65536 if -32768 <= number < 0 else max(0, number)


def _long(value: Value | None) -> int | None:
    """Return a 32-bit integer written as two words, low one first."""
    if not isinstance(value, np.ndarray) or len(value) < 2:
        return None
    low, high = (_integer(value[k : k + 1]) for k in (0, 1))
    return low + 65536 * high
