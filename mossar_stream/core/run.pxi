"""Run: the one loop. Frames of one performer or of many, for body and limbs and what reads the poses, in one compiled call.

    for each performer, for each frame:
        body      the frame step; after a frame in which something happened, the window step
        limbs     the same for each, if the body processed the frame
        readers   who else follows the frames, each when it is due
        phase     of the repeated movement, if it is asked for

It stops where Python must do something, and goes on from there: `HEAD` says where.
`advance` and `update_window` are linked: each is compiled once, and ends of takes call the latter on their own.
"""

cdef enum:
    AFTER_A_FRAME = 0
    ONE = 1
    NOTHING = 0
    POINT_BYTES = 12
    WINDOW_FULL = 10  # what the caller must do besides what `advance` asks for
    BUFFER_FULL = 11
    ANALYSED = 12
    READ = 13
    PHASE = 14
    SAID = 15


# ENTRY: called from Python
cdef int64_t run(Bytes desk, Bytes tools, EvidenceSpan params, FloatPlanes positions, Doubles times) noexcept nogil:
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
    cdef LoopHead* head
    cdef SeatSpan seats
    cdef Tools* own
    cdef (Bytes, Bytes, Bytes) buffers
    cdef int64_t stop
    # CHECK call of part: part(desk, 0, HEAD, (1,))
    # CHECK subscript part(desk, 0, HEAD, (1,))[0]
    # CHECK call of part: part(desk, HEAD_BYTES, SEAT, (head.performers,))
    # CHECK call of part: part(tools, 0, TOOLS, (1,))
    # CHECK subscript part(tools, 0, TOOLS, (1,))[0]
    # CHECK call of part: part(tools, own.scratch, np.uint8, (own.scratch_bytes,))
    # CHECK call of part: part(tools, own.store, np.uint8, (own.store_bytes,))
    # CHECK call of part: part(tools, own.events, np.uint8, (own.events_bytes,))
    # CHECK call of part: part(buffers[2], 0, EVENT, (1,))
    # CHECK subscript part(buffers[2], 0, EVENT, (1,))[0]
    head = part(desk, 0, HEAD, (1,))[0]
    seats = part(desk, HEAD_BYTES, SEAT, (head.performers))
    own = part(tools, 0, TOOLS, (1,))[0]
    buffers = (part(tools, own.scratch, np.uint8, (own.scratch_bytes)), part(tools, own.store, np.uint8, (own.store_bytes)), part(tools, own.events, np.uint8, (own.events_bytes)))
    while head.performer < head.performers:
        stop = _process(head, &seats.at[head.performer], buffers, params, (positions, times))
        if stop != DONE:
            head.stopped = stop
            return stop
        head.performer += 1
        head.frame = 0
    head.performer = 0
    return SAID if part(buffers[2], 0, EVENT, (1,))[0].row > 0 else DONE


cdef inline int64_t _process(LoopHead* head, Seat* seat, (Bytes, Bytes, Bytes) buffers, EvidenceSpan params, (FloatPlanes, Doubles) frames) noexcept nogil:
    """Process the frames of one performer, from where the head stands; return DONE or why it stopped."""
    cdef Station* station
    cdef ChannelSpan channels
    cdef int64_t count, here, stage, stop, most, code
    cdef bint is_alone
    cdef FloatPlanes positions
    cdef Doubles times
    cdef Channel* channel
    cdef (FloatPlanes, Doubles) ready
    cdef ReaderSpan readers
    # CHECK sign (C truncates): code % STOPS; code // STOPS
    # CHECK call of at_address: at_address(seat.station, STATION, (1,))
    # CHECK subscript at_address(seat.station, STATION, (1,))[0]
    # CHECK call of at_address: at_address(seat.station + STATION_BYTES, CHANNEL, (1 + station.limbs,))
    # CHECK slice positions[here:here + most]
    # CHECK call of at_address: at_address(channel.row, ROW, (1,))
    # CHECK subscript at_address(channel.row, ROW, (1,))[0]
    # CHECK call of at_address: at_address(seat.station + STATION_BYTES + CHANNEL_BYTES * len(channels), READER, (station.readers,))
    positions, times = frames
    station = at_address(seat.station, STATION, (1,))[0]
    channels = at_address(seat.station + STATION_BYTES, CHANNEL, (1 + station.limbs))
    count = times.count if head.count == 0 else head.count
    is_alone = station.limbs + station.readers + station.phase == 0
    while head.frame < count:
        here = seat.begin + head.frame
        stage = head.stage
        if stage <= station.limbs:
            channel = &channels.at[stage]
            if stage == 0:
                if _is_any_full(channels):
                    return WINDOW_FULL
                most = count - head.frame if is_alone else ONE
                ready = (SLICE("positions[here:here + most]"), part_of_doubles(times, here, here + most))
                code = _step(channel, buffers, part_of_evidence_span(params, 0, 1), ready[0], ready[1])
            else:
                code = _step_limb((seat, station, channels), stage, buffers, params, part_of_doubles(times, here, here + 1))
            stop = code % STOPS
            if is_alone:
                head.frame += code // STOPS
            if stop == ANALYSIS_DUE:
                if _analyse(head, station, channel, buffers[1], times.at[seat.begin + head.frame]):
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
                    _run_gather(seat, station, channels, plane_of_floats(positions, here))
        elif stage <= station.limbs + station.readers:
            head.stage += 1
            readers = at_address(seat.station + STATION_BYTES + CHANNEL_BYTES * channels.count, READER, (station.readers))
            if _has_news(&readers.at[stage - channels.count], plane_of_floats(positions, here), times.at[here]):
                return READ
        else:
            head.stage = 0
            head.frame += 1
            if station.phase == 1:
                return PHASE
    return DONE


