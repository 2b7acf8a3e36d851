"""Run: the one loop. Frames of one performer or of many, for body, limbs and readers, in one compiled call.

    for each performer, for each frame:
        body      the frame step; after a frame in which something happened, the window step
        limbs     the same for each, if the body processed the frame
        readers   each when it is due
        phase     of the repeated movement, if it is reported

It stops where its owner (performer.pxi) must do something with Python objects, and goes on from there: `Seat` has the place.
"""

cdef enum:
    BODY_FULL = 10  # reasons to stop, beside those of `advance`: rows need room for more key frames,
    EVENTS_FULL = 11  # the event buffer is full,
    ANALYSED = 12  # counts are to be collected,
    READ = 13  # a reader has events,
    PHASE = 14  # the phase is to be reported
    NO_ANALYSIS = 0  # in Part.heed
    CHANGES = 1
    ALL_ANALYSES = 2

cdef double BACK = 0.5  # s; a reader does not see a frame this much before it is due, or less

# Whether a frame causes events, 0 or 1, of: state and store of a reader, (J, 3) positions in m, the number of joints, and the
# time in s.
ctypedef int64_t (*See)(
    uint8_t* state, uint8_t* store, float* positions, int64_t joints, double time
) noexcept nogil


cdef struct Part:  # the body, or a limb
    Row* row
    Measure* measure
    int64_t first  # of its joints among those of all limbs; -1 of the body
    int64_t heed  # which analyses of its repetitions are to stop the loop
    int64_t is_taken  # whether the frame step processed the last frame


cdef struct Follower:  # a reader
    See see
    uint8_t* state  # the first eight bytes are a double, `due`: see reader.pxi
    uint8_t* store
    Periods* periods  # where it keeps what is counted of the body's repetitions; NULL if it does not ask


cdef struct Seat:  # one performer
    Part* parts  # the body's, then those of limbs
    int64_t limbs
    Follower* followers
    int64_t readers
    int64_t phase  # whether the phase of each frame is reported
    int64_t joints  # of all limbs together
    int64_t* order  # (joints,) which joint of the performer each is, negative for the middle
    float* positions  # (joints, 3) m, where each is in the frame that the body processed last
    int64_t frame  # number of processed frames,
    int64_t stage  # and the next stage of the frame: 0 the body, then limbs, readers, the phase
    int64_t changed  # whether the last analysis of repetitions changed the counts


cdef struct Frames:  # of one performer
    float* positions  # (n, J, 3) m
    double* times  # (n,) s
    int64_t count
    int64_t joints


cdef struct Room:  # shared by performers, which take turns
    Bytes scratch
    Bytes store  # in which repetitions are analysed
    EventSpan events
    int64_t used  # of the event buffer


cdef int64_t run_frames(Seat* seat, Room* room, Frames* frames) noexcept nogil:
    """Process the frames of one performer, from where the seat stands.

    Returns:
        DONE; else the task of the owner before the loop goes on, at the stage of the seat: TAKE_ENDS, RING_FULL, BODY_FULL,
        EVENTS_FULL; ANALYSED, READ, PHASE: report the counts, the events of a reader, or the phase.
    """
    cdef int64_t used, stop
    cdef float* positions
    cdef double time
    if seat.limbs + seat.readers + seat.phase == 0:
        return _run_body(seat, room, frames)
    while seat.frame < frames.count:
        positions = frames.positions + seat.frame * 3 * frames.joints
        time = frames.times[seat.frame]
        while seat.stage <= seat.limbs:
            if seat.stage == 0:
                if _is_any_full(seat):
                    return BODY_FULL
                stop = _step(&seat.parts[0], room, positions, &time, 1, &used)
            else:
                stop = _step_limb(seat, room, &time)
            if stop == ANALYSIS_DUE:
                if _analyse(seat, &seat.parts[seat.stage], room, time):
                    return ANALYSED
                continue
            if stop != DONE and (seat.stage == 0 or stop != TAKE_ENDS):  # limbs' takes end with the body's
                return stop
            if seat.stage > 0:
                seat.stage += 1
                continue
            seat.stage = 1
            if seat.parts[0].row.clock.open == 0:  # a take begins with the first visible joint
                seat.stage += seat.limbs + seat.readers
            elif seat.parts[0].is_taken == 0:
                seat.stage += seat.limbs
            elif seat.limbs > 0:
                _gather_limbs(seat, positions)
        while seat.stage <= seat.limbs + seat.readers:
            seat.stage += 1
            tell_periods(&seat.followers[seat.stage - seat.limbs - 2], seat.parts[0].row)
            if _has_news(&seat.followers[seat.stage - seat.limbs - 2], positions, frames.joints, time):
                return READ
        seat.stage = 0
        seat.frame += 1
        if seat.phase == 1:
            return PHASE
    return DONE


