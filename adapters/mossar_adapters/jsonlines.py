"""JSON lines: frames in on standard input, events or frames out on standard output or into a file."""

import io
import os
import queue
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from typing import IO

from mossar_adapters.address import Address
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.output import OutputError, OutputFile
from mossar_adapters.live import Counters, OutputClosedError
from mossar_adapters.maps.codec import from_json, to_json
from mossar_adapters.maps.decoder import MapIntake
from mossar_adapters.maps.frame_maps import FrameMap, MetaMap, map_of_meta, maps_of_frames
from mossar_adapters.receiving.batch import Batch
from mossar_adapters.source import Left, Meta
from mossar_stream.errors import FrameError, MossarError
from mossar_stream.events import Event
from mossar_stream.events import to_json as event_to_json
from mossar_stream.frames import Frames

MAX_LINE = 1 << 20  # bytes
_READ = 1 << 16  # bytes
_WAITING = 8  # reads ahead; the writer waits beyond that
_POLL = 0.1  # s


class JsonLinesSource:
    """Frame and meta maps, one JSON object per line, from standard input; implements `LiveSource`.

    It reads no faster than its frames are taken, so that nothing is lost from a pipe.

    Args:
        address: `-`.
        options: The user's fps and unit.
        stream: Read instead of standard input.
    """

    live = False

    def __init__(
        self, address: Address, options: ReadOptions | None = None, stream: IO[bytes] | None = None
    ) -> None:
        options = options or ReadOptions()
        self.name = "standard input" if stream is None else address.url
        self.counters = Counters()
        self._batch = Batch(options.fps)
        self._intake = MapIntake(self._batch, self.counters, options)
        self._stream = stream
        self._parts: queue.Queue[bytes] = queue.Queue(_WAITING)
        self._usable = 0  # frames
        self._problem = ""  # what was wrong with the first malformed line
        self._started = time.monotonic()
        self._closed = False

    def items(self) -> Iterator[Meta | Frames | Left | None]:
        """Yield metas and chunks of frames until the input ends; None when nothing came for a tenth of a second.

        Raises:
            MossarError: At the end, if no line held a usable frame.
        """
        threading.Thread(target=self._read, name="standard input", daemon=True).start()
        rest, data = b"", b"."
        while data and not self._closed:
            try:
                data = self._parts.get(timeout=_POLL)
            except queue.Empty:
                yield None
                continue
            # What follows the last line's end is a line only when the input ends.
            *lines, rest = [*(rest + data).split(b"\n"), *([] if data else [b""])]
            for line in lines:
                self._take(line)
            if len(rest) > MAX_LINE:
                self._refuse(f"longer than {MAX_LINE} bytes")
                rest = b""
            yield from self._batch.take()
        if not self._usable and not self._closed:
            raise MossarError(f"{self.name}: there is no frame in it{self._problem}")

    def explain(self) -> str:
        """Return one line that says what came."""
        counters = self.counters
        text = f"{self.name}: {counters.received} lines came"
        if counters.malformed:
            return f"{text}, {counters.malformed} malformed{self._problem}"
        return f'{text}, none of them a frame such as {{"type":"frame","t":0.0,"xyz":[[0,1,0],[0,2,0]]}}'

    def close(self) -> None:
        """End `items` after what comes next. May be called twice, and from any thread."""
        self._closed = True

    def _read(self) -> None:
        """Hand over what comes, nothing at the end; in a thread, since pipes cannot be polled everywhere."""
        data = b"."
        while data and not self._closed:
            try:
                data = self._next()
            except (OSError, ValueError):  # closed under our hands
                data = b""
            while not self._closed:
                try:
                    self._parts.put(data, timeout=_POLL)
                    break
                except queue.Full:
                    continue

    def _next(self) -> bytes:
        stream = sys.stdin.buffer if self._stream is None else self._stream
        try:
            # Not through the stream: a thread blocked in it would hold its lock when the interpreter ends.
            return os.read(stream.fileno(), _READ)
        except io.UnsupportedOperation:  # a stream in memory
            return stream.read(_READ)

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
            self._intake.take(found, time.monotonic() - self._started)
            self._usable += isinstance(found, FrameMap)
        except FrameError as error:
            self._refuse(str(error))

    def _refuse(self, why: str) -> None:
        self.counters.reject(why)
        self._problem = self._problem or f" (line {self.counters.received}: {why})"


