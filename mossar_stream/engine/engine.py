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
    LOOK_DUE,
    RING_FULL,
    STOPS,
    TAKE_ENDS,
    WINDOW_FULL,
    advance,
)
from mossar_stream.algorithm.window_step import END, FOLLOW, LEVEL, RANK, update_window
from mossar_stream.engine.buffers import IN_USE
from mossar_stream.engine.pool import Pool, Row
from mossar_stream.engine.run import BUFFER_FULL, run
from mossar_stream.events import Event, StreamChange, StreamEvent

ONE_DONE, ONE_HAPPENED = STOPS + DONE, STOPS + HAPPENED
NOBODY = "nobody seen"  # in the reason for which a take ended
_BEGIN = np.zeros(1, np.int64)


def push(
    row: Row,
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
    first_frame: int | None = None,
) -> list[Event]:
    """Take frames of one performer in and return the events they cause, after those that were pending.

    Args:
        row: The performer's.
        positions: (n, J, 3) m.
        times: (n,) s.
        first_frame: Number of the first frame; None to count on.

    Raises:
        RuntimeError: If another thread is using the row's pool.
    """
    guard = row.guard
    guard.enter()
    try:
        return _push(row, positions, times, first_frame)
    finally:
        guard.is_busy = False


def _push(
    row: Row,
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
    first_frame: int | None = None,
) -> list[Event]:
    events = _take_pending(row)
    if first_frame is not None:
        row.clock["next_frame"] = first_frame
    cursor, ends = np.zeros(2, np.int64), np.array([len(times)])
    stop = BUFFER_FULL
    while stop != DONE:
        batch = row.indices, _BEGIN, ends, cursor
        stop = _run(row.pool, [row], batch, (positions, times), events)
        used = int(cursor[1])
        if stop == TAKE_ENDS:
            events += _end_take(row, _why_it_ends(row, times[used]))
            if first_frame is not None:
                row.clock["next_frame"] = first_frame + used
        elif stop == LOOK_DUE:
            events += row.look_at_repetitions(times[used])
        elif stop == RING_FULL:  # the source is quicker than its nominal rate
            row.grow(row.plan.larger(ring=2))
        elif stop == WINDOW_FULL:
            row.grow(row.plan.larger(window=2))
    return events


def _why_it_ends(row: Row, time: np.float64) -> str:
    """Return the reason for which a take ends before a frame at this time, s."""
    step = time - row.clock["time"]
    if 0.0 <= step <= row.plan.given.max_pause:
        return NOBODY
    return "gap" if step > 0.0 else "clock stepped back"


def push_frame(row: Row, position: NDArray[np.float32], time: NDArray[np.float64]) -> list[Event] | None:
    """Take one frame of a take that goes on in: `push`, without what would cost more than the frame itself.

    Returns:
        The events; None if the take ends before the frame, which was not taken in then.

    Args:
        row: The performer's, whose take is live.
        position: (1, J, 3) m.
        time: (1,) s.
    """
    guard = row.guard  # as `enter` would do it, which takes longer
    if guard.is_busy:
        raise RuntimeError(IN_USE)
    guard.is_busy = True
    try:
        code = advance(row.memory, 0, row.params, position, time)
        if code == ONE_DONE and not row.pending:
            return []
        if code == ONE_HAPPENED:
            events = row.take_pending()
            events += _update(row, FOLLOW)
            return events
        if code == TAKE_ENDS:
            return None
        return row.take_pending() if code == ONE_DONE else _push(row, position, time)
    finally:
        guard.is_busy = False


def push_short(
    row: Row, positions: NDArray[np.float32], times: NDArray[np.float64], first_frame: int | None = None
) -> list[Event]:
    """Take frames in as `push` does, by `push_frame` where it is one of a take that goes on."""
    counted = first_frame is None or counts_on(row, first_frame)
    if counted and len(times) == 1 and row.is_live and not row.is_level_new:
        events = push_frame(row, positions, times)
        if events is not None:
            return events
    return push(row, positions, times, first_frame)


def counts_on(row: Row, first_frame: int) -> bool:
    """Tell whether a frame's number is the one that it would have anyway, unless a new take begins with it."""
    return bool(first_frame == row.clock["next_frame"])


