"""Engine: the one loop around the kernels. It does what they ask for and turns what they found into events.

Whatever is caused is added to `Row.pending`, step by step in its order; callers take it from there once all is done.
`mend` finishes what an exception, such as Ctrl-C, cut short between two steps. A compiled call is never cut short, nor do
exceptions come between two statements without a call, as in `x.is_live = True; x.pending += events`.

`Segmenter` is a pool of one, `Performers` pools of many, `segment_recording` a pool of one that decides at the end.
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

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
from mossar_stream.engine.buffers import IN_USE, Guard
from mossar_stream.engine.pool import Pool, Row
from mossar_stream.engine.run import BUFFER_FULL, run
from mossar_stream.events import BODY, Event, StreamChange, StreamEvent

T = TypeVar("T")
ONE_DONE, ONE_HAPPENED = STOPS + DONE, STOPS + HAPPENED
NOBODY = "nobody seen"  # in the reason for which a take ended
_BEGIN = np.zeros(1, np.int64)


def push(
    row: Row,
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
    first_frame: int | None = None,
) -> list[Event]:
    """Process frames of one performer that nothing else follows, and return what is pending then; see `process`."""
    begin = 0
    while begin < len(times) or not begin:
        number = None if first_frame is None else first_frame + begin
        begin += process(row, positions[begin:], times[begin:], number)
        if begin >= len(times):
            break
        end_take(row, why_ended(row, times[begin]))
    return row.take_pending()


def process(
    row: Row,
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
    first_frame: int | None = None,
) -> int:
    """Process frames of one performer; the events they cause are pending.

    Returns:
        How many were processed: all, or those before which the take ends.

    Args:
        row: The performer's.
        positions: (n, J, 3) m.
        times: (n,) s.
        first_frame: Number of the first frame; None to count on.

    Raises:
        RuntimeError: If another thread is using the row's pool.
    """
    return guarded(row.guard, lambda: _process(row, positions, times, first_frame))


def _process(
    row: Row,
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
    first_frame: int | None = None,
) -> int:
    settle_level(row)
    if first_frame is not None:
        row.clock["next_frame"] = first_frame
    cursor, ends = np.zeros(2, np.int64), np.array([len(times)])
    stop = BUFFER_FULL
    while stop != DONE:
        batch = row.indices, _BEGIN, ends, cursor
        stop = run_rows(row.pool, [row], batch, (positions, times))
        used = int(cursor[1])
        if stop == TAKE_ENDS:
            return used
        if stop == LOOK_DUE:
            row.look_at_repetitions(times[used])
        elif stop == RING_FULL:  # the source is quicker than its nominal rate
            row.grow(row.plan.larger(ring=2))
        elif stop == WINDOW_FULL:
            row.grow(row.plan.larger(window=2))
    return len(times)


def reason_of(row: Row, reason: str) -> str:
    """Return why a take ends: also if nobody was seen, as every joint was missing, or at the origin, in all frames."""
    return reason if row.is_placed else ", ".join(filter(None, (reason, NOBODY)))


def why_ended(row: Row, time: float) -> str:
    """Return the reason for which a take ends before a frame at this time, s."""
    step = time - row.clock["time"]
    if 0.0 <= step <= row.plan.given.max_pause:
        return NOBODY
    return "gap" if step > 0.0 else "clock stepped back"


def process_frame(row: Row, position: NDArray[np.float32], time: NDArray[np.float64]) -> bool:
    """Process one frame of a take that goes on: `process`, without what would cost more than the frame itself.

    Returns:
        Whether it was processed; if not, the take ends before it.

    Args:
        row: The performer's, whose take is live and whose level has not moved.
        position: (1, J, 3) m.
        time: (1,) s.
    """
    guard = row.guard  # as `enter` would do it, which takes longer
    if guard.is_busy:
        raise RuntimeError(IN_USE)
    try:
        guard.is_busy = True
        code = advance(row.memory, 0, row.params, position, time)
        if code != ONE_DONE:
            if code == TAKE_ENDS:
                guard.is_busy = False
                return False
            if code == ONE_HAPPENED:
                _update(row, FOLLOW)
            else:
                _process(row, position, time)
        guard.is_busy = False
    except BaseException:
        guard.is_busy = False
        raise
    return True


def process_short(
    row: Row, positions: NDArray[np.float32], times: NDArray[np.float64], first_frame: int | None = None
) -> int:
    """Process frames as `process` does, by `process_frame` where it is one of a take that goes on."""
    counted = first_frame is None or counts_on(row, first_frame)
    short = counted and len(times) == 1 and row.is_live and not row.is_level_new
    if short:
        return int(process_frame(row, positions, times))
    return process(row, positions, times, first_frame)


def counts_on(row: Row, first_frame: int) -> bool:
    """Tell whether a frame's number is the one that it would have anyway, unless a new take begins with it."""
    return bool(first_frame == row.clock["next_frame"])


