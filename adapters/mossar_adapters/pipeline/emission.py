"""Emission: which events go out. Filtering never changes `rev`: the core counts, this only withholds."""

import difflib
from collections.abc import Sequence
from typing import get_args, get_type_hints

from mossar_stream import Event, SettingsError

_EVENTS: dict[type, str] = {event: event.__struct_config__.tag for event in get_args(Event)}
_KINDS: dict[str, tuple[str, ...]] = {
    kind: get_args(get_type_hints(event).get("status")) or ("",) for event, kind in _EVENTS.items()
}


class Emission:
    """Tells which events are wanted.

    Args:
        wanted: Types (`key_frame`), statuses (`confirmed`), or both (`key_frame.final`); empty is everything.

    Raises:
        SettingsError: If there is no such type or status.

    Example:
        >>> sorted(Emission(("stream", "key_frame.final")).allowed)
        [('key_frame', 'final'), ('stream', '')]
    """

    def __init__(self, wanted: Sequence[str] = ()) -> None:
        pairs = [(kind, status) for kind, statuses in _KINDS.items() for status in statuses]
        chosen = {pair for word in wanted for pair in _meant(word, pairs)}
        self.allowed = frozenset(chosen if wanted else pairs)
        self._everything = len(self.allowed) == len(pairs)

    @property
    def kinds(self) -> set[str]:
        """The types of which any event is wanted."""
        return {kind for kind, _ in self.allowed}

    def of(self, events: list[Event]) -> list[Event]:
        """Return the wanted ones among events."""
        if self._everything:
            return events
        return [event for event in events if _pair(event) in self.allowed]


def _meant(word: str, pairs: list[tuple[str, str]]) -> list[tuple[str, str]]:
    kind, _, status = word.partition(".")
    found = [p for p in pairs if (word in p) or (status and p == (kind, status))]
    if not found:
        statuses = dict.fromkeys(status for _, status in pairs if status)
        near = difflib.get_close_matches(word, [*_KINDS, *statuses], 1)
        hint = f" - did you mean {near[0]}?" if near else ""
        raise SettingsError(
            f"no events called {word[:40]!r}{hint}; there are {', '.join(_KINDS)}, the statuses {', '.join(statuses)}, "
            "and both together as in key_frame.final"
        )
    return found


def _pair(event: Event) -> tuple[str, str]:
    return _EVENTS[type(event)], getattr(event, "status", "")
