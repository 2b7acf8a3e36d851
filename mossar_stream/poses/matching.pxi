"""Matching: which pose a performer holds.

At most every `EVERY` seconds the directions of bones, relative to the performer's facing, are averaged and compared with
all poses. A pose is entered when the performer is nearly at rest near it, and nearer to it than to the others. It is left
when the body has strayed farther, by a margin, for `PATIENCE`, or when another pose is entered.
"""

cdef double EVERY = 0.06  # s between two samples
cdef double POSE_SMOOTHED = 0.1  # s, time constant of the directions that are compared
cdef double POSE_SETTLED = 0.4  # s, of those by which rest is judged
cdef enum:
    FIRST = 5  # samples after a gap before rest is judged
cdef double PATIENCE = 0.3  # s, so long a pose is kept while the body strays farther
# Squares of chords between directions; 2 sin(angle / 2) is the chord of an angle.
cdef double NEAR_POSE = 0.068  # 15 degrees over all bones, 25 of each limb: a pose is entered
cdef double NEAR_OF_LIMB = 0.187
cdef double FAR = 0.12  # 20 and 35: it is left
cdef double FAR_OF_LIMB = 0.362
cdef double RESTING = 0.0248  # 9 degrees between the two averages of a limb's directions: it turns by 30 degrees a second
cdef double NEARER = 0.02  # by so much another pose must be nearer than the one that is held
cdef enum:
    NOTHING = 0
    ENTERED = 1
    HELD = 2
    LEFT = 3


# ENTRY: called from Python
cdef int64_t match_frame(Bytes memory, Bytes store, FloatRows positions, double time) noexcept nogil:
    """Process a frame; a function as readers have it.

    Args:
        memory: Of the performer; see `layout.py`.
        store: The bank.
        positions: (J, 3) float32 metres; NaN where a joint is missing.
        time: s.

    Returns:
        1 if a pose was entered, held or left, which stands in `happened`; else 0.
    """
    cdef PoseBank bank
    cdef PoseMemory known
    cdef HoldingState* state
    cdef bint continues
    cdef double seconds
    # CHECK call of open_bank: open_bank(store)
    # CHECK call of open_memory: open_memory(memory, bank.head[0])
    bank = open_bank(store)
    known = open_memory(memory, &bank.head.at[0])
    state = &known.state.at[0]
    state.happened = NOTHING
    if not is_new(state.frames, time, state.time, LEAST_SPACING) or state.due - EVERY < time < state.due:
        return 0
    continues = follows(state.frames, time, state.time)
    if not continues and state.active >= 0:
        _matching_leave(&known)
    if not continues:
        state.frames = 0
        state.near = -1
    seconds = time - state.time
    if not _matching_measure(&known, &bank, positions, seconds):
        return 1 if state.happened else 0
    state.time = time
    state.due = time + EVERY - EARLY
    state.frames += 1
    if state.happened == NOTHING:
        _decide(&known, &bank, time)
    return 1 if state.happened else 0


cdef bint _matching_measure(PoseMemory* known, PoseBank* bank, FloatRows positions, double seconds) noexcept nogil:
    """Average the directions of bones; return whether all joints that are needed are known."""
    cdef HoldingState* state
    cdef bint started, whole
    cdef float x, z
    # CHECK place_pose is called with several kinds of arguments
    # CHECK Slice: :
    # CHECK facing_of is called with several kinds of arguments
    state = &known.state.at[0]
    started = state.frames > 0
    whole = place_pose(known.pose, bank, positions)
    if not whole and not started:
        return False
    if not started:
        state.facing[:] = 0.0
    if bank.head.at[0].girdles[0] >= 0:
        x, z = facing_of(known.pose, bank.head.at[0].girdles)
        smooth_facing(state.facing, x, z, seconds)
    _matching_average(known, bank, seconds, started)
    return True