def run_rows(
    pool: Pool,
    rows: Sequence[Row],
    batch: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
    frames: tuple[NDArray[np.float32], NDArray[np.float64]],
) -> int:
    """Process frames until the kernels ask for something, report takes that began, and hand out the events there are.

    Args:
        pool: Of the rows.
        rows: Performers.
        batch: Their indices, where their frames begin and end, and the cursor; see `run`.
        frames: (n, J, 3) m; (n,) s.

    Returns:
        The stop code.
    """
    silent = [row for row in rows if not row.is_live]
    stop = run(pool.memory, pool.plan.params, pool.buffers.for_run, batch, *frames)
    for row in silent:
        if pool.is_open[row.index]:
            _report_start(row)
    pool.buffers.hand_out()
    return stop


def update(row: Row, reason: int) -> list[Event]:
    """Let the compiled part do what is due for one performer, and return what is pending then.

    Args:
        row: The performer's.
        reason: See `update_window`.
    """
    guarded(row.guard, lambda: _update(row, reason))
    return row.take_pending()


def _update(row: Row, reason: int) -> None:
    buffers = row.pool.buffers
    if reason in {END, RANK}:
        row.look_at_repetitions()
    update_window(row.memory, 0, row.params, buffers.scratch, buffers.events, reason)
    buffers.hand_out()


def apply_level(row: Row) -> None:
    """Let a level that moved act on the undecided key frames."""
    if row.is_level_new:
        guarded(row.guard, lambda: settle_level(row))


def settle_level(row: Row) -> None:
    """Do so for the thread that is in."""
    if row.is_level_new:
        _update(row, LEVEL)
        row.is_level_new = False


def end_take(row: Row, reason: str) -> None:
    """End the take of a performer whom nothing else follows."""
    close_take(row)
    report_end(row, reason)


def close_take(row: Row) -> None:
    """Decide everything in a performer's take, which `report_end` reports to have ended when all others are done."""
    guarded(row.guard, lambda: _close_take(row))


def _close_take(row: Row) -> None:
    settle_level(row)
    if row.clock["open"]:
        _update(row, END)


def report_end(row: Row, reason: str) -> None:
    """Report that a take has ended, once; takes of limbs end with their body's, and are not reported."""
    if row.is_live:
        if row.telling is not None:
            row.telling.end()
        ended = stream_event(row, "ended", reason, int(row.clock["take"]) - 1)
        row.is_live = row.is_placed = False
        if row.plan.channel == BODY:
            row.pending += [ended]


def _report_start(row: Row) -> None:
    """Report that a take has begun."""
    started = stream_event(row, "started")
    row.is_live = True
    if row.plan.channel == BODY:
        row.pending += [started]
    row.look_for_place()


def stream_event(row: Row, change: StreamChange, reason: str = "", take: int | None = None) -> StreamEvent:
    """Return the event that tells of a change of the stream in a take: the one that is open, or the next one."""
    number = int(row.clock["take"]) if take is None else take
    return StreamEvent(performer=row.name, event=change, take=number, reason=reason)


def mend(row: Row) -> None:
    """Finish what an exception cut short between two steps; a row that is in order stays as it is.

    The steps that are due can be read from the row: what happened in its last frame and was not followed, events in the
    buffer, a take that began or ended and was not reported.
    """
    guarded(row.guard, lambda: _mend(row))


def _mend(row: Row) -> None:
    row.mend()
    is_open = bool(row.clock["open"])
    if is_open and not row.is_live:
        _report_start(row)
    row.pool.buffers.hand_out()
    state = row.state
    if is_open and (state["curve"]["found"]["happened"] or row.clock["time"] >= state["window"]["due_time"]):
        _update(row, FOLLOW)
    row.look_for_place()


def guarded(guard: Guard, work: Callable[[], T]) -> T:
    """Do something while no other thread may, and return what it returns.

    Raises:
        RuntimeError: If another one is in.
    """
    if guard.is_busy:
        raise RuntimeError(IN_USE)
    try:
        guard.is_busy = True
        found = work()
        guard.is_busy = False
    except BaseException:
        guard.is_busy = False
        raise
    return found
