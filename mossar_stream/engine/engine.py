"""Engine: the one loop around the kernels. It does what they ask for and turns what they found into events.

`Segmenter` is a pool of one, `Performers` pools of many, `segment_recording` a pool of one that decides at the end.
"""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.frame_step import (
    DONE,
    HAPPENED,
    RING_FULL,
    STOPS,
    TAKE_ENDS,
    WINDOW_FULL,
    advance,
)
from mossar_stream.algorithm.window_step import END, FOLLOW, update_window
from mossar_stream.engine.pool import Pool, Slot
from mossar_stream.engine.run import BUFFER_FULL, run
from mossar_stream.events import Event, StreamChange, StreamEvent

ONE_DONE, ONE_HAPPENED = STOPS + DONE, STOPS + HAPPENED
_BEGIN = np.zeros(1, np.int64)


def push(
    slot: Slot,
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
    first_frame: int | None = None,
) -> list[Event]:
    """Take frames of one performer in and return the events they cause, after those that were pending.

    Args:
        slot: The performer's.
        positions: (n, J, 3) m.
        times: (n,) s.
        first_frame: Number of the first frame; None to count on.
    """
    if first_frame is not None:
        slot.clock["next_frame"] = first_frame
    events = slot.take_pending()
    cursor, ends = np.zeros(2, np.int64), np.array([len(times)])
    stop = BUFFER_FULL
    while stop != DONE:
        batch = slot.rows, _BEGIN, ends, cursor
        stop = _run(slot.pool, [slot], batch, (positions, times), events)
        used = int(cursor[1])
        if stop == TAKE_ENDS:
            later = times[used] > slot.clock["time"]
            events += end_take(slot, "gap" if later else "clock stepped back")
            if first_frame is not None:
                slot.clock["next_frame"] = first_frame + used
        elif stop == RING_FULL:  # the source is quicker than its nominal rate
            slot.grow(slot.plan.larger(ring=2))
        elif stop == WINDOW_FULL:
            slot.grow(slot.plan.larger(window=2))
    return events


def push_frame(slot: Slot, position: NDArray[np.float32], time: NDArray[np.float64]) -> list[Event]:
    """Take one frame of a take that goes on in: `push`, without what would cost more than the frame itself.

    Args:
        slot: The performer's, whose take is live.
        position: (1, J, 3) m.
        time: (1,) s.
    """
    code = advance(slot.memory, 0, slot.params, position, time)
    if code == ONE_DONE and not slot.pending:
        return []
    if code == ONE_HAPPENED:
        events = slot.take_pending()
        events += update(slot, FOLLOW)
        return events
    return slot.take_pending() if code == ONE_DONE else push(slot, position, time)


def push_many(
    slots: Sequence[Slot], positions: NDArray[np.float32], times: NDArray[np.float64]
) -> list[Event]:
    """Take as many frames of each of many performers in, pool by pool, and return the events they cause.

    Args:
        slots: P slots.
        positions: (P, n, J, 3) m.
        times: (P, n) s.
    """
    count = positions.shape[1]
    positions, times = positions.reshape(-1, *positions.shape[2:]), times.reshape(-1)
    by_pool: dict[Pool, list[int]] = defaultdict(list)
    for k, slot in enumerate(slots):
        by_pool[slot.pool].append(k)
    events: list[Event] = []
    # First those who have a pool of their own.
    for pool, members in sorted(by_pool.items(), key=lambda item: len(item[0].memory)):
        own, begins = [slots[k] for k in members], np.array(members) * count
        for slot in own:
            if slot.pending:
                events += slot.take_pending()
        rows, ends, cursor = np.array([slot.row for slot in own]), begins + count, np.zeros(2, np.int64)
        stop = BUFFER_FULL
        while stop != DONE:
            stop = _run(pool, own, (rows, begins, ends, cursor), (positions, times), events)
            if stop not in (DONE, BUFFER_FULL):
                # This performer needs more than the others, who go on after it.
                k, used = cursor.tolist()
                rest = slice(int(begins[k]) + used, int(ends[k]))
                events += push(own[k], positions[rest], times[rest])
                cursor[:] = k + 1, 0
    return events


def _run(
    pool: Pool,
    slots: Sequence[Slot],
    batch: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
    frames: tuple[NDArray[np.float32], NDArray[np.float64]],
    events: list[Event],
) -> int:
    """Take frames in until the kernels ask for something, tell of takes that began, and add the events there are.

    Args:
        pool: Of the slots.
        slots: Performers.
        batch: Their rows, where their frames begin and end, and the cursor; see `run`.
        frames: (n, J, 3) m; (n,) s.
        events: Is added to.

    Returns:
        The stop code.
    """
    silent = [slot for slot in slots if not slot.is_live]
    stop = run(pool.memory, pool.plan.params, pool.buffers.for_run, batch, *frames)
    for slot in silent:
        if pool.is_open[slot.row]:
            slot.is_live = True
            events.append(stream_event(slot, "started"))
    events += pool.take_events()
    return stop


def update(slot: Slot, reason: int) -> list[Event]:
    """Let the compiled part do what is due for one performer, and return its events.

    Args:
        slot: The performer's.
        reason: See `update_window`.
    """
    buffers = slot.pool.buffers
    update_window(slot.memory, 0, slot.params, buffers.scratch, buffers.events, reason)
    return slot.pool.take_events()


def end_take(slot: Slot, reason: str = "") -> list[Event]:
    """End a performer's take: decide everything, and return the events, after those that were pending."""
    events = slot.take_pending()
    if slot.clock["open"]:
        ended = stream_event(slot, "ended", reason)
        events += update(slot, END)
        events.append(ended)
        slot.is_live = False
    return events


def stream_event(slot: Slot, change: StreamChange, reason: str = "") -> StreamEvent:
    """Return the event that tells of a change of the stream in the take that is open, or the next one."""
    return StreamEvent(performer=slot.name, event=change, take=int(slot.clock["take"]), reason=reason)
