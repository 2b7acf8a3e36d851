"""Recorder: frames from a source to a sink of frames, as they come."""

import logging
import time
from collections.abc import Iterator

from mossar_adapters.pipeline.counting import explanation
from mossar_adapters.pipeline.feed import Feed
from mossar_adapters.pipeline.inbox import Inbox
from mossar_adapters.pipeline.upkeep import SILENCE
from mossar_adapters.replay.interleaving import part
from mossar_adapters.sink import FrameSink
from mossar_adapters.source import Departure, Meta, Occupant, Source
from mossar_stream import Frames

_POLL = 0.1  # s
_LEAVE = 1.0  # s given to the reader to end

_log = logging.getLogger("mossar.record")


class Recorder:
    """Writes the frames of a source.

    Args:
        source: Read in a thread of its own.
        sink: Receives the frames; closed at the end.
        seconds: Stop after so much time of the stream; None for no limit.
    """

    def __init__(self, source: Source, sink: FrameSink, seconds: float | None = None) -> None:
        self.frames = 0
        self.error: Exception | None = None  # error that ended the source
        self._sink = sink
        self._seconds = seconds
        self._inbox = Inbox([source.live])
        self._feed = Feed(source, 0, self._inbox)
        self._first: float | None = None  # s, time of the first frame
        self._stopping = False

    def run(self) -> Iterator[tuple[int, float]]:
        """Write until the source ends, the time is over or `stop` is called; yield frames and seconds so far."""
        self._feed.start()
        explained = False
        try:
            while not self._stopping:
                arrival = self._inbox.get(_POLL)
                if arrival is None:
                    if not explained and time.monotonic() - self._feed.heard_at > SILENCE:
                        explained = True
                        name = self._feed.source.name
                        _log.warning("%s", explanation(self._feed.source) or f"{name}: no frames come")
                    continue
                item = arrival.item
                if isinstance(item, Meta):
                    self._sink.announce(item)
                elif isinstance(item, Frames):
                    self._feed.heard_at = arrival.at
                    yield self.frames, self._write(item)
                elif not isinstance(item, Departure | Occupant):
                    self.error = item if isinstance(item, Exception) else None
                    return
        finally:
            self._inbox.close()
            self._feed.stop()
            self._sink.close()
            self._feed.join(_LEAVE)
            if dropped := self._inbox.dropped[0]:
                _log.warning("%s: %d frames were dropped, the disk is too slow", self._sink.name, dropped)

    def stop(self) -> None:
        """Make `run` end. Signal handlers and other threads may call it."""
        self._stopping = True

    def _write(self, frames: Frames) -> float:
        """Write frames up to the wanted end; return the seconds so far."""
        self._first = float(frames.times[0]) if self._first is None else self._first
        if self._seconds is not None:
            kept = int((frames.times - self._first < self._seconds).sum())
            if kept < len(frames):
                self._stopping = True
                frames = part(frames, 0, kept)
        if not len(frames):
            return self._seconds or 0.0
        self._sink.send_frames(frames)
        self.frames += len(frames)
        return float(frames.times[-1]) - self._first
