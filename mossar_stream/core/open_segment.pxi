"""Open segment: the frames since the last key frame, divided by the splitter.

Frames since the last key frame lie in three summaries: those up to the candidate (`settled`), those after it
(`since`), and those of a plateau that may yet become a candidate (`run`). The last frame waits outside, because
the next one shows whether it was a minimum. When a candidate is confirmed, `settled` is the segment before it and
`since` the beginning of the one after it; nothing is replayed.
"""

cdef enum:
    MOST_WAITING = 32  # frames, in single precision: their sums are good to a millionth
    NO_SLOT = -1

cdef struct OpenSegmentState:
    int64_t settled  # slot of the frames up to the candidate
    int64_t since  # slot of those after it
    int64_t run  # slot of those of the current run of equal values
    int64_t closed  # slot of the segment that a key frame ended, -1 if none
    int64_t fed  # slot that the sums in the body belong to
    int64_t waiting  # frames in them
    double last_time  # s, of the last frame, which is in no summary yet
    double last_weight  # s
    int64_t last_moving
    double last_speed  # m/s, rms of the joints, see scales.pxi


cdef struct OpenSegment:  # The open segment, as the functions below need it.
    Plan* plan  # PLAN
    OpenSegmentState* state  # OPEN_SEGMENT
    Slots* slots  # SLOTS
    Measure* params  # of the similarity measure
    Ints unused  # (slots,) stack of unused slots
    DoubleRows summaries  # (slots, slot)
    Floats body  # see joint_pages.pxi
    FloatRows pose  # (4, padded_joints), if the measure takes it


cdef void start_open_segment(OpenSegment* segment) noexcept nogil:
    """Begin with no frame, all slots being unused."""
    cdef OpenSegmentState* state
    cdef int64_t first, i
    cdef Floats sums
    state = segment.state
    for first from 0 <= first < segment.body.count by PAGE_SIZE:
        sums = part_of_floats(segment.body, first + SUM_X, first + SUM_PATH + PAGE)
        for i in range(sums.count):
            sums.at[i] = 0.0
    state.settled = take_slot(segment.slots, segment.unused, segment.summaries)
    state.since = take_slot(segment.slots, segment.unused, segment.summaries)
    state.run = take_slot(segment.slots, segment.unused, segment.summaries)
    state.closed = NO_SLOT
    state.fed = state.settled
    state.waiting = 0
    state.last_time = 0.0
    state.last_weight = 0.0
    state.last_moving = 0
    state.last_speed = 0.0


cdef inline void note_last_frame(
    OpenSegmentState* state, double time, double weight, int64_t moving, double speed
) noexcept nogil:
    """Note the last frame, which joins a summary when the next one has come."""
    state.last_time = time
    state.last_weight = weight
    state.last_moving = moving
    state.last_speed = speed


cdef inline void split(
    OpenSegment* segment, Curve* curve, Clock* clock, double value, double scale, bint seen
) noexcept nogil:
    """Process the next velocity, add the last frame to its summary, and close the segment that a key frame ends.

    Args:
        segment: OpenSegment; the features are still those of the last frame.
        curve: CURVE.
        clock: CLOCK.
        value: V[t].
        scale: Value of 1 on the scale of V.
        seen: Whether a crossing is a key frame.
    """
    cdef OpenSegmentState* state
    cdef int64_t run_length, happened
    cdef double theta
    cdef bint goes_on
    state = segment.state
    run_length = curve.run_length
    theta = segment.plan.theta * scale
    happened = follow_curve(curve, value, theta, scale, clock.used_frame, clock.time)
    if not seen:
        happened &= ~CROSSED
        curve.found.happened = happened
    goes_on = curve.run_length > run_length and happened & CROSSED == 0
    if happened & REPLACED:
        settle(segment)
    place_last_frame(segment, curve.candidate, run_length, goes_on)
    if happened == 0:
        return
    if happened & FORGOTTEN:
        settle(segment)
        forget_candidate(curve)
    if happened & (CROSSED | ACCEPTED):
        forget_candidate(curve)
        state.closed = state.settled
        state.settled = state.since
        state.since = take_slot(segment.slots, segment.unused, segment.summaries)


cdef inline void place_last_frame(
    OpenSegment* segment, int64_t candidate, int64_t run_length, bint goes_on
) noexcept nogil:
    """Add the last frame to its summary, and the run with it if the run is over.

    Args:
        segment: OpenSegment.
        candidate: Frame of the candidate, negative if there is none.
        run_length: Of the run that the last frame belongs to.
        goes_on: Whether the run goes on.
    """
    cdef int64_t target, slot
    cdef OpenSegmentState* state
    cdef DoubleRows summaries
    state = segment.state
    summaries = segment.summaries
    target = state.since if candidate >= 0 else state.settled
    slot = state.run if goes_on or run_length > 1 else target
    if slot != state.fed or state.waiting >= MOST_WAITING:
        add_waiting_frames(segment)
        state.fed = slot
    add_last_frame(segment, slot)
    state.waiting += 1
    if slot != target and not goes_on:
        add_waiting_frames(segment)
        merge_into(segment.params, row_of_doubles(summaries, target), row_of_doubles(summaries, slot))
        empty(row_of_doubles(summaries, slot))


cdef inline void add_last_frame(OpenSegment* segment, int64_t slot) noexcept nogil:
    """Add the last frame to a summary, or to the sums in the body that wait for it."""
    cdef SummaryFrame frame
    cdef OpenSegmentState* state
    state = segment.state
    frame.body, frame.pose, frame.joints = segment.body, segment.pose, segment.plan.joints
    frame.time, frame.weight = state.last_time, state.last_weight
    frame.moving, frame.speed = state.last_moving, state.last_speed
    add_frame(segment.params, row_of_doubles(segment.summaries, slot), &frame)


cdef inline void add_waiting_frames(OpenSegment* segment) noexcept nogil:
    """Add the waiting sums to their summary; call it before any other use of that summary."""
    cdef OpenSegmentState* state
    state = segment.state
    if state.waiting > 0:
        flush_sums(segment.params, row_of_doubles(segment.summaries, state.fed), segment.body, segment.plan.padded_joints)
        state.waiting = 0


cdef void settle(OpenSegment* segment) noexcept nogil:
    """Add the frames since the candidate to those before it."""
    cdef OpenSegmentState* state
    cdef DoubleRows summaries
    add_waiting_frames(segment)
    state = segment.state
    summaries = segment.summaries
    merge_into(segment.params, row_of_doubles(summaries, state.settled), row_of_doubles(summaries, state.since))
    empty(row_of_doubles(summaries, state.since))
