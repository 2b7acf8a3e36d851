"""Standard input: JSON lines frames, one meta or frame map per line."""

import os
import sys
import time
from collections.abc import Iterator

from mossar_adapters.batch import Batch
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.frame_codec import from_json
from mossar_adapters.frame_maps import FrameMap, MetaMap
from mossar_adapters.live import Counters
from mossar_adapters.map_intake import MapIntake
from mossar_adapters.source import Meta
from mossar_stream.errors import FrameError, MossarError
from mossar_stream.frames import Frames

MAX_LINE = 1 << 20  # bytes; 1024 joints take about 70 thousand

_READ = 1 << 16  # bytes


class StandardInput:
    """Reads frames from a file descriptor; implements `Source`.

    A frame without `t` has the time that its number gives at the rate, and without a rate the time of its
    arrival. Lines that hold no usable frame are counted and passed over.

    Args:
        options: The user's rate and unit.
        descriptor: What to read; None is standard input.
    """

    name = "standard input"
    live = False  # the sender waits for us; nothing is lost

    def __init__(self, options: ReadOptions | None = None, descriptor: int | None = None) -> None:
        options = options or ReadOptions()
        self.counters = Counters()
        self._descriptor = sys.stdin.fileno() if descriptor is None else descriptor
        self._batch = Batch(options.fps)
        self._intake = MapIntake(self._batch, self.counters, options)
        self._problem = ""  # what was wrong with the first malformed line
        self._usable = 0
        self._closed = False

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield metas and frames until the input ends.

        Raises:
            MossarError: At the end, if no line held a usable frame.
        """
        rest = b""
        # Not through sys.stdin: a thread blocked in it would hold its lock when the interpreter ends.
        while not self._closed and (data := os.read(self._descriptor, _READ)):
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                self._take(line)
            if len(rest) > MAX_LINE:
                self._refuse(f"longer than {MAX_LINE} bytes")
                rest = b""
            yield from self._batch.take()
        self._take(rest)
        yield from self._batch.take()
        if not self._usable and not self._closed:
            raise MossarError(f"{self.name}: there is no frame in it{self._problem}")

    def close(self) -> None:
        """End `items` after the next line."""
        self._closed = True

    def explain(self) -> str:
        """Return why no frames come."""
        counters = self.counters
        return (
            f"{self.name}: {counters.received} lines came, {counters.malformed} of them malformed{self._problem}; "
            'a frame is a line such as {"type":"frame","t":0.0,"xyz":[[0,1,0],[0,2,0]]}'
        )

    def _take(self, line: bytes) -> None:
        if not line or line.isspace():
            return
        self.counters.received += 1
        try:
            found = from_json(line)
            if found is None:
                self.counters.ignored += 1
                return
            if isinstance(found, MetaMap) and self._batch.fps is None:
                self._batch.fps = found.fps or None  # UNSET is false
            self._intake.take(found, time.monotonic())
            self._usable += isinstance(found, FrameMap)
        except FrameError as error:
            self._refuse(str(error))

    def _refuse(self, why: str) -> None:
        self.counters.reject(why)
        self._problem = self._problem or f" (line {self.counters.received}: {why})"
