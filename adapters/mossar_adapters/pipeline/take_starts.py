"""Take starts: when the takes began that a chunk of frames opened."""

import msgspec
import numpy as np

from mossar_stream.events import Event, StreamEvent
from mossar_stream.frames import Frames


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


def take_starts(
    events: list[Event], frames: Frames, before: float | None, max_pause: float
) -> list[TakeStart]:
    """Return the takes that began with frames of a chunk.

    Args:
        events: What the chunk caused.
        frames: The chunk.
        before: Time of the frame before the chunk, s; None if there was none.
        max_pause: Longest step in time within a take, s.

    Returns:
        One for each `started` event; none if the frames do not tell which ones began them.
    """
    started = [event for event in events if isinstance(event, StreamEvent) and event.event == "started"]
    if not started:
        return []
    times = frames.times
    steps = np.diff(times, prepend=np.inf if before is None else before)
    breaks = [float(time) for time in times[np.abs(steps) > max_pause]]
    if len(breaks) < len(started):  # the take before had been ended by the wall clock
        breaks.insert(0, float(times[0]))
    if len(breaks) != len(started):
        return []
    return [TakeStart(e.performer, e.take, time) for e, time in zip(started, breaks, strict=True)]
