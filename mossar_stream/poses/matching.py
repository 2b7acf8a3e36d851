"""Matching: which pose a performer holds.

At most every `EVERY` seconds the directions of bones, relative to the performer's facing, are averaged and compared with
all poses. A pose is entered when the performer is nearly at rest near it, and nearer to it than to the others. It is left
when the body has strayed farther, by a margin, for `PATIENCE`, or when another pose is entered.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.following.sampling import LEAST_SPACING, place_pose
from mossar_stream.jit.decorators import entry_point, inline_kernel, kernel
from mossar_stream.moves.facing import facing_of, heading, smooth_facing, turned_back
from mossar_stream.moves.points import EARLY, follows, is_new
from mossar_stream.poses.layout import open_bank, open_memory

EVERY = 0.06  # s between two samples
POSE_SMOOTHED = 0.1  # s, time constant of the directions that are compared
POSE_SETTLED = 0.4  # s, of those by which rest is judged
FIRST = 5  # samples after a gap before rest is judged
PATIENCE = 0.3  # s, so long a pose is kept while the body strays farther
# Squares of chords between directions; 2 sin(angle / 2) is the chord of an angle.
NEAR_POSE, NEAR_OF_LIMB = 0.068, 0.187  # 15 degrees over all bones, 25 of each limb: a pose is entered
FAR, FAR_OF_LIMB = 0.12, 0.362  # 20 and 35: it is left
RESTING = 0.0248  # 9 degrees between the two averages of a limb's directions: it turns by 30 degrees a second
NEARER = 0.02  # by so much another pose must be nearer than the one that is held

NOTHING, ENTERED, HELD, LEFT = 0, 1, 2, 3


@entry_point(makes_arrays=False)
def match_frame(
    memory: NDArray[np.uint8], store: NDArray[np.uint8], positions: NDArray[np.float32], time: float
) -> int:
    """Process a frame; a function as readers have it.

    Args:
        memory: Of the performer; see `layout.py`.
        store: The bank.
        positions: (J, 3) float32 metres; NaN where a joint is missing.
        time: s.

    Returns:
        1 if a pose was entered, held or left, which stands in `happened`; else 0.
    """
    bank = open_bank(store)
    known = open_memory(memory, bank.head[0])
    state = known.state[0]
    state.happened = NOTHING
    if not is_new(state.frames, time, state.time, LEAST_SPACING) or state.due - EVERY < time < state.due:
        return 0
    continues = follows(state.frames, time, state.time)
    if not continues and state.active >= 0:
        _leave(known)
    if not continues:
        state.frames = 0
        state.near = -1
    seconds = time - state.time
    if not _measure(known, bank, positions, seconds):
        return 1 if state.happened else 0
    state.time = time
    state.due = time + EVERY - EARLY
    state.frames += 1
    if state.happened == NOTHING:
        _decide(known, bank, time)
    return 1 if state.happened else 0


@kernel
def _measure(known, bank, positions, seconds):
    """Average the directions of bones; return whether all joints that are needed are known."""
    state = known.state[0]
    started = state.frames > 0
    whole = place_pose(known.pose, bank, positions)
    if not whole and not started:
        return False
    if not started:
        state.facing[:] = 0.0
    if bank.head[0].girdles[0] >= 0:
        x, z = facing_of(known.pose, bank.head[0].girdles)
        smooth_facing(state.facing, x, z, seconds)
    _average(known, bank, seconds, started)
    return True


@inline_kernel
def _average(known, bank, seconds, started):
    """Let both averages of the directions follow."""
    cosine, sine = heading(known.state[0].facing[0], known.state[0].facing[1])
    quick = 1.0 - np.exp(-seconds / POSE_SMOOTHED) if started else 1.0
    slow = 1.0 - np.exp(-seconds / POSE_SETTLED) if started else 1.0
    for b in range(bank.bones.size):
        begin, end = bank.bones[b].begin, bank.bones[b].end
        x = np.float64(known.pose[end, 0] - known.pose[begin, 0])
        y = np.float64(known.pose[end, 1] - known.pose[begin, 1])
        z = np.float64(known.pose[end, 2] - known.pose[begin, 2])
        length = max(np.sqrt(x * x + y * y + z * z), 1e-6)
        x, z = turned_back(x, z, cosine, sine)
        for d, way in enumerate((x, y, z)):
            known.fast[b, d] += quick * (way / length - known.fast[b, d])
            known.slow[b, d] += slow * (way / length - known.slow[b, d])


@kernel
def _decide(known, bank, time):
    """See whether a pose is entered, held or left."""
    state = known.state[0]
    nearest, least = _nearest(known, bank)
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
        _leave(known)
    elif mean < FAR and worst < FAR_OF_LIMB:
        _stay(known, bank, best, time)
    elif time - state.seen > PATIENCE + EARLY:
        _leave(known)


@inline_kernel
def _same(bank, one, other):
    """Tell whether two poses have one name."""
    return bank.shown[one].name == bank.shown[other].name


@kernel
def _nearest(known, bank):
    """Return the nearest of the poses that are near, -1 for none, and its mean square of the chord."""
    found, least = -1, np.inf
    for p in range(bank.shown.size):
        mean, worst = _compare(known, bank, p)
        if mean < NEAR_POSE and worst < NEAR_OF_LIMB and mean < least:
            found, least = p, mean
    return found, least


@kernel
def _best_of_active(known, bank):
    """Return the mean square of the chord to the pose that is held, the largest of a limb, and of which example."""
    least, worst, best = np.inf, np.inf, known.state[0].active
    for p in range(bank.shown.size):
        if _same(bank, p, known.state[0].active):
            mean, largest = _compare(known, bank, p)
            if mean < least:
                least, worst, best = mean, largest, p
    return least, worst, best


@kernel
def _compare(known, bank, pose):
    """Compare the directions with a pose; return the mean square of the chord, and the largest of a limb."""
    chords = known.chords
    for b in range(chords.size):
        x, y, z = known.fast[b, 0], known.fast[b, 1], known.fast[b, 2]
        length = max(np.sqrt(x * x + y * y + z * z), 1e-6)
        row = bank.rows[pose, b]
        chords[b] = max(0.0, 2.0 - 2.0 * (x * row[0] + y * row[1] + z * row[2]) / length)
        if row[0] == row[1] == row[2] == 0.0:  # two joints of the pose are in one place
            chords[b] = 0.0
    total = 0.0
    for b in range(chords.size):
        total += chords[b]
    return total / chords.size, _largest(known, bank)


@kernel
def _largest_turn(known, bank):
    """Return how far the directions of a limb have turned lately, at most: mean square of the chord."""
    chords = known.chords
    for b in range(chords.size):
        chords[b] = 0.0
        for d in range(3):
            way = known.fast[b, d] - known.slow[b, d]
            chords[b] += way * way
    return _largest(known, bank)


@inline_kernel
def _largest(known, bank):
    """Return the largest mean of `chords` over the bones of a limb."""
    groups = known.groups
    groups[:, :] = 0.0
    for b in range(bank.bones.size):
        groups[0, bank.bones[b].limb] += known.chords[b]
        groups[1, bank.bones[b].limb] += 1.0
    largest = 0.0
    for g in range(groups.shape[1]):
        largest = max(largest, groups[0, g] / groups[1, g])
    return largest


@kernel
def _enter(known, bank, pose, time):
    state = known.state[0]
    state.is_held = 0
    state.start = state.since
    state.matched = 0
    state.number += 1
    state.rev = 1
    state.happened = ENTERED
    for b in range(known.strays.size):
        known.strays[b] = 0.0
    _count(known, bank, pose, time)


@kernel
def _stay(known, bank, pose, time):
    state = known.state[0]
    _count(known, bank, pose, time)
    if not state.is_held and time - state.start >= bank.shown[pose].hold - EARLY:
        state.is_held = 1
        state.rev += 1
        state.happened = HELD


@kernel
def _count(known, bank, pose, time):
    """Add how far the body strays to what it strayed since the start."""
    _compare(known, bank, pose)
    state = known.state[0]
    state.active = state.latest = pose
    state.seen = time
    state.matched += 1
    for b in range(known.strays.size):
        known.strays[b] += known.chords[b]


@kernel
def _leave(known):
    state = known.state[0]
    state.active = -1
    state.rev += 1
    state.happened = LEFT
