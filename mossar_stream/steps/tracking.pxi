"""Tracking: a foot's speed and place over the last seconds, and its state: stand, begin to move, swing, come down.

A foot is as fast as the slowest of its points: while the heel rises and the toes stand, it stands. It leaves the ground
where its speed passes a share of the greatest speed of the swing that follows. It comes down where the speed falls
below another share. The shares make slow and fast steps comparable. A swing shorter than `LEAST_WAY` is a wiggle.

On a treadmill the ground moves. Its velocity is the one that both feet have for most of the time while they are low. Once it is
known, the last seconds are judged again, and all places and speeds are those on the belt. Over ground nothing is subtracted.
"""

cdef enum:
    MOST_POINTS = 4  # of a foot
    MOST_TOPS = 4  # joints above the feet, by which the direction upwards is known
    FOOT_RING = 256  # samples, a power of two: 1.9 s or more
cdef double FOOT_TICK = 0.0075  # s, least time between two samples: at most 133 Hz
cdef double BASE = 0.045  # s over which a speed is measured: two frames at 30 Hz
cdef double FOOT_LATE = 1.0  # s, frames that are so late are repeated or out of order
cdef double FOOT_ROUNDING = 1e-06  # s, for the rounding of times
cdef double FOOT_GAP = 0.25  # s without a foot, after which it begins anew
cdef double FASTEST = 20.0  # m/s; a point that seems faster is not seen
# Shares of the greatest speed of the swing. In real gait, the toe has a third of it when it leaves the ground and the heel a
# seventh when it comes down; of a foot that starts and stops as smoothly as can be, both are 0. These lie between.
cdef double LEAVES = 0.16
cdef double LANDS = 0.11
# m that a foot goes in a step; of feet without toes and heels more, because ankles rise with the heel.
cdef double LEAST_WAY = 0.06
cdef double LEAST_WAY_OF_ANKLES = 0.08  # m
cdef double LEAST_PEAK = 0.35  # m/s, the greatest speed of a step
cdef double MAY_LEAVE = 0.25  # m/s, from which a foot may be about to leave
cdef double QUIET_AT_LEAST = 0.08, QUIET_AT_MOST = 0.3  # m/s, limits of standing still
cdef double TIMES_NOISE = 3.0  # times the speed that a standing foot seems to have
cdef double REST = 0.05  # s that a foot has been down before it is reported
cdef double WIGGLE = 0.1  # s of rest that end a movement which was no step
cdef double AIR = 0.45  # m above the standing foot: a foot that rests there hangs in the air
cdef double LIFTED = 0.04  # m above where it stood, less than so far beside that: the same
cdef double BESIDE = 0.15
cdef double HOP = 0.12  # m above where it stood, while the other foot is not standing
cdef double UP_TIME = 1.0  # s, over which the direction upwards is averaged
# The belt of a treadmill.
cdef double BELT_EVERY = 0.1  # s between two looks for a belt
cdef double BELT_TIME = 1.6  # s that are compared, more than a stride
cdef double BELT_AT_LEAST = 0.8  # s
cdef double SLOWEST_BELT = 0.12  # m/s
cdef double BELT_NEAR = 0.1  # m/s, and a tenth of the speed: largest difference of equal velocities
cdef double BELT_SHARE = 0.28  # of the time in which a foot stands, in running less than in walking
cdef double BELT_TIMES = 3.0  # as often as standing still: a swing, which is fast for long, is thus no belt
cdef double BELT_JUMP = 0.3  # m/s, by which a belt differs from the one that was followed
cdef double BELT_FOLLOWS = 0.25  # s, in which standing feet change the belt's velocity
cdef double GROUND_SHARE = 0.5  # of the time in which feet stand still: the belt has stopped
cdef enum:
    MOST_MOVES = 264  # velocities that are compared
    REWOUND = 240  # samples that are judged again
    CATCH_UP = 3  # samples that are judged with one frame
cdef enum:
    FOOT_UNKNOWN = 0
    FOOT_STANDING = 1
    FOOT_MOVING = 2
    FOOT_SWINGING = 3
    NO_NEWS = 0
    STRIKE = 1
    OFF = 2

