"""Engine: what Python does around the one loop (run.pxi): it does what the loop stops for, and ends takes.

Whatever is caused is added to `Row.pending`, step by step in its order; callers take it from there once all is done.
`mend` finishes what an exception, such as Ctrl-C, cut short between two steps. A compiled call is never cut short, nor do
exceptions come between two statements without a call, as in `reader.reported = reported; row.pending += events`.

`Segmenter` is a desk of one performer, `Performers.push_many` desks of many, `segment_recording` one that decides at the end.
"""

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.buffers import IN_USE, Buffers
from mossar_stream.core.intake import is_frame, narrow_frame
from mossar_stream.core.kernels import (
    ANALYSED,
    DONE,
    END,
    LEVEL,
    NOT_PLAIN,
    PHASE,
    RANK,
    READ,
    RING_FULL,
    SAID,
    TAKE_ENDS,
    WINDOW_FULL,
    analyse,
    run,
    run_one,
    update_window,
)
from mossar_stream.core.pool import Row
from mossar_stream.core.station import Desk
from mossar_stream.events import BODY, Event, StreamChange, StreamEvent
from mossar_stream.repetitions.reporting import Reported

T = TypeVar("T")
NOBODY = "nobody seen"  # in the reason for which a take ended
NO_ENDS: list[tuple[int, int]] = []
NOTHING_REPORTED, NOT_STOPPED = Reported(), np.zeros(1, np.int64)
UNCHANGED = -1  # the first cycle that an analysis changed, if it changed none


def process(desk: Desk, positions: NDArray[np.float32], times: NDArray[np.float64]) -> list[tuple[int, int]]:
    """Process frames of one performer or of many; the events they cause are pending.

    Returns:
        Those whose take ends before a frame of theirs: who, and how many frames were processed. Theirs are left from there.

    Args:
        desk: Of the performers.
        positions: (n, J, 3) m.
        times: (n,) s.

    Raises:
        RuntimeError: If another thread is using their buffers.
    """
    buffers = desk.buffers  # as `guarded` would do it, which takes longer
    if buffers.is_busy:
        raise RuntimeError(IN_USE)
    try:
        buffers.is_busy = True
        stop = run(desk.memory, buffers.tools, desk.params, positions, times)
        ended = _go_on(desk, stop, positions, times) if stop != DONE else NO_ENDS
        buffers.is_busy = False
    except BaseException:
        buffers.is_busy = False
        raise
    return ended


def process_one(
    desk: Desk,
    positions: Any,
    time: Any,
    buffer: NDArray[np.float32],
    origin: NDArray[np.float64] | None,
) -> bool:
    """Process one frame of one performer, if it is an array of (J, 3) numbers with a time, and in its take.

    Args:
        desk: Of the performer.
        positions: As given, m.
        time: As given, s.
        buffer: (1, J, 3), to work with.
        origin: Where the performer is, m, as `Row.origin`.

    Returns:
        Whether it was processed; if not, it is to be checked and processed as all frames are.
    """
    buffers = desk.buffers
    if buffers.is_busy:
        raise RuntimeError(IN_USE)
    try:
        buffers.is_busy = True
        stop = NOT_PLAIN
        if origin is None:
            stop = run_one(desk.memory, buffers.tools, desk.params, positions, time, buffer)
        if stop == NOT_PLAIN and is_frame(positions, time, buffer.shape[1:]):
            narrow_frame(positions, origin, buffer[0])
            stop = run_one(desk.memory, buffers.tools, desk.params, buffer[0], float(time), buffer)
        done = stop == DONE
        if not done and stop != NOT_PLAIN:
            narrow_frame(positions, origin, buffer[0])
            done = not _go_on(desk, stop, buffer, np.array([time], np.float64))
        buffers.is_busy = False
    except BaseException:
        buffers.is_busy = False
        raise
    return done


def _go_on(
    desk: Desk, stop: int, positions: NDArray[np.float32], times: NDArray[np.float64]
) -> list[tuple[int, int]]:
    """Do what the loop stopped for, and let it go on, until all frames are processed."""
    buffers, head, ended = desk.buffers, desk.head, list[tuple[int, int]]()
    while stop not in (DONE, SAID):
        buffers.hand_out()
        at, used = int(head["performer"][0]), int(head["frame"][0])
        station = desk.stations[at]
        if stop in (ANALYSED, READ, PHASE):
            tell(desk, float(times[desk.begins[at] + used]) if stop == ANALYSED else math.inf)
        elif stop == RING_FULL:  # the source is quicker than its nominal rate
            row = station.rows[int(head["stage"][0])]
            row.grow(row.plan.with_longer_ring)
            station.refresh()
        elif stop == WINDOW_FULL:  # much is undecided, or a recording is long
            for row in station.rows:
                if row.is_full:
                    row.grow(row.plan.with_more_room)
            station.refresh()
        elif stop == TAKE_ENDS:
            ended.append((at, used))
            head["performer"], head["frame"] = at + 1, 0
        desk.stopped[0] = DONE
        stop = run(desk.memory, buffers.tools, desk.params, positions, times)
    buffers.hand_out()
    return ended


