"""Run: the one loop. Frames of one performer or of many, for body and limbs and what reads the poses, in one compiled call.

    for each performer, for each frame:
        body      the frame step; after a frame in which something happened, the window step
        limbs     the same for each, if the body processed the frame
        readers   who else follows the frames, each when it is due
        phase     of the repeated movement, if it is asked for

It stops where Python must do something, and goes on from there: `HEAD` says where.
`advance` and `update_window` are linked: each is compiled once, and ends of takes call the latter on their own.
"""

from typing import Any

import numpy as np
from numba import int64, void
from numpy.typing import NDArray

from mossar_stream.algorithm.frame_step import (
    ANALYSIS_DUE,
    DONE,
    HAPPENED,
    STOPS,
    TAKE_ENDS,
    advance,
)
from mossar_stream.algorithm.row import ROW
from mossar_stream.algorithm.window_step import FOLLOW, update_window
from mossar_stream.engine.layout import (
    ALL_ANALYSES,
    CHANGES,
    CHANNEL,
    CHANNEL_BYTES,
    HEAD,
    HEAD_BYTES,
    READER,
    SEAT,
    STATION,
    STATION_BYTES,
    TOOLS,
)
from mossar_stream.engine.middle import put_middle
from mossar_stream.jit.decorators import entry_point, inline_kernel, kernel
from mossar_stream.jit.linked import linked
from mossar_stream.jit.views import at_address, part
from mossar_stream.memory.event_buffer import EVENT, EVENT_BYTES, put_start
from mossar_stream.readers import BACK, call_reader
from mossar_stream.repetitions.state import PERIODS, copy_periods

ADVANCE, UPDATE = "mossar.advance", "mossar.update_window"
advance_by_name = linked(ADVANCE, int64)(advance)
update_window_by_name = linked(UPDATE, void)(update_window)
AFTER_A_FRAME = np.int64(FOLLOW)
ONE, NOTHING = np.int64(1), np.int64(0)
POINT_BYTES = 12
WINDOW_FULL, BUFFER_FULL, ANALYSED, READ, PHASE, SAID = range(
    STOPS - 6, STOPS
)  # what the caller must do besides what `advance` asks for


@entry_point(makes_arrays=False)
def run(
    desk: NDArray[np.uint8],
    tools: NDArray[np.uint8],
    params: NDArray[np.void],
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
) -> int:
    """Process frames until they are used up or the caller must do something.

    Args:
        desk: Whose frames they are, and how far they are processed; see `Desk`.
        tools: Scratch and the event buffer; see `Buffers`.
        params: (1 + L,) records of the similarity measure, for body and limbs.
        positions: (n, J, 3) float32 m.
        times: (n,) s.

    Returns:
        DONE, or SAID if that left events; else what must be done before the loop goes on, of the performer and the stage at
        which `HEAD` stands: TAKE_ENDS, RING_FULL, BUFFER_FULL; WINDOW_FULL: before a frame, rows need room for more key frames;
        ANALYSED, READ, PHASE: ask what is counted, a reader, or the phase for its events.
    """
    head = part(desk, 0, HEAD, (1,))[0]
    seats = part(desk, HEAD_BYTES, SEAT, (head.performers,))
    own = part(tools, 0, TOOLS, (1,))[0]
    buffers = (
        part(tools, own.scratch, np.uint8, (own.scratch_bytes,)),
        part(tools, own.store, np.uint8, (own.store_bytes,)),
        part(tools, own.events, np.uint8, (own.events_bytes,)),
    )
    while head.performer < head.performers:
        stop = _process(head, seats[head.performer], buffers, params, (positions, times))
        if stop != DONE:
            head.stopped = stop
            return stop  # type: ignore[no-any-return]
        head.performer += 1
        head.frame = 0
    head.performer = 0
    return SAID if part(buffers[2], 0, EVENT, (1,))[0].row > 0 else DONE


@inline_kernel
def _process(head: Any, seat: Any, buffers: Any, params: Any, frames: Any) -> Any:
    """Process the frames of one performer, from where the head stands; return DONE or why it stopped."""
    positions, times = frames
    station = at_address(seat.station, STATION, (1,))[0]
    channels = at_address(seat.station + STATION_BYTES, CHANNEL, (1 + station.limbs,))
    count = len(times) if head.count == 0 else head.count
    is_alone = station.limbs + station.readers + station.phase == 0
    while head.frame < count:
        here = seat.begin + head.frame
        stage = head.stage
        if stage <= station.limbs:
            channel = channels[stage]
            if stage == 0:
                if _is_any_full(channels):
                    return WINDOW_FULL
                most = count - head.frame if is_alone else ONE
                ready = positions[here : here + most], times[here : here + most]
                code = _step(channel, buffers, params[:1], ready[0], ready[1])
            else:
                code = _step_limb((seat, station, channels), stage, buffers, params, times[here : here + 1])
            stop = code % STOPS
            if is_alone:
                head.frame += code // STOPS
            if stop == ANALYSIS_DUE:
                if _analyse(head, station, channel, buffers[1], times[seat.begin + head.frame]):
                    return ANALYSED
            elif stop != DONE and (stage == 0 or stop != TAKE_ENDS):  # limbs' takes end with the body's
                return stop
            elif stage > 0:
                head.stage += 1
            elif not is_alone:
                head.stage = 1
                if at_address(channel.row, ROW, (1,))[0].clock.open == 0:  # a take begins with somebody
                    head.stage += station.limbs + station.readers
                elif channel.is_taken == 0:
                    head.stage += station.limbs
                elif station.limbs > 0:
                    _gather(seat, station, channels, positions[here])
        elif stage <= station.limbs + station.readers:
            head.stage += 1
            readers = at_address(
                seat.station + STATION_BYTES + CHANNEL_BYTES * len(channels), READER, (station.readers,)
            )
            if _has_news(readers[stage - len(channels)], positions[here], times[here]):
                return READ
        else:
            head.stage = 0
            head.frame += 1
            if station.phase == 1:
                return PHASE
    return DONE


