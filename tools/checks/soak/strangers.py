"""Strangers: names without end, some of them malicious."""

import random

from mossar_adapters.source import Meta
from mossar_stream import Event, Skeleton

# How many come at once: as many as there is room for (256), then such as make others give way.
FIRST, LATER = 232, 20
# Before them, so that little grows later: with those after, more names than sinks keep metas of (1024).
WAVES = 4
# s after each wave. A source may bring 1,024 joints a second after 16,384 at once, and a newcomer counts for 32 more than
# its own (docs/operations.md): so all waves, all performers and the first flood are within its allowance.
MOMENT = 6.5
# Seconds between two floods: longer than a take stays open, so that a performer that is dropped has none.
PERIOD = 25.0
SKELETON = Skeleton(("hip", "hand"), (-1, 0))
_BEGINNING = "stranger"
_ENDS = ("", "   ", "\x1b[2J", "\r\nmossar: all is well", "\u00e9" * 80, "/0/12", "=1+1", "\u202e")


def names(rng: random.Random, count: int) -> list[str]:
    """Return names that no performer has had."""
    return [f"{_BEGINNING}{rng.getrandbits(48):x}{rng.choice(_ENDS)}" for _ in range(count)]


def meta(name: str) -> Meta:
    """Return the meta of a stranger."""
    return Meta(name, SKELETON)


def is_of_a_stranger(event: Event) -> bool:
    """Return whether an event is about one of them: no events are predicted for those."""
    return event.performer.startswith(_BEGINNING)