def push_many(rows: Sequence[Row], positions: NDArray[np.float32], times: NDArray[np.float64]) -> list[Event]:
    """Take as many frames of each of many performers in, pool by pool, and return the events they cause.

    Args:
        rows: P rows.
        positions: (P, n, J, 3) m.
        times: (P, n) s.
    """
    count = positions.shape[1]
    positions, times = positions.reshape(-1, *positions.shape[2:]), times.reshape(-1)
    by_pool: dict[Pool, list[int]] = defaultdict(list)
    for k, row in enumerate(rows):
        by_pool[row.pool].append(k)
    events: list[Event] = []
    # First those who have a pool of their own.
    for pool, members in sorted(by_pool.items(), key=lambda item: len(item[0].memory)):
        own, begins = [rows[k] for k in members], np.array(members) * count
        guard = pool.buffers.guard
        guard.enter()
        try:
            for row in [row for row in own if row.pending or row.is_level_new]:
                events += _take_pending(row)
            indices, ends, cursor = (
                np.array([row.index for row in own]),
                begins + count,
                np.zeros(2, np.int64),
            )
            stop = BUFFER_FULL
            while stop != DONE:
                stop = _run(pool, own, (indices, begins, ends, cursor), (positions, times), events)
                if stop not in (DONE, BUFFER_FULL):
                    # What this performer needs is done apart; the others go on after it.
                    k, used = cursor.tolist()
                    rest = slice(int(begins[k]) + used, int(ends[k]))
                    events += _push(own[k], positions[rest], times[rest])
                    cursor[:] = k + 1, 0
        finally:
            guard.is_busy = False
    return events


def _run(
    pool: Pool,
    rows: Sequence[Row],
    batch: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
    frames: tuple[NDArray[np.float32], NDArray[np.float64]],
    events: list[Event],
) -> int:
    """Take frames in until the kernels ask for something, tell of takes that began, and add the events there are.

    Args:
        pool: Of the rows.
        rows: Performers.
        batch: Their indices, where their frames begin and end, and the cursor; see `run`.
        frames: (n, J, 3) m; (n,) s.
        events: Is added to.

    Returns:
        The stop code.
    """
    silent = [row for row in rows if not row.is_live]
    stop = run(pool.memory, pool.plan.params, pool.buffers.for_run, batch, *frames)
    for row in silent:
        if pool.is_open[row.index]:
            row.is_live = True
            events.append(stream_event(row, "started"))
    events += pool.take_events()
    return stop


def update(row: Row, reason: int) -> list[Event]:
    """Let the compiled part do what is due for one performer, and return its events.

    Args:
        row: The performer's.
        reason: See `update_window`.
    """
    guard = row.guard
    guard.enter()
    try:
        return _update(row, reason)
    finally:
        guard.is_busy = False


def _update(row: Row, reason: int) -> list[Event]:
    buffers = row.pool.buffers
    told = row.look_at_repetitions() if reason in {END, RANK} else []
    update_window(row.memory, 0, row.params, buffers.scratch, buffers.events, reason)
    return told + row.pool.take_events()


def take_pending(row: Row) -> list[Event]:
    """Return the events that waited for the next push, those of a level that moved included."""
    guard = row.guard
    guard.enter()
    try:
        return _take_pending(row)
    finally:
        guard.is_busy = False


def _take_pending(row: Row) -> list[Event]:
    if row.is_level_new:
        row.is_level_new = False
        row.pending += _update(row, LEVEL)
    return row.take_pending()


def end_take(row: Row, reason: str = "") -> list[Event]:
    """End a performer's take: decide everything, and return the events, after those that were pending.

    The last one says so if nobody was seen: every joint was missing, or at the origin, in all frames.
    """
    guard = row.guard
    guard.enter()
    try:
        said = reason if row.is_placed else ", ".join(filter(None, (reason, NOBODY)))
        return _end_take(row, said)
    finally:
        guard.is_busy = False


def _end_take(row: Row, reason: str) -> list[Event]:
    events = _take_pending(row)
    if row.clock["open"]:
        ended = stream_event(row, "ended", reason)
        events += _update(row, END)
        events.append(ended)
        if row.telling is not None:
            row.telling.end()
        row.is_live = False
    return events


def stream_event(row: Row, change: StreamChange, reason: str = "") -> StreamEvent:
    """Return the event that tells of a change of the stream in the take that is open, or the next one."""
    return StreamEvent(performer=row.name, event=change, take=int(row.clock["take"]), reason=reason)
