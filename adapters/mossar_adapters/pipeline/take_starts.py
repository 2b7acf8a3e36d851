"""Take starts: when the takes began that a chunk of frames opened.

Sinks that count time from the beginning of a take need it before the take's first event. A chunk is therefore cut
where its times show that a take may end: a take that begins in a part begins with its first frame.
"""

import itertools
from typing import TypeGuard

import msgspec
import numpy as np

from mossar_adapters.replay.interleaving import part
from mossar_stream import Event, Frames, StreamEvent

_SAFE = 0.99  # of the pause: a cut too many changes nothing, one too few does


class TakeStart(msgspec.Struct, frozen=True):
    """A take began.

    Args:
        performer: Name.
        take: Its number.
        time: Source time of its first frame, s.
    """

    performer: str
    take: int
    time: float


def parts(frames: Frames, max_pause: float) -> list[Frames]:
    """Return a chunk cut where a take may end within it.

    Args:
        frames: The chunk.
        max_pause: Longest step in time within a take, s.
    """
    if len(frames) < 2:
        return [frames]
    cuts = np.flatnonzero(np.abs(np.diff(frames.times)) > _SAFE * max_pause) + 1
    if not len(cuts):
        return [frames]
    edges = [0, *cuts.tolist(), len(frames)]
    return [part(frames, first, end) for first, end in itertools.pairwise(edges)]


def take_starts(events: list[Event], frames: Frames) -> list[TakeStart]:
    """Return the take that began with a part, if one did: see `parts`."""
    time = float(frames.times[0])
    return [TakeStart(event.performer, event.take, time) for event in events if is_start(event)]


def is_start(event: Event) -> TypeGuard[StreamEvent]:
    """Return whether an event reports the begin of a take."""
    return isinstance(event, StreamEvent) and event.event == "started"