cdef inline bint _is_any_full(ChannelSpan channels) noexcept nogil:
    """Tell whether body or limbs have no room for one more undecided key frame."""
    cdef int64_t i
    cdef Row* row
    # CHECK call of at_address: at_address(channels[i].row, ROW, (1,))
    # CHECK subscript at_address(channels[i].row, ROW, (1,))[0]
    for i in range(channels.count):
        row = at_address(channels[i].row, ROW, (1,))[0]
        if row.window.undecided > row.plan.room:
            return True
    return False


cdef int64_t _step(Channel* channel, (Bytes, Bytes, Bytes) buffers, EvidenceSpan params, FloatPlanes positions, Doubles times) noexcept nogil:
    """Process frames of the body or of a limb, with all that follows, until something happened.

    Returns:
        STOPS times the number of frames processed, plus the stop code; DONE if nothing need be done.
    """
    cdef Bytes row, scratch, _, event_buffer
    cdef Row* state
    cdef Clock* clock
    cdef EventSpan events
    cdef int64_t code, was_open
    cdef double before
    # CHECK sign (C truncates): len(event_buffer) // EVENT_BYTES; code % STOPS
    # CHECK call of at_address: at_address(channel.row, np.uint8, (channel.row_bytes,))
    # CHECK call of part: part(row, 0, ROW, (1,))
    # CHECK subscript part(row, 0, ROW, (1,))[0]
    # CHECK call of part: part(event_buffer, 0, EVENT, (len(event_buffer) // EVENT_BYTES,))
    # CHECK call of advance_by_name: advance_by_name(row, params, positions, times)
    # CHECK call of update_window_by_name: update_window_by_name(row, params, scratch, event_buffer, AFTER_A_FRAME)
    scratch, _, event_buffer = buffers
    row = at_address(channel.row, np.uint8, (channel.row_bytes))
    state = part(row, 0, ROW, (1,))[0]
    clock = &state.clock
    events = part(event_buffer, 0, EVENT, (event_buffer.count // EVENT_BYTES))
    if events.at[0].row + state.plan.most_events + 1 >= events.count:
        return BUFFER_FULL
    was_open, before = clock.open, clock.taken_time
    code = advance_by_name(row, params, positions, times)
    channel.is_taken = <int64_t>(clock.open == 1 and (was_open == 0 or clock.taken_time != before))
    if was_open == 0 and clock.open == 1 and channel.first < 0:
        put_start(clock, events)
    if code % STOPS == HAPPENED:
        update_window_by_name(row, params, scratch, event_buffer, AFTER_A_FRAME)
        code += DONE - HAPPENED
    return code


cdef void _run_gather(Seat* seat, Station* station, ChannelSpan channels, FloatRows positions) noexcept nogil:
    """Set the joints of all limbs, and their clocks, after the body processed a frame."""
    cdef Ints order
    cdef FloatRows frame
    cdef Row* body, limb
    cdef int64_t k, i, axis
    cdef Clock* clock
    # CHECK call of at_address: at_address(seat.station + station.order, np.int64, (station.joints,))
    # CHECK call of at_address: at_address(seat.station + station.frame, np.float32, (station.joints, 3))
    # CHECK call of at_address: at_address(channels[0].row, ROW, (1,))
    # CHECK subscript at_address(channels[0].row, ROW, (1,))[0]
    # CHECK call of at_address: at_address(channels[0].row, np.uint8, (channels[0].row_bytes,))
    # CHECK call of at_address: at_address(channels[i].row, ROW, (1,))
    # CHECK subscript at_address(channels[i].row, ROW, (1,))[0]
    order = at_address(seat.station + station.order, np.int64, (station.joints))
    frame = at_address(seat.station + station.frame, np.float32, (station.joints, 3))
    body = at_address(channels[0].row, ROW, (1,))[0]
    for k in range(order.count):
        if order.at[k] >= 0:
            for axis in range(3):
                frame.at[k * frame.columns + axis] = positions.at[order.at[k] * positions.columns + axis]
        else:
            put_middle(at_address(channels.at[0].row, np.uint8, (channels.at[0].row_bytes)), row_of_floats(frame, k))
    for i in range(1, channels.count):
        limb = at_address(channels[i].row, ROW, (1,))[0]
        clock = &limb.clock
        if clock.open == 1:  # frames that the body passed over are no pause
            clock.time = max(clock.time, body.clock.time - 0.5 * limb.plan.max_pause)
        else:
            clock.take = body.clock.take
        clock.next_frame = body.clock.used_frame


cdef inline int64_t _step_limb((Seat*, Station*, ChannelSpan) where, int64_t stage, (Bytes, Bytes, Bytes) buffers, EvidenceSpan params, Doubles time) noexcept nogil:
    """Process the frame of a limb, which knows what is counted of its body by then."""
    cdef Channel* channel
    cdef Row* limb, body
    cdef FloatPlanes frame
    cdef Seat* seat
    cdef Station* station
    cdef ChannelSpan channels
    cdef Periods* own, counted
    # CHECK call of at_address: at_address(channel.row, ROW, (1,))
    # CHECK subscript at_address(channel.row, ROW, (1,))[0]
    # CHECK call of at_address: at_address(channels[0].row, ROW, (1,))
    # CHECK subscript at_address(channels[0].row, ROW, (1,))[0]
    # CHECK call of at_address: at_address(channel.row + limb.at.adopted, PERIODS, (1,))
    # CHECK subscript at_address(channel.row + limb.at.adopted, PERIODS, (1,))[0]
    # CHECK call of at_address: at_address(channels[0].row + body.at.periods, PERIODS, (1,))
    # CHECK subscript at_address(channels[0].row + body.at.periods, PERIODS, (1,))[0]
    # CHECK copy_periods is called with several kinds of arguments
    # CHECK call of at_address: at_address(seat.station + station.frame + POINT_BYTES * channel.first, np.float32, (ONE, channel.joints, 3))
    seat, station, channels = where
    channel = &channels.at[stage]
    limb = at_address(channel.row, ROW, (1,))[0]
    body = at_address(channels[0].row, ROW, (1,))[0]
    if limb.plan.adopts == 1 and body.plan.repetitions == 1:
        own = at_address(channel.row + limb.at.adopted, PERIODS, (1,))[0]
        counted = at_address(channels[0].row + body.at.periods, PERIODS, (1,))[0]
        if own.analysed != counted.analysed or own.origin != counted.origin:
            copy_periods(own, counted)
    frame = at_address(seat.station + station.frame + POINT_BYTES * channel.first, np.float32, (ONE, channel.joints, 3))
    return _step(channel, buffers, part_of_evidence_span(params, stage, stage + 1), frame, time)


cdef bint _analyse(LoopHead* head, Station* station, Channel* channel, Bytes store, double time) noexcept nogil:
    """Analyse what is repeated before a frame, and tell whether somebody asks for what that brought."""
    cdef Row* state
    cdef Bytes counted
    cdef int64_t changed
    # CHECK call of at_address: at_address(channel.row, ROW, (1,))
    # CHECK subscript at_address(channel.row, ROW, (1,))[0]
    # CHECK call of at_address: at_address(channel.row + state.at.counted, np.uint8, (state.at.adopted - state.at.counted,))
    # CHECK call of part: part(store, 0, np.float32, (NOTHING, 3))
    # CHECK call of call_reader: call_reader(station.analyse, (counted, store, part(store, 0, np.float32, (NOTHING, 3)), time))
    state = at_address(channel.row, ROW, (1,))[0]
    counted = at_address(channel.row + state.at.counted, np.uint8, (state.at.adopted - state.at.counted))
    changed = call_reader(station.analyse, (counted, store, part(store, 0, np.float32, (NOTHING, 3)), time))
    head.changed = changed
    return channel.heed == ALL_ANALYSES or channel.heed == CHANGES and changed == 1


cdef inline bint _has_news(Reader* reader, FloatRows position, double time) noexcept nogil:
    """Show a frame to a reader if it is due, and tell whether it has events."""
    cdef double due
    cdef Bytes state, store
    # CHECK call of at_address: at_address(reader.state, np.float64, (1,))
    # CHECK subscript at_address(reader.state, np.float64, (1,))[0]
    # CHECK call of at_address: at_address(reader.state, np.uint8, (reader.state_bytes,))
    # CHECK call of at_address: at_address(reader.store, np.uint8, (reader.store_bytes,))
    # CHECK call of call_reader: call_reader(reader.call, (state, store, position, time))
    due = at_address(reader.state, np.float64, (1,))[0]
    if due - BACK <= time < due:
        return False
    state = at_address(reader.state, np.uint8, (reader.state_bytes))
    store = at_address(reader.store, np.uint8, (reader.store_bytes))
    return call_reader(reader.call, (state, store, position, time)) == 1