cdef inline void _matching_average(PoseMemory* known, PoseBank* bank, double seconds, bint started) noexcept nogil:
    """Let both averages of the directions follow."""
    cdef double quick, slow, cosine, sine, x, y, z, length, way
    cdef int64_t b, begin, end, d
    # CHECK heading is called with several kinds of arguments
    # CHECK turned_back is called with several kinds of arguments
    # CHECK loop over enumerate((x, y, z))
    # CHECK call of enumerate: enumerate((x, y, z))
    cosine, sine = heading(known.state.at[0].facing[0], known.state.at[0].facing[1])
    quick = 1.0 - exp(-seconds / POSE_SMOOTHED) if started else 1.0
    slow = 1.0 - exp(-seconds / POSE_SETTLED) if started else 1.0
    for b in range(bank.bones.count):
        begin, end = bank.bones.at[b].begin, bank.bones.at[b].end
        x = <double>(known.pose.at[end * known.pose.columns + 0] - known.pose.at[begin * known.pose.columns + 0])
        y = <double>(known.pose.at[end * known.pose.columns + 1] - known.pose.at[begin * known.pose.columns + 1])
        z = <double>(known.pose.at[end * known.pose.columns + 2] - known.pose.at[begin * known.pose.columns + 2])
        length = max(sqrt(x * x + y * y + z * z), 1e-6)
        x, z = turned_back(x, z, cosine, sine)
        for (d, way) in enumerate((x, y, z)):
            known.fast.at[b * known.fast.columns + d] += quick * (way / length - known.fast.at[b * known.fast.columns + d])
            known.slow.at[b * known.slow.columns + d] += slow * (way / length - known.slow.at[b * known.slow.columns + d])


cdef void _decide(PoseMemory* known, PoseBank* bank, double time) noexcept nogil:
    """See whether a pose is entered, held or left."""
    cdef HoldingState* state
    cdef int64_t nearest, best
    cdef bint other
    cdef double least, mean, worst
    state = &known.state.at[0]
    nearest, least = _matching_nearest(known, bank)
    if nearest != state.near and (nearest < 0 or state.near < 0 or not _same(bank, nearest, state.near)):
        state.since = time
    state.near = nearest
    if state.active < 0:
        if nearest >= 0 and state.frames >= FIRST and _largest_turn(known, bank) < RESTING:
            _enter(known, bank, nearest, time)
        return
    mean, worst, best = _best_of_active(known, bank)
    other = nearest >= 0 and not _same(bank, nearest, state.active)
    if other and least < mean - NEARER and _largest_turn(known, bank) < RESTING:
        _matching_leave(known)
    elif mean < FAR and worst < FAR_OF_LIMB:
        _stay(known, bank, best, time)
    elif time - state.seen > PATIENCE + EARLY:
        _matching_leave(known)


cdef inline bint _same(PoseBank* bank, int64_t one, int64_t other) noexcept nogil:
    """Tell whether two poses have one name."""
    return bank.shown.at[one].name == bank.shown.at[other].name


cdef (int64_t, double) _matching_nearest(PoseMemory* known, PoseBank* bank) noexcept nogil:
    """Return the nearest of the poses that are near, -1 for none, and its mean square of the chord."""
    cdef int64_t p, found
    cdef double least, mean, worst
    found, least = -1, INFINITY
    for p in range(bank.shown.count):
        mean, worst = _matching_compare(known, bank, p)
        if mean < NEAR_POSE and worst < NEAR_OF_LIMB and mean < least:
            found, least = p, mean
    return found, least


cdef (double, double, int64_t) _best_of_active(PoseMemory* known, PoseBank* bank) noexcept nogil:
    """Return the mean square of the chord to the pose that is held, the largest of a limb, and of which example."""
    cdef int64_t p, best
    cdef double least, worst, mean, largest
    least, worst, best = INFINITY, INFINITY, known.state.at[0].active
    for p in range(bank.shown.count):
        if _same(bank, p, known.state.at[0].active):
            mean, largest = _matching_compare(known, bank, p)
            if mean < least:
                least, worst, best = mean, largest, p
    return least, worst, best


