"""Interleaving: the frames of several performers in order of time."""

import heapq
from collections.abc import Iterable, Iterator

from mossar_stream import Frames

MOST_WAITING = 64  # chunks per performer; one that has ended must not hold up the others for ever


def in_order_of_time(chunks: Iterable[Frames], performers: int) -> Iterator[Frames]:
    """Yield the frames of chunks, one at a time if there are several performers, in order of time.

    A frame is held back until every other performer has got that far. Readers hand over a chunk of one performer
    after the other; a performer that falls `MOST_WAITING` chunks behind is not waited for.

    Args:
        chunks: Chunks, those of each performer in order.
        performers: Number of performers.
    """
    if performers == 1:
        yield from chunks
        return
    waiting: list[tuple[float, int, Frames]] = []
    reached: dict[str, float] = {}  # s, the last time that arrived of each performer
    held = number = 0
    for chunk in chunks:
        for i in range(len(chunk)):
            number += 1
            heapq.heappush(waiting, (float(chunk.times[i]), number, part(chunk, i, i + 1)))
        reached[chunk.performer] = float(chunk.times[-1])
        held += 1
        if held > MOST_WAITING * performers:
            until, held = max(reached.values()), 0
        else:
            until = min(reached.values()) if len(reached) == performers else -float("inf")
        while waiting and waiting[0][0] <= until:
            yield heapq.heappop(waiting)[2]
        held = held if waiting else 0
    while waiting:
        yield heapq.heappop(waiting)[2]


def part(frames: Frames, start: int, stop: int) -> Frames:
    """Return frames `start` up to `stop` of a chunk."""
    return Frames(
        frames.positions[start:stop],
        frames.times[start:stop],
        None if frames.confidence is None else frames.confidence[start:stop],
        frames.performer,
        None if frames.first_frame is None else frames.first_frame + start,
    )
