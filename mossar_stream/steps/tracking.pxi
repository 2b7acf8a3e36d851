"""Tracking: a foot's speed and place over the last seconds, and what it does: stand, begin to move, swing, come down.

A foot is as fast as the slowest of its points: while the heel rises and the toes stand, it stands. It leaves the ground
where its speed passes a share of the greatest speed of the swing that follows. It comes down where the speed falls
below another share. So slow and fast steps are measured alike. A swing that goes less far than `LEAST_WAY` is a wiggle.
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
cdef double QUIET_AT_LEAST = 0.08, QUIET_AT_MOST = 0.3  # m/s: what counts as standing still
cdef double TIMES_NOISE = 3.0  # times the speed that a standing foot seems to have
cdef double REST = 0.05  # s that a foot has been down before it is reported
cdef double WIGGLE = 0.1  # s of rest that end a movement which was no step
cdef double AIR = 0.45  # m above the standing foot: a foot that rests there hangs in the air
cdef double LIFTED = 0.04  # m above where it stood, less than so far beside that: the same
cdef double BESIDE = 0.15
cdef double HOP = 0.12  # m above where it stood, while the other foot is not standing
cdef double UP_TIME = 1.0  # s, over which the direction upwards is averaged
cdef enum:
    FOOT_UNKNOWN = 0
    FOOT_STANDING = 1
    FOOT_MOVING = 2
    FOOT_SWINGING = 3
    NO_NEWS = 0
    STRIKE = 1
    OFF = 2

# Sizes are numbers below: numpy is told of these records, and Cython describes no other arrays to it.
cdef struct Foot:
    int64_t points[4]  # joints, -1 for none
    int64_t state
    int64_t count  # samples so far; sample n lies at n % FOOT_RING
    double times[256]  # s, when each sample was
    double middles[256]  # s, the middle of the time over which its speed was measured
    double speeds[256]  # m/s
    float places[256][4][3]  # m
    double centre[3]  # m, mean of the points that are seen, of the latest sample
    double base[3]  # m, where it stood
    double noise  # m/s, that it seems to have while it stands
    double peak  # m/s, greatest speed of the movement
    int64_t peak_at  # sample of it
    double way  # m, farthest from the base in this movement
    double rest  # s, since when it has been slow; NaN if it is not
    int64_t first  # sample behind the last gap
    # What is reported: written when `event` is not NO_NEWS.
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
    int64_t number  # of the latest event of the take
    int64_t take


cdef int64_t follow_feet(
    uint8_t* state, uint8_t* store, float* positions, int64_t joints, double time
) noexcept nogil:
    """Process a frame; a function as readers have it.

    Args:
        state: Steps.
        store: Not looked at.
        positions: (J, 3) m.
        joints: Not looked at.
        time: s.

    Returns:
        1 if a foot came down or left the ground, else 0.
    """
    cdef Steps* own = <Steps*>state
    cdef int64_t happened, f
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
    own.sample = time
    own.due = time + FOOT_TICK - FOOT_ROUNDING
    happened = 0
    for f in range(2):
        own.feet[f].event = NO_NEWS
        if _sample(&own.feet[f], positions, time):
            _judge(own, f)
            if own.feet[f].event != NO_NEWS:
                happened = 1
    return happened


cdef void _forget(Steps* own, double time) noexcept nogil:
    cdef int64_t f
    own.time = time
    own.sample = -INFINITY
    for f in range(2):
        own.feet[f].state = FOOT_UNKNOWN
        own.feet[f].first = own.feet[f].count
        own.feet[f].rest = NAN


cdef void _find_up(Steps* own, float* positions, double step) noexcept nogil:
    """Let the direction upwards follow that from the feet to the head."""
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


cdef bint _sample(Foot* foot, float* positions, double time) noexcept nogil:
    """Note where a foot is and how fast; return whether its speed is known."""
    cdef int64_t number, here, seen, d, k, before, joint
    cdef double speed
    cdef bint whole
    number = foot.count
    here = number % FOOT_RING
    seen = 0
    for d in range(3):
        foot.centre[d] = 0.0
    for k in range(MOST_POINTS):
        joint = foot.points[k]
        if joint < 0:
            break
        whole = isfinite(positions[3 * joint] + positions[3 * joint + 1] + positions[3 * joint + 2])
        seen += whole
        for d in range(3):
            foot.places[here][k][d] = positions[3 * joint + d]
            foot.centre[d] += positions[3 * joint + d] if whole else 0.0
    if seen == 0:
        return False
    for d in range(3):
        foot.centre[d] /= seen
    if number > foot.first and time - foot.times[(number - 1) % FOOT_RING] > FOOT_GAP + FOOT_ROUNDING:
        foot.first = number
        foot.state = FOOT_UNKNOWN
        foot.rest = NAN
    foot.times[here] = time
    foot.count = number + 1
    before = number - 1
    while (
        before > foot.first
        and time - foot.times[before % FOOT_RING] < BASE - FOOT_ROUNDING
        and number - before < FOOT_RING - 1
    ):
        before -= 1
    if before < foot.first or time - foot.times[before % FOOT_RING] < 0.5 * BASE - FOOT_ROUNDING:
        foot.middles[here] = time
        foot.speeds[here] = NAN
        return False
    speed = _speed(foot, here, before % FOOT_RING, time - foot.times[before % FOOT_RING])
    foot.speeds[here] = speed
    foot.middles[here] = 0.5 * (time + foot.times[before % FOOT_RING])
    return isfinite(speed)


cdef double _speed(Foot* foot, int64_t here, int64_t there, double span) noexcept nogil:
    """Return the speed of the slowest point of a foot, m/s."""
    cdef double slowest, squares, speed
    cdef int64_t k, d
    slowest = INFINITY
    for k in range(MOST_POINTS):
        if foot.points[k] < 0:
            break
        squares = 0.0
        for d in range(3):
            squares += squared_float(foot.places[here][k][d] - foot.places[there][k][d])
        speed = sqrt(squares) / span
        if speed < FASTEST:  # false of a point that is not seen
            slowest = min(slowest, speed)
    return slowest if slowest < INFINITY else NAN


cdef void _judge(Steps* own, int64_t f) noexcept nogil:
    """Go on with the state of a foot after a sample, and note an event."""
    cdef Foot* foot
    cdef int64_t number, here, d
    cdef double quiet, speed, middle
    foot = &own.feet[f]
    number = foot.count - 1
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
    """Let a foot that is seen for the first time stand or swing."""
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
    """Report that a foot left the ground, once it has gone far enough; let one that only wiggled stand."""
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
    """Return when the speed crossed a level between sample `at` and the one before, s."""
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
    """Note an event with how sure it is: how far beyond a wiggle and beyond the noise the movement was."""
    cdef int64_t d
    cdef double far, clear
    foot.event = event
    foot.time = time
    for d in range(3):
        foot.place[d] = foot.centre[d] if event == STRIKE else foot.base[d]
    far = 1.0 - 0.5 * own.way / max(foot.way, own.way)
    clear = foot.peak / (foot.peak + TIMES_NOISE * foot.noise)
    foot.confidence = min(far, 1.0) * clear
