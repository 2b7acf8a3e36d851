"""Open segment: what came since the last key frame, and how splitter and window part it.

Frames since the last key frame lie in three summaries: those up to the candidate (`settled`), those after it
(`since`), and those of a plateau that may yet become a candidate (`run`). The last frame waits outside, because
the next one tells whether it was a minimum. When a candidate is confirmed, `settled` is the segment before it and
`since` the beginning of the one after it; nothing is replayed.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.splitter import (
    ACCEPTED,
    CROSSED,
    FORGOTTEN,
    REPLACED,
    follow_curve,
    forget_candidate,
)
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.joint_pages import PAGE, PAGE_SIZE, SUM_PATH, SUM_X
from mossar_stream.memory.slots import allocate, empty
from mossar_stream.similarity.protocol import add_frame, flush_sums, merge_into
from mossar_stream.similarity.summary import SummaryFrame

MOST_WAITING = 32  # frames, in single precision: their sums are good to a millionth
NO_SLOT = np.int64(-1)
OPEN_SEGMENT = np.dtype(
    [
        ("settled", "i8"),  # slot of the frames up to the candidate
        ("since", "i8"),  # slot of those after it
        ("run", "i8"),  # slot of those of the current run of equal values
        ("closed", "i8"),  # slot of the segment that a key frame ended, -1 if none
        ("fed", "i8"),  # slot that the sums in the body belong to
        ("waiting", "i8"),  # frames in them
        ("last_time", "f8"),  # s, of the last frame, which is in no summary yet
        ("last_weight", "f8"),  # s
        ("last_moving", "i8"),
        ("last_speed", "f8"),  # m/s, rms of the joints, see scales.py
    ],
)


class OpenSegment(NamedTuple):
    """The open segment, as the functions below need it."""

    plan: np.void  # PLAN
    state: np.void  # OPEN_SEGMENT
    slots: np.void  # SLOTS
    params: np.void  # of the similarity measure
    unused: NDArray[np.int64]  # (slots,) stack of unused slots
    summaries: NDArray[np.float64]  # (slots, slot)
    body: NDArray[np.float32]  # see joint_pages.py
    pose: NDArray[np.float32]  # (4, padded_joints), if the measure takes it


@kernel
def start_open_segment(segment):
    """Begin with no frame, all slots being unused."""
    state = segment.state
    for first in range(0, len(segment.body), PAGE_SIZE):
        sums = segment.body[first + SUM_X : first + SUM_PATH + PAGE]
        for i in range(len(sums)):
            sums[i] = 0.0
    state.settled = allocate(segment.slots, segment.unused, segment.summaries)
    state.since = allocate(segment.slots, segment.unused, segment.summaries)
    state.run = allocate(segment.slots, segment.unused, segment.summaries)
    state.closed = NO_SLOT
    state.fed = state.settled
    state.waiting = 0
    state.last_time = 0.0
    state.last_weight = 0.0
    state.last_moving = 0
    state.last_speed = 0.0


@inline_kernel
def note_last_frame(state, time, weight, moving, speed):
    """Note the last frame, which joins a summary when the next one has come."""
    state.last_time = time
    state.last_weight = weight
    state.last_moving = moving
    state.last_speed = speed


@inline_kernel
def split(segment, curve, clock, value, scale, seen):
    """Take the next velocity in, give the last frame to its summary, and close the segment that a key frame ends.

    Args:
        segment: OpenSegment; the features are still those of the last frame.
        curve: CURVE.
        clock: CLOCK.
        value: V[t].
        scale: What 1 is on the scale of V.
        seen: Whether a crossing is a key frame.
    """
    state = segment.state
    run_length = curve.run_length
    theta = segment.plan.theta * scale
    happened = follow_curve(curve, value, theta, scale, clock.used_frame, clock.time)
    if not seen:
        happened &= ~CROSSED
        curve.found.happened = happened
    goes_on = curve.run_length > run_length and happened & CROSSED == 0
    if happened & REPLACED:
        settle(segment)
    place_last_frame(segment, curve.candidate, run_length, goes_on)
    if happened == 0:
        return
    if happened & FORGOTTEN:
        settle(segment)
        forget_candidate(curve)
    if happened & (CROSSED | ACCEPTED):
        forget_candidate(curve)
        state.closed = state.settled
        state.settled = state.since
        state.since = allocate(segment.slots, segment.unused, segment.summaries)


@inline_kernel
def place_last_frame(segment, candidate, run_length, goes_on):
    """Give the last frame to the summary it belongs to, and the run with it if the run is over.

    Args:
        segment: OpenSegment.
        candidate: Frame of the candidate, negative if there is none.
        run_length: Of the run that the last frame belongs to.
        goes_on: Whether the run does.
    """
    state, summaries = segment.state, segment.summaries
    target = state.since if candidate >= 0 else state.settled
    slot = state.run if goes_on or run_length > 1 else target
    if slot != state.fed or state.waiting >= MOST_WAITING:
        flush_waiting(segment)
        state.fed = slot
    add_last_frame(segment, slot)
    state.waiting += 1
    if slot != target and not goes_on:
        flush_waiting(segment)
        merge_into(segment.params, summaries[target], summaries[slot])
        empty(summaries[slot])


@inline_kernel
def add_last_frame(segment, slot):
    """Add the last frame to a summary, or to the sums in the body that wait for it."""
    state, joints = segment.state, segment.plan.joints
    frame = SummaryFrame(
        segment.body,
        segment.pose,
        joints,
        state.last_time,
        state.last_weight,
        state.last_moving,
        state.last_speed,
    )
    add_frame(segment.params, segment.summaries[slot], frame)


@inline_kernel
def flush_waiting(segment):
    """Add the sums that wait to the summary they belong to; before anything else is done with it."""
    state = segment.state
    if state.waiting > 0:
        flush_sums(segment.params, segment.summaries[state.fed], segment.body, segment.plan.padded_joints)
        state.waiting = 0


@kernel
def settle(segment):
    """Give what came since the candidate to what came before it."""
    flush_waiting(segment)
    state, summaries = segment.state, segment.summaries
    merge_into(segment.params, summaries[state.settled], summaries[state.since])
    empty(summaries[state.since])
