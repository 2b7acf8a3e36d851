"""Location: a final key frame may move to the likeliest place near where Algorithm 2 found it.

Half of the error at motion level is location, not detection (`sig_threshold` finds the pause, not its middle).
`free` tries every kept pose within `refine` seconds, `candidates` the undecided key frames to the right that are
not kept. The new place lies strictly between the neighbouring key frames; undecided key frames that it passes
are merged for good.
"""

cdef enum:
    LOCATION_NONE = 0
    LOCATION_FREE = 1
    LOCATION_CANDIDATES = 2
cdef enum:
    UNMOVED = -1


cdef int64_t right_neighbour(Window* w) noexcept nogil:
    """Return the place in the window of the next kept key frame after the oldest, or their number."""
    cdef int64_t i
    for i in range(1, w.state.undecided):
        if w.keys.at[i].kept == 1:
            return i
    return w.state.undecided


cdef void _load_left(Window* w) noexcept nogil:
    """Set the scratch's LEFT to the segment that ends at the oldest key frame."""
    cdef int64_t d
    for d in range(w.plan.slot):
        w.scratch.summaries.at[LEFT_OF_KEY * w.scratch.summaries.columns + d] = (
            w.summaries.at[w.order.at[0] * w.summaries.columns + d]
        )


cdef int64_t best_candidate(Window* w, int64_t open_slot) noexcept nogil:
    """Return the place of the likelier key frame for the oldest to move to; 0 to stay."""
    cdef int64_t neighbour, i, place
    cdef Doubles left, right, both
    cdef double best, cost
    neighbour = right_neighbour(w)
    left = row_of_doubles(w.scratch.summaries, LEFT_OF_KEY)
    right = row_of_doubles(w.scratch.summaries, RIGHT_OF_KEY)
    both = row_of_doubles(w.scratch.summaries, BOTH)
    _load_left(w)
    best, place = -1.0, 0
    for i in range(neighbour):
        if w.keys.at[i].time - w.keys.at[0].time > w.plan.refine + TIME_ROUNDING:
            break
        if i > 0:
            merge_into(w.params, left, row_of_doubles(w.summaries, w.order.at[i]))
            close(w.params, left)
        span(w, i + 1, neighbour, open_slot, RIGHT_OF_KEY)
        cost = strength(w.params, left, right, both)
        if cost > best:
            best, place = cost, i
    return place


cdef inline int64_t best_pose(Window* w, int64_t open_slot, int64_t end_frame) noexcept nogil:
    """Return the likeliest pose for the oldest key frame, counted back from the newest kept pose; -1 to stay.

    Args:
        w: Window.
        open_slot: Slot of the open segment.
        end_frame: The new place lies before this frame.
    """
    cdef int64_t unmoved, neighbour, limit, direction, place, there
    cdef double most, cost
    unmoved = _newer_poses(w, w.keys.at[0].frame) - 1  # of those not older than the key frame, the oldest; or none
    neighbour = right_neighbour(w)
    limit = w.keys.at[neighbour].frame if neighbour < w.state.undecided else end_frame
    place, most = UNMOVED, -1.0
    for direction in range(1, -2, -2):  # to earlier poses, and to later ones: they are counted back from the newest
        there, cost = _search(w, open_slot, unmoved, direction, limit)
        if cost > most:
            place, most = there, cost
    return place


cdef int64_t _newer_poses(Window* w, int64_t frame) noexcept nogil:
    """Return the number of kept poses of this frame or a later one, by bisection: a recording keeps many."""
    cdef int64_t low, high, middle
    low, high = 0, w.history.state.filled
    while low < high:
        middle = (low + high) // 2
        if w.history.marks.at[place_back(&w.history, middle)].frame >= frame:
            low = middle + 1
        else:
            high = middle
    return low


cdef inline (int64_t, double) _search(
    Window* w, int64_t open_slot, int64_t unmoved, int64_t direction, int64_t limit
) noexcept nogil:
    """Move the border pose by pose away from `unmoved`; return the best place, -1 for unmoved, and its cost."""
    cdef int64_t border, place, passed
    cdef Doubles left, right, both
    cdef FloatRows pose
    cdef MarkSpan marks
    cdef double best, cost
    cdef Mark* mark
    span(w, 1, right_neighbour(w), open_slot, RIGHT_OF_KEY)
    _load_left(w)
    left = row_of_doubles(w.scratch.summaries, LEFT_OF_KEY)
    right = row_of_doubles(w.scratch.summaries, RIGHT_OF_KEY)
    both = row_of_doubles(w.scratch.summaries, BOTH)
    pose = w.scratch.pose
    marks = w.history.marks
    best, place = strength(w.params, left, right, both), UNMOVED
    border = unmoved
    while unmoved >= 0 and 0 <= border + direction < w.history.state.filled:
        passed = border + direction if direction > 0 else border
        border += direction
        mark = &marks.at[place_back(&w.history, border)]
        if abs(mark.time - w.keys.at[0].time) > w.plan.refine + TIME_ROUNDING:
            break
        if not w.state.left_frame < mark.frame < limit:
            break
        load_pose(&w.history, pose, passed)
        mark = &marks.at[place_back(&w.history, passed)]
        add_pose(w.params, right, pose, w.plan.joints, mark.time, mark.weight * direction)
        add_pose(w.params, left, pose, w.plan.joints, mark.time, -mark.weight * direction)
        close(w.params, left)
        close(w.params, right)
        cost = merge_cost(w.params, left, right, both)  # both segments together stay the same
        if cost > best:
            best, place = cost, border
    return place, best


cdef void move_poses(Window* w, int64_t source, int64_t target, int64_t begin_frame, int64_t end_frame) noexcept nogil:
    """Move the kept poses of frames begin … end - 1 from one slot to another."""
    cdef FloatRows pose
    cdef int64_t back
    cdef Mark* mark
    pose = w.scratch.pose
    for back in range(_newer_poses(w, end_frame), _newer_poses(w, begin_frame)):
        mark = &w.history.marks.at[place_back(&w.history, back)]
        load_pose(&w.history, pose, back)
        add_pose(w.params, row_of_doubles(w.summaries, source), pose, w.plan.joints, mark.time, -mark.weight)
        add_pose(w.params, row_of_doubles(w.summaries, target), pose, w.plan.joints, mark.time, mark.weight)
    close(w.params, row_of_doubles(w.summaries, source))
    close(w.params, row_of_doubles(w.summaries, target))
