"""Tables of markers, one row per frame: the common part of TRC, Motive and QTM."""

from collections.abc import Iterator, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.assembly import in_stated_unit, sane_frames, skeleton_of
from mossar_adapters.files.cells import numbers
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.missing import without_zeros
from mossar_adapters.files.options import ReadOptions, plausible_rate
from mossar_adapters.files.rates import rate_of_times
from mossar_adapters.files.rows import Block, Rows
from mossar_adapters.files.running_times import why_absurd
from mossar_adapters.files.subjects import subjects_of
from mossar_adapters.joint_sets import with_known_parents
from mossar_adapters.source import Recording
from mossar_stream import Frames, constant_times

RATES_DIFFER = 0.05  # share by which times contradict a stated rate


class MarkerTable(msgspec.Struct, frozen=True):
    """A table whose heading is understood.

    Args:
        rows: Its rows.
        labels: Name of each marker, with its subject in front if there are several.
        xyz: Column of x of each marker; y and z follow.
        fps: Rate in Hz as the file states it, None if it does not.
        metres: Metres per unit, None if the file states none.
        time: Column of the time in seconds, -1 without.
        frame: Column of the frame number, -1 without.
        first_number: Number of the first frame of a take in the file, 0 or 1.
        parents: Label of each marker's parent if the file has them.
        notes: For the user.
    """

    rows: Rows
    labels: tuple[str, ...]
    xyz: tuple[int, ...]
    fps: float | None
    metres: float | None
    time: int = -1
    frame: int = -1
    first_number: int = 0
    parents: Sequence[str | None] | None = None
    notes: tuple[str, ...] = ()


def read_markers(table: MarkerTable, options: ReadOptions) -> Recording:
    """Return the recording of a table.

    Raises:
        FileError: If there is no marker or no time.
    """
    path = table.rows.path
    subjects, notes = subjects_of(path, table.labels, options.performer)
    fps = options.fps or table.fps
    timed = options.fps is None and table.time >= 0 and _has_times(table)
    if timed:
        fps, timed, noted = _compared(_columns(next(table.rows.blocks()), table, [table.time])[:, 0], fps)
        notes = (*notes, *noted)
    if not timed and (fps is None or not plausible_rate(fps)):
        stated = "the file states neither rate nor times" if fps is None else f"{fps} Hz is no possible rate"
        raise FileError(path, f"{stated}; set --fps")
    if fps is not None and not plausible_rate(fps):
        fps = None
    trimmed = table.frame >= 0 and _first_frame(next(table.rows.blocks()), table) > 0

    def chunks() -> Iterator[Frames]:
        for block in table.rows.blocks():
            first = _first_frame(block, table) if trimmed else None
            times = _times(block, table, fps, timed=timed)
            for subject in subjects:
                positions = _positions(block, table, subject.columns)
                yield sane_frames(positions, times, performer=subject.name, first_frame=first)

    labels = subjects[0].labels
    parents, root = _parents(table, subjects[0].columns) or with_known_parents(labels)
    recording = Recording(
        path=str(path),
        skeleton=skeleton_of(path, labels, parents, root),
        fps=fps,
        chunks=chunks,
        notes=(*table.notes, *notes),
        frame_count=table.rows.count * len(subjects),
        performers=tuple(subject.name for subject in subjects),
    )
    return in_stated_unit(recording, options, table.metres)


def _compared(times: NDArray[np.float64], stated: float | None) -> tuple[float | None, bool, tuple[str, ...]]:
    """Return the rate of a table, whether its times are used, and notes where they contradict the stated rate, Hz."""
    found = rate_of_times(times)
    if stated is None:
        return found, True, ()
    if plausible_rate(stated) and (why := why_absurd(times)) is not None:
        return (
            stated,
            False,
            (f"the heading says {stated:g} Hz, {why}: the heading counts; set --fps to change",),
        )
    mean = (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 else stated  # times may be rounded
    if found is None or min(abs(rate / stated - 1) for rate in (found, mean)) <= RATES_DIFFER:
        return stated, True, ()
    note = f"the heading says {stated:g} Hz and the times say {found:.4g} Hz: the times count; set --fps to change"
    return found, True, (note,)


def _columns(block: Block, table: MarkerTable, columns: Sequence[int]) -> NDArray[np.float64]:
    """Return (n, len(columns)) numbers."""
    return numbers([[row[c] for c in columns] for row in block.cells], table.rows.path, block.lines)


def _positions(block: Block, table: MarkerTable, markers: Sequence[int]) -> NDArray[np.float64]:
    columns = [table.xyz[marker] + k for marker in markers for k in range(3)]
    return without_zeros(_columns(block, table, columns).reshape(len(block.cells), len(markers), 3))


def _has_times(table: MarkerTable) -> bool:
    times = _columns(next(table.rows.blocks()), table, [table.time])[:, 0]
    return bool(np.isfinite(times).all() and (len(times) < 2 or times[-1] > times[0]))


def _times(block: Block, table: MarkerTable, fps: float | None, *, timed: bool) -> NDArray[np.float64]:
    if not timed:
        return constant_times(len(block.cells), fps or 1.0, block.start)
    times = _columns(block, table, [table.time])[:, 0]
    for i in np.flatnonzero(~np.isfinite(times)):
        raise FileError(table.rows.path, "the row has no time", block.lines[i])
    return times


def _first_frame(block: Block, table: MarkerTable) -> int:
    """Return the number of the block's first frame, counted from 0."""
    number = _columns(Block(block.start, block.lines[:1], block.cells[:1]), table, [table.frame])[0, 0]
    return int(number) - table.first_number if np.isfinite(number) and abs(number) < 2**52 else block.start


def _parents(table: MarkerTable, columns: Sequence[int]) -> tuple[tuple[int, ...], int] | None:
    if table.parents is None:
        return None
    place = {table.labels[column]: i for i, column in enumerate(columns)}
    parents = tuple(place.get(table.parents[column] or "", -1) for column in columns)
    return parents, parents.index(-1) if any(p >= 0 for p in parents) and -1 in parents else -1
