"""Discarding: what live senders send while kernels are compiled is read at once, and discarded.

Nobody else reads then. Queues that are full keep the oldest, and a connection on which nothing is read for minutes stays
silent for a minute afterwards.
"""

import threading
from collections.abc import Sequence

from mossar_adapters.abilities import SkipsWaiting, offered
from mossar_adapters.source import Source

_EVERY = 0.1  # s


class Discarding:
    """Reads live sources in a thread of its own from `begin` to `end`.

    Args:
        sources: Those that cannot discard are left alone.
    """

    def __init__(self, sources: Sequence[Source]) -> None:
        found = (offered(source, SkipsWaiting) for source in sources)
        self._sources = [source for source in found if source is not None]
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def begin(self) -> None:
        """Begin, if that has not been done."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._go_on, name="discarding", daemon=True)
            self._thread.start()

    def end(self) -> None:
        """End; the sources go on with what comes from now on, if this had begun."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()

    def _go_on(self) -> None:
        while True:
            for source in self._sources:
                source.skip_waiting()
            if self._ended.wait(_EVERY):
                return