cdef int64_t _run_body(Seat* seat, Room* room, Frames* frames) noexcept nogil:
    """Process the frames of a performer without limbs and readers, all in one go."""
    cdef int64_t used, stop
    while seat.frame < frames.count:
        if _is_any_full(seat):
            return BODY_FULL
        stop = _step(
            &seat.parts[0], room, frames.positions + seat.frame * 3 * frames.joints, frames.times + seat.frame,
            frames.count - seat.frame, &used,
        )
        seat.frame += used
        if stop == ANALYSIS_DUE:
            if _analyse(seat, &seat.parts[0], room, frames.times[seat.frame]):
                return ANALYSED
        elif stop != DONE:
            return stop
    return DONE


cdef bint _is_any_full(Seat* seat) noexcept nogil:
    """Return whether body or limbs have no room for one more undecided key frame."""
    cdef int64_t i
    for i in range(1 + seat.limbs):
        if is_row_full(seat.parts[i].row):
            return True
    return False


cdef int64_t _step(
    Part* part, Room* room, float* positions, double* times, int64_t count, int64_t* used
) noexcept nogil:
    """Process frames of the body or of a limb, with all that follows, until something happened.

    Args:
        part: The body, or the limb.
        room: To work in.
        positions: (count, J, 3) m.
        times: (count,) s.
        count: Their number.
        used: Set to the number of processed frames.

    Returns:
        The task of the caller; DONE if there is none.
    """
    cdef Row* row = part.row
    cdef Clock* clock = &row.clock
    cdef int64_t stop, was_open
    cdef double before
    used[0] = 0
    if room.used + row.plan.most_events + 1 > room.events.count:
        return EVENTS_FULL
    was_open, before = clock.open, clock.taken_time
    stop = advance(row, part.measure, positions, times, count, used)
    part.is_taken = clock.open == 1 and (was_open == 0 or clock.taken_time != before)
    if was_open == 0 and clock.open == 1 and part.first < 0:
        put_start(clock, room.events)
    if stop == HAPPENED:
        step_window(row, part.measure, room.scratch, room.events, FOLLOW)
        stop = DONE
    return stop


cdef void _gather_limbs(Seat* seat, float* positions) noexcept nogil:
    """Set the joints of all limbs, and their clocks, after the body processed a frame."""
    cdef Row* body = seat.parts[0].row
    cdef Row* limb
    cdef int64_t i, k, axis
    for k in range(seat.joints):
        if seat.order[k] >= 0:
            for axis in range(3):
                seat.positions[3 * k + axis] = positions[3 * seat.order[k] + axis]
        else:
            put_middle(body, seat.positions + 3 * k)
    for i in range(1, 1 + seat.limbs):
        limb = seat.parts[i].row
        if limb.clock.open == 1:  # frames that the body skipped are no pause
            limb.clock.time = max(limb.clock.time, body.clock.time - 0.5 * limb.plan.max_pause)
        else:
            limb.clock.take = body.clock.take
        limb.clock.next_frame = body.clock.used_frame


cdef int64_t _step_limb(Seat* seat, Room* room, double* time) noexcept nogil:
    """Process the frame of the next limb, after copying the periods of its body."""
    cdef Part* limb = &seat.parts[seat.stage]
    cdef int64_t used
    adopt_periods(limb.row, seat.parts[0].row)
    return _step(limb, room, seat.positions + 3 * limb.first, time, 1, &used)


cdef inline void adopt_periods(Row* limb, Row* body) noexcept nogil:
    """Copy the periods of the body to a limb, if the limb uses them and they are new."""
    if limb.plan.adopts == 1 and body.plan.repetitions == 1:
        renew_periods(adopted_of(limb), periods_of(body))


cdef inline void tell_periods(Follower* reader, Row* body) noexcept nogil:
    """Copy the periods of the body to a reader that asks for them, if they are new."""
    if reader.periods != NULL and body.plan.repetitions == 1:
        renew_periods(reader.periods, periods_of(body))


cdef bint _analyse(Seat* seat, Part* part, Room* room, double time) noexcept nogil:
    """Analyse the repetitions before a frame, and return whether the counts are to be reported."""
    seat.changed = analyse_repetitions(<uint8_t*>counting_of(part.row), room.store.at, time)
    return part.heed == ALL_ANALYSES or (part.heed == CHANGES and seat.changed == 1)


cdef bint _has_news(Follower* reader, float* positions, int64_t joints, double time) noexcept nogil:
    """Show a frame to a reader if it is due, and return whether it has events."""
    cdef double due = (<double*>reader.state)[0]
    if due - BACK <= time < due:
        return False
    return reader.see(reader.state, reader.store, positions, joints, time) == 1
