"""Tracking: a foot's speed and place over the last seconds, and what it does: stand, begin to move, swing, come down.

A foot is as fast as the slowest of its points: while the heel rises and the toes stand, it stands. It leaves the ground
where its speed passes a share of the greatest speed of the swing that follows. It comes down where the speed falls
below another share. So slow and fast steps are measured alike. A swing that goes less far than `LEAST_WAY` is a wiggle.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import entry_point, kernel
from mossar_stream.jit.views import part
from mossar_stream.settings.feet import MOST_POINTS
from mossar_stream.steps.feet import MOST_TOPS

FOOT_RING = 256  # samples, a power of two: 1.9 s or more
FOOT_TICK = 0.0075  # s, least time between two samples: at most 133 Hz
BASE = 0.045  # s over which a speed is measured: two frames at 30 Hz
LATE = 1.0  # s, frames that are so late are repeated or out of order
EARLY = 1e-6  # s, for the rounding of times
MAX_STEP = 0.25  # s without a foot, after which it begins anew
FASTEST = 20.0  # m/s; a point that seems faster is not seen
# Shares of the greatest speed of the swing. In real gait, the toe has a third of it when it leaves the ground and the heel a
# seventh when it comes down; of a foot that starts and stops as smoothly as can be, both are 0. These lie between.
LEAVES, LANDS = 0.16, 0.11
LEAST_WAY = 0.06  # m that a foot goes in a step; of feet without toes and heels more, because ankles rise with the heel
LEAST_WAY_OF_ANKLES = 0.08  # m
LEAST_PEAK = 0.35  # m/s, the greatest speed of a step
MAY_LEAVE = 0.25  # m/s, from which a foot may be about to leave
QUIET_SPEED = 0.08, 0.30  # m/s: what counts as standing still, at least and at most
TIMES_NOISE = 3.0  # times the speed that a standing foot seems to have
REST = 0.05  # s that a foot has been down before it is reported
WIGGLE = 0.1  # s of rest that end a movement which was no step
AIR = 0.45  # m above the standing foot: a foot that rests there hangs in the air
LIFTED, BESIDE = 0.04, 0.15  # m above where it stood, less than so far beside that: the same
HOP = 0.12  # m above where it stood, while the other foot is not standing
UP_TIME = 1.0  # s, over which the direction upwards is averaged

FOOT_UNKNOWN, FOOT_STANDING, FOOT_MOVING, FOOT_SWINGING = 0, 1, 2, 3
NO_NEWS, STRIKE, OFF = 0, 1, 2

FOOT = np.dtype(
    [
        ("points", "i8", (MOST_POINTS,)),  # joints, -1 for none
        ("state", "i8"),
        ("count", "i8"),  # samples so far; sample n lies at n % FOOT_RING
        ("times", "f8", (FOOT_RING,)),  # s, when each sample was
        ("middles", "f8", (FOOT_RING,)),  # s, the middle of the time over which its speed was measured
        ("speeds", "f8", (FOOT_RING,)),  # m/s
        ("places", "f4", (FOOT_RING, MOST_POINTS, 3)),  # m
        ("centre", "f8", (3,)),  # m, mean of the points that are seen, of the latest sample
        ("base", "f8", (3,)),  # m, where it stood
        ("noise", "f8"),  # m/s, that it seems to have while it stands
        ("peak", "f8"),  # m/s, greatest speed of the movement
        ("peak_at", "i8"),  # sample of it
        ("way", "f8"),  # m, farthest from the base in this movement
        ("rest", "f8"),  # s, since when it has been slow; NaN if it is not
        ("first", "i8"),  # sample behind the last gap
        # What is reported: written when `event` is not NO_NEWS.
        ("event", "i8"),
        ("time", "f8"),  # s
        ("place", "f8", (3,)),  # m
        ("confidence", "f8"),
    ]
)
STEPS = np.dtype(
    [
        ("due", "f8"),  # s, from when on a frame becomes a sample; see readers.py
        ("feet", FOOT, (2,)),
        ("tops", "i8", (MOST_TOPS,)),  # joints above the feet, -1 for none
        ("up", "f8", (3,)),  # direction upwards, not normalised; of unit length and fixed if it was given
        ("is_up_given", "i8"),
        ("time", "f8"),  # s, of the latest frame
        ("sample", "f8"),  # s, of the latest that became a sample
        ("sensitivity", "f8"),
        ("way", "f8"),  # m, least way of a step
        ("number", "i8"),  # of the latest event of the take
        ("take", "i8"),
    ]
)


@entry_point(makes_arrays=False)
def follow_feet(
    memory: NDArray[np.uint8], _store: NDArray[np.uint8], positions: NDArray[np.float32], time: float
) -> int:
    """Process a frame; a function as readers have it.

    Args:
        memory: The bytes of one STEPS.
        positions: (J, 3) float32, metres.
        time: s.

    Returns:
        1 if a foot came down or left the ground, else 0.
    """
    own = part(memory, 0, STEPS, (1,))[0]
    if not np.isfinite(time):
        return 0
    if time <= own.time:
        if own.time - time <= LATE:
            return 0
        _forget(own, time)  # time was set back: another take
    own.time = time
    if time - own.sample < FOOT_TICK - EARLY:
        return 0
    _find_up(own, positions, min(time - own.sample, 0.1))
    own.sample = time
    own.due = time + FOOT_TICK - EARLY
    happened = 0
    for f in range(2):
        own.feet[f].event = NO_NEWS
        if _sample(own.feet[f], positions, time):
            _judge(own, f)
            if own.feet[f].event != NO_NEWS:
                happened = 1
    return happened


@kernel
def _forget(own, time):
    own.time = time
    own.sample = -np.inf
    for f in range(2):
        own.feet[f].state = FOOT_UNKNOWN
        own.feet[f].first = own.feet[f].count
        own.feet[f].rest = np.nan


@kernel
def _find_up(own, positions, step):
    """Let the direction upwards follow that from the feet to the head."""
    if own.is_up_given:
        return
    share = step / UP_TIME
    tops = 0
    for k in range(MOST_TOPS):
        tops += own.tops[k] >= 0
    for d in range(3):
        top = 0.0
        for k in range(tops):
            top += positions[own.tops[k], d] / tops
        bottom = 0.0
        for f in range(2):
            bottom += 0.5 * positions[own.feet[f].points[0], d]
        if tops and np.isfinite(top - bottom):
            own.up[d] += share * (top - bottom - own.up[d])


@kernel
def _sample(foot, positions, time):
    """Note where a foot is and how fast; return whether its speed is known."""
    number = foot.count
    here = number % FOOT_RING
    seen = 0
    for d in range(3):
        foot.centre[d] = 0.0
    for k in range(MOST_POINTS):
        joint = foot.points[k]
        if joint < 0:
            break
        whole = np.isfinite(positions[joint, 0] + positions[joint, 1] + positions[joint, 2])
        seen += whole
        for d in range(3):
            foot.places[here, k, d] = positions[joint, d]
            foot.centre[d] += positions[joint, d] if whole else 0.0
    if seen == 0:
        return False
    for d in range(3):
        foot.centre[d] /= seen
    if number > foot.first and time - foot.times[(number - 1) % FOOT_RING] > MAX_STEP + EARLY:
        foot.first = number
        foot.state = FOOT_UNKNOWN
        foot.rest = np.nan
    foot.times[here] = time
    foot.count = number + 1
    before = number - 1
    while (
        before > foot.first
        and time - foot.times[before % FOOT_RING] < BASE - EARLY
        and number - before < FOOT_RING - 1
    ):
        before -= 1
    if before < foot.first or time - foot.times[before % FOOT_RING] < 0.5 * BASE - EARLY:
        foot.middles[here] = time
        foot.speeds[here] = np.nan
        return False
    speed = _speed(foot, here, before % FOOT_RING, time - foot.times[before % FOOT_RING])
    foot.speeds[here] = speed
    foot.middles[here] = 0.5 * (time + foot.times[before % FOOT_RING])
    return np.isfinite(speed)


@kernel
def _speed(foot, here, there, span):
    """Return the speed of the slowest point of a foot, m/s."""
    slowest = np.inf
    for k in range(MOST_POINTS):
        if foot.points[k] < 0:
            break
        squares = 0.0
        for d in range(3):
            squares += (foot.places[here, k, d] - foot.places[there, k, d]) ** 2
        speed = np.sqrt(squares) / span
        if speed < FASTEST:  # false of a point that is not seen
            slowest = min(slowest, speed)
    return slowest if slowest < np.inf else np.nan


@kernel
def _judge(own, f):
    """Go on with the state of a foot after a sample, and note an event."""
    foot = own.feet[f]
    number = foot.count - 1
    here = number % FOOT_RING
    speed, middle = foot.speeds[here], foot.middles[here]
    quiet = min(max(TIMES_NOISE * foot.noise, QUIET_SPEED[0]), QUIET_SPEED[1])
    if foot.state == FOOT_UNKNOWN:
        _begin(foot, speed, number, quiet)
        return
    if foot.state == FOOT_STANDING:
        if speed < quiet:
            for d in range(3):
                foot.base[d] += 0.2 * (foot.centre[d] - foot.base[d])
        foot.noise += 0.03 * (min(speed, QUIET_SPEED[1]) - foot.noise)
        if speed > max(MAY_LEAVE / own.sensitivity, 1.2 * quiet):
            foot.state = FOOT_MOVING
            foot.peak, foot.peak_at, foot.way = speed, number, 0.0
            foot.rest = np.nan
        return
    if speed > foot.peak:
        foot.peak, foot.peak_at = speed, number
    foot.way = max(foot.way, _distance(foot))
    if foot.state == FOOT_MOVING:
        _leave(own, foot, speed, middle, quiet)
    else:
        _land(own, f, foot, speed, number, quiet)


@kernel
def _begin(foot, speed, number, quiet):
    """Let a foot that is seen for the first time stand or swing."""
    if speed < quiet:
        foot.state = FOOT_STANDING
        for d in range(3):
            foot.base[d] = foot.centre[d]
    elif speed > 2.0 * LEAST_PEAK:
        foot.state = FOOT_SWINGING
        foot.peak, foot.peak_at, foot.way = speed, number, 1.0
        for d in range(3):
            foot.base[d] = foot.centre[d]
    foot.rest = np.nan


@kernel
def _distance(foot):
    squares = 0.0
    for d in range(3):
        squares += (foot.centre[d] - foot.base[d]) ** 2
    return np.sqrt(squares)


@kernel
def _leave(own, foot, speed, middle, quiet):
    """Report that a foot left the ground, once it has gone far enough; let one that only wiggled stand."""
    is_step = foot.way >= own.way and foot.peak >= LEAST_PEAK / own.sensitivity
    if is_step and speed < 0.9 * foot.peak:
        level = max(LEAVES * foot.peak, quiet)
        at = foot.peak_at
        while (
            at - 1 >= foot.first
            and foot.peak_at - at < FOOT_RING - 8
            and foot.speeds[(at - 1) % FOOT_RING] > level
        ):
            at -= 1
        _report(own, foot, OFF, _crossing(foot, at, level))
        foot.state = FOOT_SWINGING
        foot.rest = np.nan
        return
    if speed >= quiet:
        foot.rest = np.nan
    elif not np.isfinite(foot.rest):
        foot.rest = middle
    elif middle - foot.rest >= WIGGLE:
        foot.state = FOOT_STANDING
        for d in range(3):
            foot.base[d] = foot.centre[d]


@kernel
def _land(own, f, foot, speed, number, quiet):
    """Report that a foot came down, once it has stayed there for a moment."""
    level = max(LANDS * foot.peak, quiet)
    if speed > 1.6 * level:
        foot.rest = np.nan
        return
    if speed <= level and not np.isfinite(foot.rest):
        foot.rest = _crossing(foot, number, level)
    if not np.isfinite(foot.rest) or foot.middles[number % FOOT_RING] - foot.rest < REST:
        return
    if _hangs(own, f):
        return
    _report(own, foot, STRIKE, foot.rest)
    foot.state = FOOT_STANDING
    for d in range(3):
        foot.base[d] = foot.centre[d]


@kernel
def _crossing(foot, at, level):
    """Return when the speed crossed a level between sample `at` and the one before, s."""
    b, a = at % FOOT_RING, (at - 1) % FOOT_RING
    if at - 1 < foot.first or not np.isfinite(foot.speeds[a]) or foot.speeds[a] == foot.speeds[b]:
        return foot.middles[b]
    share = (level - foot.speeds[a]) / (foot.speeds[b] - foot.speeds[a])
    return foot.middles[a] + min(max(share, 0.0), 1.0) * (foot.middles[b] - foot.middles[a])


@kernel
def _hangs(own, f):
    """Return whether a foot that rests is too high above the other foot, or above where it stood, to be on the ground."""
    foot, other = own.feet[f], own.feet[1 - f]
    length = np.sqrt(own.up[0] ** 2 + own.up[1] ** 2 + own.up[2] ** 2)
    if length < 1e-6:
        return False
    above_other = above_base = squares = 0.0
    for d in range(3):
        above_other += own.up[d] / length * (foot.centre[d] - other.centre[d])
        above_base += own.up[d] / length * (foot.centre[d] - foot.base[d])
        squares += (foot.centre[d] - foot.base[d]) ** 2
    if above_base > LIFTED and squares - above_base**2 < BESIDE**2 and foot.way < 1.0:
        return True
    if other.state == FOOT_STANDING:
        return above_other > AIR
    return above_base > HOP


@kernel
def _report(own, foot, event, time):
    """Note an event with how sure it is: how far beyond a wiggle and beyond the noise the movement was."""
    foot.event = event
    foot.time = time
    for d in range(3):
        foot.place[d] = foot.centre[d] if event == STRIKE else foot.base[d]
    far = 1.0 - 0.5 * own.way / max(foot.way, own.way)
    clear = foot.peak / (foot.peak + TIMES_NOISE * foot.noise)
    foot.confidence = min(far, 1.0) * clear
