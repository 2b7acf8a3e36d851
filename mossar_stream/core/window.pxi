"""Window: Algorithm 3 over the key frames that are still undecided.

    left end   key 0   key 1        key m-1        now
       │ segment │ segment │   …   │ segment │ open │
       └ the last final key frame

When a key frame is confirmed the hierarchy of the window is brought up to date. The newest one takes part once its
right segment is closed. The oldest is decided for good when more than W are undecided or it is older than
`remerge_seconds`: final if it stands at the level, merged if not. Where its strength lies near the level, or the one
before it was just decided, the window is ranked again first, the newest key frame and the open segment included.
W and the number of joints bound the cost, whatever the length of the stream.
"""

cdef enum:
    NOT_KEPT = -2  # in KEY.before
    BEFORE_WINDOW = -3  # identity of the begin of the segment before the window
    OWN = 0  # rows of the scratch's summaries, before the nodes
    PREVIOUS = 1
    BOTH = 2
    RIGHT_OF_KEY = 3
    LEFT_OF_KEY = 4
    NODES = 5
    SPARE_SUMMARIES = 8  # more than W

cdef struct WindowState:
    int64_t undecided  # key frames in the window
    int64_t ordinal  # of the next key frame; they are counted through a take
    int64_t ranked  # whether the strengths are those of the present window
    int64_t left_frame  # start of the window's first segment: the last final key frame
    int64_t left_id  # Algorithm 2's frame of it
    double left_time  # s
    int64_t left_ordinal
    int64_t has_before  # whether there is a segment before the window
    int64_t before  # slot of it
    double due_time  # s, when the oldest key frame must be decided; inf if there is none
    double pace  # divisor of the costs at the last ranking: tempo, and share of the joints that count


cdef struct Key:
    int64_t ordinal  # counts the key frames of the take
    int64_t frame  # Algorithm 2's frame
    double time  # s
    double velocity  # share of the range
    double strength  # NaN until first computed
    int64_t kind  # index into events.KEY_FRAME_KINDS
    int64_t kept  # whether it is kept at the current level
    int64_t before  # ordinal of the kept key frame before, where a segment between them was reported
    int64_t place  # in the order in which key frames are removed
    int64_t rev  # messages sent
    int64_t at_frame  # reported frame
    double at_time  # s
    int64_t reported  # whether it was reported as confirmed
    int64_t label  # on whether it ends a repetition, see repetition_labels.pxi
    int64_t rests  # whether a rest begins or ends there, see rests.pxi
    int64_t pause_frame  # middle of the dwell near it, see dwells.pxi; `NO_DWELL` if there is none
    double pause_time  # s


cdef struct KeySpan:
    Key* at
    int64_t count


cdef struct Scratch:  # Arrays to work in, shared by all performers of a plan; see remerging.pxi.
    DoubleRows summaries  # (W + SPARE_SUMMARIES, slot)
    FloatRows pose  # (4, padded_joints)
    Ints places  # (W + 4,)
    Ints bounds  # (W + 4,)
    Ints removed  # (W + 4,)
    Ints active  # (W + 4,)
    Ints labels  # (W + 4,)
    int64_t* links  # (5, W + 4), see Remerging
    Doubles costs  # (W + 4,)
    Doubles strengths  # (W + 4,)


# The undecided key frames of a performer and the segments between them, as the functions below need them.
cdef struct Window:
    Plan* plan  # PLAN
    Clock* clock  # CLOCK
    JointsState* joints  # JOINTS
    WindowState* state  # WINDOW
    Tempo* tempo  # TEMPO
    Scales* scales  # SCALES
    Dwells* dwells  # DWELLS
    Slots* slots  # SLOTS
    Measure* params  # of the similarity measure
    PoseHistory history
    RepetitionLabels labels
    Activity activity
    Noise* noise  # NOISE
    KeySpan keys  # (W + 2,) KEY, from left to right
    Ints order  # (W + 2,) slots of the segments, from left to right
    Ints unused  # (slots,) stack of unused slots
    DoubleRows summaries  # (slots, slot)
    Int32Rows counts  # (W + 3, W + 2) messages sent about each segment of the window
    MemoSpan memo  # (memo,) MEMO
    EventSpan events  # EVENT, the event buffer
    Scratch scratch


