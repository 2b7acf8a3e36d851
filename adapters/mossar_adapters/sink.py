"""The protocols of consumers of events, or of replayed frames."""

from collections.abc import Sequence
from typing import Protocol

from mossar_adapters.source import Meta
from mossar_stream import Event, Frames


class Sink(Protocol):
    """Takes events. Never blocks for long: events for a slow receiver are dropped and counted.

    Its methods are called one at a time, and from one thread, except those with `prompt = True`. A prompt sink
    never blocks, so events go to it without a detour through a thread of its own. `abilities.py` lists
    the optional members of a sink.
    """

    name: str  # the URL or path, for messages

    @property
    def dropped(self) -> int:
        """Events that could not be handed over."""
        ...

    def announce(self, meta: Meta) -> None:
        """Note a performer: before its first events, and when its skeleton or its settings change."""

    def send(self, events: Sequence[Event]) -> None:
        """Hand events over, in order; now and then without any, to look after receivers that join in quiet times."""

    def close(self) -> None:
        """Flush and release all resources. May be called twice."""


class FrameSink(Protocol):
    """Takes frames of `mossar replay` and `mossar record`."""

    name: str

    def announce(self, meta: Meta) -> None:
        """Note a performer, before its first frames and when its skeleton changes."""

    def send_frames(self, frames: Frames) -> None:
        """Hand frames over, in order."""

    def close(self) -> None:
        """Flush and release all resources. May be called twice."""
