"""Face: what Python calls, and what it knows of records and constants. The only file here that works on Python objects."""

from mossar_stream.core.records import record_types


def run(cnp.ndarray desk, cnp.ndarray tools, cnp.ndarray measures, cnp.ndarray positions, cnp.ndarray times, /):
    """Process frames until they are used up or the caller must do something; see `run_loop`.

    Args:
        desk: Bytes: LoopHead, then a Seat for each performer.
        tools: Bytes: Tools, then scratch, what analyses of repetitions need, events.
        measures: (1 + L,) MEASURE, of body and limbs.
        positions: (n, J, 3) float32 m.
        times: (n,) float64 s.

    Returns:
        DONE, SAID, or what must be done.
    """
    cdef LoopHead* head = <LoopHead*>cnp.PyArray_DATA(desk)
    cdef Room room = _room_of(<uint8_t*>cnp.PyArray_DATA(tools), <Measure*>cnp.PyArray_DATA(measures))
    cdef Frames frames
    cdef int64_t stop
    frames.positions = <float*>cnp.PyArray_DATA(positions)
    frames.times = <double*>cnp.PyArray_DATA(times)
    frames.count = cnp.PyArray_DIM(times, 0)
    frames.joints = cnp.PyArray_DIM(positions, 1)
    with nogil:
        stop = run_loop(head, <Seat*>(head + 1), &room, &frames)
    return stop


cdef enum:
    NOT_PLAIN = -1  # a frame that must be looked at before it is processed


def run_one(
    cnp.ndarray desk, cnp.ndarray tools, cnp.ndarray measures, object positions, object time, cnp.ndarray buffer, /
):
    """Process one frame of one performer, if it is plain: an array of (J, 3) float32 or float64, contiguous, and a float.

    The lock of the interpreter is kept: releasing it takes as long as a frame.

    Args:
        desk: As for `run`.
        tools: Likewise.
        measures: Likewise.
        positions: Whatever was given, m.
        time: Whatever was given, s.
        buffer: (1, J, 3) float32, for positions in double precision.

    Returns:
        NOT_PLAIN, with nothing processed, or what `run` returns.
    """
    cdef LoopHead* head = <LoopHead*>cnp.PyArray_DATA(desk)
    cdef Room room = _room_of(<uint8_t*>cnp.PyArray_DATA(tools), <Measure*>cnp.PyArray_DATA(measures))
    cdef int64_t joints = cnp.PyArray_DIM(buffer, 1)
    cdef cnp.ndarray given
    cdef Frames frames
    cdef double moment
    cdef int64_t i
    if not (cnp.PyArray_CheckExact(positions) and isinstance(time, float)):
        return NOT_PLAIN
    given = positions
    if (
        cnp.PyArray_NDIM(given) != 2
        or cnp.PyArray_DIM(given, 0) != joints
        or cnp.PyArray_DIM(given, 1) != 3
        or not cnp.PyArray_ISCARRAY_RO(given)
    ):
        return NOT_PLAIN
    if cnp.PyArray_TYPE(given) == cnp.NPY_FLOAT32:
        frames.positions = <float*>cnp.PyArray_DATA(given)
    elif cnp.PyArray_TYPE(given) == cnp.NPY_FLOAT64:
        frames.positions = <float*>cnp.PyArray_DATA(buffer)
        for i in range(3 * joints):
            frames.positions[i] = <float>(<double*>cnp.PyArray_DATA(given))[i]
    else:
        return NOT_PLAIN
    moment = time
    frames.times, frames.count, frames.joints = &moment, 1, joints
    return run_loop(head, <Seat*>(head + 1), &room, &frames)


def update_window(cnp.ndarray row, cnp.ndarray measure, cnp.ndarray tools, int64_t reason, /):
    """Carry out what follows from the last frame; see `step_window`.

    Args:
        row: Bytes of the performer.
        measure: (1,) MEASURE.
        tools: As for `run`.
        reason: LEVEL, END, RANK or DECIDE.
    """
    cdef Room room = _room_of(<uint8_t*>cnp.PyArray_DATA(tools), <Measure*>cnp.PyArray_DATA(measure))
    cdef Row* performer = <Row*>cnp.PyArray_DATA(row)
    with nogil:
        step_window(performer, room.measures, room.scratch, room.events, reason)


def set_middle(cnp.ndarray row, cnp.ndarray middle, /):
    """Set the middle of the joints of the frame that a body processed last; see `put_middle`.

    Args:
        row: Bytes of the performer.
        middle: (3,) float32 m, set.
    """
    put_middle(<Row*>cnp.PyArray_DATA(row), <float*>cnp.PyArray_DATA(middle))