@inline_kernel
def _is_any_full(channels: Any) -> Any:
    """Tell whether body or limbs have no room for one more undecided key frame."""
    for i in range(len(channels)):
        row = at_address(channels[i].row, ROW, (1,))[0]
        if row.window.undecided > row.plan.room:
            return True
    return False


@kernel
def _step(channel: Any, buffers: Any, params: Any, positions: Any, times: Any) -> Any:
    """Process frames of the body or of a limb, with all that follows, until something happened.

    Returns:
        STOPS times the number of frames processed, plus the stop code; DONE if nothing need be done.
    """
    scratch, _, event_buffer = buffers
    row = at_address(channel.row, np.uint8, (channel.row_bytes,))
    state = part(row, 0, ROW, (1,))[0]
    clock = state.clock
    events = part(event_buffer, 0, EVENT, (len(event_buffer) // EVENT_BYTES,))
    if events[0].row + state.plan.most_events + 1 >= len(events):
        return np.int64(BUFFER_FULL)
    was_open, before = clock.open, clock.taken_time
    code = advance_by_name(row, params, positions, times)
    channel.is_taken = int(clock.open == 1 and (was_open == 0 or clock.taken_time != before))
    if was_open == 0 and clock.open == 1 and channel.first < 0:
        put_start(clock, events)  # type: ignore[no-untyped-call]
    if code % STOPS == HAPPENED:
        update_window_by_name(row, params, scratch, event_buffer, AFTER_A_FRAME)
        code += DONE - HAPPENED
    return code


@kernel
def _gather(seat: Any, station: Any, channels: Any, positions: Any) -> None:
    """Set the joints of all limbs, and their clocks, after the body processed a frame."""
    order = at_address(seat.station + station.order, np.int64, (station.joints,))
    frame = at_address(seat.station + station.frame, np.float32, (station.joints, 3))
    body = at_address(channels[0].row, ROW, (1,))[0]
    for k in range(len(order)):
        if order[k] >= 0:
            for axis in range(3):
                frame[k, axis] = positions[order[k], axis]
        else:
            put_middle(at_address(channels[0].row, np.uint8, (channels[0].row_bytes,)), frame[k])
    for i in range(1, len(channels)):
        limb = at_address(channels[i].row, ROW, (1,))[0]
        clock = limb.clock
        if clock.open == 1:  # frames that the body passed over are no pause
            clock.time = max(clock.time, body.clock.time - 0.5 * limb.plan.max_pause)
        else:
            clock.take = body.clock.take
        clock.next_frame = body.clock.used_frame


@inline_kernel
def _step_limb(where: Any, stage: Any, buffers: Any, params: Any, time: Any) -> Any:
    """Process the frame of a limb, which knows what is counted of its body by then."""
    seat, station, channels = where
    channel = channels[stage]
    limb = at_address(channel.row, ROW, (1,))[0]
    body = at_address(channels[0].row, ROW, (1,))[0]
    if limb.plan.adopts == 1 and body.plan.repetitions == 1:
        own = at_address(channel.row + limb.at.adopted, PERIODS, (1,))[0]
        counted = at_address(channels[0].row + body.at.periods, PERIODS, (1,))[0]
        if own.analysed != counted.analysed or own.origin != counted.origin:
            copy_periods(own, counted)  # type: ignore[no-untyped-call]
    frame = at_address(
        seat.station + station.frame + POINT_BYTES * channel.first, np.float32, (ONE, channel.joints, 3)
    )
    return _step(channel, buffers, params[stage : stage + 1], frame, time)


@kernel
def _analyse(head: Any, station: Any, channel: Any, store: Any, time: Any) -> Any:
    """Analyse what is repeated before a frame, and tell whether somebody asks for what that brought."""
    state = at_address(channel.row, ROW, (1,))[0]
    counted = at_address(channel.row + state.at.counted, np.uint8, (state.at.adopted - state.at.counted,))
    changed = call_reader(station.analyse, (counted, store, part(store, 0, np.float32, (NOTHING, 3)), time))
    head.changed = changed
    return channel.heed == ALL_ANALYSES or (channel.heed == CHANGES and changed == 1)


@inline_kernel
def _has_news(reader: Any, position: Any, time: Any) -> Any:
    """Show a frame to a reader if it is due, and tell whether it has events."""
    due = at_address(reader.state, np.float64, (1,))[0]
    if due - BACK <= time < due:
        return False
    state = at_address(reader.state, np.uint8, (reader.state_bytes,))
    store = at_address(reader.store, np.uint8, (reader.store_bytes,))
    return call_reader(reader.call, (state, store, position, time)) == 1
