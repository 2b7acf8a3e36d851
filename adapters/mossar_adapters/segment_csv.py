"""Segments as a table that spreadsheets and ELAN open: one row for each segment; the same for streams and whole files."""

from collections.abc import Sequence
from typing import NamedTuple

from mossar_adapters.address import Address
from mossar_adapters.files.output import OutputFile
from mossar_adapters.source import Meta
from mossar_adapters.table_text import csv_text
from mossar_stream import BODY, Event, KeyFrameEvent, Segment, SegmentEvent

COLUMNS = (
    "recording",
    "performer",
    "take",
    "start",
    "end",
    "duration",
    "start_frame",
    "end_frame",
    "state",
    "kind",
    "strength",
    "similarity",
    "active_joints",
    "channel",
    "limb",
)
_KEPT = 10_000  # key frames kept whose segment is still open


class Ending(NamedTuple):
    """The key frame at a segment's end; empty at the end of a take.

    Args:
        kind: `onset`, `offset` or `minimum`.
        strength: None until it is known.
    """

    kind: str = ""
    strength: float | None = None


def segment_row(
    recording: str,
    performer: str,
    take: int,
    part: SegmentEvent | Segment,
    ending: Ending,
    channel: str = BODY,
) -> Sequence[object]:
    """Return the cells of a segment, not yet guarded, in the order of `COLUMNS`; times in s on the source's clock."""
    return (
        recording,
        performer,
        take,
        f"{part.start_time:.4f}",
        f"{part.end_time:.4f}",
        f"{part.end_time - part.start_time:.4f}",
        part.start_frame,
        part.end_frame,
        part.state,
        ending.kind,
        _number(ending.strength),
        _number(part.similarity),
        " ".join(part.active_joints),
        channel,
        part.limb or "",
    )


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4f}"


class SegmentCsvSink:
    """Writes final segments; implements `Sink`. The strength is that of the key frame at the segment's end.

    Args:
        address: Path of the file.
        force: Whether to replace a file that is there.
        position: Go on at this byte of a file that is there.

    Raises:
        FileError: If there is a file and `force` is not given, or the path cannot be written.
    """

    def __init__(self, address: Address, *, force: bool = False, position: int | None = None) -> None:
        self.name = address.url
        self.dropped = 0
        self._file = OutputFile(address.path, replace=force, position=position)
        self._endings: dict[str, Ending] = {}  # by id of the key frame
        self._recordings: dict[str, str] = {}  # by performer
        self._closed = False

    def announce(self, meta: Meta) -> None:
        """Remember the recording of a performer."""
        if meta.recording:
            self._recordings[meta.performer] = meta.recording

    def send(self, events: Sequence[Event]) -> None:
        """Write the segments among the events that are final."""
        rows: list[Sequence[object]] = []
        for event in events:
            if isinstance(event, KeyFrameEvent) and event.strength is not None:
                self._remember(event.id, Ending(event.kind, event.strength))
            elif isinstance(event, SegmentEvent) and event.status == "final":
                rows.append(self._row(event))
        if rows:
            self._write(rows)

    def position(self) -> int | None:
        """Return the bytes in the file."""
        return self._file.tell()

    def sync(self) -> None:
        """Have everything written to the disk, before a snapshot counts on it."""
        self._file.sync()

    def close(self) -> None:
        """Close the file. May be called twice."""
        if not self._closed:
            self._closed = True
            self._write([])
        self._file.close()

    def _row(self, event: SegmentEvent) -> Sequence[object]:
        # Ids keep Algorithm 2's frame, while a final key frame may have moved.
        who, _, frames = event.id.rpartition("/")
        ending = self._endings.pop(f"{who}/{frames.rpartition('-')[2]}", Ending())
        recording = self._recordings.get(event.performer, "")
        return segment_row(recording, event.performer, event.take, event, ending, event.channel)

    def _remember(self, key: str, ending: Ending) -> None:
        if len(self._endings) == _KEPT and key not in self._endings:
            del self._endings[next(iter(self._endings))]
        self._endings[key] = ending

    def _write(self, rows: Sequence[Sequence[object]]) -> None:
        head = [COLUMNS] if self._file.tell() == 0 else []  # late: a file with nothing in it may be replaced
        self._file.write(csv_text([*head, *rows]).encode())
        self._file.flush()
