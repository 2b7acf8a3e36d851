"""Matching: the pose that a performer holds.

At most every `EVERY` seconds the directions of bones, relative to the performer's facing, are averaged and
compared with all poses. A pose is entered when the performer is nearly at rest near it, and nearer to it than
to the others. It is left when the body has strayed farther, by a margin, for `PATIENCE`, or when another pose
is entered.
"""

cdef double EVERY = 0.06  # s between two samples
cdef double POSE_SMOOTHED = 0.1  # s, time constant of the directions that are compared
cdef double POSE_SETTLED = 0.4  # s, of those by which rest is judged
cdef double PATIENCE = 0.3  # s for which a pose is kept while the body strays farther
# Squares of chords between directions; 2 sin(angle / 2) is the chord of an angle.
cdef double NEAR_POSE = 0.068  # 15 degrees over all bones, 25 of each limb: a pose is entered
cdef double NEAR_OF_LIMB = 0.187
cdef double FAR = 0.12  # 20 and 35: it is left
cdef double FAR_OF_LIMB = 0.362
# 9 degrees between the two averages of a limb's directions: it turns by 30 degrees a second.
cdef double RESTING = 0.0248
cdef double NEARER = 0.02  # margin by which another pose must be nearer than the held one
cdef double SHORTEST_DIRECTION = 1e-6  # m, of a bone; 1, of the average of its directions
cdef enum:
    FIRST_JUDGED = 5  # samples after a gap before rest is judged
cdef enum:  # results of a sample
    POSE_UNCHANGED = 0
    POSE_ENTERED = 1
    POSE_HELD = 2
    POSE_LEFT = 3


cdef int64_t match_frame(
    uint8_t* memory, uint8_t* store, float* positions, int64_t joints, double time
) noexcept nogil:
    """Process a frame; a function of a reader.

    Args:
        memory: Of the performer.
        store: The bank.
        positions: (joints, 3) m; NaN where a joint is missing.
        joints: Number of joints.
        time: s.

    Returns:
        1 if a pose was entered, held or left, as `happened` tells; else 0.
    """
    cdef PoseBank bank
    cdef PoseMemory known
    cdef HoldingState* state
    cdef bint continues
    bank = open_pose_bank(store)
    known = open_pose_memory(memory, bank.head)
    state = known.state
    state.happened = POSE_UNCHANGED
    if not is_new(state.frames, time, state.time, LEAST_SPACING) or state.due - EVERY < time < state.due:
        return 0
    continues = follows(state.frames, time, state.time)
    if not continues and state.active >= 0:
        _leave_pose(state)
    if not continues:
        state.frames = 0
        state.near = -1
    if _measure_pose(&known, &bank, floats_in_rows(positions, joints, 3), time - state.time):
        state.time = time
        state.due = time + EVERY - EARLY
        state.frames += 1
        if state.happened == POSE_UNCHANGED:
            _decide_pose(&known, &bank, time)
    return 1 if state.happened else 0


cdef bint _measure_pose(
    PoseMemory* known, PoseBank* bank, FloatRows positions, double seconds
) noexcept nogil:
    """Average the directions of bones; return whether all joints that are needed are known."""
    cdef HoldingState* state
    cdef float x, z
    cdef bint started, whole
    state = known.state
    started = state.frames > 0
    whole = place_pose(known.pose, bank.points, positions, bank.head.axis, <float>bank.head.sign)
    if not whole and not started:
        return False
    if not started:
        state.facing[0] = state.facing[1] = 0.0
    if bank.head.girdles[0] >= 0:
        x, z = facing_of(known.pose, bank.head.girdles)
        smooth_facing(state.facing, x, z, seconds)
    _average_directions(known, bank, seconds, started)
    return True


cdef inline void _average_directions(
    PoseMemory* known, PoseBank* bank, double seconds, bint started
) noexcept nogil:
    """Update both averages of the directions."""
    cdef const float* begin
    cdef const float* end
    cdef double quick, slow, cosine, sine, x, y, z, length
    cdef int64_t b
    cosine, sine = heading(known.state.facing[0], known.state.facing[1])
    quick = 1.0 - exp(-seconds / POSE_SMOOTHED) if started else 1.0
    slow = 1.0 - exp(-seconds / POSE_SETTLED) if started else 1.0
    for b in range(bank.head.bones):
        begin, end = known.pose.at + 3 * bank.bones[b].begin, known.pose.at + 3 * bank.bones[b].end
        x, y, z = end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]
        length = max(sqrt(x * x + y * y + z * z), SHORTEST_DIRECTION)
        x, z = turned_back(x, z, cosine, sine)
        _come_nearer(known.fast.at + 3 * b, x / length, y / length, z / length, quick)
        _come_nearer(known.slow.at + 3 * b, x / length, y / length, z / length, slow)


cdef inline void _come_nearer(double* average, double x, double y, double z, double share) noexcept nogil:
    average[0] += share * (x - average[0])
    average[1] += share * (y - average[1])
    average[2] += share * (z - average[2])


