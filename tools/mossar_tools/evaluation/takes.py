"""Takes: recordings in memory, each with its true cuts."""

from collections.abc import Callable, Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files import FileError, ReadOptions, open_recording
from mossar_adapters.files.loaded import load
from mossar_stream import LevelName, MossarError, Skeleton
from mossar_tools.console import LOGGER
from mossar_tools.evaluation.annotated import annotated_cuts, is_annotated
from mossar_tools.evaluation.judges import truth_from_judges
from mossar_tools.evaluation.labels import LabelError, Labels, read_folder, read_labels
from mossar_tools.evaluation.matching import Cut

SECONDS_LOOK = 5.0  # Hz; at lower rates frames and seconds look alike


class Take(msgspec.Struct, frozen=True):
    """A recording with its true cuts.

    Args:
        name: For the tables.
        group: Name of the group over which scores are averaged: the level, and more if groups of a level differ.
        level: The level of the cuts.
        skeleton: The joints.
        fps: Nominal rate, Hz.
        positions: (n, J, 3) m, NaN where a joint is missing.
        times: (n,) s.
        cuts: True cuts, s.
        tolerance: Largest distance from a cut to a key frame that hits it, s.
    """

    name: str
    group: str
    level: LevelName
    skeleton: Skeleton
    fps: float
    positions: NDArray[np.float32]
    times: NDArray[np.float64]
    cuts: list[Cut]
    tolerance: float

    @property
    def duration(self) -> float:
        """Time from the first to the last frame, s."""
        return float(self.times[-1] - self.times[0])


def load_folder(folder: Path, on_progress: Callable[[str], None] = lambda _: None) -> list[Take]:
    """Return the takes of a labelled folder.

    Args:
        folder: See `labels`.
        on_progress: Gets the name of each label file before its recording is read.

    Raises:
        LabelError: If a label file cannot be used or its recording is missing.
        FileError: If a recording cannot be read.
    """
    takes: list[Take] = []
    stray: MossarError | None = None
    for path, labels in read_folder(folder):
        on_progress(str(path))
        try:
            takes.append(_load(path, labels, path.relative_to(folder).with_suffix("").as_posix()))
        except MossarError as error:
            if not is_annotated(path):  # a label file names its own recording
                raise
            stray = error
            LOGGER.warning(
                "%s and %s are skipped, they are not annotations and recording: %s",
                path,
                labels.recording,
                error,
            )
    if stray is not None and not takes:
        raise stray
    return takes


def _load(path: Path, labels: Labels, name: str) -> Take:
    """Return the take that a label file describes."""
    for part in filter(None, (labels.recording, labels.skeleton, labels.annotations)):
        if not (path.parent / part).exists():
            raise LabelError(f"{path}: it names {part}, which is not in {path.parent}")
    skeleton = str(path.parent / labels.skeleton) if labels.skeleton else None
    options = ReadOptions(fps=labels.fps, unit=labels.unit, skeleton=skeleton)
    recording = open_recording(path.parent / labels.recording, options)
    loaded = load(recording)
    positions, times = loaded.positions, loaded.times
    if len(times) < 2:
        raise FileError(recording.path, "fewer than two frames; there is nothing to segment")
    return Take(
        name=name,
        group=labels.level,
        level=labels.level,
        skeleton=loaded.skeleton,
        fps=recording.fps or (len(times) - 1) / float(times[-1] - times[0]),
        positions=positions,
        times=times,
        cuts=_cuts(path, labels, times),
        tolerance=labels.tolerance_s,
    )


def cuts_of(
    path: Path, times: NDArray[np.float64], level: LevelName = "motion", tier: str | None = None
) -> tuple[list[Cut], float]:
    """Return the cuts that a label file or an annotation file has for a recording, s, and their tolerance, s.

    Args:
        path: The file.
        times: Of the recording's frames, s.
        level: The level of the cuts, for annotations without one.
        tier: Of an annotation file; see `annotated_cuts`.

    Raises:
        LabelError: If it is no label file, its cuts are not of this recording, or a tier is given for it.
        MossarError: If an annotation file cannot be read, or the choice of its tier is not clear.
    """
    if is_annotated(path):
        annotated = Labels("", annotations=path.name, tier=tier, level=level)
        return _cuts(path, annotated, times), annotated.tolerance_s
    if tier is not None:
        raise LabelError(f"{path}: a label file has no tiers; leave --tier out")
    labels = read_labels(path)
    if labels is None:
        raise LabelError(f"{path}: no labels; there must be a recording and its cuts in it")
    return _cuts(path, labels, times), labels.tolerance_s


def _cuts(path: Path, labels: Labels, times: NDArray[np.float64]) -> list[Cut]:
    """Return the cuts in seconds on the recording's clock."""
    if labels.annotations is not None:
        return annotated_cuts(
            path.parent / labels.annotations, labels.tier, labels.level, times, labels.tolerance_s
        )
    bounds = [cut if isinstance(cut, tuple) else (cut, cut, cut) for cut in labels.cuts or ()]
    if labels.cuts_in is None:
        _check_frames(path, [moment for part in labels.judges or bounds for moment in part], times)
    if labels.judges is not None:
        judges = [sorted(_seconds(path, labels, judge, times)) for judge in labels.judges]
        return truth_from_judges(judges, labels.bandwidth_s, labels.density_floor)
    return [Cut(*_seconds(path, labels, bound, times)) for bound in bounds]


def _check_frames(path: Path, frames: Sequence[float], times: NDArray[np.float64]) -> None:
    """Refuse numbers that look like seconds: as frames they would score 0 without a warning."""
    between = [frame for frame in frames if not (2 * frame).is_integer()]
    if between:
        raise LabelError(
            f'{path}: {between[0]:g} is no frame; if cuts are seconds, add "cuts_in": "seconds", else "frames"'
        )
    duration = float(times[-1] - times[0])
    if frames and len(times) - 1 >= SECONDS_LOOK * duration and max(frames) <= duration:
        raise LabelError(
            f"{path}: all cuts lie in the first {max(frames):g} of {len(times)} frames; "
            'if they are seconds, add "cuts_in": "seconds", else "frames"'
        )


def _seconds(path: Path, labels: Labels, moments: Sequence[float], times: NDArray[np.float64]) -> list[float]:
    """Return the times of the moments in a label file."""
    if labels.cuts_in == "seconds":
        duration = float(times[-1] - times[0])
        wrong = [moment for moment in moments if not 0 <= moment <= duration]
        if wrong:
            raise LabelError(f"{path}: {wrong[0]:g} s is not in the recording, which lasts {duration:.2f} s")
        return [float(times[0]) + moment for moment in moments]
    wrong = [frame for frame in moments if not 0 <= frame <= len(times) - 1]
    if wrong:
        raise LabelError(
            f"{path}: frame {wrong[0]:g} is not in the recording, which has frames 0 to {len(times) - 1}"
        )
    seconds: list[float] = np.interp(moments, np.arange(len(times)), times).tolist()
    return seconds
