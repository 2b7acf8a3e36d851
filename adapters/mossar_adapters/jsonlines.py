"""JSON lines: frames in on standard input, events or frames out on standard output or into a file."""

import os
import queue
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO

from mossar_adapters.address import Address
from mossar_adapters.batch import Batch
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.frame_codec import from_json, to_json
from mossar_adapters.frame_maps import map_of_meta, maps_of_frames
from mossar_adapters.live import Counters, OutputClosedError
from mossar_adapters.map_intake import MapIntake
from mossar_adapters.source import Meta
from mossar_stream.errors import FrameError, MossarError
from mossar_stream.events import Event
from mossar_stream.events import to_json as event_to_json
from mossar_stream.frames import Frames

MAX_LINE = 1 << 20  # bytes
_WAITING = 256  # lines read ahead; the writer waits beyond that
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
        self.name = address.url
        self.counters = Counters()
        self._batch = Batch(options.fps)
        self._intake = MapIntake(self._batch, self.counters, options)
        self._stream = sys.stdin.buffer if stream is None else stream
        self._lines: queue.Queue[bytes | None] = queue.Queue(_WAITING)
        self._started = time.monotonic()
        self._closed = threading.Event()

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield metas and chunks of frames until the input ends; None when nothing came for a tenth of a second."""
        threading.Thread(target=self._read, name="standard input", daemon=True).start()
        while not self._closed.is_set():
            try:
                line = self._lines.get(timeout=_POLL)
            except queue.Empty:
                yield None
                continue
            while line is not None:
                self._take(line)
                try:
                    line = self._lines.get_nowait()
                except queue.Empty:
                    break
            yield from self._batch.take()
            if line is None:
                return

    def explain(self) -> str:
        """Return one line that says what came."""
        counters = self.counters
        text = f"standard input: {counters.received} lines came"
        if counters.malformed:
            return f"{text}, {counters.malformed} malformed, the last: {counters.last_error}"
        return f'{text}, none of them a frame such as {{"type":"frame","t":0.0,"xyz":[[0,1,0],[0,2,0]]}}'

    def close(self) -> None:
        """End `items` soon. May be called twice, and from any thread."""
        self._closed.set()

    def _read(self) -> None:
        """Hand over lines; runs on a thread of its own, since pipes cannot be polled everywhere."""
        line: bytes | None = b""
        while line is not None and not self._closed.is_set():
            try:
                line = self._stream.readline(MAX_LINE) or None
            except (OSError, ValueError):  # closed under our hands
                line = None
            while not self._closed.is_set():
                try:
                    self._lines.put(line, timeout=_POLL)
                    break
                except queue.Full:
                    continue

    def _take(self, line: bytes) -> None:
        if line.isspace():
            return
        self.counters.received += 1
        if len(line) == MAX_LINE:
            self.counters.reject(f"a line is longer than {MAX_LINE} bytes")
            return
        try:
            found = from_json(line)
            if found is None:
                self.counters.ignored += 1
            else:
                self._intake.take(found, time.monotonic() - self._started)
        except FrameError as error:
            self.counters.reject(str(error))


class JsonLinesSink:
    """Events, one JSON object per line; implements `Sink`.

    Args:
        address: `-` for standard output, else a path; what is there is replaced.
        stream: Written instead.

    Raises:
        FileError: If the path cannot be written.
    """

    def __init__(self, address: Address, stream: IO[bytes] | None = None) -> None:
        self.name = address.url
        self.dropped = 0
        self._output = _Output(address, stream)

    def announce(self, meta: Meta) -> None:
        """Do nothing: the events name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Write events.

        Raises:
            OutputClosedError: If nobody reads any more.
        """
        self._output.write(event_to_json(event) for event in events)

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

    def __init__(self, address: Address, stream: IO[bytes] | None = None, *, replace: bool = True) -> None:
        self._owned = stream is None and address.scheme != "-"
        if stream is None:
            stream = opened_file(address.path, replace=replace) if self._owned else sys.stdout.buffer
        self._stream = stream
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
            _silence(self._stream)
            raise OutputClosedError("standard output was closed") from None
        except OSError as error:
            self._closed = True
            raise MossarError(f"the output cannot be written: {error.strerror or error}") from None

    def close(self) -> None:
        self._closed = True
        if self._owned:
            self._stream.close()


def opened_file(path: str, *, replace: bool) -> IO[bytes]:
    """Open a file for writing.

    Raises:
        FileError: If it is there and may not be replaced, or cannot be written.
    """
    try:
        return Path(path).open("wb" if replace else "xb")
    except FileExistsError:
        raise FileError(path, "there is a file already; --force replaces it") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise FileError(path, f"cannot be written: {reason}") from None


def _silence(stream: IO[bytes]) -> None:
    """Point a broken standard output nowhere, so that the interpreter's last flush stays quiet."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
    except (OSError, ValueError):
        return