def tell(desk: Desk, time: float) -> None:
    """Add the events to what is pending for which the loop stopped.

    Args:
        desk: Where it did.
        time: s, of the frame before which repetitions were analysed.
    """
    head, stop = desk.head, int(desk.stopped[0])
    station, stage = desk.stations[int(head["performer"][0])], int(head["stage"][0])
    body = station.body
    take = int(body.clock["take"])
    if stop == READ:
        reader = station.readers[stage - len(station.rows) - 1]
        events, reported = reader.report(take, body.origin)
        desk.stopped[0] = DONE
        reader.reported = reported
        body.pending += events
    elif stop == PHASE and body.reporter is not None and body.clock["open"]:
        events, reported = body.reporter.report_phase(take, float(body.clock["time"]))
        desk.stopped[0] = DONE
        body.reporter.reported = reported
        body.pending += events
    elif stop == ANALYSED:
        row = station.rows[stage]
        if row.analyses is not None:
            row.analyses.append((time, row.periods.copy()))
        if head["changed"][0]:
            _report_repetitions(row, desk.stopped)


def _report_repetitions(row: Row, stopped: NDArray[np.int64]) -> None:
    """Add the events of an analysis that changed something to what is pending."""
    if row.reporter is None:
        return
    take = int(row.clock["take"])
    events, reported = row.reporter.report(take)
    stopped[0] = DONE
    row.analysed_take = take if row.is_analysing else row.analysed_take
    row.is_analysing = False
    row.reporter.reported = reported
    row.pending += events


def reason_of(row: Row, reason: str) -> str:
    """Return why a take ends: also if nobody was seen, as every joint was missing, or at the origin, in all frames."""
    return reason if row.is_placed else ", ".join(filter(None, (reason, NOBODY)))


def why_ended(row: Row, time: float) -> str:
    """Return the reason for which a take ends before a frame at this time, s."""
    step = time - row.clock["time"]
    if 0.0 <= step <= row.state["plan"]["max_pause"]:
        return NOBODY
    return "gap" if step > 0.0 else "clock stepped back"


def update(row: Row, reason: int) -> list[Event]:
    """Let the compiled part do what is due for one performer, and return what is pending then.

    Args:
        row: The performer's.
        reason: See `update_window`.
    """
    guarded(row.buffers, lambda: _update(row, reason))
    return row.take_pending()


def _update(row: Row, reason: int) -> None:
    buffers = row.buffers
    if reason in {END, RANK}:
        _analyse_once_more(row)
    update_window(row.memory, row.plan.params, buffers.tools, reason)
    buffers.hand_out()


def _analyse_once_more(row: Row) -> None:
    """Analyse what was repeated, as the take ends, once: each analysis adds the newest pose to the samples."""
    take = int(row.clock["take"])
    if not len(row.counting) or row.analysed_take == take:
        return
    row.counted["changed"] = UNCHANGED  # an analysis of too few samples leaves it as it was
    row.samples = int(row.counted["open"][0])
    row.is_analysing = True
    changed = analyse(row.counting, row.buffers.store, math.inf)
    if row.analyses is not None:
        row.analyses.append((math.inf, row.periods.copy()))
    if changed:
        _report_repetitions(row, NOT_STOPPED)
    row.is_analysing = False
    row.analysed_take = take


def _finish_analysis(row: Row) -> None:
    """Tell what the last analysis of a take has changed, if an exception kept that from being reported."""
    if row.is_analysing and row.counted["open"][0] > row.samples:
        take = int(row.clock["take"])
        if row.counted["changed"][0] != UNCHANGED:
            _report_repetitions(row, NOT_STOPPED)
        row.analysed_take = take
    row.is_analysing = False


def apply_level(row: Row) -> None:
    """Let a level that moved act on the undecided key frames."""
    if row.is_level_new:
        guarded(row.buffers, lambda: _settle_level(row))


def _settle_level(row: Row) -> None:
    if row.is_level_new:
        _update(row, LEVEL)
        row.is_level_new = False


def close_take(row: Row) -> None:
    """Decide everything in a performer's take, which `report_end` reports to have ended when all others are done."""
    guarded(row.buffers, lambda: _close_take(row))


def _close_take(row: Row) -> None:
    _settle_level(row)
    if row.clock["open"]:
        _update(row, END)


def report_end(row: Row, reason: str) -> None:
    """Report that a take has ended, once; takes of limbs end with their body's, and are not reported."""
    if row.is_live:
        number = int(row.clock["take"])
        ended = [stream_event(row, "ended", reason, number - 1)] if row.plan.channel == BODY else []
        if row.reporter is not None:
            row.reporter.reported = NOTHING_REPORTED
        row.ended = number
        row.pending += ended


def stream_event(row: Row, change: StreamChange, reason: str = "", take: int | None = None) -> StreamEvent:
    """Return the event that tells of a change of the stream in a take: the one that is open, or the next one."""
    number = int(row.clock["take"]) if take is None else take
    return StreamEvent(performer=row.name, event=change, take=number, reason=reason)


def mend(desk: Desk, crowd: Desk | None) -> None:
    """Finish what an exception cut short between two steps; what is in order stays as it is.

    The steps that are due can be read from the desks: why the loop stopped, events in the buffer, a row that was about to move.

    Args:
        desk: Of the performer alone.
        crowd: That which the exception came for, if it is of several performers.
    """
    guarded(desk.buffers, lambda: _mend(desk, crowd))


def _mend(desk: Desk, crowd: Desk | None) -> None:
    desk.buffers.hand_out()
    for torn in filter(None, (crowd, desk)):
        tell(torn, math.inf)
        torn.begin_anew()
    for row in desk.stations[0].rows:
        row.mend()
        _finish_analysis(row)
    desk.stations[0].refresh()


def guarded(buffers: Buffers, work: Callable[[], T]) -> T:
    """Do something while no other thread may, and return what it returns.

    Raises:
        RuntimeError: If another one is in.
    """
    if buffers.is_busy:
        raise RuntimeError(IN_USE)
    try:
        buffers.is_busy = True
        found = work()
        buffers.is_busy = False
    except BaseException:
        buffers.is_busy = False
        raise
    return found
