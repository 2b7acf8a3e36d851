"""Feed: one thread that reads one source into the inbox."""

import threading
import time

from mossar_adapters.abilities import Dates, offered
from mossar_adapters.newest import Newest
from mossar_adapters.pipeline.inbox import Arrival, Inbox
from mossar_adapters.source import Departure, Meta, Occupant, Source
from mossar_stream import Frames, MossarError

MOST_METAS = 4096  # performers of a source that are remembered; more than any source of ours knows at a time


class Feed:
    """Reads a source in a thread of its own until it ends or is stopped.

    Args:
        source: The source to read.
        index: Its number.
        inbox: Receives its items.
    """

    def __init__(self, source: Source, index: int, inbox: Inbox) -> None:
        self.source = source
        self.heard_at = time.monotonic()  # s, time of the last frames
        self.looked_at = self.heard_at  # s, last time at which the source had an item, or reported none
        self.delivered = False  # whether frames came at all
        self._index = index
        self._inbox = inbox
        self._metas: Newest[str, Meta] = Newest(MOST_METAS)  # the latest of each performer, last used last
        self._stopped = False
        self._thread = threading.Thread(target=self._read, name=f"read {source.name}", daemon=True)

    def start(self) -> None:
        """Begin to read."""
        self.heard_at = self.looked_at = time.monotonic()
        self._thread.start()

    def stop(self) -> None:
        """Make the thread end; a source that does not come back is left to the end of the process."""
        self._stopped = True
        self.source.close()

    def join(self, timeout: float) -> None:
        """Wait for the thread's end."""
        if self._thread.ident is not None:
            self._thread.join(timeout)

    def _arrival(self, item: Meta | Frames | Departure | Occupant) -> Arrival:
        """Return an arrival; frames with the latest meta of their performer."""
        now = time.monotonic()
        if isinstance(item, Departure | Occupant):
            return Arrival(self._index, item, now)
        meta = item if isinstance(item, Meta) else self._metas.get(item.performer)
        if meta is not None:
            self._metas[item.performer] = meta
        came = None
        if isinstance(item, Frames) and (source := offered(self.source, Dates)) is not None:
            came = source.came(item.performer)
        return Arrival(self._index, item, now, meta, came)

    def _read(self) -> None:
        last: Exception | None = None
        try:
            for item in self.source.items():
                if self._stopped:
                    break
                if item is not None and not self._inbox.put(self._arrival(item)):
                    return
                self.looked_at = time.monotonic()
        except MossarError as error:
            last = error
        except Exception as error:  # noqa: BLE001 - a source of any kind must not end the others
            last = error
        self._inbox.put(Arrival(self._index, last, time.monotonic()))