cdef (double, double) _matching_compare(PoseMemory* known, PoseBank* bank, int64_t pose) noexcept nogil:
    """Compare the directions with a pose; return the mean square of the chord, and the largest of a limb."""
    cdef Doubles chords, row
    cdef int64_t b
    cdef double total, length, x, y, z
    chords = known.chords
    for b in range(chords.count):
        x, y, z = known.fast.at[b * known.fast.columns + 0], known.fast.at[b * known.fast.columns + 1], known.fast.at[b * known.fast.columns + 2]
        length = max(sqrt(x * x + y * y + z * z), 1e-6)
        row = row_of_doubles(plane_of_doubles(bank.rows, pose), b)
        chords.at[b] = max(0.0, 2.0 - 2.0 * (x * row.at[0] + y * row.at[1] + z * row.at[2]) / length)
        if row.at[0] == row.at[1] == row.at[2] == 0.0:  # two joints of the pose are in one place
            chords.at[b] = 0.0
    total = 0.0
    for b in range(chords.count):
        total += chords.at[b]
    return (total / chords.count, _matching_largest(known, bank))


cdef double _largest_turn(PoseMemory* known, PoseBank* bank) noexcept nogil:
    """Return how far the directions of a limb have turned lately, at most: mean square of the chord."""
    cdef Doubles chords
    cdef int64_t b, d
    cdef double way
    chords = known.chords
    for b in range(chords.count):
        chords.at[b] = 0.0
        for d in range(3):
            way = known.fast.at[b * known.fast.columns + d] - known.slow.at[b * known.slow.columns + d]
            chords.at[b] += way * way
    return _matching_largest(known, bank)


cdef inline double _matching_largest(PoseMemory* known, PoseBank* bank) noexcept nogil:
    """Return the largest mean of `chords` over the bones of a limb."""
    cdef DoubleRows groups
    cdef int64_t b, g
    cdef double largest
    # CHECK slice groups[:, :]
    groups = known.groups
    SLICE("groups[:, :]") = 0.0
    for b in range(bank.bones.count):
        groups.at[bank.bones.at[b].limb] += known.chords.at[b]
        groups.at[1 * groups.columns + bank.bones.at[b].limb] += 1.0
    largest = 0.0
    for g in range(groups.columns):
        largest = max(largest, groups.at[g] / groups.at[1 * groups.columns + g])
    return largest


cdef void _enter(PoseMemory* known, PoseBank* bank, int64_t pose, double time) noexcept nogil:
    cdef HoldingState* state
    cdef int64_t b
    state = &known.state.at[0]
    state.is_held = 0
    state.start = state.since
    state.matched = 0
    state.number += 1
    state.rev = 1
    state.happened = ENTERED
    for b in range(known.strays.count):
        known.strays.at[b] = 0.0
    _count(known, bank, pose, time)


cdef void _stay(PoseMemory* known, PoseBank* bank, int64_t pose, double time) noexcept nogil:
    cdef HoldingState* state
    state = &known.state.at[0]
    _count(known, bank, pose, time)
    if not state.is_held and time - state.start >= bank.shown.at[pose].hold - EARLY:
        state.is_held = 1
        state.rev += 1
        state.happened = HELD


cdef void _count(PoseMemory* known, PoseBank* bank, int64_t pose, double time) noexcept nogil:
    """Add how far the body strays to what it strayed since the start."""
    cdef HoldingState* state
    cdef int64_t b
    _matching_compare(known, bank, pose)
    state = &known.state.at[0]
    state.active = state.latest = pose
    state.seen = time
    state.matched += 1
    for b in range(known.strays.count):
        known.strays.at[b] += known.chords.at[b]


cdef void _matching_leave(PoseMemory* known) noexcept nogil:
    cdef HoldingState* state
    state = &known.state.at[0]
    state.active = -1
    state.rev += 1
    state.happened = LEFT
