"""A recording on disk as a source: at the pace of its times, or as fast as it is read."""

from collections.abc import Iterator, Mapping
from typing import Final, Literal

import msgspec

from mossar_adapters.replay.interleaving import in_order_of_time, part
from mossar_adapters.replay.pacing import Pacer
from mossar_adapters.source import Meta, Recording
from mossar_stream import Frames, performer_name

LOOP_PAUSE: Final = 1.5  # s between two rounds: longer than `max_pause`, so that receivers begin a new take

_IDLE: Final = 0.1  # s without frames after which a live source yields None


class RecordingSource:
    """Plays a recording; implements `Source`.

    At a speed frames leave one by one, each at its own time, those of several performers in order of time. With
    "max" they come in the chunks of the reader, each performer's in order.

    Args:
        recording: The recording to play.
        speed: Seconds of the recording per second, or "max".
        performer: Another name for the recording's only performer.
        loop: Whether to play it again and again; times go on, after a pause of `LOOP_PAUSE`.

    Raises:
        ValueError: If `speed` is neither a positive number nor "max".
    """

    def __init__(
        self,
        recording: Recording,
        speed: float | Literal["max"] = "max",
        performer: str | None = None,
        *,
        loop: bool = False,
    ) -> None:
        self.name = recording.path
        self.live = speed != "max"
        self.pacer = Pacer(speed)
        self.recording = recording
        self.notes = recording.notes
        self.in_order = self.live  # whether frames of several performers come in order of time
        self._loop = loop
        self._closed = False
        self._skip: Mapping[str, int] = {}
        self._names = {name: name for name in recording.performers}
        if performer is not None and len(self._names) == 1:
            self._names = {recording.performers[0]: performer_name(performer)}

    def resume(self, position: Mapping[str, int]) -> None:
        """Begin behind the first `position[performer]` frames of each performer; before `items`."""
        self._skip = dict(position)

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield a meta per performer, then frames; to be iterated once."""
        skeleton, fps = self.recording.skeleton, self.recording.fps
        path = str(self.recording.path)
        reference = self.recording.reference
        yield from (
            Meta(name, skeleton, fps, recording=path, reference=reference) for name in self._names.values()
        )
        for frames in self._frames():
            if not self.live:
                yield frames
            else:
                yield from self._paced(frames)
            if self._closed:
                return

    def close(self) -> None:
        """End `items` soon. May be called twice, and from any thread."""
        self._closed = True
        self.pacer.interrupt()

    def _frames(self) -> Iterator[Frames]:
        chunks = self._rounds()
        return in_order_of_time(chunks, len(self._names)) if self.in_order else chunks

    def _rounds(self) -> Iterator[Frames]:
        """Yield all chunks, renamed, without the frames to skip, and in a loop with times that go on."""
        left = dict(self._skip)
        begin: float | None = None
        while True:
            end, shift = 0.0, 0.0
            first: float | None = None
            for frames in self.recording.chunks():
                if not len(frames):
                    continue
                first = float(frames.times[0]) if first is None else first
                shift = 0.0 if begin is None else begin - first
                frames = msgspec.structs.replace(
                    frames, performer=self._names[frames.performer], times=frames.times + shift
                )
                end = max(end, float(frames.times[-1]))
                skipped = min(len(frames), left.get(frames.performer, 0))
                left[frames.performer] = left.get(frames.performer, 0) - skipped
                if skipped < len(frames):
                    yield part(frames, skipped, len(frames))
            if not self._loop or first is None or self._closed:
                return
            begin = end + LOOP_PAUSE

    def _paced(self, frames: Frames) -> Iterator[Frames | None]:
        for i, time in enumerate(frames.times):
            while not self.pacer.wait_until(float(time), timeout=_IDLE):
                if self._closed:
                    return
                yield None
            yield part(frames, i, i + 1)