# Sizes are numbers below: numpy knows these records, and Cython can describe no other arrays to it.
cdef struct Foot:
    int64_t points[4]  # joints, -1 for none
    int64_t state
    int64_t count  # samples so far; sample n lies at n % FOOT_RING
    double times[256]  # s, when each sample was
    double middles[256]  # s, the middle of the time over which its speed was measured
    double speeds[256]  # m/s
    float places[256][4][3]  # m
    float moves[256][4]  # m/s along the ground of its lowest point, and the height of that, m; NaN where it is not known
    double drifts[256][3]  # m, way of the belt so far
    int64_t judged  # samples so far
    double last  # s, time of the latest event
    double centre[3]  # m, mean of the points that are seen, of the latest sample
    double base[3]  # m, where it stood
    double noise  # m/s, that it seems to have while it stands
    double peak  # m/s, greatest speed of the movement
    int64_t peak_at  # sample of it
    double way  # m, farthest from the base in this movement
    double rest  # s, since when it has been slow; NaN if it is not
    int64_t first  # sample behind the last gap
    # The report, written when `event` is not NO_NEWS.
    int64_t event
    double time  # s
    double place[3]  # m
    double confidence


cdef struct Steps:
    double due  # s, from when on a frame becomes a sample; see core/reader.pxi
    Foot feet[2]
    int64_t tops[4]  # joints above the feet, -1 for none
    double up[3]  # direction upwards, not normalised; of unit length and fixed if it was given
    int64_t is_up_given
    double time  # s, of the latest frame
    double sample  # s, of the latest that became a sample
    double sensitivity
    double way  # m, least way of a step
    double belt[3]  # m/s, velocity of the ground
    double drift[3]  # m, its way so far
    double looked  # s, when it was looked for
    int64_t number  # of the latest event of the take
    int64_t take


cdef int64_t follow_feet(
    uint8_t* state, uint8_t* store, float* positions, int64_t joints, double time
) noexcept nogil:
    """Process a frame; a function of a reader.

    Args:
        state: Steps.
        store: Not used.
        positions: (J, 3) m.
        joints: Not used.
        time: s.

    Returns:
        1 if a foot came down or left the ground, else 0.
    """
    cdef Steps* own = <Steps*>state
    cdef int64_t happened, f, d
    if not isfinite(time):
        return 0
    if time <= own.time:
        if own.time - time <= FOOT_LATE:
            return 0
        _forget(own, time)  # time was set back: another take
    own.time = time
    if time - own.sample < FOOT_TICK - FOOT_ROUNDING:
        return 0
    _find_up(own, positions, min(time - own.sample, 0.1))
    for d in range(3):
        own.drift[d] += own.belt[d] * min(time - own.sample, FOOT_GAP) if own.belt[d] != 0.0 else 0.0
    own.sample = time
    own.due = time + FOOT_TICK - FOOT_ROUNDING
    happened = 0
    for f in range(2):
        own.feet[f].event = NO_NEWS
        if _sample(own, &own.feet[f], positions, time):
            _judge_samples(own, f)
            if own.feet[f].event != NO_NEWS:
                happened = 1
    if time - own.looked >= BELT_EVERY:
        own.looked = time
        _find_belt(own, time)
    return happened


cdef void _forget(Steps* own, double time) noexcept nogil:
    cdef int64_t f
    own.time = time
    own.sample = own.looked = -INFINITY
    for f in range(3):
        own.belt[f] = own.drift[f] = 0.0
    for f in range(2):
        own.feet[f].state = FOOT_UNKNOWN
        own.feet[f].first = own.feet[f].count
        own.feet[f].rest = NAN
        own.feet[f].judged = own.feet[f].count
        own.feet[f].last = -INFINITY


cdef void _find_up(Steps* own, float* positions, double step) noexcept nogil:
    """Update the direction upwards with that from the feet to the head."""
    cdef double share, top, bottom
    cdef int64_t tops, k, d, f
    if own.is_up_given:
        return
    share = step / UP_TIME
    tops = 0
    for k in range(MOST_TOPS):
        tops += own.tops[k] >= 0
    for d in range(3):
        top = 0.0
        for k in range(tops):
            top += <double>positions[3 * own.tops[k] + d] / tops
        bottom = 0.0
        for f in range(2):
            bottom += 0.5 * positions[3 * own.feet[f].points[0] + d]
        if tops and isfinite(top - bottom):
            own.up[d] += share * (top - bottom - own.up[d])