cdef void _decide_pose(PoseMemory* known, PoseBank* bank, double time) noexcept nogil:
    """Decide whether a pose is entered, held or left."""
    cdef HoldingState* state
    cdef double least, mean, worst
    cdef int64_t nearest, best
    cdef bint other
    state = known.state
    nearest, least = _nearest_pose(known, bank)
    if nearest != state.near and (nearest < 0 or state.near < 0 or not _same_name(bank, nearest, state.near)):
        state.since = time
    state.near = nearest
    if state.active < 0:
        if nearest >= 0 and state.frames >= FIRST_JUDGED and _largest_turn(known, bank) < RESTING:
            _enter_pose(known, bank, nearest, time)
        return
    mean, worst, best = _best_of_active(known, bank)
    other = nearest >= 0 and not _same_name(bank, nearest, state.active)
    if other and least < mean - NEARER and _largest_turn(known, bank) < RESTING:
        _leave_pose(state)
    elif mean < FAR and worst < FAR_OF_LIMB:
        _stay_in_pose(known, bank, best, time)
    elif time - state.seen > PATIENCE + EARLY:
        _leave_pose(state)


cdef inline bint _same_name(PoseBank* bank, int64_t one, int64_t other) noexcept nogil:
    return bank.shown[one].name == bank.shown[other].name


cdef (int64_t, double) _nearest_pose(PoseMemory* known, PoseBank* bank) noexcept nogil:
    """Return the nearest of the poses that are near, -1 for none, and its mean square of the chord."""
    cdef double least, mean, worst
    cdef int64_t p, found
    found, least = -1, INFINITY
    for p in range(bank.head.poses):
        mean, worst = _compare_pose(known, bank, p)
        if mean < NEAR_POSE and worst < NEAR_OF_LIMB and mean < least:
            found, least = p, mean
    return found, least


cdef (double, double, int64_t) _best_of_active(PoseMemory* known, PoseBank* bank) noexcept nogil:
    """Return the mean square of the chord to the pose held, the largest of a limb, and of which example."""
    cdef double least, worst, mean, largest
    cdef int64_t p, best
    least, worst, best = INFINITY, INFINITY, known.state.active
    for p in range(bank.head.poses):
        if _same_name(bank, p, known.state.active):
            mean, largest = _compare_pose(known, bank, p)
            if mean < least:
                least, worst, best = mean, largest, p
    return least, worst, best


cdef (double, double) _compare_pose(PoseMemory* known, PoseBank* bank, int64_t pose) noexcept nogil:
    """Compare the directions with a pose; return the mean square of the chord, and the largest of a limb."""
    cdef const double* here
    cdef const double* shown
    cdef double* chords
    cdef double total, length, twice
    cdef int64_t b, bones
    bones, chords = bank.head.bones, known.chords.at
    for b in range(bones):
        here, shown = known.fast.at + 3 * b, bank.rows.at + 3 * (pose * bones + b)
        length = sqrt(here[0] * here[0] + here[1] * here[1] + here[2] * here[2])
        twice = 2.0 * (here[0] * shown[0] + here[1] * shown[1] + here[2] * shown[2])
        chords[b] = max(0.0, 2.0 - twice / max(length, SHORTEST_DIRECTION))
        if shown[0] == shown[1] == shown[2] == 0.0:  # two joints of the pose are in one place
            chords[b] = 0.0
    total = 0.0
    for b in range(bones):
        total += chords[b]
    return total / bones, _largest_of_limbs(known, bank)


cdef double _largest_turn(PoseMemory* known, PoseBank* bank) noexcept nogil:
    """Return the largest recent turn of a limb's directions: mean square of the chord."""
    cdef double way
    cdef int64_t b, d
    for b in range(bank.head.bones):
        known.chords.at[b] = 0.0
        for d in range(3 * b, 3 * b + 3):
            way = known.fast.at[d] - known.slow.at[d]
            known.chords.at[b] += way * way
    return _largest_of_limbs(known, bank)


cdef inline double _largest_of_limbs(PoseMemory* known, PoseBank* bank) noexcept nogil:
    """Return the largest mean of `chords` over the bones of a limb."""
    cdef double* sums
    cdef double* counts
    cdef double largest
    cdef int64_t b, g
    sums, counts = known.groups.at, known.groups.at + bank.head.groups
    for g in range(bank.head.groups):
        sums[g] = counts[g] = 0.0
    for b in range(bank.head.bones):
        sums[bank.bones[b].limb] += known.chords.at[b]
        counts[bank.bones[b].limb] += 1.0
    largest = 0.0
    for g in range(bank.head.groups):
        largest = max(largest, sums[g] / counts[g])
    return largest


cdef void _enter_pose(PoseMemory* known, PoseBank* bank, int64_t pose, double time) noexcept nogil:
    cdef HoldingState* state
    cdef int64_t b
    state = known.state
    state.is_held = 0
    state.start = state.since
    state.matched = 0
    state.number += 1
    state.rev = 1
    state.happened = POSE_ENTERED
    for b in range(bank.head.bones):
        known.strays.at[b] = 0.0
    _count_strays(known, bank, pose, time)


cdef void _stay_in_pose(PoseMemory* known, PoseBank* bank, int64_t pose, double time) noexcept nogil:
    cdef HoldingState* state
    state = known.state
    _count_strays(known, bank, pose, time)
    if not state.is_held and time - state.start >= bank.shown[pose].hold - EARLY:
        state.is_held = 1
        state.rev += 1
        state.happened = POSE_HELD


cdef void _count_strays(PoseMemory* known, PoseBank* bank, int64_t pose, double time) noexcept nogil:
    """Add the body's deviation to the sum since the start."""
    cdef HoldingState* state
    cdef int64_t b
    _compare_pose(known, bank, pose)
    state = known.state
    state.active = state.latest = pose
    state.seen = time
    state.matched += 1
    for b in range(bank.head.bones):
        known.strays.at[b] += known.chords.at[b]


cdef void _leave_pose(HoldingState* state) noexcept nogil:
    state.active = -1
    state.rev += 1
    state.happened = POSE_LEFT