class JsonLinesSink:
    """Events, one JSON object per line; implements `Sink`.

    Args:
        address: `-` for standard output, else a path; what is there is replaced.
        stream: Written instead.
        position: Go on at this byte of a file that is there.

    Raises:
        FileError: If the path cannot be written.
    """

    def __init__(
        self, address: Address, stream: IO[bytes] | None = None, position: int | None = None
    ) -> None:
        self.name = "standard output" if address.scheme == "-" else address.url
        self.dropped = 0
        self._output = _Output(address, stream, position=position)

    def announce(self, meta: Meta) -> None:
        """Do nothing: the events name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Write events.

        Raises:
            OutputClosedError: If nobody reads any more.
        """
        self._output.write(event_to_json(event) for event in events)

    def position(self) -> int | None:
        """Return the bytes in the file; None if it is none."""
        return self._output.position()

    def close(self) -> None:
        """Write what is left. May be called twice."""
        self._output.close()


class JsonLinesFrameSink:
    """Metas and frames, one JSON object per line; implements `FrameSink`.

    Args:
        address: `-` for standard output, else a path.
        force: Whether to replace a file that is there.

    Raises:
        FileError: If there is a file and `force` is not given, or the path cannot be written.
    """

    def __init__(self, address: Address, *, force: bool = False) -> None:
        self.name = address.url
        self._output = _Output(address, replace=force)
        self._counts: dict[str, int] = {}

    def announce(self, meta: Meta) -> None:
        """Write a meta.

        Raises:
            OutputClosedError: If nobody reads any more.
        """
        self._output.write([to_json(map_of_meta(meta))])

    def send_frames(self, frames: Frames) -> None:
        """Write frames.

        Raises:
            OutputClosedError: If nobody reads any more.
        """
        count = self._counts.get(frames.performer, 0)
        self._output.write(to_json(found) for found in maps_of_frames(frames, count))
        self._counts[frames.performer] = count + len(frames)

    def close(self) -> None:
        """Write what is left. May be called twice."""
        self._output.close()


class _Output:
    """Standard output or a file."""

    def __init__(
        self,
        address: Address,
        stream: IO[bytes] | None = None,
        *,
        replace: bool = True,
        position: int | None = None,
    ) -> None:
        self._stream: IO[bytes] | OutputFile
        if stream is None and address.scheme != "-":
            self._stream = OutputFile(address.path, replace=replace, position=position)
        else:
            self._stream = stream or sys.stdout.buffer
        self._closed = False

    def write(self, lines: Iterator[bytes] | Sequence[bytes]) -> None:
        data = b"".join(line + b"\n" for line in lines)
        if not data or self._closed:
            return
        try:
            self._stream.write(data)
            self._stream.flush()
        except (BrokenPipeError, ValueError):
            self._closed = True
            if not isinstance(self._stream, OutputFile):
                _silence(self._stream)
            raise OutputClosedError("standard output was closed") from None
        except OSError as error:
            self._closed = True
            raise OutputError(f"standard output cannot be written: {error.strerror or error}") from None

    def position(self) -> int | None:
        return self._stream.tell() if isinstance(self._stream, OutputFile) else None

    def close(self) -> None:
        self._closed = True
        if isinstance(self._stream, OutputFile):
            self._stream.close()


def _silence(stream: IO[bytes]) -> None:
    """Point a broken standard output nowhere, so that the interpreter's last flush stays quiet."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
    except (OSError, ValueError):
        return