cdef void start_window(WindowState* state, int64_t frame, double time) noexcept nogil:
    """Begin without a key frame; the first segment starts at the first frame."""
    state.undecided = 0
    state.ordinal = 0
    state.ranked = 0
    state.left_frame = frame
    state.left_id = frame
    state.left_time = time
    state.left_ordinal = -1
    state.has_before = 0
    state.before = NO_SLOT
    state.due_time = INFINITY
    state.pace = 1.0


cdef void add_key(Window* w, int64_t slot, Point point, double time, int64_t rev, int64_t reported) noexcept nogil:
    """Add a confirmed key frame and the segment that it ends.

    Args:
        w: Window.
        slot: Slot of that segment; it belongs to the window from now on.
        point: Point of the key frame.
        time: s, of Algorithm 2's frame.
        rev: Messages about it, this one included.
        reported: Whether it is reported now; else only when it is decided, if it is final.
    """
    cdef Key* key
    cdef int64_t here, i
    cdef WindowState* state
    cdef Int32Rows counts
    state = w.state
    counts = w.counts
    close(w.params, row_of_doubles(w.summaries, slot))
    w.order.at[state.undecided] = slot
    key = &w.keys.at[state.undecided]
    key.ordinal = state.ordinal
    key.frame = point.id
    key.time = time
    key.at_frame = point.frame
    key.at_time = point.time
    key.reported = reported
    key.label = UNLABELLED
    key.rests = 0
    key.pause_frame = NO_DWELL
    key.pause_time = NAN
    key.velocity = point.velocity
    key.strength = NAN
    key.kind = point.kind
    key.kept = reported
    key.before = NOT_KEPT
    key.rev = rev + reported - 1
    here = state.ordinal % (w.plan.capacity + 2)
    for i in range(counts.columns):
        counts.at[i * counts.columns + here] = 0
        counts.at[here * counts.columns + i] = 0
        counts.at[counts.columns * counts.columns + here] = 0
    state.undecided += 1
    state.ordinal += 1
    if reported == 1:
        put_key_frame(w.clock, w.events, point, KEY_CONFIRMED, rev, UNDECIDED)


cdef void report_kept(Window* w, int64_t count) noexcept nogil:
    """Report the first key frames that are about to be final as confirmed, if they were not reported."""
    cdef int64_t any_reported, i
    cdef Key* key
    cdef Point point
    any_reported = 0
    for i in range(count):
        key = &w.keys.at[i]
        if key.reported == 1 or not is_kept(key, w.state.undecided, w.plan.alpha, w.plan.beta):
            continue
        key.reported = key.kept = any_reported = 1
        key.rev += 1
        point = point_of(key, key.at_frame, key.at_time, key.strength)
        put_key_frame(w.clock, w.events, point, KEY_CONFIRMED, key.rev, UNDECIDED)
    if any_reported == 1 and w.plan.offline == 0:
        _update_segments(w, SEGMENT_WITHDRAWN)
        _update_segments(w, SEGMENT_CLOSED)


cdef inline Point point_of(Key* key, int64_t frame, double time, double strength) noexcept nogil:
    """Return an undecided key frame for a message, with its present place and its strength."""
    return Point(key.kind, key.frame, frame, time, key.velocity, strength)


cdef void rank(Window* w, int64_t open_slot) noexcept nogil:
    """Compute the strengths of the undecided key frames; without an open slot the newest takes no part."""
    cdef int64_t count, places, i
    cdef WindowState* state
    cdef Scratch* scratch
    cdef Remerging run
    state = w.state
    scratch = &w.scratch
    count = state.undecided if open_slot != NO_SLOT else state.undecided - 1
    if count <= 0:
        return
    state.pace = pace(w.tempo) if w.plan.tempo == 1 else 1.0
    if w.plan.is_mean == 1:
        state.pace *= <double>w.joints.moving / w.plan.moving_joints
    scratch.bounds.at[0] = state.left_ordinal
    for i in range(count + 1):
        scratch.places.at[i] = w.order.at[i] if i < state.undecided else open_slot
        scratch.bounds.at[i + 1] = w.keys.at[i].ordinal if i < state.undecided else UNKNOWN_BOUNDARY
        scratch.labels.at[i] = w.keys.at[i].label if i < state.undecided else UNLABELLED
    if w.plan.rests == 1:
        label_rests(w, count)
    places = scratch.places.count
    run.params, run.segments, run.memo = w.params, w.summaries, w.memo
    run.places, run.bounds, run.labels = scratch.places, scratch.bounds, scratch.labels
    run.nodes = rows_of_doubles(scratch.summaries, NODES, scratch.summaries.rows)
    run.both = row_of_doubles(scratch.summaries, BOTH)
    run.before, run.after, run.node = scratch.links, scratch.links + places, scratch.links + 2 * places
    run.waiting, run.last_waiting = scratch.links + 3 * places, scratch.links + 4 * places
    run.costs, run.strengths, run.removed = scratch.costs, scratch.strengths, scratch.removed
    run.tree = scratch.active  # which is not needed before segments are described
    remerge(&run, count, state.pace)
    for i in range(count):
        w.keys.at[i].strength = scratch.strengths.at[i]
        w.keys.at[scratch.removed.at[i]].place = i