cdef bint _sample(Steps* own, Foot* foot, float* positions, double time) noexcept nogil:
    """Note the place of a foot; return whether it is seen."""
    cdef int64_t number, here, seen, d, k, joint
    cdef bint whole
    number = foot.count
    here = number % FOOT_RING
    seen = 0
    for k in range(MOST_POINTS):
        joint = foot.points[k]
        if joint < 0:
            break
        whole = isfinite(positions[3 * joint] + positions[3 * joint + 1] + positions[3 * joint + 2])
        seen += whole
        for d in range(3):
            foot.places[here][k][d] = positions[3 * joint + d]
    if seen == 0:
        for d in range(3):
            foot.centre[d] = 0.0
        return False
    for d in range(3):
        foot.drifts[here][d] = own.drift[d]
    if number > foot.first and time - foot.times[(number - 1) % FOOT_RING] > FOOT_GAP + FOOT_ROUNDING:
        foot.first = foot.judged = number
        foot.state = FOOT_UNKNOWN
        foot.rest = NAN
    foot.times[here] = time
    foot.count = number + 1
    return True


cdef void _judge_samples(Steps* own, int64_t f) noexcept nogil:
    """Judge the samples of a foot that have not been: the latest one, and more after the belt has been found."""
    cdef Foot* foot
    cdef int64_t k
    foot = &own.feet[f]
    for k in range(CATCH_UP):
        if foot.judged >= foot.count or foot.event != NO_NEWS:
            return
        if _measure_foot(own, foot, foot.judged):
            _judge(own, f, foot.judged)
        foot.judged += 1


cdef bint _measure_foot(Steps* own, Foot* foot, int64_t number) noexcept nogil:
    """Find the place and the speed of a foot at a sample, on the belt if there is one; return whether the speed is known."""
    cdef int64_t here, there, seen, d, k, before
    cdef double time, speed
    here = number % FOOT_RING
    time = foot.times[here]
    seen = 0
    for d in range(3):
        foot.centre[d] = 0.0
    for k in range(MOST_POINTS):
        if foot.points[k] < 0:
            break
        if isfinite(foot.places[here][k][0] + foot.places[here][k][1] + foot.places[here][k][2]):
            seen += 1
            for d in range(3):
                foot.centre[d] += foot.places[here][k][d]
    for d in range(3):
        foot.centre[d] = foot.centre[d] / seen - foot.drifts[here][d]
    before = number - 1
    while (
        before > foot.first
        and time - foot.times[before % FOOT_RING] < BASE - FOOT_ROUNDING
        and number - before < FOOT_RING - 1
    ):
        before -= 1
    there = before % FOOT_RING
    for d in range(4):
        foot.moves[here][d] = NAN
    if before < foot.first or time - foot.times[there] < 0.5 * BASE - FOOT_ROUNDING:
        foot.middles[here] = time
        foot.speeds[here] = NAN
        return False
    speed = _speed(foot, here, there, time - foot.times[there])
    _note_move(own, foot, here, there, time - foot.times[there])
    foot.speeds[here] = speed
    foot.middles[here] = 0.5 * (time + foot.times[there])
    return isfinite(speed)


cdef double _speed(Foot* foot, int64_t here, int64_t there, double span) noexcept nogil:
    """Return the speed of the slowest point of a foot on the ground, m/s."""
    cdef double slowest, squares, speed
    cdef double drift[3]
    cdef int64_t k, d
    cdef bint drifts
    slowest = INFINITY
    drifts = False
    for d in range(3):
        drift[d] = foot.drifts[here][d] - foot.drifts[there][d]
        drifts = drifts or drift[d] != 0.0
    for k in range(MOST_POINTS):
        if foot.points[k] < 0:
            break
        squares = 0.0
        for d in range(3):
            if drifts:
                squares += squared(foot.places[here][k][d] - foot.places[there][k][d] - drift[d])
            else:
                squares += squared_float(foot.places[here][k][d] - foot.places[there][k][d])
        speed = sqrt(squares) / span
        if speed < FASTEST:  # false of a point that is not seen
            slowest = min(slowest, speed)
    return slowest if slowest < INFINITY else NAN


