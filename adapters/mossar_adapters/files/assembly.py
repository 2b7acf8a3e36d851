"""The last steps that all readers share: skeleton, sane numbers, metres."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.body import body_height, first_frames
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.units import Scale, guessed_scale, metres_of, stated_scale
from mossar_adapters.source import Chunks, Recording
from mossar_stream import MAX_JOINTS, MAX_NAME, FrameError, Frames, Skeleton, narrow

FARTHEST = 1e5  # m; a coordinate beyond this is damage, as in the core


def skeleton_of(path: Path, names: Sequence[str], parents: Sequence[int] = (), root: int = 0) -> Skeleton:
    """Return a skeleton from names as files have them: repeated, empty, too long.

    Raises:
        FileError: If the number of joints or the parents are impossible.
    """
    if not 1 <= len(names) <= MAX_JOINTS:
        raise FileError(path, f"there are {len(names)} joints; 1 to {MAX_JOINTS} can be used")
    try:
        return Skeleton(unique_names(names), tuple(parents), root)
    except FrameError as error:
        raise FileError(path, str(error)) from None


def unique_names(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names cleaned, with `_2`, `_3` … behind those that repeat.

    Example:
        >>> unique_names(["End", "End", ""])
        ('End', 'End_2', 'joint2')
    """
    seen: set[str] = set()
    result = []
    for i, name in enumerate(names):
        clean = "".join(c for c in name if c.isprintable()).strip()[: MAX_NAME - 8] or f"joint{i}"
        unique, again = clean, 1
        while unique in seen:
            again += 1
            unique = f"{clean}_{again}"
        seen.add(unique)
        result.append(unique)
    return tuple(result)


def sane_frames(
    positions: NDArray[Any],
    times: NDArray[np.float64],
    confidence: NDArray[np.floating] | None = None,
    performer: str = "p1",
    first_frame: int | None = None,
) -> Frames:
    """Return frames in which every joint has three finite coordinates or is missing.

    Args:
        positions: (n, J, 3), metres.
        times: (n,) seconds.
        confidence: (n, J) or None.
        performer: Name of the performer.
        first_frame: Number of the first frame, or None.
    """
    with np.errstate(invalid="ignore"):
        present = (np.abs(positions) < FARTHEST).all(axis=2)
        clean = narrow(np.where(present[:, :, None], positions, positions.dtype.type(np.nan)))
    if confidence is not None:
        confidence = np.clip(np.nan_to_num(confidence, posinf=1.0, neginf=0.0), 0.0, 1.0).astype(np.float32)
    return Frames(clean, np.ascontiguousarray(times, np.float64), confidence, performer, first_frame)


def confident(frames: Frames) -> NDArray[np.float32]:
    """Return positions (n, J, 3), m, with NaN where there is no confidence."""
    if frames.confidence is None:
        return frames.positions
    return np.where(frames.confidence[:, :, None] > 0, frames.positions, np.float32(np.nan))


def first_chunk(path: Path, chunks: Chunks) -> Frames:
    """Return the first frames of a recording.

    Raises:
        FileError: If there is none, or it cannot be read.
    """
    for frames in chunks():
        if len(frames):
            return frames
    raise FileError(path, "there is no frame in the file")


def in_metres(recording: Recording, scale: Scale) -> Recording:
    """Return the recording with its coordinates multiplied and the note about it added."""
    notes = recording.notes if scale.note is None else (*recording.notes, scale.note)
    if scale.metres == 1.0:
        return msgspec.structs.replace(recording, notes=notes, metres=1.0)

    def chunks() -> Iterator[Frames]:
        for frames in recording.chunks():
            scaled = frames.positions.astype(np.float64) * scale.metres
            yield sane_frames(scaled, frames.times, frames.confidence, frames.performer, frames.first_frame)

    return msgspec.structs.replace(recording, chunks=chunks, notes=notes, metres=scale.metres)


def in_stated_unit(recording: Recording, options: ReadOptions, unit: str | float | None) -> Recording:
    """Return the recording in metres.

    Args:
        recording: Coordinates in the file's unit.
        options: The user's word about the unit takes precedence.
        unit: The stated unit: a name or metres; if it is unknown, the height decides.
    """
    metres = metres_of(unit) if isinstance(unit, str) else unit
    if metres is not None:
        return in_metres(recording, stated_scale(options, metres))
    return scaled_by_height(recording, lambda tall: guessed_scale(options, tall))


def scaled_by_height(recording: Recording, choose: Callable[[float], Scale]) -> Recording:
    """Return the recording in metres, where the scale follows from the body in the first frames.

    Args:
        recording: Coordinates in the file's unit.
        choose: Makes the scale of the height in the file's unit.
    """
    first_chunk(Path(recording.path), recording.chunks)  # refuses an empty file
    shown = first_frames(recording)
    return in_metres(recording, choose(body_height(recording.skeleton, shown)))
