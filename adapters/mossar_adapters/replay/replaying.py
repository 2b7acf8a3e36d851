"""Replaying: frames from a source to sinks of frames, with rotations for sinks that want them."""

from collections.abc import Iterator, Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files import JointMotion, MotionChunk
from mossar_adapters.sink import FrameSink
from mossar_adapters.source import Meta, Source
from mossar_stream import Frames, MossarError


@runtime_checkable
class MotionSink(Protocol):
    """A sink of frames that can send rotations instead."""

    def announce_motion(self, motion: JointMotion) -> None:
        """Note a recording with rotations."""

    def send_motion(self, chunk: MotionChunk) -> None:
        """Hand rotations over."""


class Replay:
    """Sends the frames of a source.

    Args:
        source: Paces itself.
        sinks: Receive the frames.
        motion: Rotations of the same recording, for sinks that send them; None if it has none.
    """

    def __init__(self, source: Source, sinks: Sequence[FrameSink], motion: JointMotion | None = None) -> None:
        self._source = source
        self._plain = list(sinks)
        self._turning: list[MotionSink] = []
        self._rows = _Rows(motion) if motion is not None else None
        for sink in sinks if motion is not None else ():
            if isinstance(sink, MotionSink) and motion is not None:
                sink.announce_motion(motion)
                self._turning.append(sink)
                self._plain.remove(sink)

    def run(self) -> Iterator[float]:
        """Send everything; yield, after each chunk, the seconds of the recording that were sent.

        Raises:
            MossarError: If there was nothing to send.
        """
        first: float | None = None
        for item in self._source.items():
            if isinstance(item, Meta):
                for sink in self._plain:
                    sink.announce(item)
            elif isinstance(item, Frames) and len(item):
                self._send(item)
                first = float(item.times[0]) if first is None else first
                yield float(item.times[-1]) - first
        if first is None:
            raise MossarError(f"{self._source.name}: there is no frame in it")

    def _send(self, frames: Frames) -> None:
        for sink in self._plain:
            sink.send_frames(frames)
        if self._rows is not None and self._turning:
            chunk = self._rows.next(frames.times)
            for turning in self._turning:
                turning.send_motion(chunk)


class _Rows:
    """Hands out the frames of a motion, again and again, in the wanted numbers."""

    def __init__(self, motion: JointMotion) -> None:
        self._motion = motion
        self._rows = self._all()

    def next(self, times: NDArray[np.float64]) -> MotionChunk:
        """Return the next frames, one for each of `times` (s), which they get."""
        rows = [next(self._rows) for _ in times]
        rotations, translations = (np.stack(arrays) for arrays in zip(*rows, strict=True))
        return MotionChunk(rotations, translations, times)

    def _all(self) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
        while True:
            for chunk in self._motion.chunks():
                yield from zip(chunk.rotations, chunk.translations, strict=True)
