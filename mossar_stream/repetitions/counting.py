"""Counting: an analysis of the window every second, and what it changes of what was counted before.

Each of the leading components, begun at its maxima or at its minima, proposes cycles. The proposal that covers most of
the window with cycles that are alike wins, with a bonus for beginning where cycles were counted before. It replaces
what was counted in the last part of the window; what is older stands.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import entry_point, kernel
from mossar_stream.jit.views import part
from mossar_stream.repetitions.alike import (
    alternation,
    copy_cycles,
    crossing,
    cycles_between,
    describe_all,
    duration,
    goes_on,
    join_pairs,
    keep_alike,
    recurring,
    rest_pose_nearness,
)
from mossar_stream.repetitions.anchoring import LONGEST_PAUSE, straightening, turn_chains, weigh
from mossar_stream.repetitions.components import find_components, smooth_scores
from mossar_stream.repetitions.sampling import STAMP_ROUNDING, append_sample
from mossar_stream.repetitions.state import (
    COMPONENTS,
    CYCLES,
    HEADER,
    LEAST_SAMPLES,
    PERIODS,
    PERIODS_AT,
    RECENT,
    ROOM_AT,
    SAMPLES,
    SAMPLES_AT,
    SCRATCH,
    copy_periods,
    note_analysis,
    ring_place,
    views,
    window_size,
)
from mossar_stream.repetitions.timing import time_at, time_cycles
from mossar_stream.repetitions.turning import HYSTERESIS, swing_range, turning_points

PROPOSING, SMOOTHED_PROPOSING = 3, 2  # components, and of those how many smoothed, too
OPEN_TO_CHANGE = 0.5  # of the window
NEAR_REST_POSE = 0.4  # for beginning nearer to how the take began
HALVES = 0.29  # how much better every second cycle agrees if cycles are halves
BONUS = 0.34  # for beginning where cycles were counted before
UPRIGHT = 0.6  # for beginning where limbs are straighter and upright
RECURRING = 1.0  # for a whole posture that recurs one cycle later: halves of cycles have it less
MOST_PREFERRED = (1.0 + BONUS) * (1.0 + NEAR_REST_POSE) * (1.0 + UPRIGHT) * (1.0 + RECURRING)
MUCH_LESS = (
    0.6  # of the range of the window, which the last `RECENT` samples swing if they followed another posture
)
NEAR_BOUNDARY = 0.15  # of a cycle
OVERLAP = 0.45  # of the shorter of two cycles, by which they may overlap
LEAST_LEAD = 0.2  # of a cycle, that is shown before the first one,
WHOLE = 0.75  # and with what is shown after the last one makes up one more
LEAST_GAP, LONGEST_GAP = 0.76, 2.1  # cycles, that were missed if the movement went on
SWING_GOES_ON = 0.54  # of a swing
DOUBTFUL = 5  # windows, for which unreported cycles are kept

WIDTHS = (1, 3, 7)  # samples over which scores are smoothed: what is uneven within a cycle is not its end
LEAST_WIDTHS = 3.0  # that a cycle lasts: of shorter ones, smoothing leaves too little
SHARE_POWER = 0.32  # power of the share of the movement that a component has


@entry_point(makes_arrays=False)
def analyse(
    state: NDArray[np.uint8], store: NDArray[np.uint8], _position: NDArray[np.float32], time: float
) -> int:
    """Analyse the window as often as is due before a frame: a function as readers have it.

    Args:
        state: Bytes of what is counted: `HEADER`, `PERIODS` from `PERIODS_AT` on, the samples from `SAMPLES_AT` on.
        store: Bytes in which an analysis works, see `store_size`.
        time: s, of the frame; inf to analyse what there is, once.

    Returns:
        1 if that changed what is counted, else 0.
    """
    header = part(state, 0, HEADER, (1,))[0]
    memory = part(state, SAMPLES_AT, np.uint8, (len(state) - SAMPLES_AT,))
    scratch = part(store, 0, SCRATCH, (1,))[0]
    room = part(store, ROOM_AT, np.float32, ((len(store) - ROOM_AT) // 4,))
    samples = views(memory, room, header.joints)
    if time == np.inf:
        if header.begun == 0:
            return 0
        append_sample(header, samples, samples.before)
    elif time < header.due:
        return 0
    changed = _analyse_once(header, samples, scratch)
    copy_periods(part(state, PERIODS_AT, PERIODS, (1,))[0], header)
    return 1 if changed else 0


@kernel
def _analyse_once(header, samples, scratch):
    """Analyse the window and renew what is counted in it; return whether anything changed."""
    note_analysis(header)
    if window_size(header) < LEAST_SAMPLES:
        return False
    n = find_components(header, samples, scratch)
    _choose_proposal(header, samples, n, scratch)
    winner = scratch.winner
    if winner.count == 0:
        return False
    was_clear = header.clear
    header.clear |= winner.clear
    changed = _renew(header, samples, n, scratch)
    if header.clear and not was_clear:
        _forget_doubtful(header)
        header.changed = 0
        time_cycles(header, header.changed)
        return header.cycles > 0
    if changed:
        time_cycles(header, header.changed)
    return changed and header.clear == 1


@kernel
def _forget_doubtful(header):
    """Forget cycles from long before it became clear that a movement repeats."""
    first = 0
    while first < header.cycles and header.cycle[first].end < header.open - DOUBTFUL * SAMPLES:
        first += 1
    for q in range(first, header.cycles):
        header.cycle[q - first] = header.cycle[q]
    header.cycles -= first
    header.dropped = 0


@kernel
def _choose_proposal(header, samples, n, scratch):
    """Set the proposal that wins, and its cycles; the smoothed scores are those in which it was found."""
    winner = scratch.winner
    winner.covered, winner.count, winner.clear = 0.0, 0, 0
    spread = np.float64(1e-12)
    for k in range(COMPONENTS):
        spread += _square(samples.scores[k], n)
    for width in WIDTHS:
        smooth_scores(samples, n, width)
        for k in range(PROPOSING if width == 1 else SMOOTHED_PROPOSING):
            share = (_square(samples.smooth[k], n) / spread) ** SHARE_POWER
            if n * share * MOST_PREFERRED <= winner.covered:
                continue  # it cannot win
            before = winner.covered
            _propose(header, samples, (n, k, width, share), scratch)
            if winner.covered > before:
                winner.width = width
    if winner.count > 0 and winner.width != WIDTHS[-1]:
        smooth_scores(samples, n, winner.width)


@kernel
def _propose(header, samples, what, scratch):
    """Let cycles of one component win if they cover more: with the hysteresis for the window, and for its last part.

    Args:
        header: `HEADER` record.
        samples: `Samples`.
        what: How many samples there are, the component, over how many it is smoothed, its share of the movement.
        scratch: `SCRATCH` record.
    """
    n, k, _, _ = what
    scores, whole = samples.smooth[k], np.float32(0.0)
    # One call for both: code that is read once a second takes longer to fetch than to run.
    for half in range(2 if n > RECENT else 1):
        begin = half * (n - RECENT)
        swing = swing_range(scores[begin:n], n - begin, scratch.counts)
        if swing <= 0 or swing < scratch.least:
            return
        if half == 0:
            whole = swing
        elif swing > MUCH_LESS * whole:
            return
        _propose_turns(header, samples, what, scratch, np.float32(HYSTERESIS) * swing)


@kernel
def _propose_turns(header, samples, what, scratch, least):
    """Let cycles between turning points, begun at maxima and at minima, win if they cover more.

    Args:
        header: `HEADER` record.
        samples: `Samples`.
        what: See `_propose`.
        scratch: `SCRATCH` record.
        least: Hysteresis.
    """
    n, k, width, share = what
    winner, scores, kept = scratch.winner, samples.smooth[k], scratch.kept
    found = turning_points(scores, n, least, scratch.turns)
    for direction in (1, -1):
        count = cycles_between(scratch.turns, found, direction, n == header.open, scratch.cycles)
        if count < 2:
            continue
        span = scratch.cycles[2, count - 1] - scratch.cycles[0, 0]
        if span * share * MOST_PREFERRED <= winner.covered:
            continue  # it cannot win
        describe_all(samples, k, scratch.cycles, count, scratch)
        halves = alternation(scratch.cycles, count, scratch) > HALVES
        for way in range(3 if halves else 1):  # as they are; joined from the first; from the second
            if way == 0:
                left = count
                copy_cycles(scratch.cycles, count, kept)
            else:
                left = join_pairs(scores, scratch.cycles, count, way - 1, kept)
                describe_all(samples, k, kept, left, scratch)
            left, covered, clear = keep_alike(scores, kept, left, scratch.alike)
            if left == 0 or (width > 1 and duration(kept, left) < LEAST_WIDTHS * width * left):
                continue
            covered *= share
            if covered * MOST_PREFERRED <= winner.covered:
                continue  # it cannot win, and saying how preferred it is takes long
            covered *= _preference(header, samples, n, kept, left)
            if covered > winner.covered:
                winner.covered, winner.count, winner.component, winner.clear = covered, left, k, int(clear)
                copy_cycles(kept, left, scratch.best)


@kernel
def _preference(header, samples, n, cycles, count):
    """Return the weight of a proposal: it recurs, begins where cycles began before, where limbs are straight and upright, and at home."""
    weight = 1.0 + BONUS * _agreeing(header, n, cycles, count)
    weight *= 1.0 + RECURRING * recurring(samples.scores, cycles, count)
    weight *= 1.0 + UPRIGHT * straightening(header, samples, cycles, count)
    return weight * (1.0 + NEAR_REST_POSE * rest_pose_nearness(samples, cycles, count))


@kernel
def _square(row, n):
    total = 0.0
    for i in range(n):
        total += float(row[i]) * float(row[i])
    return total


@kernel
def _agreeing(header, n, cycles, count):
    """Return the share of proposed cycles that begin where one was counted before."""
    if count == 0:
        return 0.0
    hits = 0
    oldest = header.open - n
    for i in range(count):
        slack = max(2.0, NEAR_BOUNDARY * (cycles[2, i] - cycles[0, i]))
        for q in range(header.cycles - 1, -1, -1):
            apart = cycles[0, i] + oldest - header.cycle[q].start
            if abs(apart) <= slack:
                hits += 1
            if apart >= -slack:
                break
    return hits / count


@kernel
def _renew(header, samples, n, scratch):
    """Replace the counted cycles that the window shows anew; return whether anything changed."""
    component, cycles, proposed = scratch.winner.component, scratch.best, scratch.missed
    oldest = header.open - n
    settled = header.open - OPEN_TO_CHANGE * SAMPLES
    middle = 2 * (oldest + cycles[0, 0])
    before, header.changed = header.cycles, -1
    while header.cycles > 0:
        last = header.cycle[header.cycles - 1]
        if last.end <= settled or last.start + last.end <= middle:
            break
        header.cycles -= 1
    for i in range(scratch.winner.count):
        start, end = oldest + cycles[0, i], oldest + cycles[2, i]
        last, missed = start, 0
        if header.cycles > 0:
            before_it = header.cycle[header.cycles - 1]
            last = before_it.end
            if start < last - OVERLAP * min(end - start, last - before_it.start):
                continue
            missed = _missed(samples.smooth[component], cycles[:, i], max(last - oldest, 0))
        for q in range(missed + 1):
            for k in range(3):
                proposed[k] = cycles[k, i]
            if q < missed:
                proposed[0] = last - oldest + q * (start - last) // missed
                proposed[2] = last - oldest + (q + 1) * (start - last) // missed
                proposed[1] = (proposed[0] + proposed[2]) // 2
            before = _write(header, samples, component, proposed, oldest, before)
            row = header.cycle[header.cycles - 1]
            if q < missed:  # what was not alike does not say when it is half way
                row.out = 0.75 * row.leaves + 0.25 * row.arrives
                row.back = 0.25 * row.leaves + 0.75 * row.arrives
                row.straighter = row.resting = 0.0
            else:
                weigh(header, samples, component, proposed, row)
        if i + 1 == scratch.winner.count or cycles[0, i + 1] > cycles[2, i]:
            limit = n - 1 if i + 1 == scratch.winner.count else cycles[0, i + 1]
            before = _go_on(header, samples, (n, oldest, component, limit), proposed, before)
    turn_chains(header)
    if header.changed < 0 and header.cycles != before:
        header.changed = header.cycles
    if header.changed > 0 and header.changed < header.cycles and header.cycle[header.changed].count > 1:
        header.changed -= 1  # its end is where this one begins
    return header.changed >= 0


@kernel
def _go_on(header, samples, what, cycle, before):
    """Append one repetition more if what was shown before the first cycle and after the last make up one.

    Cycles begin at an extreme, movements need not.

    Args:
        header: `HEADER` record.
        samples: `Samples`.
        what: How many samples there are, the number of the oldest, the component, the sample up to which to look.
        cycle: (3,) start, far extreme, end of the last cycle.
        before: How many cycles there were before the analysis.
    """
    n, oldest, component, limit = what
    lead = header.cycle[header.cycles - 1].lead
    if lead < LEAST_LEAD:
        return before
    shown, last = goes_on(header, n, samples.smooth, cycle, 1, limit)
    if lead + shown < WHOLE or last <= cycle[2]:
        return before
    row = header.cycle[header.cycles - 1]
    straighter, resting, lasts = row.straighter, row.resting, row.out - row.leaves
    cycle[0], cycle[1], cycle[2] = cycle[2], last, last
    before = _write(header, samples, component, cycle, oldest, before)
    row = header.cycle[header.cycles - 1]
    row.straighter, row.resting = straighter, resting
    row.out, row.back = min(row.leaves + lasts, row.arrives), row.arrives
    return before


@kernel
def _missed(scores, cycle, begin):
    """Return how many cycles were missed between an earlier one and this: the movement went on, but not alike."""
    gap, period = cycle[0] - begin, cycle[2] - cycle[0]
    if gap < LEAST_GAP * period or gap > LONGEST_GAP * period:
        return 0
    low = high = scores[begin]
    for i in range(begin, cycle[0]):
        low, high = min(low, scores[i]), max(high, scores[i])
    if high - low < np.float32(SWING_GOES_ON) * abs(scores[cycle[1]] - scores[cycle[0]]):
        return 0
    return int(gap / period + 0.5)


@kernel
def _write(header, samples, component, cycle, oldest, before):
    """Append a counted cycle, with its number in the bout; return how many cycles there were before the analysis."""
    if header.cycles == CYCLES:
        for q in range(CYCLES - 1):
            header.cycle[q] = header.cycle[q + 1]
        header.dropped += 1
        header.cycles -= 1
        before -= 1
        header.changed = max(header.changed - 1, -1 if header.changed < 0 else 0)
    start, far, end = oldest + cycle[0], oldest + cycle[1], oldest + cycle[2]
    place = header.cycles
    header.cycles += 1
    row = header.cycle[place]
    same = place < before and abs(row.start - start) <= 1 and abs(row.end - end) <= 1
    if not same and header.changed < 0:
        header.changed = place
    row.start, row.far, row.end = start, far, end
    _measure(header, samples, component, cycle, header.open - oldest, row)
    row.count, row.lead = 1, 0.0
    if place > 0:
        last = header.cycle[place - 1]
        if row.leaves - last.arrives <= LONGEST_PAUSE * (row.arrives - row.leaves) + STAMP_ROUNDING:
            row.count, row.lead = last.count + 1, last.lead
    if row.count == 1:
        limit = 0 if place == 0 else max(header.cycle[place - 1].end - oldest, 0)
        if limit < cycle[0]:
            row.lead, _ = goes_on(header, header.open - oldest, samples.smooth, cycle, -1, limit)
    return before


@kernel
def _measure(header, samples, component, cycle, n, row):
    """Set times, amplitude and the leading joint of a cycle of which the window holds at least the end."""
    scores, smooth = samples.scores[component], samples.smooth[component]
    start, far, end = max(cycle[0], 0), max(cycle[1], 0), cycle[2]
    row.leaves = header.left[ring_place(header, n, start)]
    row.out = time_at(header, n, crossing(smooth, start, far, 0.5))
    place = ring_place(header, n, far)
    row.turns = 0.5 * (header.at[place] + header.left[place])
    row.back = time_at(header, n, crossing(smooth, np.int64(end), far, 0.5))
    row.returning = int(end >= n - 2)
    row.arrives = header.at[ring_place(header, n, end)]
    swing = abs(scores[far] - np.float32(0.5) * (scores[start] + scores[end]))
    row.amplitude = float(swing) / np.sqrt(float(header.joints))
    row.joint = _leading_joint(header, samples.axes[component])


@kernel
def _leading_joint(header, axis):
    """Return the joint that moves most along an axis."""
    most, leading = np.float32(-1.0), 0
    for j in range(header.joints):
        square = axis[3 * j] ** 2 + axis[3 * j + 1] ** 2 + axis[3 * j + 2] ** 2
        if square > most:
            most, leading = square, j
    return leading