cdef void relabel(Window* w) noexcept nogil:
    """Apply the present level to every undecided key frame, and report the changes."""
    cdef Plan* plan
    cdef int64_t i, kept, status
    cdef Key* key
    cdef Point point
    plan = w.plan
    for i in range(w.state.undecided):
        key = &w.keys.at[i]
        kept = 1 if is_kept(key, w.state.undecided, plan.alpha, plan.beta) else 0
        if kept != key.kept and key.reported == 1:
            key.kept = kept
            key.rev += 1
            status = KEY_RESTORED if kept == 1 else KEY_MERGED
            point = point_of(key, key.at_frame, key.at_time, key.strength)
            put_key_frame(w.clock, w.events, point, status, key.rev, UNDECIDED)
    if plan.offline == 0:
        _update_segments(w, SEGMENT_WITHDRAWN)
        _update_segments(w, SEGMENT_CLOSED)


cdef inline void _update_segments(Window* w, int64_t status) noexcept nogil:
    """Withdraw the segments whose ends no longer follow each other, or close those that now do."""
    cdef int64_t left, i, was, now
    cdef Key* key
    left = w.state.left_ordinal
    for i in range(w.state.undecided):
        key = &w.keys.at[i]
        was = key.before
        now = left if key.kept == 1 else NOT_KEPT
        if was != now:
            if status == SEGMENT_WITHDRAWN:
                if was != NOT_KEPT:
                    put_segment(w, was, i, status)
            else:
                if now != NOT_KEPT:
                    put_segment(w, now, i, status)
                key.before = now
        if key.kept == 1:
            left = key.ordinal


cdef void span(Window* w, int64_t begin, int64_t end, int64_t open_slot, int64_t target) noexcept nogil:
    """Set a row of the scratch to the closed summary of the window's segments begin … end together.

    Args:
        w: Window.
        begin: Place of the first segment; segment i ends at key frame i.
        end: Place of the last one; the number of undecided key frames means the open segment.
        open_slot: Slot of the open segment.
        target: Row of the scratch's summaries.
    """
    _window_join(w, begin, end, open_slot, row_of_doubles(w.scratch.summaries, target))
    close(w.params, row_of_doubles(w.scratch.summaries, target))


cdef inline void _window_join(Window* w, int64_t begin, int64_t end, int64_t open_slot, Doubles own) noexcept nogil:
    """Do the same for any summary, but leave it open; a short one gets only the fields that all measures have."""
    cdef int64_t slot, d, i, undecided, size
    undecided, size = w.state.undecided, own.count
    slot = w.order.at[begin] if begin < undecided else open_slot
    for d in range(size):
        own.at[d] = w.summaries.at[slot * w.summaries.columns + d]
    for i in range(begin + 1, end + 1):
        slot = w.order.at[i] if i < undecided else open_slot
        if size == w.plan.slot:
            merge_into(w.params, own, row_of_doubles(w.summaries, slot))
        else:
            for d in range(size):
                own.at[d] += w.summaries.at[slot * w.summaries.columns + d]


