"""Labels of candidates: which candidates end a repetition, and which lie inside one.

While the performer repeats a movement, as counted in `repetitions`, every candidate of Algorithm 2 gets a label when it
is `LABELLED_AFTER` old, or decided. In a recording, where nothing is decided before a take ends, it waits for
`LABELLED_LATE`: by then even the first repetitions of a bout are counted. It is compared with all candidates within
half a period around it. It ends a repetition if it is the best of them: slowest, nearest to the rest pose, and nearest
to where one repetition ends and the next begins. The first two weigh what they do as evidence of a key frame. Only even
bouts are labelled, whose longest period is at most twice the shortest: beats of gestures are alike in shape, but uneven
in time, and people do not cut at them. What it is compared with is fixed, so that the label is the same whatever the
window of Algorithm 3 holds.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.pose_history import MARGIN
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.repetitions.alike import LONGEST_RATIO
from mossar_stream.repetitions.state import ANALYSIS_INTERVAL, StoredSamples
from mossar_stream.repetitions.timing import LONGEST_SILENCE
from mossar_stream.similarity.evidence import SPEED_FLOOR_OF_ODDS, WEIGHTS

NOTED_CANDIDATES = 32  # remembered on a stream,
NOTED_LATE = 256  # and of a recording
LABELLED_AFTER = 1.5 - 1e-6  # s; a little less, for the rounding of timestamps
# s; the first repetitions of a take are counted 3 to 8 s after it began. Labelled recordings of exercises (UI-PRMD): final
# F1 0.804 instead of 0.781, other sets within 0.003.
LABELLED_LATE = 12.0 - 1e-6
# s, a longer period has no labels: half of it is more than the 3 s that a key frame waits, so what it would be compared
# with is still to come.
LONGEST_PERIOD = 6.0
NEAREST_END = 0.75  # periods between two repetitions' ends, at least
OFF_BOUND = 5.0  # log odds a period, of the time from where one repetition ends and the next begins
UNLABELLED, ENDS, WITHIN = np.arange(3)  # labels: no repetition, end of one, inside one

LABELS = np.dtype(
    [
        ("last_time", "f8"),  # s, end of the last repetition
        ("candidates", "i8"),  # noted so far
        ("labelled", "i8"),  # of them
    ],
)
NOTE = np.dtype(
    [
        ("time", "f8"),  # s, of Algorithm 2's frame
        ("reported", "f8"),  # s, reported time
        ("cost", "f8"),  # how unlike the end of a repetition it is
    ]
)


class RepetitionLabels(NamedTuple):
    """What is needed to label candidates, as the functions below need it."""

    state: np.void  # LABELS
    notes: NDArray[np.void]  # (NOTED_CANDIDATES or NOTED_LATE,) NOTE, ring
    periods: NDArray[np.void]  # (1,) PERIODS of the performer's repetitions


class RepetitionRecords(NamedTuple):
    """The repetitions of a performer, as frames need them."""

    headers: NDArray[np.void]  # (1,) HEADER
    samples: StoredSamples


@kernel
def start_labels(state):
    """Begin a take."""
    state.last_time = -np.inf
    state.candidates = 0
    state.labelled = 0


@inline_kernel
def note_candidate(labels, time, reported, rest_distance, speed):
    """Remember a candidate that Algorithm 2 accepted.

    Args:
        labels: RepetitionLabels.
        time: s, of the candidate.
        reported: s, reported time.
        rest_distance: Distance from the pose in which the performer dwells, in A.
        speed: In V.
    """
    note = labels.notes[labels.state.candidates % len(labels.notes)]
    note.time = time
    note.reported = reported
    note.cost = WEIGHTS.rest_distance * rest_distance + (WEIGHTS.stop - WEIGHTS.rest) * np.log(
        speed + SPEED_FLOOR_OF_ODDS
    )
    labels.state.candidates += 1


@inline_kernel
def due_label(labels, delay):
    """Return when the next candidate must be judged, s; inf if none waits."""
    state = labels.state
    if state.labelled == state.candidates:
        return np.inf
    return labels.notes[state.labelled % len(labels.notes)].time + delay


@kernel
def label_candidate(labels):
    """Return the label of the oldest candidate that has none."""
    state = labels.state
    number = state.labelled
    state.labelled += 1
    if state.candidates - number > len(labels.notes):
        return UNLABELLED
    note = labels.notes[number % len(labels.notes)]
    period = _period_at(labels.periods[0], note.reported)
    if not 0.0 < period <= LONGEST_PERIOD + MARGIN:
        return UNLABELLED
    best, least = number, np.inf
    for other in range(max(0, state.candidates - len(labels.notes)), state.candidates):
        candidate = labels.notes[other % len(labels.notes)]
        if abs(candidate.reported - note.reported) > 0.5 * period + MARGIN:
            continue
        off = _off_bound(labels.periods[0], candidate.reported) / period
        cost = candidate.cost + OFF_BOUND * off
        if cost < least:
            best, least = other, cost
    if best != number or note.reported - state.last_time < NEAREST_END * period - MARGIN:
        return WITHIN
    state.last_time = note.reported
    return ENDS


@kernel
def _period_at(periods, time):
    """Return the period of the even bout that a time lies in, or goes on to, s; 0 if it lies in none."""
    if periods.clear == 0:
        return 0.0
    at = time - periods.origin
    for place in range(periods.cycles - 1, -1, -1):
        cycle = periods.cycle[place]
        period = _duration(cycle)
        silence = LONGEST_SILENCE * period + ANALYSIS_INTERVAL if place == periods.cycles - 1 else 0.0
        if at >= cycle.begins - MARGIN:
            goes_on = at <= cycle.ends + silence + MARGIN
            return period if goes_on and _is_even(periods, place) else 0.0
    return 0.0


@kernel
def _is_even(periods, place):
    """Tell whether all periods of a repetition's bout are alike."""
    first = last = place
    while first > 0 and periods.cycle[first].count > 1:
        first -= 1
    while last + 1 < periods.cycles and periods.cycle[last + 1].count > 1:
        last += 1
    shortest, longest = np.inf, 0.0
    for i in range(first, last + 1):
        period = _duration(periods.cycle[i])
        shortest, longest = min(shortest, period), max(longest, period)
    return longest <= LONGEST_RATIO * shortest + MARGIN


@inline_kernel
def _duration(cycle):
    """Return the period at a repetition, s; of the first of a bout how long it took."""
    return cycle.ends - cycle.begins if np.isnan(cycle.period) else cycle.period


@kernel
def _off_bound(periods, time):
    """Return how far a time is from where a repetition begins or ends, after the last one from where one should, s."""
    at = time - periods.origin
    off = np.inf
    for place in range(periods.cycles - 1, -1, -1):
        cycle = periods.cycle[place]
        if place == periods.cycles - 1 and at > cycle.ends:
            period = _duration(cycle)
            steps = (at - cycle.ends) / period
            off = abs(steps - np.rint(steps)) * period
        off = min(off, abs(at - cycle.begins), abs(at - cycle.ends))
        if cycle.ends < at - off:  # those before are farther away
            break
    return off


@inline_kernel
def forget_newest(labels):
    """Forget the newest candidate, which was taken back."""
    state = labels.state
    state.candidates -= 1
    state.labelled = min(state.labelled, state.candidates)
