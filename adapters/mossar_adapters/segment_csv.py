"""Segments as a table that spreadsheets and ELAN open: one row for each segment that is final."""

import csv
import io
from collections.abc import Sequence

from mossar_adapters.address import Address
from mossar_adapters.jsonlines import opened_file
from mossar_adapters.source import Meta
from mossar_stream.errors import MossarError
from mossar_stream.events import Event, KeyFrameEvent, SegmentEvent

COLUMNS = ("start", "end", "duration", "state", "strength", "performer", "take")
_KEPT = 10_000  # strengths of key frames whose segment is still open


class SegmentCsvSink:
    """Writes final segments; implements `Sink`. The strength is that of the key frame at the segment's end.

    Args:
        address: Path of the file; what is there is replaced.

    Raises:
        FileError: If the path cannot be written.
    """

    def __init__(self, address: Address) -> None:
        self.name = address.url
        self.dropped = 0
        self._file = opened_file(address.path, replace=True)
        self._strengths: dict[tuple[str, int, int], float] = {}  # performer, take, frame
        self._write([COLUMNS])

    def announce(self, meta: Meta) -> None:
        """Do nothing: the rows name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Write the segments among the events that are final."""
        rows: list[Sequence[object]] = []
        for event in events:
            if isinstance(event, KeyFrameEvent) and event.strength is not None:
                self._remember((event.performer, event.take, event.frame), event.strength)
            elif isinstance(event, SegmentEvent) and event.status == "final":
                rows.append(self._row(event))
        if rows:
            self._write(rows)

    def close(self) -> None:
        """Close the file. May be called twice."""
        self._file.close()

    def _row(self, event: SegmentEvent) -> Sequence[object]:
        strength = self._strengths.pop((event.performer, event.take, event.end_frame), None)
        return (
            f"{event.start_time:.4f}",
            f"{event.end_time:.4f}",
            f"{event.end_time - event.start_time:.4f}",
            event.state,
            "" if strength is None else f"{strength:.4f}",
            event.performer,
            event.take,
        )

    def _remember(self, key: tuple[str, int, int], strength: float) -> None:
        if len(self._strengths) == _KEPT and key not in self._strengths:
            del self._strengths[next(iter(self._strengths))]
        self._strengths[key] = strength

    def _write(self, rows: Sequence[Sequence[object]]) -> None:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows)
        try:
            self._file.write(text.getvalue().encode())
            self._file.flush()
        except OSError as error:
            raise MossarError(f"{self.name}: cannot be written: {error.strerror or error}") from None
