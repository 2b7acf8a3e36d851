"""Shared parts of live sources: counters, the discarded start, and a listener."""

import logging
from collections import deque
from collections.abc import Sequence
from typing import Any, Protocol

import msgspec

from mossar_adapters.source import Departure, Meta
from mossar_stream import Frames, MossarError

SEEN_LIMIT = 8  # addresses kept as examples
SEEN_LENGTH = 80  # characters of each
_MOST_KEPT = 4096  # metas and departures

_log = logging.getLogger("mossar.source")


class Counters(msgspec.Struct):
    """Counters of a source since it was opened; for the stats and for the explanation of silence.

    Args:
        received: Datagrams (OSC) or messages (ZeroMQ, LSL, standard input).
        malformed: Those, or parts of those, that could not be used.
        kernel_drops: Datagrams that the operating system dropped because they were not read in time.
        ignored: Messages that no profile wanted, or whose sender is not allowed.
        gaps: Frames that the sender numbered but that never came.
        retimed: Frames with another time than the sender's, because its clock does not run, or not in seconds.
        skipped: Frames that came before the program was ready, and were discarded.
        seen: A few addresses or topics with their counts, used or not.
        last_error: Why the last malformed one could not be used.
    """

    received: int = 0
    malformed: int = 0
    kernel_drops: int = 0
    ignored: int = 0
    gaps: int = 0
    retimed: int = 0
    skipped: int = 0
    seen: dict[str, int] = msgspec.field(default_factory=dict)
    last_error: str = ""

    def see(self, address: str) -> None:
        """Remember an address if it is among the first few."""
        address = address[:SEEN_LENGTH]
        if address in self.seen:
            self.seen[address] += 1
        elif len(self.seen) < SEEN_LIMIT:
            self.seen[address] = 1

    def reject(self, why: str) -> None:
        """Count something malformed."""
        self.malformed += 1
        self.last_error = why


class Skipped:
    """Items that a source discards because they came before the program was ready.

    Args:
        counters: Of the source, where the frames are counted.

    Attributes:
        kept: The latest of the other items.
    """

    def __init__(self, counters: Counters) -> None:
        self.kept: deque[Meta | Departure] = deque(maxlen=_MOST_KEPT)
        self._counters = counters
        self._span: tuple[float, float] | None = None  # times of the first and the last one, s

    def add(self, found: Sequence[Meta | Frames | Departure]) -> None:
        """Keep all items but frames, and count the frames."""
        for item in found:
            if isinstance(item, Frames):
                self._counters.skipped += len(item)
                first, last = float(item.times[0]), float(item.times[-1])
                self._span = (first if self._span is None else self._span[0], last)
            else:
                self.kept.append(item)

    def log(self, name: str) -> None:
        """Log the number of frames, with the name of the source."""
        if self._span is None:
            return
        first, last = self._span
        _log.info(
            "%s: %s frames (%.1f s) came before the program was ready and were discarded",
            name,
            f"{self._counters.skipped:,}",
            abs(last - first),
        )


class Listener(Protocol):
    """Receives, on the reader's thread, the messages of a source that are no frames."""

    def control(self, address: str, arguments: Sequence[Any]) -> None:
        """Act on `/mossar/set/<name> value` or `/mossar/reset`."""


class OutputClosedError(MossarError):
    """The reader of our output has closed it; programs end quietly on it."""
