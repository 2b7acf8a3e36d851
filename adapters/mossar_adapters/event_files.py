"""Event files: events as JSON lines, segments as a table, frames as a recording."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

from mossar_adapters.files import FileError, MskWriter
from mossar_adapters.source import Meta
from mossar_stream.events import Event, KeyFrameEvent, SegmentEvent, to_json
from mossar_stream.frames import Frames

CSV_COLUMNS = ("performer", "start", "end", "duration", "state", "strength")


class JsonLinesSink:
    """Writes one event per line, each batch at once; implements `Sink`.

    Args:
        file: Opened for writing bytes.
        name: For messages.
        owned: Whether to close the file at the end.
    """

    dropped = 0

    def __init__(self, file: BinaryIO, name: str, *, owned: bool = True) -> None:
        self.name = name
        self._file = file
        self._owned = owned

    @classmethod
    def open(cls, path: Path | str, position: int | None = None) -> "JsonLinesSink":
        """Return a sink that writes a new file, or goes on at byte `position` of one that is there.

        Raises:
            FileError: If the file cannot be written.
        """
        return cls(_open(Path(path), position), str(path))

    def announce(self, meta: Meta) -> None:
        """Do nothing: events name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Write events."""
        self._file.write(b"".join(to_json(event) + b"\n" for event in events))
        self._file.flush()

    def position(self) -> int:
        """Return the bytes written so far."""
        return self._file.tell()

    def close(self) -> None:
        """Close the file. May be called twice."""
        if self._owned:
            self._file.close()


class SegmentCsvSink:
    """Writes a row for each final segment; opens in spreadsheets and ELAN; implements `Sink`.

    Times are seconds on the source's clock. The strength is that of the key frame that ends the segment.

    Args:
        file: Opened for writing bytes, at its beginning or where a former run stopped.
        name: For messages.
    """

    dropped = 0

    def __init__(self, file: BinaryIO, name: str) -> None:
        self.name = name
        self._file = file
        self._strengths: dict[str, float | None] = {}  # of final key frames, by id, until their segment comes
        if file.tell() == 0:
            self._write([CSV_COLUMNS])

    @classmethod
    def open(cls, path: Path | str, position: int | None = None) -> "SegmentCsvSink":
        """Return a sink that writes a new file, or goes on at byte `position` of one that is there.

        Raises:
            FileError: If the file cannot be written.
        """
        return cls(_open(Path(path), position), str(path))

    def announce(self, meta: Meta) -> None:
        """Do nothing: rows name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Write the final segments among events."""
        rows = []
        for event in events:
            if isinstance(event, KeyFrameEvent) and event.status == "final":
                self._strengths[event.id] = event.strength
            elif isinstance(event, SegmentEvent) and event.status == "final":
                rows.append(self._row(event))
        self._write(rows)

    def position(self) -> int:
        """Return the bytes written so far."""
        return self._file.tell()

    def close(self) -> None:
        """Close the file. May be called twice."""
        self._file.close()

    def _row(self, event: SegmentEvent) -> tuple[str, ...]:
        ending_key_frame = f"{event.performer}/{event.take}/{event.id.rpartition('-')[2]}"
        strength = self._strengths.pop(ending_key_frame, None)
        return (event.performer, *segment_cells(event.start_time, event.end_time, event.state, strength))

    def _write(self, rows: Sequence[Sequence[str]]) -> None:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows)
        self._file.write(text.getvalue().encode())
        self._file.flush()


class RecordingSink:
    """Writes frames to a `.msk` recording; implements `FrameSink`.

    Args:
        path: Where to write.
        force: Whether to replace a file that is there.

    Raises:
        FileError: If there is a file and `force` is not given, or the path cannot be written.
    """

    dropped = 0

    def __init__(self, path: Path | str, *, force: bool = False) -> None:
        self.name = str(path)
        self._writer = MskWriter(path, force=force)

    def announce(self, meta: Meta) -> None:
        """Write a meta."""
        self._writer.write(meta)

    def send_frames(self, frames: Frames) -> None:
        """Write frames."""
        self._writer.write(frames)

    def close(self) -> None:
        """Write what is left. May be called twice."""
        self._writer.close()


def segment_cells(start: float, end: float, state: str, strength: float | None) -> tuple[str, ...]:
    """Return the cells of a segment, times to 0.1 ms."""
    ended = "" if strength is None else f"{strength:.4f}"
    return f"{start:.4f}", f"{end:.4f}", f"{end - start:.4f}", state, ended


def _open(path: Path, position: int | None) -> BinaryIO:
    try:
        if position is None:
            return path.open("wb")
        file = path.open("r+b")
        file.truncate(position)
        file.seek(position)
    except OSError as error:
        raise FileError(path, f"cannot be written: {error.strerror or error}") from None
    return file
