"""A recording on disk as a source: at the pace of its times, or as fast as it is read."""

import time
from collections.abc import Iterator
from typing import Literal

import msgspec

from mossar_adapters.pacing import Pacer
from mossar_adapters.source import Meta, Recording
from mossar_stream.frames import Frames

_CHUNK = 1 / 250  # s of frames in a chunk when they are paced
_IDLE = 0.1  # s without frames after which a live source says so


class RecordingSource:
    """Plays a recording; implements `Source`.

    Args:
        recording: What to play.
        speed: 1 is real time, "max" does not wait.
        performer: New name of a single performer, or None.

    Raises:
        ValueError: If `speed` is neither a positive number nor "max".
    """

    def __init__(
        self,
        recording: Recording,
        speed: float | Literal["max"] = "max",
        performer: str | None = None,
    ) -> None:
        self.name = recording.path
        self.live = speed != "max"
        self.recording = recording
        self.notes = recording.notes
        self.pacer = Pacer(speed)
        single = len(recording.performers) == 1
        self._renamed = {recording.performers[0]: performer} if performer and single else {}
        self._closed = False

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield a meta per performer, then the frames; None while paused or slow."""
        for performer in self.recording.performers:
            name = self._renamed.get(performer, performer)
            yield Meta(name, self.recording.skeleton, self.recording.fps, "m")
        for frames in self.recording.chunks():
            name = self._renamed.get(frames.performer, frames.performer)
            for piece in self._pieces(msgspec.structs.replace(frames, performer=name)):
                yield from self._waited(piece)
                if self._closed:
                    return
                yield piece

    def close(self) -> None:
        """End `items` soon. May be called twice, and from any thread."""
        self._closed = True
        self.pacer.interrupt()

    def _waited(self, piece: Frames) -> Iterator[None]:
        """Wait until the last frame of a piece is due."""
        due = float(piece.times[-1])
        started = time.monotonic()
        while not self._closed and not self.pacer.wait_until(due, timeout=_IDLE):
            if time.monotonic() - started >= _IDLE:
                yield None

    def _pieces(self, frames: Frames) -> Iterator[Frames]:
        """Yield the frames in pieces short enough for their pace."""
        if not self.live:
            yield frames
            return
        start = 0
        for i in range(1, len(frames) + 1):
            if i == len(frames) or not 0 <= frames.times[i] - frames.times[start] < _CHUNK:
                yield _slice(frames, start, i)
                start = i


def _slice(frames: Frames, start: int, end: int) -> Frames:
    first = None if frames.first_frame is None else frames.first_frame + start
    confidence = None if frames.confidence is None else frames.confidence[start:end]
    return Frames(frames.positions[start:end], frames.times[start:end], confidence, frames.performer, first)