cdef void _note_move(Steps* own, Foot* foot, int64_t here, int64_t there, double span) noexcept nogil:
    """Note the velocity of the lowest point of a foot along the ground of the room: of toes, which stand longest."""
    cdef double length, height, lowest, upwards
    cdef double move[3]
    cdef int64_t k, d, found
    length = sqrt(own.up[0] * own.up[0] + own.up[1] * own.up[1] + own.up[2] * own.up[2])
    if length < 1e-6:
        return
    found, lowest = -1, INFINITY
    for k in range(MOST_POINTS):
        if foot.points[k] < 0:
            break
        height = 0.0
        for d in range(3):
            height += own.up[d] / length * (foot.places[here][k][d] + 0.0 * foot.places[there][k][d])
        if height < lowest:  # false of a point that is not seen
            found, lowest = k, height
    if found < 0:
        return
    upwards = 0.0
    for d in range(3):
        move[d] = (<double>foot.places[here][found][d] - <double>foot.places[there][found][d]) / span
        upwards += own.up[d] / length * move[d]
    for d in range(3):
        foot.moves[here][d] = <float>(move[d] - upwards * own.up[d] / length)
    foot.moves[here][3] = <float>lowest


cdef void _find_belt(Steps* own, double time) noexcept nogil:
    """Look for a velocity that both feet have for most of the time while they are low; rewind the feet if it is new."""
    cdef double moves[264][4]
    cdef int64_t of[264]
    cdef double best[3]
    cdef int64_t count, still, k, d, f, n, step, hits, most
    cdef Foot* foot
    count = 0
    for f in range(2):
        foot = &own.feet[f]
        n = foot.judged - 1
        # At 60 Hz and more every other sample is enough.
        step = 2 if n > foot.first and time - foot.times[(n - 1) % FOOT_RING] < 0.02 else 1
        while n >= foot.first and n > foot.count - FOOT_RING + 8 and time - foot.times[n % FOOT_RING] <= BELT_TIME:
            if isfinite(foot.moves[n % FOOT_RING][0]) and count < (f + 1) * MOST_MOVES // 2:
                for d in range(4):
                    moves[count][d] = foot.moves[n % FOOT_RING][d]
                of[count] = f
                count += 1
            n -= step
        if n + step >= foot.count or time - foot.times[(n + step) % FOOT_RING] < BELT_AT_LEAST:
            return
    for d in range(3):
        best[d] = 0.0
    still = _moves_like(moves, of, count, best, -1)
    if still >= GROUND_SHARE * count:
        for d in range(3):
            own.belt[d] = 0.0
        return
    most = 0
    for k in range(0, count, 4):
        hits = _moves_like(moves, of, count, &moves[k][0], -1)
        if hits > most:
            most = hits
            for d in range(3):
                best[d] = moves[k][d]
    for k in range(2):
        _middle_of_moves(moves, count, best)
    _accept_belt(own, time, moves, of, count, best, still)


cdef void _accept_belt(
    Steps* own, double time, double[4]* moves, int64_t* of, int64_t count, double* best, int64_t still
) noexcept nogil:
    """Accept a velocity as the belt's if the feet bear it out."""
    cdef double speed, other, low, high
    cdef int64_t f, k, d, own_hits, lows, highs
    cdef bint moved
    speed = sqrt(squared(best[0]) + squared(best[1]) + squared(best[2]))
    if speed < SLOWEST_BELT or _moves_like(moves, of, count, best, -1) < BELT_TIMES * still:
        return
    for f in range(2):
        own_hits = 0
        for k in range(count):
            own_hits += of[k] == f
        if _moves_like(moves, of, count, best, f) < BELT_SHARE * own_hits:
            return
    low = high = 0.0
    lows = highs = 0
    for k in range(count):
        if _near_move(&moves[k][0], best):
            low, lows = low + moves[k][3], lows + 1
        else:
            high, highs = high + moves[k][3], highs + 1
    if highs and low / lows > high / highs:
        return  # that is the swing
    moved = own.belt[0] != 0.0 or own.belt[1] != 0.0 or own.belt[2] != 0.0
    other = sqrt(squared(best[0] - own.belt[0]) + squared(best[1] - own.belt[1]) + squared(best[2] - own.belt[2]))
    if moved and other < BELT_JUMP:
        return  # standing feet change it
    for d in range(3):
        own.belt[d] = best[d]
    if not moved:
        for f in range(2):
            _rewind_foot(own, &own.feet[f], time)


cdef void _rewind_foot(Steps* own, Foot* foot, double time) noexcept nogil:
    """Judge a foot again on the belt, from its earliest known place on."""
    cdef int64_t n, d
    n = max(foot.first, foot.count - REWOUND)
    foot.first = foot.judged = n
    foot.state = FOOT_UNKNOWN
    foot.rest = NAN
    foot.noise = 0.0
    while n < foot.count:
        for d in range(3):
            foot.drifts[n % FOOT_RING][d] = own.drift[d] + own.belt[d] * (foot.times[n % FOOT_RING] - time)
        n += 1


