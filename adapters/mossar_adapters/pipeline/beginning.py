"""Beginning: frames that waited in a socket or a queue while the program started are old, and are dropped."""

import logging
import time

from mossar_adapters.abilities import NamesPerformers, offered
from mossar_adapters.pipeline.inbox import Arrival
from mossar_adapters.source import Source

OLD = 1.0  # s from the arrival of a frame to its processing

_log = logging.getLogger("mossar.pipeline")


class Beginning:
    """Drops the first frames of a live source as long as they are old; counts them.

    Args:
        source: The source. Recordings and the built-in performer, which know their performers, wait for the program.
    """

    def __init__(self, source: Source) -> None:
        self.dropped = 0  # frames
        self._name = source.name
        self._is_over = not source.live or offered(source, NamesPerformers) is not None

    def is_old(self, arrival: Arrival, count: int) -> bool:
        """Return whether frames are to be dropped; logs their number with the first that are not.

        Args:
            arrival: Of the frames.
            count: Their number.
        """
        if self._is_over:
            return False
        came = arrival.at if arrival.came is None else min(arrival.came, arrival.at)
        if time.monotonic() - came > OLD:
            self.dropped += count
            return True
        self._is_over = True
        if self.dropped:
            _log.warning(
                "%s: %d frames were older than %g s at the start and were dropped",
                self._name,
                self.dropped,
                OLD,
            )
        return False