cdef void put_segment(Window* w, int64_t start, int64_t end, int64_t status) noexcept nogil:
    """Put a message about the segment between two key frames of the window into the event buffer.

    Args:
        w: Window.
        start: Ordinal of the earlier key frame, or that of the left end.
        end: Place of the later one in the window.
        status: Index into SEGMENT_STATUSES.
    """
    cdef int64_t first, begin, before, size, places, line, column, left, right, earlier, d
    cdef bint from_left, has_previous
    cdef Event* event
    cdef WindowState* state
    cdef Plan* plan
    cdef DoubleRows summaries
    state = w.state
    plan = w.plan
    summaries = w.scratch.summaries
    first = state.ordinal - state.undecided
    from_left = start == state.left_ordinal
    begin = 0 if from_left else start - first + 1
    event = next_event(w.clock, w.events, SEGMENT)
    event.id = state.left_id if from_left else w.keys.at[begin - 1].frame
    event.frame = state.left_frame if from_left else w.keys.at[begin - 1].at_frame
    event.time = state.left_time if from_left else w.keys.at[begin - 1].at_time
    event.end_id = w.keys.at[end].frame
    event.until_frame = w.keys.at[end].at_frame
    event.until_time = w.keys.at[end].at_time
    left, right = BEFORE_WINDOW, w.keys.at[end].ordinal
    before = 0
    if not from_left:
        earlier = w.keys.at[begin - 1].before
        before = 0 if earlier in (NOT_KEPT, state.left_ordinal) else earlier - first + 1
        left = state.left_ordinal if before == 0 else earlier
    has_previous = not from_left or state.has_before == 1
    # With a remembered cost, the message needs only the heads of the summaries.
    size = PATH + plan.padded_joints if is_known(w.memo, left, start, right) else plan.slot
    _window_join(w, begin, end, NO_SLOT, part_of_doubles(row_of_doubles(summaries, OWN), 0, size))
    if not from_left:
        _window_join(w, before, begin - 1, NO_SLOT, part_of_doubles(row_of_doubles(summaries, PREVIOUS), 0, size))
    elif has_previous:
        for d in range(size):
            summaries.at[PREVIOUS * summaries.columns + d] = w.summaries.at[state.before * w.summaries.columns + d]
    window_describe(w, event, has_previous, status, (left, start, right))
    places = plan.capacity + 2
    line = places if from_left else start % places
    column = (first + end) % places
    event.rev = 1
    if plan.offline == 0:
        w.counts.at[line * w.counts.columns + column] += 1
        event.rev = w.counts.at[line * w.counts.columns + column]


cdef inline void note_span(Window* w, Event* event) noexcept nogil:
    """Fill in when the performer moved in a segment whose ends are known, and so its state."""
    cdef double path, late
    cdef int64_t j
    path = 0.0
    for j in range(w.plan.joints):
        path += w.scratch.summaries.at[OWN * w.scratch.summaries.columns + (PATH + j)]
    late = EARLIER if w.plan.has_features == 1 else 0.0
    event.active_start, event.active_end = active_span(&w.activity, event.time, event.until_time, path, late)
    event.nature = 0 if isnan(event.active_start) else 1


cdef inline void window_describe(
    Window* w, Event* event, bint has_previous, int64_t status, (int64_t, int64_t, int64_t) bounds
) noexcept nogil:
    """Fill in status, state, when it was active, active joints and similarity of the segment in the scratch.

    Args:
        w: Window; OWN and, if there is one, PREVIOUS in the scratch are the summaries, not closed.
        event: To be filled in.
        has_previous: Whether there is a segment before.
        status: Index into SEGMENT_STATUSES.
        bounds: Identities of the boundaries as in remerging.pxi: where the previous segment begins, the one between
            the two, and where the segment ends.
    """
    cdef Doubles own, both, previous
    cdef int64_t left, middle, right
    cdef Ints active
    left, middle, right = bounds
    active = w.scratch.active
    both = row_of_doubles(w.scratch.summaries, BOTH)
    own = row_of_doubles(w.scratch.summaries, OWN)
    event.status = status
    note_span(w, event)
    event.decided = 1 if status == SEGMENT_FINAL else 0
    event.strength = NAN
    if has_previous:
        previous = row_of_doubles(w.scratch.summaries, PREVIOUS)
        if right == UNKNOWN_BOUNDARY or not is_known(w.memo, left, middle, right):
            close(w.params, own)
            close(w.params, previous)
            remember(w.memo, left, middle, right, strength(w.params, previous, own, both))
        event.strength = similarity(w.params, recall(w.memo, left, middle, right), previous, own)
    find_active(part_of_doubles(own, PATH, PATH + w.plan.joints), w.plan.details, active)
    event.joint0, event.joint1, event.joint2 = active.at[0], active.at[1], active.at[2]
    event.joint3, event.joint4 = active.at[3], active.at[4]