cdef bint _near_move(double* move, double* other) noexcept nogil:
    cdef double squares, speed
    squares = squared(move[0] - other[0]) + squared(move[1] - other[1]) + squared(move[2] - other[2])
    speed = sqrt(squared(other[0]) + squared(other[1]) + squared(other[2]))
    return squares <= squared(BELT_NEAR + 0.1 * speed)


cdef int64_t _moves_like(double[4]* moves, int64_t* of, int64_t count, double* move, int64_t f) noexcept nogil:
    """Return the number of velocities of a foot, or of both for -1, near one."""
    cdef int64_t k, found
    found = 0
    for k in range(count):
        if f < 0 or of[k] == f:
            found += _near_move(&moves[k][0], move)
    return found


cdef void _middle_of_moves(double[4]* moves, int64_t count, double* move) noexcept nogil:
    """Replace a velocity by the mean of those near it."""
    cdef double sums[3]
    cdef int64_t k, d, found
    found = 0
    for d in range(3):
        sums[d] = 0.0
    for k in range(count):
        if _near_move(&moves[k][0], move):
            found += 1
            for d in range(3):
                sums[d] += moves[k][d]
    for d in range(3):
        move[d] = sums[d] / found if found else move[d]


cdef void _follow_belt(Steps* own, Foot* foot, int64_t here, double step) noexcept nogil:
    """Update the belt's velocity with that of a standing foot; `step` is the time since the sample before, s."""
    cdef int64_t d
    if step > 0.0 and isfinite(foot.moves[here][0]):
        for d in range(3):
            own.belt[d] += min(step / BELT_FOLLOWS, 1.0) * (foot.moves[here][d] - own.belt[d])


cdef void _judge(Steps* own, int64_t f, int64_t number) noexcept nogil:
    """Update the state of a foot after a sample, and note an event."""
    cdef Foot* foot
    cdef int64_t here, d
    cdef double quiet, speed, middle
    foot = &own.feet[f]
    here = number % FOOT_RING
    speed, middle = foot.speeds[here], foot.middles[here]
    quiet = min(max(TIMES_NOISE * foot.noise, QUIET_AT_LEAST), QUIET_AT_MOST)
    if foot.state == FOOT_UNKNOWN:
        _tracking_begin(foot, speed, number, quiet)
        return
    if foot.state == FOOT_STANDING:
        if speed < quiet:
            for d in range(3):
                foot.base[d] += 0.2 * (foot.centre[d] - foot.base[d])
        if speed < QUIET_AT_MOST and (own.belt[0] != 0.0 or own.belt[1] != 0.0 or own.belt[2] != 0.0):
            _follow_belt(own, foot, here, foot.times[here] - foot.times[(number - 1) % FOOT_RING])
        foot.noise += 0.03 * (min(speed, QUIET_AT_MOST) - foot.noise)
        if speed > max(MAY_LEAVE / own.sensitivity, 1.2 * quiet):
            foot.state = FOOT_MOVING
            foot.peak, foot.peak_at, foot.way = speed, number, 0.0
            foot.rest = NAN
        return
    if speed > foot.peak:
        foot.peak, foot.peak_at = speed, number
    foot.way = max(foot.way, _tracking_distance(foot))
    if foot.state == FOOT_MOVING:
        _tracking_leave(own, foot, speed, middle, quiet)
    else:
        _land(own, f, foot, speed, number, quiet)


cdef void _tracking_begin(Foot* foot, double speed, int64_t number, double quiet) noexcept nogil:
    """Decide whether a foot that is seen for the first time stands or swings."""
    cdef int64_t d
    if speed < quiet:
        foot.state = FOOT_STANDING
        for d in range(3):
            foot.base[d] = foot.centre[d]
    elif speed > 2.0 * LEAST_PEAK:
        foot.state = FOOT_SWINGING
        foot.peak, foot.peak_at, foot.way = speed, number, 1.0
        for d in range(3):
            foot.base[d] = foot.centre[d]
    foot.rest = NAN


cdef double _tracking_distance(Foot* foot) noexcept nogil:
    cdef double squares
    cdef int64_t d
    squares = 0.0
    for d in range(3):
        squares += squared(foot.centre[d] - foot.base[d])
    return sqrt(squares)


