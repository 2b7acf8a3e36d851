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
from mossar_adapters.live import OutputClosedError
from mossar_adapters.maps.codec import to_json
from mossar_adapters.maps.frame_maps import map_of_meta, maps_of_frames
from mossar_adapters.maps.lines import LineDecoder
from mossar_adapters.source import Departure, Meta
from mossar_stream import Event, Frames, MossarError
from mossar_stream import to_json as event_to_json

_READ = 1 << 16  # bytes
_WAITING = 8  # reads ahead; the writer waits beyond that
_POLL = 0.1  # s


class JsonLinesSource:
    """Frame and meta maps, one JSON object per line, from standard input; implements `Source`.

    It reads no faster than its frames are taken, so that nothing is lost from a pipe.

    Args:
        address: `-`.
        options: The user's fps and unit.
        stream: Read instead of standard input.

    Raises:
        MossarError: If there is no standard input.
    """

    live = False

    def __init__(
        self, address: Address, options: ReadOptions | None = None, stream: IO[bytes] | None = None
    ) -> None:
        self.name = "standard input" if stream is None else address.url
        if stream is None and sys.stdin is None:
            raise MossarError("standard input is closed; there is nothing to read")
        self.decoder = LineDecoder(options)
        self.counters = self.decoder.counters
        self._stream = stream
        self._parts: queue.Queue[bytes] = queue.Queue(_WAITING)
        self._started = time.monotonic()
        self._closed = False

    def items(self) -> Iterator[Meta | Frames | Departure | None]:
        """Yield metas and chunks of frames until the input ends; None when nothing came for a tenth of a second.

        Raises:
            MossarError: At the end, if no line held a usable frame.
        """
        threading.Thread(target=self._read, name="standard input", daemon=True).start()
        data = b"."
        while data and not self._closed:
            try:
                data = self._parts.get(timeout=_POLL)
            except queue.Empty:
                yield from self.decoder.idle(time.monotonic() - self._started)
                yield None
                continue
            now = time.monotonic() - self._started
            yield from self.decoder.receive(data, now) if data else self.decoder.end(now)
        if not self.decoder.usable and not self._closed:
            raise MossarError(f"{self.name}: there is no frame in it{self.decoder.problem}")

    def explain(self) -> str:
        """Return one line about the arrivals."""
        counters = self.counters
        text = f"{self.name}: {counters.received} lines came"
        if counters.malformed:
            return f"{text}, {counters.malformed} malformed{self.decoder.problem}"
        return f'{text}, none of them a frame such as {{"type":"frame","t":0.0,"xyz":[[0,1,0],[0,2,0]]}}'

    def close(self) -> None:
        """End `items` after the next item. May be called twice, and from any thread."""
        self._closed = True

    def _read(self) -> None:
        """Hand over the input, then empty bytes at the end; in a thread, since pipes cannot be polled everywhere."""
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


class JsonLinesSink:
    """Events, one JSON object per line; implements `Sink`.

    Args:
        address: `-` for standard output, else a path.
        stream: Written instead.
        force: Whether to replace a file that is there.
        position: Go on at this byte of a file that is there.

    Raises:
        FileError: If there is a file and `force` is not given, or the path cannot be written.
        OutputError: If there is no standard output.
    """

    def __init__(
        self,
        address: Address,
        stream: IO[bytes] | None = None,
        *,
        force: bool = False,
        position: int | None = None,
    ) -> None:
        self.name = "standard output" if address.scheme == "-" else address.url
        self.dropped = 0
        self._output = _Output(address, stream, replace=force, position=position)

    def announce(self, meta: Meta) -> None:
        """Do nothing: the events name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Write events.

        Raises:
            OutputClosedError: If the reader is gone.
        """
        self._output.write(event_to_json(event) for event in events)

    def position(self) -> int | None:
        """Return the bytes in the file; None if it is none."""
        return self._output.position()

    def sync(self) -> None:
        """Have everything written to the disk, before a snapshot counts on it."""
        self._output.sync()

    def close(self) -> None:
        """Write the rest. May be called twice."""
        self._output.close()


class JsonLinesFrameSink:
    """Metas and frames, one JSON object per line; implements `FrameSink`.

    Args:
        address: `-` for standard output, else a path.
        force: Whether to replace a file that is there.

    Raises:
        FileError: If there is a file and `force` is not given, or the path cannot be written.
        OutputError: If there is no standard output.
    """

    def __init__(self, address: Address, *, force: bool = False) -> None:
        self.name = address.url
        self._output = _Output(address, replace=force)
        self._counts: dict[str, int] = {}

    def announce(self, meta: Meta) -> None:
        """Write a meta.

        Raises:
            OutputClosedError: If the reader is gone.
        """
        self._output.write([to_json(map_of_meta(meta))])

    def send_frames(self, frames: Frames) -> None:
        """Write frames.

        Raises:
            OutputClosedError: If the reader is gone.
        """
        count = self._counts.get(frames.performer, 0)
        self._output.write(to_json(found) for found in maps_of_frames(frames, count))
        self._counts[frames.performer] = count + len(frames)

    def close(self) -> None:
        """Write the rest. May be called twice."""
        self._output.close()


class _Output:
    """Standard output or a file."""

    def __init__(
        self,
        address: Address,
        stream: IO[bytes] | None = None,
        *,
        replace: bool = False,
        position: int | None = None,
    ) -> None:
        self._stream: IO[bytes] | OutputFile
        if stream is None and address.scheme != "-":
            self._stream = OutputFile(address.path, replace=replace, position=position)
        elif stream is None and sys.stdout is None:
            raise OutputError("standard output is closed; --to says where else events may go")
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

    def sync(self) -> None:
        if isinstance(self._stream, OutputFile):
            self._stream.sync()

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
