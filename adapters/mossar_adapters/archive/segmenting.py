"""Segmenting: one recording of an archive, offline, with all its performers."""

from pathlib import Path

import msgspec
import numpy as np

from mossar_adapters.files import FileError, ReadOptions, open_recording
from mossar_adapters.files.assembly import confident
from mossar_adapters.files.body import body_recording
from mossar_adapters.source import Recording
from mossar_stream import (
    FollowEvent,
    FrameError,
    Frames,
    KeyFrame,
    MossarError,
    MoveEvent,
    Moves,
    PoseEvent,
    RepetitionEvent,
    Segment,
    Segmenter,
    Settings,
    StepEvent,
    segment_recording,
)

MAX_BYTES = 2 << 30  # of positions


class Segmented(msgspec.Struct, frozen=True):
    """The results of one performer's frames.

    Args:
        performer: Name.
        fps: Nominal rate, Hz, if it is known.
        joints: Number of joints.
        frames: Number of frames.
        seconds: From the first frame to the last one.
        key_frames: All of Algorithm 2, with their strengths.
        segments: Those at the level of the settings.
        notes: Notes of the reader, one line each; why moves or steps were not looked for.
        limbs: The same of each limb, with the setting `limbs`.
        moves: Those that were recognised.
        repetitions: Of the body and of limbs, with the setting `repetitions`.
        steps: With the setting `steps`.
        followed: Performances of the moves that are followed that were done.
        poses: Those that were held or entered, if the moves have poses.
    """

    performer: str
    fps: float | None
    joints: int
    frames: int
    seconds: float
    key_frames: list[KeyFrame]
    segments: list[Segment]
    notes: tuple[str, ...]
    limbs: dict[str, tuple[list[KeyFrame], list[Segment]]] = {}
    moves: list[MoveEvent] = []
    repetitions: list[RepetitionEvent] = []
    steps: list[StepEvent] = []
    followed: list[FollowEvent] = []
    poses: list[PoseEvent] = []


def segment_file(
    path: Path,
    settings: Settings,
    reading: ReadOptions,
    moves: Moves | None = None,
    follow: tuple[str, ...] | bool = (),
) -> list[Segmented]:
    """Return the results of a recording, one entry for each performer.

    Args:
        path: A file.
        settings: Settings of the segmenters.
        reading: Options of reading.
        moves: That are recognised, where the skeleton has the joints that they need.
        follow: Names of those that are followed, or True for all.

    Raises:
        MossarError: If it cannot be read, or is too large to be held in memory.
    """
    recording = body_recording(open_recording(path, reading))
    chunks = _chunks(recording)
    if not chunks:
        raise FileError(path, "there is no frame in the file")
    notes = recording.notes
    if moves is not None:
        try:
            moves.store(recording.skeleton)
        except FrameError as error:
            notes, moves, follow = (*notes, str(error)), None, ()
    if settings.steps:
        try:
            Segmenter(recording.skeleton, Settings(steps=True, feet=settings.feet))
        except FrameError as error:
            notes, settings = (*notes, str(error)), settings.replace(steps=False)
    shown = moves, follow
    return [_segmented(recording, who, found, settings, shown, notes) for who, found in chunks.items()]


def problem(error: Exception) -> str:
    """Return an error as one line for the errors table."""
    text = " ".join(str(error).split())
    return text if isinstance(error, MossarError) else f"internal error: {type(error).__name__}: {text}"


def _chunks(recording: Recording) -> dict[str, list[Frames]]:
    """Return the frames of each performer; sizes are checked while they are read."""
    found: dict[str, list[Frames]] = {}
    taken = 0
    for frames in recording.chunks():
        taken += frames.positions.nbytes
        if max(taken, (recording.frame_count or 0) * len(recording.skeleton) * 12) > MAX_BYTES:
            raise FileError(recording.path, "too long to be held in memory; mossar run takes it as a stream")
        if len(frames):
            found.setdefault(frames.performer, []).append(frames)
    return found


def _segmented(
    recording: Recording,
    performer: str,
    chunks: list[Frames],
    settings: Settings,
    shown: tuple[Moves | None, tuple[str, ...] | bool],
    notes: tuple[str, ...],
) -> Segmented:
    times = np.concatenate([frames.times for frames in chunks])
    positions = np.concatenate([confident(frames) for frames in chunks])
    moves, follow = shown
    result = segment_recording(
        positions,
        recording.fps,
        recording.skeleton,
        settings,
        times=times,
        moves=moves,
        follow=follow,
        takes=True,
    )
    repetitions = [*result.repetitions, *(one for limb in result.limbs.values() for one in limb.repetitions)]
    return Segmented(
        performer,
        recording.fps,
        len(recording.skeleton),
        len(times),
        float(times[-1] - times[0]),
        result.key_frames,
        result.segments,
        notes,
        {name: (limb.key_frames, limb.segments) for name, limb in result.limbs.items()},
        result.moves,
        repetitions,
        list(result.steps),
        result.followed,
        result.poses,
    )
