"""Watch: notices on the wall clock that frames have stopped, and that they are back."""

from collections.abc import Callable, Container, Mapping
from types import MappingProxyType
from typing import Literal

import msgspec

STALL = 0.3  # s without frames

Finding = Literal["stalled", "ended"]


class _Watched(msgspec.Struct):
    at: float  # monotonic s of the last frames
    source: int
    stalled: bool = False
    ended: bool = False


class Watch:
    """Keeps the time of the last frames of each performer of live sources.

    Args:
        max_pause: Returns the time without frames after which a performer's take ends, s.

    Example:
        >>> watch = Watch(lambda _: 1.0)
        >>> watch.heard("p1", 0, now=0.0), watch.check(0.2), watch.check(0.4), watch.check(0.5)
        (False, [], [('p1', 'stalled')], [])
        >>> watch.check(1.1), watch.heard("p1", 0, now=2.0)
        ([('p1', 'ended')], True)
    """

    def __init__(self, max_pause: Callable[[str], float]) -> None:
        self._max_pause = max_pause
        self._heard: dict[str, _Watched] = {}

    def heard(self, performer: str, source: int, now: float, came: float | None = None) -> bool:
        """Take note of frames; return whether they had stalled.

        Frames that arrived before the stall, and waited for what completes them, change nothing.

        Args:
            performer: Whose.
            source: Where they come from.
            now: Monotonic s.
            came: When they arrived, monotonic s; None: now.
        """
        known = self._heard.get(performer)
        if known is not None and known.stalled and came is not None and came - known.at <= STALL:
            return False
        self._heard[performer] = _Watched(now, source)
        return known is not None and known.stalled

    def leave(self, performer: str) -> None:
        """Stop watching a performer who has left."""
        self._heard.pop(performer, None)

    def keep(self, performers: Container[str]) -> None:
        """Stop watching all others."""
        self._heard = {name: heard for name, heard in self._heard.items() if name in performers}

    def forget(self, source: int) -> None:
        """Stop watching the performers of a source that has ended."""
        self._heard = {name: heard for name, heard in self._heard.items() if heard.source != source}

    def check(
        self, now: float, until: Mapping[int, float] = MappingProxyType({})
    ) -> list[tuple[str, Finding]]:
        """Return the performers that have stalled, and those whose takes are over, since the last call.

        Args:
            now: Monotonic s.
            until: Up to when each source has been heard out: what waits in a queue has come in time.
        """
        found: list[tuple[str, Finding]] = []
        for name, heard in self._heard.items():
            quiet = until.get(heard.source, now) - heard.at
            if quiet > STALL and not heard.stalled:
                heard.stalled = True
                found.append((name, "stalled"))
            if heard.stalled and not heard.ended and quiet > self._max_pause(name):
                heard.ended = True
                found.append((name, "ended"))
        return found
