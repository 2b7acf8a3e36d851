"""Window: Algorithm 3 over the key frames that are still undecided.

    left end   key 0   key 1        key m-1        now
       │ segment │ segment │   …   │ segment │ open │
       └ the last final key frame

When a key frame is confirmed the hierarchy of the window is brought up to date. The newest one takes part once its
right segment is closed. The oldest is decided for good when more than W are undecided or it is older than
`remerge_seconds`: final if it stands at the level, merged if not. Where its strength lies near the level, or the one
before it was just decided, the window is ranked again first, the newest key frame and the open segment included.
What it costs is bounded by W and the number of joints, whatever the length of the stream.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.activity import Activity, active_span
from mossar_stream.algorithm.candidate_features import EARLIER
from mossar_stream.algorithm.open_segment import NO_SLOT
from mossar_stream.algorithm.pose_history import PoseHistory
from mossar_stream.algorithm.remerging import (
    UNKNOWN_BOUNDARY,
    is_kept,
    is_known,
    prepared,
    recall,
    remember,
    remerge,
)
from mossar_stream.algorithm.repetition_labels import UNLABELLED, RepetitionLabels
from mossar_stream.algorithm.rests import label_rests
from mossar_stream.algorithm.tempo import pace
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.event_buffer import (
    KEY_CONFIRMED,
    KEY_MERGED,
    KEY_RESTORED,
    SEGMENT,
    SEGMENT_CLOSED,
    SEGMENT_FINAL,
    SEGMENT_WITHDRAWN,
    UNDECIDED,
    Point,
    find_active,
    next_event,
    put_key_frame,
)
from mossar_stream.similarity.protocol import close, merge_into, similarity
from mossar_stream.similarity.protocol import strength as merge_cost
from mossar_stream.similarity.summary import PATH

WINDOW = np.dtype(
    [
        ("undecided", "i8"),  # key frames in the window
        ("ordinal", "i8"),  # of the next key frame; they are counted through a take
        ("ranked", "i8"),  # whether the strengths are those of the window as it is
        ("left_frame", "i8"),  # where the window's first segment starts: the last final key frame
        ("left_id", "i8"),  # Algorithm 2's frame of it
        ("left_time", "f8"),  # s
        ("left_ordinal", "i8"),
        ("has_before", "i8"),  # whether there is a segment before the window
        ("before", "i8"),  # slot of it
        ("due_time", "f8"),  # s, when the oldest key frame must be decided; inf if there is none
        (
            "pace",
            "f8",
        ),  # what costs were divided by at the last ranking: tempo, and share of the joints that count
    ],
)
KEY = np.dtype(
    [
        ("ordinal", "i8"),  # counts the key frames of the take
        ("frame", "i8"),  # Algorithm 2's frame
        ("time", "f8"),  # s
        ("velocity", "f8"),  # share of the range
        ("strength", "f8"),  # NaN until first computed
        ("kind", "i8"),  # index into events.KEY_FRAME_KINDS
        ("kept", "i8"),  # whether it is kept at the current level
        ("before", "i8"),  # ordinal of the kept key frame before, where a segment between them was reported
        ("place", "i8"),  # in the order in which key frames are removed
        ("rev", "i8"),  # messages sent
        ("at_frame", "i8"),  # reported frame
        ("at_time", "f8"),  # s
        ("reported", "i8"),  # whether it was reported as confirmed
        ("label", "i8"),  # on whether it ends a repetition, see repetition_labels.py
    ],
)
NOT_KEPT = np.int64(-2)  # in KEY.before
BEFORE_WINDOW = np.int64(-3)  # identity of where the segment before the window begins
OWN, PREVIOUS, BOTH, RIGHT_OF_KEY, LEFT_OF_KEY, NODES = np.arange(
    6
)  # rows of the scratch's summaries, before the nodes
SPARE_SUMMARIES = 8  # more than W


class Scratch(NamedTuple):
    """Arrays to work in, shared by all performers of a plan; see remerging.py."""

    summaries: NDArray[np.float64]  # (W + SPARE_SUMMARIES, slot)
    pose: NDArray[np.float32]  # (4, padded_joints)
    places: NDArray[np.int64]  # (W + 4,)
    bounds: NDArray[np.int64]  # (W + 4,)
    removed: NDArray[np.int64]  # (W + 4,)
    active: NDArray[np.int64]  # (W + 4,)
    labels: NDArray[np.int64]  # (W + 4,)
    links: NDArray[np.int64]  # (5, W + 4)
    costs: NDArray[np.float64]  # (W + 4,)
    strengths: NDArray[np.float64]  # (W + 4,)


class Window(NamedTuple):
    """The undecided key frames of a performer and the segments between them, as the functions below need them."""

    plan: np.void  # PLAN
    clock: np.void  # CLOCK
    joints: np.void  # JOINTS
    state: np.void  # WINDOW
    tempo: np.void  # TEMPO
    slots: np.void  # SLOTS
    params: np.void  # of the similarity measure
    history: PoseHistory
    labels: RepetitionLabels
    activity: Activity
    noise: np.void  # NOISE
    keys: NDArray[np.void]  # (W + 2,) KEY, from left to right
    order: NDArray[np.int64]  # (W + 2,) slots of the segments, from left to right
    unused: NDArray[np.int64]  # (slots,) stack of unused slots
    summaries: NDArray[np.float64]  # (slots, slot)
    counts: NDArray[np.int32]  # (W + 3, W + 2) messages sent about each segment of the window
    memo: NDArray[np.void]  # (memo,) MEMO
    events: NDArray[np.void]  # EVENT, the event buffer
    scratch: Scratch


@kernel
def start_window(state, frame, time):
    """Begin without a key frame; the first segment starts at the first frame."""
    state.undecided = 0
    state.ordinal = 0
    state.ranked = 0
    state.left_frame = frame
    state.left_id = frame
    state.left_time = time
    state.left_ordinal = -1
    state.has_before = 0
    state.before = NO_SLOT
    state.due_time = np.inf
    state.pace = 1.0


@kernel
def add_key(w, slot, point, time, rev, reported):
    """Add a confirmed key frame and the segment that it ends.

    Args:
        w: Window.
        slot: Slot of that segment; it belongs to the window from now on.
        point: Point of the key frame.
        time: s, of Algorithm 2's frame.
        rev: Messages about it, this one included.
        reported: Whether it is reported now; else only when it is decided, if it is final.
    """
    state, counts = w.state, w.counts
    close(w.params, w.summaries[slot])
    w.order[state.undecided] = slot
    key = w.keys[state.undecided]
    key.ordinal = state.ordinal
    key.frame = point.id
    key.time = time
    key.at_frame = point.frame
    key.at_time = point.time
    key.reported = reported
    key.label = UNLABELLED
    key.velocity = point.velocity
    key.strength = np.nan
    key.kind = point.kind
    key.kept = reported
    key.before = NOT_KEPT
    key.rev = rev + reported - 1
    here = state.ordinal % (w.plan.capacity + 2)
    for i in range(counts.shape[1]):
        counts[i, here] = 0
        counts[here, i] = 0
        counts[counts.shape[1], here] = 0
    state.undecided += 1
    state.ordinal += 1
    if reported == 1:
        put_key_frame(w.clock, w.events, point, KEY_CONFIRMED, rev, UNDECIDED)


@kernel
def report_kept(w, count):
    """Report the first key frames that are about to be final as confirmed, if they were not reported."""
    any_reported = 0
    for i in range(count):
        key = w.keys[i]
        if key.reported == 1 or not is_kept(key, w.state.undecided, w.plan.alpha, w.plan.beta):
            continue
        key.reported = key.kept = any_reported = 1
        key.rev += 1
        point = point_of(key, key.at_frame, key.at_time, key.strength)
        put_key_frame(w.clock, w.events, point, KEY_CONFIRMED, key.rev, UNDECIDED)
    if any_reported == 1 and w.plan.offline == 0:
        _update_segments(w, SEGMENT_WITHDRAWN)
        _update_segments(w, SEGMENT_CLOSED)


@inline_kernel
def point_of(key, frame, time, strength):
    """Return an undecided key frame as messages tell of it, with where it is now and its strength."""
    return Point(key.kind, key.frame, frame, time, key.velocity, strength)


@kernel
def rank(w, open_slot):
    """Compute the strengths of the undecided key frames; without an open slot the newest takes no part."""
    state, scratch = w.state, w.scratch
    count = state.undecided if open_slot != NO_SLOT else state.undecided - 1
    if count <= 0:
        return
    state.pace = pace(w.tempo) if w.plan.tempo == 1 else 1.0
    if w.plan.is_mean == 1:
        state.pace *= w.joints.moving / w.plan.moving_joints
    scratch.bounds[0] = state.left_ordinal
    for i in range(count + 1):
        scratch.places[i] = w.order[i] if i < state.undecided else open_slot
        scratch.bounds[i + 1] = w.keys[i].ordinal if i < state.undecided else UNKNOWN_BOUNDARY
        scratch.labels[i] = w.keys[i].label if i < state.undecided else UNLABELLED
    if w.plan.rests == 1:
        label_rests(w, count)
    nodes, both = scratch.summaries[NODES:], scratch.summaries[BOTH]
    remerge(prepared(w.params, w.summaries, w.memo, scratch, nodes, both), count, state.pace)
    for i in range(count):
        w.keys[i].strength = scratch.strengths[i]
        w.keys[scratch.removed[i]].place = i


@kernel
def relabel(w):
    """Keep every undecided key frame or not at the level as it is now, and say what changed."""
    plan = w.plan
    for i in range(w.state.undecided):
        key = w.keys[i]
        kept = 1 if is_kept(key, w.state.undecided, plan.alpha, plan.beta) else 0
        if kept != key.kept and key.reported == 1:
            key.kept = kept
            key.rev += 1
            status = KEY_RESTORED if kept == 1 else KEY_MERGED
            point = point_of(key, key.at_frame, key.at_time, key.strength)
            put_key_frame(w.clock, w.events, point, status, key.rev, UNDECIDED)
    if plan.offline == 0:
        _update_segments(w, SEGMENT_WITHDRAWN)
        _update_segments(w, SEGMENT_CLOSED)


@inline_kernel
def _update_segments(w, status):
    """Withdraw the segments whose ends no longer follow each other, or close those that now do."""
    left = w.state.left_ordinal
    for i in range(w.state.undecided):
        key = w.keys[i]
        was = key.before
        now = left if key.kept == 1 else NOT_KEPT
        if was != now:
            if status == SEGMENT_WITHDRAWN:
                if was != NOT_KEPT:
                    put_segment(w, was, i, status)
            else:
                if now != NOT_KEPT:
                    put_segment(w, now, i, status)
                key.before = now
        if key.kept == 1:
            left = key.ordinal


@kernel
def span(w, begin, end, open_slot, target):
    """Set a row of the scratch to the closed summary of the window's segments begin … end together.

    Args:
        w: Window.
        begin: Place of the first segment; segment i ends at key frame i.
        end: Place of the last one; the number of undecided key frames means the open segment.
        open_slot: Slot of the open segment.
        target: Row of the scratch's summaries.
    """
    _join(w, begin, end, open_slot, w.scratch.summaries[target])
    close(w.params, w.scratch.summaries[target])


@inline_kernel
def _join(w, begin, end, open_slot, own):
    """Do the same for any summary, but leave it open; a short one gets only as much, of what all measures add."""
    undecided, size = w.state.undecided, len(own)
    slot = w.order[begin] if begin < undecided else open_slot
    for d in range(size):
        own[d] = w.summaries[slot, d]
    for i in range(begin + 1, end + 1):
        slot = w.order[i] if i < undecided else open_slot
        if size == w.plan.slot:
            merge_into(w.params, own, w.summaries[slot])
        else:
            for d in range(size):
                own[d] += w.summaries[slot, d]


@kernel
def put_segment(w, start, end, status):
    """Put a message about the segment between two key frames of the window into the event buffer.

    Args:
        w: Window.
        start: Ordinal of the earlier key frame, or that of the left end.
        end: Place of the later one in the window.
        status: Index into SEGMENT_STATUSES.
    """
    state, plan, summaries = w.state, w.plan, w.scratch.summaries
    first = state.ordinal - state.undecided
    from_left = start == state.left_ordinal
    begin = 0 if from_left else start - first + 1
    event = next_event(w.clock, w.events, SEGMENT)
    event.id = state.left_id if from_left else w.keys[begin - 1].frame
    event.frame = state.left_frame if from_left else w.keys[begin - 1].at_frame
    event.time = state.left_time if from_left else w.keys[begin - 1].at_time
    event.end_id = w.keys[end].frame
    event.until_frame = w.keys[end].at_frame
    event.until_time = w.keys[end].at_time
    left, right = BEFORE_WINDOW, w.keys[end].ordinal
    before = 0
    if not from_left:
        earlier = w.keys[begin - 1].before
        before = 0 if earlier in (NOT_KEPT, state.left_ordinal) else earlier - first + 1
        left = state.left_ordinal if before == 0 else earlier
    has_previous = not from_left or state.has_before == 1
    # Where the cost is remembered, what is reported needs no more than the heads of the summaries.
    size = PATH + plan.padded_joints if is_known(w.memo, left, start, right) else plan.slot
    _join(w, begin, end, NO_SLOT, summaries[OWN, :size])
    if not from_left:
        _join(w, before, begin - 1, NO_SLOT, summaries[PREVIOUS, :size])
    elif has_previous:
        for d in range(size):
            summaries[PREVIOUS, d] = w.summaries[state.before, d]
    describe(w, event, has_previous, status, (left, start, right))
    places = plan.capacity + 2
    line = places if from_left else start % places
    column = (first + end) % places
    event.rev = 1
    if plan.offline == 0:
        w.counts[line, column] += 1
        event.rev = w.counts[line, column]


@inline_kernel
def note_span(w, event):
    """Fill in when the performer moved in a segment whose ends are known, and so its state."""
    path = 0.0
    for j in range(w.plan.joints):
        path += w.scratch.summaries[OWN, PATH + j]
    late = EARLIER if w.plan.has_features == 1 else 0.0
    event.active_start, event.active_end = active_span(w.activity, event.time, event.until_time, path, late)
    event.nature = 0 if np.isnan(event.active_start) else 1


@inline_kernel
def describe(w, event, has_previous, status, bounds):
    """Fill in status, state, when it was active, active joints and similarity of the segment in the scratch.

    Args:
        w: Window; OWN and, if there is one, PREVIOUS in the scratch are the summaries, not closed.
        event: To be filled in.
        has_previous: Whether there is a segment before.
        status: Index into SEGMENT_STATUSES.
        bounds: Identities of the boundaries as in remerging.py: where the previous segment begins, the one between
            the two, and where the segment ends.
    """
    left, middle, right = bounds
    active, both = w.scratch.active, w.scratch.summaries[BOTH]
    own = w.scratch.summaries[OWN]
    event.status = status
    note_span(w, event)
    event.decided = 1 if status == SEGMENT_FINAL else 0
    event.strength = np.nan
    if has_previous:
        previous = w.scratch.summaries[PREVIOUS]
        if right == UNKNOWN_BOUNDARY or not is_known(w.memo, left, middle, right):
            close(w.params, own)
            close(w.params, previous)
            remember(w.memo, left, middle, right, merge_cost(w.params, previous, own, both))
        event.strength = similarity(w.params, recall(w.memo, left, middle, right), previous, own)
    find_active(own[PATH : PATH + w.plan.joints], w.plan.details, active)
    event.joint0, event.joint1, event.joint2 = active[0], active[1], active[2]
    event.joint3, event.joint4 = active[3], active[4]
