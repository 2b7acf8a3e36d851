"""Counts frames that were numbered by the sender but never came."""

from mossar_adapters.live import Counters
from mossar_adapters.newest import Newest

_MAX_KNOWN = 256
_RESTART = 10_000  # frames; a larger jump means that the sender started again, not that frames were lost


class Sequences:
    """The latest `seq` of each performer.

    Args:
        counters: They count gaps.
    """

    def __init__(self, counters: Counters) -> None:
        self._counters = counters
        self._latest: Newest[str, int] = Newest(_MAX_KNOWN)

    def count(self, performer: str, seq: int) -> None:
        """Note a frame's number."""
        latest = self._latest.get(performer)
        if latest is not None and 1 < seq - latest <= _RESTART:
            self._counters.gaps += seq - latest - 1
        self._latest[performer] = seq
