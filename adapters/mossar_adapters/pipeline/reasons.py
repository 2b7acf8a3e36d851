"""Reasons: whose frames a take begins with, where a slot stands for the ids of a sender."""

import msgspec

from mossar_adapters.people.source import shown
from mossar_adapters.pipeline.take_starts import is_start
from mossar_stream import Event

_WHOLE = 10.0  # s from which on tenths do not matter


class Reasons:
    """Adds to `started` the id of the sender that a slot has, and the absence of its person.

    Example:
        >>> from mossar_stream import StreamEvent
        >>> reasons = Reasons()
        >>> reasons.set_occupant("p7")
        >>> reasons.seen(3.0)
        >>> started = StreamEvent(performer="p1", event="started", take=1, reason="")
        >>> reasons.add_to([started], 15.0)[0].reason
        'id 7; back after 12 s'
    """

    def __init__(self) -> None:
        self._id: str | None = None  # of the sender; None where performers have no slots
        self._seen: float | None = None  # s of the source's clock, when the slot had frames last

    def set_occupant(self, ident: str, *, another: bool = False) -> None:
        """Set the person in the slot; another person than before is not reported as back."""
        self._id = ident
        if another:
            self._seen = None

    def seen(self, time: float) -> None:
        """Set the time of the slot's latest frame, s."""
        if self._id is not None:
            self._seen = time

    def add_to(self, events: list[Event], time: float) -> list[Event]:
        """Return events, with the reason added to those that begin a take.

        Args:
            events: Of the performer.
            time: Of the first frame that they are of, s.
        """
        if self._id is None:
            return events
        reason, away = shown(self._id), time - (time if self._seen is None else self._seen)
        if away > 0:
            reason += f"; back after {away:.0f} s" if away >= _WHOLE else f"; back after {away:.1f} s"
        return [msgspec.structs.replace(e, reason=reason) if is_start(e) else e for e in events]
