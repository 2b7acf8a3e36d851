"""Run: the one loop. Frames of one performer or of many, for body and limbs and what reads the poses, in one compiled call.

    for each performer, for each frame:
        body      the frame step; after a frame in which something happened, the window step
        limbs     the same for each, if the body processed the frame
        readers   who else follows the frames, each when it is due
        phase     of the repeated movement, if it is asked for

It stops where Python must do something, and goes on from there: `LoopHead` says where.
"""

cdef enum:
    WINDOW_FULL = 10  # what the caller must do besides what `advance` asks for
    BUFFER_FULL = 11
    ANALYSED = 12
    READ = 13
    PHASE = 14
    SAID = 15

cdef double BACK = 0.5  # s; a frame that is due later by no more than this is not shown to a reader


cdef struct Frames:  # of all performers, one after the other
    float* positions  # (n, J, 3) m
    double* times  # (n,) s
    int64_t count
    int64_t joints


cdef struct Room:  # what performers share, because they are worked on one after the other
    Measure* measures  # (1 + L,) of body and limbs
    Bytes scratch
    Bytes store  # in which repetitions are analysed
    EventSpan events


cdef int64_t run_loop(LoopHead* head, Seat* seats, Room* room, Frames* frames) noexcept nogil:
    """Process frames until they are used up or the caller must do something.

    Args:
        head: How far they are processed.
        seats: Whose frames they are.
        room: To work in.
        frames: Of all performers.

    Returns:
        DONE, or SAID if that left events; else what must be done before the loop goes on, of the performer and the stage at
        which `head` stands: TAKE_ENDS, RING_FULL, BUFFER_FULL; WINDOW_FULL: before a frame, rows need room for more key frames;
        ANALYSED, READ, PHASE: ask what is counted, a reader, or the phase for its events.
    """
    cdef int64_t stop
    while head.performer < head.performers:
        stop = _process(head, &seats[head.performer], room, frames)
        if stop != DONE:
            head.stopped = stop
            return stop
        head.performer += 1
        head.frame = 0
    head.performer = 0
    return SAID if room.events.at[0].row > 0 else DONE


cdef int64_t _process(LoopHead* head, Seat* seat, Room* room, Frames* frames) noexcept nogil:
    """Process the frames of one performer, from where the head stands; return DONE or why it stopped."""
    cdef Station* station = <Station*>seat.station
    cdef Channel* channels = <Channel*>(station + 1)
    cdef Reader* readers = <Reader*>(channels + 1 + station.limbs)
    cdef int64_t count = frames.count if head.count == 0 else head.count
    cdef int64_t used, stop
    cdef float* positions
    cdef double time
    if station.limbs + station.readers + station.phase == 0:
        return _process_body(head, seat, &channels[0], station, room, frames, count)
    while head.frame < count:
        positions = frames.positions + (seat.begin + head.frame) * 3 * frames.joints
        time = frames.times[seat.begin + head.frame]
        while head.stage <= station.limbs:
            if head.stage == 0:
                if _is_any_full(channels, station.limbs):
                    return WINDOW_FULL
                stop = _step(&channels[0], room, room.measures, positions, &time, 1, &used)
            else:
                stop = _step_limb(station, seat, channels, head.stage, room, &time)
            if stop == ANALYSIS_DUE:
                if _analyse(head, station, &channels[head.stage], room.store, time):
                    return ANALYSED
                continue
            if stop != DONE and (head.stage == 0 or stop != TAKE_ENDS):  # limbs' takes end with the body's
                return stop
            if head.stage > 0:
                head.stage += 1
                continue
            head.stage = 1
            if (<Row*>channels[0].row).clock.open == 0:  # a take begins with somebody
                head.stage += station.limbs + station.readers
            elif channels[0].is_taken == 0:
                head.stage += station.limbs
            elif station.limbs > 0:
                _gather_limbs(station, seat, channels, positions)
        while head.stage <= station.limbs + station.readers:
            head.stage += 1
            if _has_news(&readers[head.stage - station.limbs - 2], positions, frames.joints, time):
                return READ
        head.stage = 0
        head.frame += 1
        if station.phase == 1:
            return PHASE
    return DONE


cdef int64_t _process_body(
    LoopHead* head, Seat* seat, Channel* body, Station* station, Room* room, Frames* frames, int64_t count
) noexcept nogil:
    """Do the same for a performer of whom nothing but the body is asked for: as many frames at once as there are."""
    cdef int64_t here, used, stop
    while head.frame < count:
        if _is_any_full(body, 0):
            return WINDOW_FULL
        here = seat.begin + head.frame
        stop = _step(
            body, room, room.measures, frames.positions + here * 3 * frames.joints, frames.times + here, count - head.frame, &used
        )
        head.frame += used
        if stop == ANALYSIS_DUE:
            if _analyse(head, station, body, room.store, frames.times[seat.begin + head.frame]):
                return ANALYSED
        elif stop != DONE:
            return stop
    return DONE


