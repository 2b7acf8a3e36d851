"""Annotated recordings: cuts from the files of annotation programs, such as exports of mossar that a person corrected."""

import glob
from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.annotations.reading import SUFFIXES, chosen_tier
from mossar_adapters.annotations.tiers import KEY_FRAMES, SEGMENTS
from mossar_adapters.files.c3d_events import read_events
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.registry import FORMATS
from mossar_adapters.regular import check_regular
from mossar_tools.evaluation.matching import Cut

_NAMED = {".csv", ".tsv"}  # may be recordings: labels only if a label file or option names them
_C3D = ".c3d"  # a recording that may hold its own labels
_EDGE = 0.05  # s; a boundary nearer to an end of the recording is no cut


def annotated_recordings(folder: Path, described: AbstractSet[Path]) -> Iterator[tuple[Path, Path]]:
    """Yield annotation files and the recordings of the same name beside them.

    Args:
        folder: The folder to search, with the folders in it.
        described: Recordings that have labels already.
    """
    known = {suffix for form in FORMATS for suffix in form.extensions} - (SUFFIXES - {_C3D, *_NAMED})
    taken = set(described)
    for path in sorted(folder.rglob("*"), key=lambda path: (path.suffix.lower() == _C3D, path)):
        if path.suffix.lower() not in SUFFIXES - _NAMED or not path.is_file():
            continue
        if path.suffix.lower() == _C3D:
            if path not in taken and _has_events(path):
                yield path, path
            continue
        beside = [
            own
            for own in sorted(path.parent.glob(f"{glob.escape(path.stem)}.*"))
            if own.suffix.lower() in known
        ]
        if beside and beside[0] not in taken and not (path.suffix.lower() == ".json" and _is_no_list(path)):
            taken.add(beside[0])
            yield path, beside[0]


def is_annotated(path: Path) -> bool:
    """Return whether a file is from an annotation program, and not a label file of mossar."""
    suffix = path.suffix.lower()
    return suffix in SUFFIXES and not (suffix == ".json" and _is_no_list(path))


def annotated_cuts(
    path: Path, wanted: str | None, level: str, times: NDArray[np.float64], gap: float
) -> list[Cut]:
    """Return the cuts in a tier of an annotation file, s.

    Moments are cuts. The boundaries of stretches are cuts, too, except at the ends of the recording. The end of a
    stretch and the start of the next are one cut if they are near.

    Args:
        path: The file.
        wanted: Name of the tier; None for `segments LEVEL`, `segments` or `key frames`, or else the only one.
        level: The level of the cuts.
        times: Of the frames, s; annotations count from the first.
        gap: Longest gap between an end and the next start that make one cut, s.

    Raises:
        MossarError: If the file cannot be read, or the choice of the tier is not clear.
    """
    tier = chosen_tier(path, wanted, (f"{SEGMENTS} {level}", SEGMENTS, KEY_FRAMES))
    last = float(times[-1])
    first = float(times[0])
    origin = 0.0 if tier.on_clock else first
    if tier.moments:
        return [Cut(*[origin + mark.start] * 3) for mark in tier.marks]
    ends = {origin + mark.end for mark in tier.marks}
    cuts: list[Cut] = []
    for time in sorted(ends | {origin + mark.start for mark in tier.marks}):
        if not first + _EDGE < time < last - _EDGE:
            continue
        before = cuts[-1].latest if cuts else None
        if before in ends and time not in ends and time - before <= gap:
            cuts[-1] = Cut(before, (before + time) / 2, time)
        else:
            cuts.append(Cut(time, time, time))
    return cuts


def _has_events(path: Path) -> bool:
    """Return whether a C3D file has events."""
    try:
        return bool(read_events(path))
    except FileError:
        return False


def _is_no_list(path: Path) -> bool:
    """Return whether a JSON file is no list, and so no export of Label Studio."""
    try:
        check_regular(path)
        with path.open("rb") as file:
            return not file.read(64).lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"[")
    except OSError:
        return True