cdef void _tracking_leave(Steps* own, Foot* foot, double speed, double middle, double quiet) noexcept nogil:
    """Report that a foot left the ground, once it has gone far enough; a foot that only wiggled stands again."""
    cdef bint is_step
    cdef double level
    cdef int64_t at, d
    is_step = foot.way >= own.way and foot.peak >= LEAST_PEAK / own.sensitivity
    if is_step and speed < 0.9 * foot.peak:
        level = max(LEAVES * foot.peak, quiet)
        at = foot.peak_at
        while at - 1 >= foot.first and foot.peak_at - at < FOOT_RING - 8 and foot.speeds[(at - 1) % FOOT_RING] > level:
            at -= 1
        _report(own, foot, OFF, _crossing(foot, at, level))
        foot.state = FOOT_SWINGING
        foot.rest = NAN
        return
    if speed >= quiet:
        foot.rest = NAN
    elif not isfinite(foot.rest):
        foot.rest = middle
    elif middle - foot.rest >= WIGGLE:
        foot.state = FOOT_STANDING
        for d in range(3):
            foot.base[d] = foot.centre[d]


cdef void _land(Steps* own, int64_t f, Foot* foot, double speed, int64_t number, double quiet) noexcept nogil:
    """Report that a foot came down, once it has stayed there for a moment."""
    cdef double level
    cdef int64_t d
    level = max(LANDS * foot.peak, quiet)
    if speed > 1.6 * level:
        foot.rest = NAN
        return
    if speed <= level and not isfinite(foot.rest):
        foot.rest = _crossing(foot, number, level)
    if not isfinite(foot.rest) or foot.middles[number % FOOT_RING] - foot.rest < REST:
        return
    if _hangs(own, f):
        return
    _report(own, foot, STRIKE, foot.rest)
    foot.state = FOOT_STANDING
    for d in range(3):
        foot.base[d] = foot.centre[d]


cdef double _crossing(Foot* foot, int64_t at, double level) noexcept nogil:
    """Return the time at which the speed crossed a level between sample `at` and the one before, s."""
    cdef double share
    cdef int64_t b, a
    b, a = at % FOOT_RING, (at - 1) % FOOT_RING
    if at - 1 < foot.first or not isfinite(foot.speeds[a]) or foot.speeds[a] == foot.speeds[b]:
        return foot.middles[b]
    share = (level - foot.speeds[a]) / (foot.speeds[b] - foot.speeds[a])
    return foot.middles[a] + min(max(share, 0.0), 1.0) * (foot.middles[b] - foot.middles[a])


cdef bint _hangs(Steps* own, int64_t f) noexcept nogil:
    """Return whether a foot that rests is too high above the other foot, or above where it stood, to be on the ground."""
    cdef double length, above_other, above_base, squares
    cdef int64_t d
    cdef Foot* foot
    cdef Foot* other
    foot = &own.feet[f]
    other = &own.feet[1 - f]
    length = sqrt(own.up[0] * own.up[0] + own.up[1] * own.up[1] + own.up[2] * own.up[2])
    if length < 1e-6:
        return False
    above_other = above_base = squares = 0.0
    for d in range(3):
        above_other += own.up[d] / length * (foot.centre[d] - other.centre[d])
        above_base += own.up[d] / length * (foot.centre[d] - foot.base[d])
        squares += squared(foot.centre[d] - foot.base[d])
    if above_base > LIFTED and squares - above_base * above_base < BESIDE * BESIDE and foot.way < 1.0:
        return True
    if other.state == FOOT_STANDING:
        return above_other > AIR
    return above_base > HOP


cdef void _report(Steps* own, Foot* foot, int64_t event, double time) noexcept nogil:
    """Note an event with its confidence: the excess of the movement over a wiggle and the noise."""
    cdef int64_t d, at
    cdef double far, clear
    if time <= foot.last:
        return  # reported before the belt was found
    foot.event = event
    foot.time = foot.last = time
    at = foot.judged % FOOT_RING
    for d in range(3):
        foot.place[d] = (foot.centre[d] if event == STRIKE else foot.base[d]) + foot.drifts[at][d]
    far = 1.0 - 0.5 * own.way / max(foot.way, own.way)
    clear = foot.peak / (foot.peak + TIMES_NOISE * foot.noise)
    foot.confidence = min(far, 1.0) * clear
