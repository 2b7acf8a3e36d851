"""Abilities: optional members of a source or a sink beyond `Source`, `Sink` and `FrameSink`.

Each ability is a protocol of one member. A source or sink offers it by having that member, nothing is inherited or registered:

    if (source := offered(feed.source, Resumes)) is not None:
        source.resume(position)

A member that is None is not offered. Wrappers pass on the abilities of their inner source or sink (`__getattr__`).
"""

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

import msgspec

from mossar_stream import Frames

Ability = TypeVar("Ability")


def offered(thing: object, ability: type[Ability]) -> Ability | None:
    """Return a source or sink as one with the ability, None if it does not offer it."""
    members = [name for name in (*ability.__annotations__, *vars(ability)) if not name.startswith("_")]
    return thing if all(getattr(thing, name, None) is not None for name in members) else None  # type: ignore[return-value]


class Explains(Protocol):
    """A source that knows why no frames come."""

    def explain(self) -> str:
        """Return one line: the bound address, the arrivals, a remedy."""


class Counts(Protocol):
    """A source that counts received messages."""

    counters: msgspec.Struct  # as `live.Counters`; whole numbers go into the stats


class Resumes(Protocol):
    """A source that can begin where a snapshot was made."""

    def resume(self, position: dict[str, int]) -> None:
        """Skip the first `position[performer]` frames of each performer; before `items`."""


class SkipsWaiting(Protocol):
    """A live source that can discard messages from before the program was ready."""

    def skip_waiting(self) -> None:
        """Discard all messages before now; called before `items`."""


class Dates(Protocol):
    """A live source whose frames may wait for messages that complete them."""

    def came(self, performer: str) -> float | None:
        """Return the time at which a performer's latest frame began to arrive, monotonic s; None if unknown."""


class Orders(Protocol):
    """A recording with several performers."""

    in_order: bool  # whether their frames come in order of time; may be set before `items`


class NamesPerformers(Protocol):
    """A source that knows the names of all its performers."""

    performers: tuple[str, ...]


class Notes(Protocol):
    """A source with notes for the user."""

    notes: tuple[str, ...]  # one line each


class HasSlots(Protocol):
    """A source with slots that follow people; see `people.PeopleSource`."""

    people: Any


class Previews(Protocol):
    """A camera whose picture can be shown."""

    preview: Callable[[], Any]


class KeepsPictures(Protocol):
    """A camera that keeps its latest picture for a preview, if it is asked to."""

    def keep_pictures(self) -> None:
        """Keep the latest picture from now on, so that `preview` returns it."""


class TakesEvents(Protocol):
    """A sink of events; see `Sink`."""

    def send(self, events: Sequence[Any]) -> None:
        """Hand events over, in order."""


class TakesFrames(Protocol):
    """A sink of frames; see `FrameSink`."""

    def send_frames(self, frames: Frames) -> None:
        """Hand frames over, in order."""


class TakesStarts(Protocol):
    """A sink that needs the time at which a take begins, as clocks that count from there do."""

    def begin_take(self, performer: str, take: int, time: float) -> None:
        """Note the start of a take, s, before its first events."""


class Prompt(Protocol):
    """A sink that may never block."""

    prompt: bool  # whether events are handed over on the thread that brings them


class Drops(Protocol):
    """A sink that drops events for a slow receiver."""

    dropped: int  # so far


class Syncs(Protocol):
    """A sink on a disk."""

    def sync(self) -> None:
        """Have everything written to the disk, before a snapshot refers to it."""


class HasPosition(Protocol):
    """A sink that can be cut where a snapshot was made."""

    def position(self) -> int | None:
        """Return the bytes in the file, None if that is not known."""
