"""Clips: each segment of a recording as a recording of its own, and a table of them.

A clip has the frames from its first up to that with which the next one begins, the last clip also the last frame: one
after the other they are the recording again.
"""

import csv
import itertools
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mossar_adapters.files.bvh_text import BvhText, bvh_text
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.loaded import LoadedRecording
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.output import OutputError
from mossar_stream import Segment

TABLE = "clips.csv"


def check_clips(folder: Path, *, replace: bool) -> None:
    """Check that clips can be written to a folder, which is made if it is not there.

    Raises:
        FileError: If they cannot, or there is something in it and `replace` is not given.
    """
    if folder.exists() and not folder.is_dir():
        raise FileError(folder, "this is a file; clips go to a folder")
    if not folder.parent.is_dir():
        raise FileError(folder, f"there is no folder {folder.parent}")
    if folder.exists() and any(folder.iterdir()) and not replace:
        raise FileError(folder, "there are files in it already; --force writes among them")


def write_clips(
    folder: Path,
    whole: LoadedRecording,
    segments: Sequence[Segment],
    rows: Sequence[Mapping[str, Any]],
    options: ReadOptions,
) -> int:
    """Write a clip for each segment: `.bvh` where the recording has rotations, otherwise `.npz`.

    Args:
        folder: Made if it is not there.
        whole: The recording.
        segments: Of it, in the order of time.
        rows: What the table has of each.
        options: How the recording was read.

    Returns:
        How many clips there are.

    Raises:
        MossarError: If the recording cannot be read again, or a clip cannot be written.
    """
    path = Path(whole.name)
    text = bvh_text(path, options) if path.exists() else None
    stem = path.stem if path.exists() else whole.performer
    names = [f"{stem}-{n:04d}.{'npz' if text is None else 'bvh'}" for n in range(1, len(segments) + 1)]
    spans = [(part.start_frame, part.end_frame) for part in segments]
    spans[-1:] = [(start, end + 1) for start, end in spans[-1:]]
    try:
        folder.mkdir(exist_ok=True)
        if text is None:
            for name, span in zip(names, spans, strict=True):
                _write_npz(folder / name, whole, slice(*span))
        else:
            for name, content in zip(names, _parts(text, spans), strict=True):
                (folder / name).write_text(content, encoding="utf-8")
        _write_table(folder / TABLE, [{"clip": n, **row} for n, row in zip(names, rows, strict=True)])
    except OSError as error:
        raise OutputError(f"{folder}: clips cannot be written: {error.strerror or error}") from None
    return len(names)


def _parts(text: BvhText, spans: Sequence[tuple[int, int]]) -> Iterator[str]:
    """Yield the file of each span, in one pass over the recording."""
    rows, done = text.rows(), 0
    for start, end in spans:
        yield text.part(list(itertools.islice(rows, start - done, end - done)))
        done = end


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
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]) if rows else ["clip"], lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
