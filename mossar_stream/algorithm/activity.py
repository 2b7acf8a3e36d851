r"""Activity: whether the performer moves or rests, reported while it happens.

The signal is the rms speed of the joints over the last tenth of a second, which every level measures for its features.
Two lines make the hysteresis: the performer moves once the speed has been above the upper line for `ONSET_CONFIRMED`;
after exact stillness, which shows that there is no noise, the first frame above it is enough. A rest needs a speed below
the lower line for the setting `rest_seconds`, so a turning point is not a rest. Both lines rise with what the sensor's
noise adds to the speed.

    speed    ___/‾‾‾\_/‾‾‾‾\_______________
                ^start           ^start of the rest
    moving       ├──────────────────┤ ... reported after rest_seconds

The latest bouts are kept, so that a segment knows when the performer moved in it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.candidate_features import SMOOTHING
from mossar_stream.algorithm.pose_history import MARGIN, SPEED_WINDOW
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.event_buffer import ACTIVITY_CHANGE, next_event
from mossar_stream.memory.joint_pages import LINES, LIVE, LOG_SPEED, place

# m/s, rms over the joints. Labelled recordings rest at 0.02 to 0.03, and turn at less than 0.06 for a frame or two.
UPPER_LINE, LOWER_LINE = 0.06, 0.04
# Times what the noise adds to the speed, and, to begin to move, times what it adds as it is now, which follows joints that
# jump. In ten minutes of standing with 5 mm of noise two frames in a row reach 2.7 and 2.1 times at most, those of limbs
# included.
UPPER_NOISE, UPPER_NOISE_NOW, LOWER_NOISE = 2.5, 2.2, 2.0
ONSET_CONFIRMED = 0.03  # s above the upper line: a second frame at 30 Hz
ACTIVITY_SETTLING = (
    0.15  # s at the start of a take, in which the speed spans too little time and noise is not known
)
BRIEF_BOUT = 0.15  # s; a bout that reaches into a segment for so long at most does not count in it
IS_RESTING, IS_MOVING = np.arange(2)  # as events.SEGMENT_STATES
BOUTS = 6  # kept on a stream, the oldest two becoming one

ACTIVITY_STATE = np.dtype(
    [
        ("moving", "i4"),
        ("changed", "i4"),  # whether that is still to be reported
        ("number", "i4"),  # changes in this take
        ("joint", "i4"),  # the fastest one when the performer began to move
        ("bouts", "i8"),  # that are kept
        ("since", "f8"),  # s, when the state began; the take's start at first
        ("before", "f8"),  # s, how long the state before it lasted; NaN at first
        # s; of a performer who rests the first frame above the upper line, inf if there is none; of one who moves the
        # last one above the lower line
        ("above", "f8"),
    ],
)
BOUT = np.dtype([("begin", "f8"), ("end", "f8")])  # s


class Activity(NamedTuple):
    """Whether the performer moves, as the functions below need it."""

    state: np.void  # ACTIVITY_STATE
    bouts: NDArray[np.void]  # (bouts,) BOUT, from the oldest to the newest that has ended


@kernel
def start_activity(state, time):
    """Begin a take at rest."""
    state.moving = state.changed = state.number = 0
    state.joint = -1
    state.bouts = 0
    state.since = time
    state.before = np.nan
    state.above = np.inf


@inline_kernel
def follow_activity(activity, body, speed, noises, moment, rest_seconds):
    """Process the speed of a frame.

    Args:
        activity: Activity; `state.changed` is set where the state changes.
        body: See joint_pages.py; the log speeds are those of the frame.
        speed: m/s, rms over the joints.
        noises: m/s, what the sensor's noise adds to it: at its quietest of late, and as it is now.
        moment: s, and whether nothing at all had moved before: a speed above the line then counts at once.
        rest_seconds: s.
    """
    state = activity.state
    noise, noise_now = noises
    time, after_stillness = moment
    if state.moving == 1:
        if speed > max(LOWER_LINE, LOWER_NOISE * noise):
            state.above = time
        elif time - state.above >= rest_seconds - MARGIN:
            _rest(activity)
    elif speed > max(UPPER_LINE, UPPER_NOISE * noise, UPPER_NOISE_NOW * noise_now):
        state.above = min(state.above, time)
        is_settled = state.number > 0 or time - state.since >= ACTIVITY_SETTLING - MARGIN
        if after_stillness or (is_settled and time - state.above >= ONSET_CONFIRMED - MARGIN):
            state.joint = _fastest(body)
            _change(state, IS_MOVING)
            state.above = time
    else:
        state.above = np.inf


@kernel
def rests_at_end(activity, time):
    """Let a performer rest who was below the line in the last frame of a take, and tell whether that is so."""
    state = activity.state
    if state.moving == 0 or not state.above < time:
        return False
    _rest(activity)
    return True


@inline_kernel
def noises_of_speed(noise, joints, is_filtered):
    """Return what the sensor's noise adds to the speed, m/s: at its quietest of late, and as it is now.

    Args:
        noise: NOISE.
        joints: How many can move relative to the centre.
        is_filtered: Whether the speed is that of poses in the low-pass filter, see candidate_features.noise_of_speed.
    """
    if noise.step <= 0.0 or (noise.known == 0 and noise.silent == 1):
        return 0.0, 0.0
    now = max(noise.estimate, noise.aside)
    quietest = min(now, noise.quietest) if noise.quietest > 0.0 else now
    added = noise.step / SPEED_WINDOW / joints
    if is_filtered:
        share = noise.step / (noise.step + SMOOTHING)
        added *= np.sqrt(share / (2.0 - share))
    return quietest * added, now * added


@kernel
def _rest(activity):
    """Let a performer rest who has moved."""
    _keep_bout(activity)
    _change(activity.state, IS_RESTING)


@kernel
def _change(state, moving):
    """Change the state, which began at `above`; resting, the performer waits for a first frame above the line."""
    state.before = state.above - state.since if state.number > 0 else np.nan
    state.since = state.above
    state.above = np.inf
    state.moving = moving
    state.number += 1
    state.changed = 1


@kernel
def _fastest(body):
    """Return the joint that moves fastest; -1 if there is none."""
    best, most = -1, -np.inf
    for j in range(len(body) // LINES):
        k = place(j)
        if body[k + LIVE] > 0.0 and body[k + LOG_SPEED] > most:
            best, most = j, body[k + LOG_SPEED]
    return best


@kernel
def _keep_bout(activity):
    """Keep the bout that ends."""
    state, bouts = activity.state, activity.bouts
    if state.bouts == len(bouts):
        bouts[0].end = bouts[1].end
        for i in range(1, len(bouts) - 1):
            bouts[i].begin, bouts[i].end = bouts[i + 1].begin, bouts[i + 1].end
        state.bouts -= 1
    bouts[state.bouts].begin, bouts[state.bouts].end = state.since, state.above
    state.bouts += 1


@kernel
def active_span(activity, begin, end, path, late):
    """Return when the performer first and last moved in a segment, s; NaN if nothing moved.

    Args:
        activity: Activity.
        begin: s, of the segment.
        end: s.
        path: m, of all joints in the segment.
        late: s, by which bouts begin later than the key frames that are reported of them.
    """
    state, bouts = activity.state, activity.bouts
    first = last = np.nan
    if not path > 0.0:
        return first, last
    for i in range(state.bouts + state.moving):
        is_over = i < state.bouts
        bout_begin = bouts[i].begin if is_over else state.since
        bout_end = bouts[i].end if is_over else state.above
        if _counts(bout_begin, bout_end, begin, end, late):
            first = min(max(bout_begin, begin), end) if np.isnan(first) else first
            last = max(min(bout_end, end), first)
    return first, last


@inline_kernel
def _counts(bout_begin, bout_end, begin, end, late):
    """Tell whether a bout is one of a segment: a brief one where it begins, others where more than `BRIEF_BOUT` lies."""
    if bout_end - bout_begin <= 2.0 * BRIEF_BOUT + late + MARGIN:
        return begin - MARGIN <= bout_begin - late < end - MARGIN
    inside = min(bout_end, end) - max(bout_begin, begin)
    covers = bout_begin <= begin + MARGIN and bout_end >= end - MARGIN
    return inside > BRIEF_BOUT + MARGIN or covers


@kernel
def put_activity(clock, events, state):
    """Put the change of state into the event buffer."""
    state.changed = 0
    event = next_event(clock, events, ACTIVITY_CHANGE)
    event.nature = state.moving
    event.id = state.number
    event.time = state.since
    event.until_time = clock.time
    event.strength = state.before
    event.joint0 = state.joint
