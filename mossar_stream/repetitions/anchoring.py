"""Where repetitions begin: at which of the two extremes of a cycle.

A rest says where: the extreme where the movement dwells, that is nearer to the pose in which the take began, and where
limbs are straighter and upright (standing, hanging, arms down: what costs least effort), as people who label recordings
see it, too. What speaks for either is summed over all cycles of a chain, whose neighbours follow without a seam, and
decided for all of them: also for those that were reported before.
"""

import math

from mossar_stream.jit.decorators import kernel
from mossar_stream.repetitions.alike import dwelling_of, rest_pose_distances
from mossar_stream.repetitions.state import ring_place, window_size

DWELL, BOUT_NEAR_REST_POSE = (
    0.3,
    0.7,
)  # how much speaks for an extreme where the movement dwells, and that is nearer to the rest pose
STRAIGHTER = 0.16  # of the length of limbs: more hardly speaks louder
LEAN = 0.15  # for leaving it as it is
LONGEST_PAUSE = 1.5  # cycles, within a bout
SEAM = 0.25  # of a cycle, by which neighbours of a chain may overlap or be apart: more shows that one was found anew


@kernel
def weigh(header, samples, component, cycle, row):
    """Note what speaks for the begin of a cycle against its other extreme.

    Args:
        header: `HEADER` record.
        samples: `Samples`.
        component: The one whose turning points these are.
        cycle: (3,) start, far extreme, end.
        row: `CYCLE` record, in and out.
    """
    start, far, end = cycle[0], cycle[1], cycle[2]
    n = window_size(header)
    dwelling, away = dwelling_of(header, n, samples.smooth[component], start, far, end)
    near, distant = rest_pose_distances(samples, start, far)
    row.resting = DWELL * (dwelling - away) / max(dwelling + away, 1e-3)
    row.resting += BOUT_NEAR_REST_POSE * (distant - near) / max(near + distant, 1e-9)
    ends = 0.5 * (_straightness(header, samples, start) + _straightness(header, samples, end))
    row.straighter = ends - _straightness(header, samples, far)


@kernel
def straightening(header, samples, cycles, count):
    """Return how much straighter and more upright limbs are where cycles begin than at their other extreme, from -1 to 1."""
    total = 0.0
    for i in range(count):
        total += _straightness(header, samples, cycles[0, i]) - _straightness(header, samples, cycles[1, i])
    return math.tanh(total / count / STRAIGHTER)


@kernel
def _straightness(header, samples, i):
    """Return the mean over a sample of the window and its neighbours."""
    n = window_size(header)
    total, count = 0.0, 0
    for q in range(max(i - 1, 0), min(i + 2, n)):
        total += float(samples.straight[ring_place(header, n, q)])
        count += 1
    return total / count


@kernel
def turn_chains(header):
    """Decide for each chain of cycles at which extreme they begin; `changed` tells of the first that this changes."""
    first = 0
    while first < header.cycles:
        last, straighter, resting = first, 0.0, 0.0
        while True:
            straighter += header.cycle[last].straighter
            resting += header.cycle[last].resting
            last += 1
            if last == header.cycles or not _follows(header.cycle[last - 1], header.cycle[last]):
                break
        lean = LEAN if header.cycle[first].turned == 0 else -LEAN
        count = last - first
        turned = math.tanh(straighter / count / STRAIGHTER) + resting / count + lean < 0
        for q in range(first, last):
            if header.cycle[q].turned != int(turned):
                header.cycle[q].turned = int(turned)
                header.changed = q if header.changed < 0 else min(header.changed, q)
        first = last


@kernel
def _follows(before, cycle):
    """Return whether a cycle follows another without a seam."""
    gap, period = cycle.start - before.end, cycle.end - cycle.start
    return abs(gap) < SEAM * period
