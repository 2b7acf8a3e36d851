"""Row: the memory of one performer.

The state of a body or a limb is one row of bytes: the records of all concepts (each declared beside
the functions that write it), then arrays whose sizes follow from the joints and the settings. A snapshot is a copy of
the row. The record `at` has the places of the arrays, in bytes from the row's start. A row that needs more room moves
into a larger one.
"""

cdef enum:
    CACHE_LINE = 64  # bytes


cdef struct Places:  # of a row's arrays, bytes from its start
    int64_t body  # positions and displacements of the joints, see joint_pages.pxi
    int64_t seen  # (padded_joints,) s, when each joint was last there; -inf if never
    int64_t tracked  # (padded_joints,) frames that bear out where each joint is, see joints.pxi
    int64_t filtered  # (6, padded_joints) m and m/s, One-Euro filter
    int64_t pose  # (4, padded_joints) last frame's features as one array, see joint_pages.flatten
    int64_t ring_time  # (ring,) s, ends of the displacements in the velocity window
    int64_t ring_step  # (ring,) 2^-40 m, those displacements summed over the joints
    int64_t average  # (smoothing_window,) 2^-40 m, velocities under the moving average
    int64_t summaries  # (slots, slot) summaries of segments, see summary.pxi
    int64_t unused  # (slots,) stack of unused slots
    int64_t order  # (W + 2,) slots of the window's segments, from left to right
    int64_t keys  # (W + 2,) undecided key frames, from left to right
    int64_t counts  # (W + 3, W + 2) messages sent about each segment of the window
    int64_t memo  # (memo,) merge costs computed before
    int64_t marks  # (history_size,) of the poses kept to take speeds from and to move key frames
    int64_t poses  # (history_size, 3, padded_joints) 1/8192 m, those poses
    int64_t bouts  # (bouts,) of movement, the latest that have ended
    int64_t notes  # (notes,) of the last candidates
    int64_t counted  # (1,) of repetitions, if they are counted here
    int64_t periods  # (1,) of it, by which candidates are judged
    int64_t samples  # of them, see repetitions/state.pxi
    int64_t adopted  # (1,) of a limb: the periods of its body, by which its candidates are judged
    int64_t end  # of the row


cdef struct Row:
    Plan plan
    Clock clock
    Counters counters
    JointsState joints
    Noise noise
    Velocity velocity
    Average average
    Range range
    Curve curve
    OpenSegmentState open_segment
    Slots slots
    History history
    Tempo tempo
    Scales scales
    Dwells dwells
    Ways ways
    Labels labels
    Candidate candidate
    ActivityState activity
    WindowState window
    Places at


cdef void lay_out_row(Row* row) noexcept nogil:
    """Set the sizes that follow from others, and the places of the arrays, without reading the rest of the row."""
    cdef Plan* plan = &row.plan
    cdef Places* at = &row.at
    cdef int64_t joints, places
    derive_sizes(plan)
    joints, places = plan.padded_joints, plan.capacity + 2
    at.body = in_lines(sizeof(Row))
    at.seen = at.body + in_lines(4 * body_numbers(plan.joints))
    at.tracked = at.seen + in_lines(8 * joints)
    at.filtered = at.tracked + in_lines(4 * joints)
    at.pose = at.filtered + in_lines(8 * 6 * plan.filtered_joints)
    at.ring_time = at.pose + in_lines(4 * 4 * joints)
    at.ring_step = at.ring_time + in_lines(8 * plan.ring)
    at.average = at.ring_step + in_lines(8 * plan.ring)
    at.summaries = at.average + in_lines(8 * plan.average_size)
    at.unused = at.summaries + in_lines(8 * plan.slot_count * plan.slot)
    at.order = at.unused + in_lines(8 * plan.slot_count)
    at.keys = at.order + in_lines(8 * places)
    at.counts = at.keys + in_lines(places * sizeof(Key))
    at.memo = at.counts + (0 if plan.offline == 1 else in_lines(4 * (places + 1) * places))
    at.marks = at.memo + in_lines(plan.memo_size * sizeof(Memo))
    at.poses = at.marks + in_lines(plan.history_size * sizeof(Mark))
    at.bouts = at.poses + in_lines(2 * plan.history_size * 3 * joints)
    at.notes = at.bouts + in_lines(plan.bouts * sizeof(Bout))
    at.counted = at.notes + in_lines(plan.notes * sizeof(Note))
    at.periods = at.counted + plan.repetitions * in_lines(sizeof(Counting))
    at.samples = at.periods + plan.repetitions * in_lines(sizeof(Periods))
    at.adopted = at.samples + in_lines(plan.samples)
    at.end = at.adopted + plan.adopts * in_lines(sizeof(Periods))


