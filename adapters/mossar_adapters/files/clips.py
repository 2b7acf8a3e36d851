"""Clips: each segment, repetition or move of a recording as a recording of its own, and a table of them.

A clip of a segment has its frames up to the one with which the next segment begins. The last clip has the last frame, too: one
after the other they are the recording again.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mossar_adapters.files.bvh_text import bvh_text
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.loaded import LoadedRecording
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.output import OutputError
from mossar_adapters.files.registry import format_of
from mossar_adapters.files.replacing import Draft, check_places
from mossar_adapters.files.trials import trc_lines, trc_part, write_c3d_trial
from mossar_adapters.table_text import csv_text
from mossar_stream import Segment

TABLE = "clips.csv"
_NAME = re.compile(rf"{re.escape(TABLE)}|.*-\d{{4,}}(-.*)?\.\w+")  # files of a folder of clips


def check_clips(folder: Path, read: Sequence[str] = (), *, replace: bool) -> None:
    """Check that clips can be written to a folder, which is made if it is not there.

    Args:
        folder: Target folder.
        read: Recordings that are read, none of which a clip replaces.
        replace: Whether files in the folder may be replaced.

    Raises:
        FileError: If they cannot, or there is something in it and `replace` is not given.
    """
    if folder.exists() and not folder.is_dir():
        raise FileError(folder, "this is a file; clips go to a folder")
    if not folder.parent.is_dir():
        raise FileError(folder, f"there is no folder {folder.parent}")
    if folder.exists() and any(folder.iterdir()) and not replace:
        raise FileError(folder, "there are files in it already; --force writes among them")
    check_places(read, [str(path) for path in folder.glob("*") if _NAME.fullmatch(path.name)])


class Clip(NamedTuple):
    """A part of a recording that becomes one of its own.

    Args:
        start: First frame.
        end: The frame behind the last.
        name: Its name; empty for a segment.
    """

    start: int
    end: int
    name: str = ""


def clips_of_segments(segments: Sequence[Segment]) -> list[Clip]:
    """Return a clip for each segment; the last one has the last frame, too."""
    clips = [Clip(part.start_frame, part.end_frame) for part in segments]
    clips[-1:] = [Clip(start, end + 1) for start, end, _ in clips[-1:]]
    return clips


def write_clips(
    folder: Path,
    whole: LoadedRecording,
    clips: Sequence[Clip],
    rows: Sequence[Mapping[str, Any]],
    options: ReadOptions,
) -> int:
    """Write each clip: `.bvh` where the recording has rotations, `.c3d` and `.trc` of such, otherwise `.npz`.

    Args:
        folder: Made if it is not there.
        whole: The recording.
        clips: Of it.
        rows: The row of each in the table.
        options: How the recording was read.

    Returns:
        How many clips there are.

    Raises:
        MossarError: If the recording cannot be read again, or a clip cannot be written.
    """
    path = Path(whole.name)
    suffix, write = _writer(path, whole, options)
    stem = path.stem if path.exists() else whole.performer
    names = [f"{stem}-{n:04d}{_named(clip.name)}{suffix}" for n, clip in enumerate(clips, 1)]
    try:
        folder.mkdir(exist_ok=True)
        for name, clip in zip(names, clips, strict=True):
            with Draft(folder / name) as draft:
                write(draft.path, clip)
        _write_table(folder / TABLE, [{"clip": n, **row} for n, row in zip(names, rows, strict=True)])
    except OSError as error:
        raise OutputError(f"{folder}: clips cannot be written: {error.strerror or error}") from None
    return len(names)


def _named(name: str) -> str:
    """Return the part of a file's name that names its content."""
    plain = re.sub(r"[^\w.-]+", "_", name).strip("._")[:80]
    return f"-{plain}" if plain else ""


def _writer(
    path: Path, whole: LoadedRecording, options: ReadOptions
) -> tuple[str, Callable[[Path, Clip], object]]:
    """Return the suffix of clips, and their writer."""
    form = format_of(path).name if path.exists() else ""
    before, after = whole.outside  # the file is of the whole recording
    if form == "C3D":
        return ".c3d", lambda target, clip: write_c3d_trial(
            path, target, before + clip.start, before + clip.end
        )
    if form == "TRC":
        head, rows = trc_lines(path)
        if len(rows) == before + len(whole.times) + after:
            return ".trc", lambda target, clip: target.write_text(
                trc_part(head, rows[before + clip.start : before + clip.end]), encoding="utf-8"
            )
    text = bvh_text(path, options, whole.reference) if path.exists() else None
    if text is None:
        return ".npz", lambda target, clip: _write_npz(target, whole, slice(clip.start, clip.end))
    lines = list(text.rows())
    return ".bvh", lambda target, clip: target.write_text(
        text.part(lines[before + clip.start : before + clip.end]), encoding="utf-8"
    )


def _write_npz(path: Path, whole: LoadedRecording, span: slice) -> None:
    skeleton = whole.skeleton
    np.savez_compressed(
        path,
        positions=whole.positions[span],
        times=whole.times[span],
        joint_names=np.array(skeleton.names),
        parents=np.array(skeleton.parents, np.int64),
    )


def _write_table(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    columns = list(rows[0]) if rows else ["clip"]
    text = csv_text([columns, *([row.get(column, "") for column in columns] for row in rows)])
    with Draft(path) as draft:
        draft.path.write_bytes(text.encode())
