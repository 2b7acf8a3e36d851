"""What every consumer of events, or of replayed frames, looks like to the pipeline."""

from collections.abc import Sequence
from typing import Protocol

from mossar_adapters.source import Meta
from mossar_stream import Event, Frames


class Sink(Protocol):
    """Takes events. Never blocks for long: what a slow receiver cannot take is dropped and counted.

    Its methods are called one at a time, and but for those that say `prompt = True` from one thread. A prompt sink
    never blocks, so events go to it without a detour through a thread of its own. `abilities.py` has what a sink may
    offer besides.
    """

    name: str  # the URL or path, for messages

    @property
    def dropped(self) -> int:
        """Events that could not be handed over."""
        ...

    def announce(self, meta: Meta) -> None:
        """Take note of a performer: before its first events, and when its skeleton or its settings change."""

    def send(self, events: Sequence[Event]) -> None:
        """Hand events over, in order; now and then without any, to look after receivers that join in quiet times."""

    def close(self) -> None:
        """Flush and release what is held. May be called twice."""


class FrameSink(Protocol):
    """Takes frames: what `mossar replay` and `mossar record` write to."""

    name: str

    def announce(self, meta: Meta) -> None:
        """Take note of a performer, before its first frames and when its skeleton changes."""

    def send_frames(self, frames: Frames) -> None:
        """Hand frames over, in order."""

    def close(self) -> None:
        """Flush and release what is held. May be called twice."""
