"""Reasons: whose frames a take begins with, where slots stand for the ids of a sender."""

from collections.abc import Container

import msgspec

from mossar_adapters.people.source import shown
from mossar_adapters.pipeline.take_starts import is_start
from mossar_stream import Event

_WHOLE = 10.0  # s from which on tenths do not matter


class Reasons:
    """Adds to `started` the id of the sender that a slot has, and how long its person was away.

    Example:
        >>> from mossar_stream import StreamEvent
        >>> reasons = Reasons()
        >>> reasons.set_occupant("p1", "p7")
        >>> reasons.seen("p1", 3.0)
        >>> started = StreamEvent(performer="p1", event="started", take=1, reason="")
        >>> reasons.add_to([started], 15.0)[0].reason
        'id 7; back after 12 s'
    """

    def __init__(self) -> None:
        self._ids: dict[str, str] = {}  # of the sender, by slot
        self._seen: dict[str, float] = {}  # s of the source's clock, when each slot had frames last

    def set_occupant(self, name: str, ident: str, *, another: bool = False) -> None:
        """Set the person in a slot; another person than before is not reported as back."""
        self._ids[name] = ident
        if another:
            self._seen.pop(name, None)

    def seen(self, name: str, time: float) -> None:
        """Set the time of a slot's latest frame, s."""
        if name in self._ids:
            self._seen[name] = time

    def add_to(self, events: list[Event], time: float) -> list[Event]:
        """Return events, with the reason added to those that begin a take.

        Args:
            events: Of one performer.
            time: Of the first frame that they are of, s.
        """
        return [self._with_reason(event, time) for event in events] if self._ids else events

    def forget(self, kept: Container[str]) -> None:
        """Forget all others."""
        self._ids = {name: ident for name, ident in self._ids.items() if name in kept}
        self._seen = {name: time for name, time in self._seen.items() if name in kept}

    def _with_reason(self, event: Event, time: float) -> Event:
        if not is_start(event) or event.performer not in self._ids:
            return event
        reason = shown(self._ids[event.performer])
        away = time - self._seen.get(event.performer, time)
        if away > 0:
            reason += f"; back after {away:.0f} s" if away >= _WHOLE else f"; back after {away:.1f} s"
        return msgspec.structs.replace(event, reason=reason)