def analyse(cnp.ndarray counting, cnp.ndarray store, double time, /):
    """Analyse what is repeated, as often as is due before a time, s, or once if it is inf; return whether that changed anything.

    Args:
        counting: Bytes of what is counted.
        store: Bytes in which an analysis works, `analysis_bytes` of them.
        time: s.
    """
    return bool(
        analyse_repetitions(
            <uint8_t*>cnp.PyArray_DATA(counting), cnp.PyArray_DIM(counting, 0),
            <uint8_t*>cnp.PyArray_DATA(store), cnp.PyArray_DIM(store, 0), NULL, 0, time,
        )
    )


def pad(int64_t joints, /):
    """Return the number of padded joints for a number of joints."""
    return (joints + PADDING - 1) // PADDING * PADDING


def samples_bytes(int64_t joints, /):
    """Return the bytes of a performer's samples of repetitions, with what is kept beside them."""
    return samples_size(joints)


def analysis_bytes(int64_t joints, /):
    """Return the bytes in which an analysis of repetitions works, for any performer of so many joints."""
    return store_size(joints)


def address_of_follow_feet():
    """Return where the compiled reader of steps lies."""
    return <size_t>&follow_feet


cdef Room _room_of(uint8_t* tools, Measure* measures) noexcept nogil:
    cdef Tools* own = <Tools*>tools
    cdef Room room
    room.measures = measures
    room.scratch = bytes_(tools + own.scratch, own.scratch_bytes)
    room.store = bytes_(tools + own.store, own.store_bytes)
    room.events.at = <Event*>(tools + own.events)
    room.events.count = own.events_bytes // <int64_t>sizeof(Event)
    return room


# The numpy type of each record; the members come from the declarations.
RECORDS = record_types(MOSSAR_RECORDS.decode(), {
    "Plan": sizeof(Plan),
    "Row": sizeof(Row),
    "Clock": sizeof(Clock),
    "Key": sizeof(Key),
    "Mark": sizeof(Mark),
    "Memo": sizeof(Memo),
    "Bout": sizeof(Bout),
    "Note": sizeof(Note),
    "Event": sizeof(Event),
    "Station": sizeof(Station),
    "Channel": sizeof(Channel),
    "Reader": sizeof(Reader),
    "LoopHead": sizeof(LoopHead),
    "Seat": sizeof(Seat),
    "Counters": sizeof(Counters),
    "Measure": sizeof(Measure),
    "Counting": sizeof(Counting),
    "Periods": sizeof(Periods),
    "Labels": sizeof(Labels),
    "Steps": sizeof(Steps),
    "Tools": sizeof(Tools),
})

# Constants that Python needs, too; `kernels` offers them by name.
CONSTANTS = {
    "ALL_ANALYSES": ALL_ANALYSES,
    "ANALYSED": ANALYSED,
    "ANALYSIS_INTERVAL": ANALYSIS_INTERVAL,
    "BOUTS": BOUTS,
    "CACHE_LINE": CACHE_LINE,
    "CHAINS": CHAINS,
    "CHANGES": CHANGES,
    "CYCLES": CYCLES,
    "DECIDE": DECIDE,
    "DONE": DONE,
    "EARLIER": EARLIER,
    "EARLIER_IN_NOISE": EARLIER_IN_NOISE,
    "END": END,
    "FARTHEST": FARTHEST,
    "LABELLED_LATE": LABELLED_LATE,
    "LEAST_WAY": LEAST_WAY,
    "LEAST_WAY_OF_ANKLES": LEAST_WAY_OF_ANKLES,
    "LEVEL": LEVEL,
    "LINES": LINES,
    "LIVE": LIVE,
    "LONGEST_SILENCE": LONGEST_SILENCE,
    "MARGIN": MARGIN,
    "NOTED_CANDIDATES": NOTED_CANDIDATES,
    "NOTED_LATE": NOTED_LATE,
    "NOT_KEPT": NOT_KEPT,
    "NO_ANALYSIS": NO_ANALYSIS,
    "NOT_PLAIN": NOT_PLAIN,
    "NO_JOINT": NO_JOINT,
    "NO_NEWS": NO_NEWS,
    "PADDING": PADDING,
    "PAGE": PAGE,
    "PAGE_SIZE": PAGE_SIZE,
    "PHASE": PHASE,
    "POSE_X": POSE_X,
    "RANK": RANK,
    "READ": READ,
    "RING_FULL": RING_FULL,
    "SAID": SAID,
    "SPACING": SPACING,
    "SPARE_SUMMARIES": SPARE_SUMMARIES,
    "SPEED_WINDOW": SPEED_WINDOW,
    "STAMP_ROUNDING": STAMP_ROUNDING,
    "STRIKE": STRIKE,
    "TAKE_ENDS": TAKE_ENDS,
    "TIME_ROUNDING": TIME_ROUNDING,
    "WINDOW_FULL": WINDOW_FULL,
}
