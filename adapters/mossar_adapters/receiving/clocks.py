"""Clocks: the times of several senders of one source, on one clock.

Each program counts its seconds from a start of its own. The shared clock is that of the first sender, whose times stay
as they are. The clock of every other sender is shifted, by an offset that its first frame gives, so that its frames
lie where they arrived. An offset stays as it is, and with it the steps from frame to frame, until the sender's clock jumps
or the sender was silent.
"""

from typing import Final

import msgspec

from mossar_adapters.newest import Newest
from mossar_adapters.receiving.senders import MAX_SENDERS

JUMP: Final = 0.25  # s; a clock that goes so far back, or so far ahead of the arrivals, was set
PRESENT: Final = 2.0  # s since the latest frame; after a longer silence a clock may have stood still


class _Clock(msgspec.Struct):
    """The clock of a sender: its latest frame, and the offset of its times."""

    time: float  # s, as sent
    arrival: float  # s
    offset: float  # s


class Clocks:
    """Puts the times of senders on one clock.

    A sender that is alone keeps its times, also where they jump.

    Example:
        >>> clocks = Clocks()
        >>> [clocks.time("", sent, came) for sent, came in [(100.0, 5.0), (100.5, 5.5)]]
        [100.0, 100.5]
        >>> [clocks.time("another", sent, came) for sent, came in [(7.0, 5.5), (7.5, 6.1)]]
        [100.5, 101.0]
    """

    def __init__(self) -> None:
        self._clocks: Newest[str, _Clock] = Newest(MAX_SENDERS)
        self._ahead: float | None = None  # s, that the shared clock is ahead of the arrivals

    def time(self, sender: str, sent: float, arrival: float) -> float:
        """Return the time of a frame on the shared clock.

        Args:
            sender: Which.
            sent: The frame's time on the sender's clock, s.
            arrival: Time of arrival, s.
        """
        clock = self._clocks.get(sender)
        shared = sent if self._ahead is None else arrival + self._ahead
        if clock is None:
            clock = self._clocks[sender] = _Clock(sent, arrival, shared - sent)
        else:
            if (
                len(self._clocks) > 1
                and self._is_off(clock, sent, arrival, shared)
                and self._others(clock, arrival)
            ):
                clock.offset = shared - sent
            clock.time, clock.arrival = sent, arrival
        self._ahead = sent + clock.offset - arrival
        return sent + clock.offset

    def forget(self, sender: str) -> None:
        """Forget a sender that is gone for good; the next one after the last of them is the first again."""
        self._clocks.pop(sender, None)
        if not self._clocks:
            self._ahead = None

    def _is_off(self, clock: _Clock, sent: float, arrival: float, shared: float) -> bool:
        """Return whether the sender's clock was set, or stood still, since its latest frame."""
        step, passed = sent - clock.time, arrival - clock.arrival
        off = sent + clock.offset - shared
        if passed > PRESENT:
            return abs(off) > JUMP
        # Frames that the network kept back come at once, behind the shared clock and up to it: nothing was set.
        return step < -JUMP or (step > passed + JUMP and off > JUMP)

    def _others(self, clock: _Clock, arrival: float) -> bool:
        """Return whether another sender is present."""
        return any(
            other is not clock and arrival - other.arrival <= PRESENT for other in self._clocks.values()
        )
