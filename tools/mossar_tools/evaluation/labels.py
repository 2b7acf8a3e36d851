"""Labels: the files with the true cuts of recordings.

A labelled folder holds, beside each recording or anywhere in it, one JSON object per recording::

    {"recording": "walk.bvh", "fps": 120, "tolerance_s": 0.25, "level": "motion",
     "cuts": [[500, 550, 600], 1150, [1930, 1980, 2030]]}

A cut is [earliest, middle, latest] frame, from 0, or one frame. Instead of `cuts` there may be `judges`, a list of
frames for each person who set cuts. There may also be `annotations`, a file of an annotation program, with the `tier`
to use. With `"cuts_in": "seconds"` cuts are seconds since the first frame. `skeleton` names the .asf of an .amc. Other
keys are for people to read. A recording without labels that has an annotation file of its name beside it, say walk.eaf,
is taken with it.
"""

from pathlib import Path
from typing import Literal

import msgspec

from mossar_adapters.regular import check_regular
from mossar_stream import LevelName, MossarError
from mossar_tools.console import LOGGER
from mossar_tools.evaluation.annotated import annotated_recordings
from mossar_tools.evaluation.judges import BANDWIDTH, DENSITY_FLOOR

MAX_BYTES = 4 << 20  # larger files are recordings in JSON
MAX_FILES = 10_000

Moment = float  # a frame, or s


class LabelError(MossarError):
    """A labelled folder cannot be used; the message names the file and the remedy."""


class Labels(msgspec.Struct, frozen=True):
    """Content of a label file; the docstring of the module describes the fields.

    Args:
        recording: Path from the label file's folder.
        cuts: Frames, or s.
        judges: The same for each judge.
        annotations: Path of an annotation file from the label file's folder; see `annotated_cuts`.
        tier: Of that file.
        cuts_in: Unit of the numbers in `cuts` and `judges`; None for frames, if the numbers can be frames.
        fps: Rate, Hz; None for the recording's.
        tolerance_s: Largest distance from a cut to a key frame that hits it, s.
        level: The level of the cuts.
        skeleton: Path from the label file's folder.
        unit: Of the recording's coordinates.
        bandwidth_s: Standard deviation of the density kernel over judges, s.
        density_floor: Share of the judges; a lower maximum is no cut.
    """

    recording: str
    cuts: list[Moment | tuple[Moment, Moment, Moment]] | None = None
    judges: list[list[Moment]] | None = None
    annotations: str | None = None
    tier: str | None = None
    cuts_in: Literal["frames", "seconds"] | None = None
    fps: float | None = None
    tolerance_s: float = 0.25
    level: LevelName = "motion"
    skeleton: str | None = None
    unit: str = "auto"
    bandwidth_s: float = BANDWIDTH
    density_floor: float = DENSITY_FLOOR


def read_folder(folder: Path) -> list[tuple[Path, Labels]]:
    """Return the label files of a folder and the folders in it, in the order of their names.

    JSON files without `recording` are skipped, because recordings can be JSON as well. Invalid JSON, and files with a
    recording but without cuts, are skipped with a warning.

    Raises:
        LabelError: If there is no such folder, no label file, or a label file that cannot be used.
    """
    if not folder.is_dir():
        kind = "this is a file" if folder.exists() else "there is no such folder"
        raise LabelError(f"{folder}: {kind}; give a folder with recordings and label files, or demo:")
    paths = sorted(folder.rglob("*.json"))
    if len(paths) > MAX_FILES:
        raise LabelError(f"{folder}: more than {MAX_FILES} JSON files; give a smaller folder")
    found = [(path, labels) for path in paths if (labels := read_labels(path)) is not None]
    described = {path.parent / labels.recording for path, labels in found}
    for path, recording in annotated_recordings(folder, described):
        found.append((path, Labels(recording.name, annotations=path.name)))
    if not found:
        raise LabelError(
            f"{folder}: no label file; put NAME.json beside each recording, with at least "
            '{"recording": "NAME.bvh", "fps": 120, "cuts": [[500, 550, 600], ...]}, or NAME.eaf'
        )
    return found


def read_labels(path: Path) -> Labels | None:
    """Return the content of a label file, None if it is another kind of file.

    Raises:
        LabelError: If it cannot be read, or has a value that makes no sense.
    """
    try:
        check_regular(path)
        if path.stat().st_size > MAX_BYTES:
            return None
        data = path.read_bytes()
    except OSError as error:
        raise LabelError(f"{path}: cannot be read: {error.strerror or error}") from None
    try:
        content = msgspec.json.decode(data)
    except (msgspec.DecodeError, RecursionError) as error:
        LOGGER.warning("%s is skipped: no valid JSON: %s", path, error)
        return None
    if not isinstance(content, dict) or "recording" not in content:
        return None
    if content.get("commands") is not None:  # a session of moves, see `sessions`
        return None
    if all(content.get(key) is None for key in ("cuts", "judges", "annotations")):
        LOGGER.warning(
            "%s is skipped: it names a recording, but has neither cuts nor judges nor annotations", path
        )
        return None
    try:
        labels = msgspec.convert(content, Labels)
    except msgspec.ValidationError as error:
        raise LabelError(f"{path}: {error}") from None
    _check(path, labels)
    return labels


def _check(path: Path, labels: Labels) -> None:
    """Refuse values that the types allow but that make no sense."""
    if [labels.cuts, labels.judges, labels.annotations].count(None) != 2:
        raise LabelError(f"{path}: needs either cuts or judges or annotations")
    if labels.fps is not None and not 0 < labels.fps <= 1e5:
        raise LabelError(f"{path}: fps must be a rate in Hz, not {labels.fps:g}")
    if not 0 <= labels.tolerance_s <= 60:
        raise LabelError(f"{path}: tolerance_s must lie between 0 and 60 s, not {labels.tolerance_s:g}")
    if not (0.001 <= labels.bandwidth_s <= 60 and 0 <= labels.density_floor <= 1):
        raise LabelError(f"{path}: bandwidth_s must lie in 0.001 to 60 s, density_floor in 0 to 1")
    bounds = [cut if isinstance(cut, tuple) else (cut, cut, cut) for cut in labels.cuts or ()]
    for number, (earliest, middle, latest) in enumerate(bounds, 1):
        if not earliest <= middle <= latest:
            raise LabelError(f"{path}: cut {number} must be [earliest, middle, latest] in this order")
        before = bounds[number - 2] if number > 1 else (0.0, 0.0, 0.0)
        if any(own < former for own, former in zip(bounds[number - 1], before, strict=True)):
            raise LabelError(
                f"{path}: cut {number} begins or ends before the one before it, or before frame 0"
            )