cdef bint _is_any_full(Channel* channels, int64_t limbs) noexcept nogil:
    """Tell whether body or limbs have no room for one more undecided key frame."""
    cdef int64_t i
    cdef Row* row
    for i in range(1 + limbs):
        row = <Row*>channels[i].row
        if row.window.undecided > row.plan.room:
            return True
    return False


cdef int64_t _step(
    Channel* channel, Room* room, Measure* measure, float* positions, double* times, int64_t count, int64_t* used
) noexcept nogil:
    """Process frames of the body or of a limb, with all that follows, until something happened.

    Args:
        channel: Of the body, or of the limb.
        room: To work in.
        measure: Its similarity.
        positions: (count, J, 3) m.
        times: (count,) s.
        count: How many there are.
        used: Set to how many were processed.

    Returns:
        What the caller must do; DONE if nothing need be done.
    """
    cdef Row* row = <Row*>channel.row
    cdef Clock* clock = &row.clock
    cdef int64_t stop, was_open
    cdef double before
    used[0] = 0
    if room.events.at[0].row + row.plan.most_events + 1 >= room.events.count:
        return BUFFER_FULL
    was_open, before = clock.open, clock.taken_time
    stop = advance(row, measure, positions, times, count, used)
    channel.is_taken = clock.open == 1 and (was_open == 0 or clock.taken_time != before)
    if was_open == 0 and clock.open == 1 and channel.first < 0:
        put_start(clock, room.events)
    if stop == HAPPENED:
        step_window(row, measure, room.scratch, room.events, FOLLOW)
        stop = DONE
    return stop


cdef void _gather_limbs(Station* station, Seat* seat, Channel* channels, float* positions) noexcept nogil:
    """Set the joints of all limbs, and their clocks, after the body processed a frame."""
    cdef int64_t* order = <int64_t*>(seat.station + station.order)
    cdef float* frame = <float*>(seat.station + station.frame)
    cdef Row* body = <Row*>channels[0].row
    cdef Row* limb
    cdef int64_t i, k, axis
    for k in range(station.joints):
        if order[k] >= 0:
            for axis in range(3):
                frame[3 * k + axis] = positions[3 * order[k] + axis]
        else:
            put_middle(body, frame + 3 * k)
    for i in range(1, 1 + station.limbs):
        limb = <Row*>channels[i].row
        if limb.clock.open == 1:  # frames that the body passed over are no pause
            limb.clock.time = max(limb.clock.time, body.clock.time - 0.5 * limb.plan.max_pause)
        else:
            limb.clock.take = body.clock.take
        limb.clock.next_frame = body.clock.used_frame


cdef int64_t _step_limb(
    Station* station, Seat* seat, Channel* channels, int64_t i, Room* room, double* time
) noexcept nogil:
    """Process the frame of limb i, which knows what is counted of its body by then."""
    cdef Row* limb = <Row*>channels[i].row
    cdef Row* body = <Row*>channels[0].row
    cdef Periods* own
    cdef Periods* counted
    cdef int64_t used
    if limb.plan.adopts == 1 and body.plan.repetitions == 1:
        own = <Periods*>(channels[i].row + limb.at.adopted)
        counted = <Periods*>(channels[0].row + body.at.periods)
        if own.analysed != counted.analysed or own.origin != counted.origin:
            copy_periods(own, counted)
    return _step(
        &channels[i], room, &room.measures[i], <float*>(seat.station + station.frame) + 3 * channels[i].first, time, 1, &used
    )


cdef bint _analyse(LoopHead* head, Station* station, Channel* channel, Bytes store, double time) noexcept nogil:
    """Analyse what is repeated before a frame, and tell whether somebody asks for what that brought."""
    cdef Row* row = <Row*>channel.row
    cdef uint8_t* counted = <uint8_t*>(channel.row + row.at.counted)
    head.changed = analyse_repetitions(counted, row.at.adopted - row.at.counted, store.at, store.count, NULL, 0, time)
    return channel.heed == ALL_ANALYSES or (channel.heed == CHANGES and head.changed == 1)


cdef bint _has_news(Reader* reader, float* positions, int64_t joints, double time) noexcept nogil:
    """Show a frame to a reader if it is due, and tell whether it has events."""
    cdef double due = (<double*>reader.state)[0]
    if due - BACK <= time < due:
        return False
    return (<See>reader.call)(
        <uint8_t*>reader.state, reader.state_bytes, <uint8_t*>reader.store, reader.store_bytes, positions, joints, time
    ) == 1
