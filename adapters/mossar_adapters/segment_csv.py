"""Segments as a table that spreadsheets and ELAN open: one row for each segment that is final."""

import csv
import io
from collections.abc import Sequence

from mossar_adapters.address import Address
from mossar_adapters.files.output import OutputFile
from mossar_adapters.source import Meta
from mossar_stream.events import Event, KeyFrameEvent, SegmentEvent

COLUMNS = ("start", "end", "duration", "state", "strength", "performer", "take")
_KEPT = 10_000  # strengths of key frames whose segment is still open


class SegmentCsvSink:
    """Writes final segments; implements `Sink`. The strength is that of the key frame at the segment's end.

    Args:
        address: Path of the file; what is there is replaced.
        position: Go on at this byte of a file that is there.

    Raises:
        FileError: If the path cannot be written.
    """

    def __init__(self, address: Address, position: int | None = None) -> None:
        self.name = address.url
        self.dropped = 0
        self._file = OutputFile(address.path, replace=True, position=position)
        self._strengths: dict[str, float] = {}  # by id of the key frame
        if position is None:
            self._write([COLUMNS])

    def announce(self, meta: Meta) -> None:
        """Do nothing: the rows name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Write the segments among the events that are final."""
        rows: list[Sequence[object]] = []
        for event in events:
            if isinstance(event, KeyFrameEvent) and event.strength is not None:
                self._remember(event.id, event.strength)
            elif isinstance(event, SegmentEvent) and event.status == "final":
                rows.append(self._row(event))
        if rows:
            self._write(rows)

    def position(self) -> int | None:
        """Return the bytes in the file."""
        return self._file.tell()

    def close(self) -> None:
        """Close the file. May be called twice."""
        self._file.close()

    def _row(self, event: SegmentEvent) -> Sequence[object]:
        # Ids keep Algorithm 2's frame, while a final key frame may have moved.
        ending = f"{event.performer}/{event.take}/{event.id.rpartition('-')[2]}"
        strength = self._strengths.pop(ending, None)
        return (
            f"{event.start_time:.4f}",
            f"{event.end_time:.4f}",
            f"{event.end_time - event.start_time:.4f}",
            event.state,
            "" if strength is None else f"{strength:.4f}",
            event.performer,
            event.take,
        )

    def _remember(self, key: str, strength: float) -> None:
        if len(self._strengths) == _KEPT and key not in self._strengths:
            del self._strengths[next(iter(self._strengths))]
        self._strengths[key] = strength

    def _write(self, rows: Sequence[Sequence[object]]) -> None:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows)
        self._file.write(text.getvalue().encode())
        self._file.flush()