cdef inline bint is_row_full(Row* row) noexcept nogil:
    """Return whether there is no room for one more undecided key frame, and the row must grow before the next frame."""
    cdef Plan* plan = &row.plan
    if plan.offline == 1:
        return row.window.undecided >= plan.capacity
    return row.window.undecided > plan.room and plan.room < plan.capacity


cdef void enlarge(Plan* plan, bint is_ring) noexcept nogil:
    """Plan a larger row: twice the places in the velocity ring, or room for more undecided key frames.

    There is room for at most W of them in a stream; W of a recording is doubled.
    """
    if is_ring:
        plan.ring *= 2
    elif plan.offline == 1:
        plan.capacity *= 2
        plan.room = plan.capacity
    else:
        plan.room = min(plan.room + MORE_ROOM, plan.capacity)


cdef void move_row(Row* old, Row* fresh) noexcept nogil:
    """Copy everything into a larger row, whose plan and places are set."""
    cdef int64_t* before = <int64_t*>&old.at
    cdef int64_t* after = <int64_t*>&fresh.at
    cdef int64_t i
    memcpy(&fresh.clock, &old.clock, <uint8_t*>&old.at - <uint8_t*>&old.clock)
    for i in range(<int64_t>(sizeof(Places) // sizeof(int64_t)) - 1):
        # The place of a remembered cost depends on the number of places.
        if &before[i] != &old.at.memo or old.plan.memo_size == fresh.plan.memo_size:
            memcpy(<uint8_t*>fresh + after[i], <uint8_t*>old + before[i], before[i + 1] - before[i])
    if fresh.plan.ring != old.plan.ring:
        unroll_velocity(
            &fresh.velocity,
            doubles(<double*>(<uint8_t*>old + old.at.ring_time), old.plan.ring),
            ints(<int64_t*>(<uint8_t*>old + old.at.ring_step), old.plan.ring),
            <double*>(<uint8_t*>fresh + fresh.at.ring_time),
            <int64_t*>(<uint8_t*>fresh + fresh.at.ring_step),
        )
    for i in range(old.plan.slot_count, fresh.plan.slot_count):
        free_slot(&fresh.slots, ints(<int64_t*>(<uint8_t*>fresh + fresh.at.unused), fresh.plan.slot_count), i)


cdef inline Floats body_of(Row* row) noexcept nogil:
    """Return the body; see joint_pages.pxi."""
    return floats(<float*>(<uint8_t*>row + row.at.body), (row.at.seen - row.at.body) // 4)


cdef inline PoseHistory history_of(Row* row) noexcept nogil:
    """Return the poses of the last seconds."""
    cdef PoseHistory history
    history.state = &row.history
    history.marks.at, history.marks.count = <Mark*>(<uint8_t*>row + row.at.marks), row.plan.history_size
    history.poses.at = <int16_t*>(<uint8_t*>row + row.at.poses)
    history.poses.planes, history.poses.rows, history.poses.columns = row.plan.history_size, 3, row.plan.padded_joints
    history.body = body_of(row)
    return history


cdef inline Activity activity_of(Row* row) noexcept nogil:
    """Return whether the performer moves."""
    cdef Activity activity
    activity.state = &row.activity
    activity.bouts.at, activity.bouts.count = <Bout*>(<uint8_t*>row + row.at.bouts), row.plan.bouts
    return activity


cdef inline OpenSegment open_segment_of(Row* row, Measure* params) noexcept nogil:
    """Return the open segment."""
    cdef uint8_t* begin = <uint8_t*>row
    cdef OpenSegment segment
    segment.plan = &row.plan
    segment.state = &row.open_segment
    segment.slots = &row.slots
    segment.params = params
    segment.unused = ints(<int64_t*>(begin + row.at.unused), row.plan.slot_count)
    segment.summaries = doubles_in_rows(<double*>(begin + row.at.summaries), row.plan.slot_count, row.plan.slot)
    segment.body = body_of(row)
    segment.pose = floats_in_rows(<float*>(begin + row.at.pose), 4, row.plan.padded_joints)
    return segment


cdef inline Counting* counting_of(Row* row) noexcept nogil:
    """Return the counter of repetitions, if the plan has one; periods and samples follow it."""
    return <Counting*>(<uint8_t*>row + row.at.counted)


cdef inline Periods* periods_of(Row* row) noexcept nogil:
    """Return the periods of the counted repetitions, if the plan has them."""
    return <Periods*>(<uint8_t*>row + row.at.periods)


cdef inline Periods* adopted_of(Row* limb) noexcept nogil:
    """Return the periods of a limb's body, if the plan uses them."""
    return <Periods*>(<uint8_t*>limb + limb.at.adopted)
