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

import numpy as np

from mossar_stream.algorithm.remerging import UNKNOWN, fall, is_known, recall, remember
from mossar_stream.algorithm.tempo import pace
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.event_buffer import (
    CONFIRMED,
    MERGED,
    RESTORED,
    SEGMENT,
    SEGMENT_CLOSED,
    SEGMENT_FINAL,
    SEGMENT_WITHDRAWN,
    UNDECIDED,
    UNKNOWN_STRENGTH,
    next_event,
    put_key_frame,
)
from mossar_stream.memory.row import PATH_JOINTS
from mossar_stream.similarity.protocol import close, merge_into, similarity
from mossar_stream.similarity.protocol import strength as merge_cost
from mossar_stream.similarity.summary import FRAMES, MOVING, PATH

NOT_STANDING = np.int64(-2)  # in KEY.before
NO_SLOT = np.int64(-1)
NO_JOINT = np.int64(-1)
BEFORE = np.int64(-3)  # identity of where the segment before the window begins
OWN, PREVIOUS, BOTH, RIGHT, LEFT, NODES = np.arange(6)  # rows of the scratch, before the nodes
SCRATCH_ROWS = 8  # more than W


@kernel
def add_key(h, w, params, events, slot, kind, frame, time, share, rev):
    """Add a confirmed key frame and the segment that it ends.

    Args:
        h: Header of the row.
        w: Views of the row's window.
        params: Parameters of the similarity measure.
        events: Outbox.
        slot: Slot of that segment; it belongs to the window from now on.
        kind: Index into KEY_FRAME_KINDS.
        frame: Frame of the key frame.
        time: s.
        share: Velocity as a share of the range.
        rev: Messages about it, this one included.
    """
    close(params, w.slots[slot])
    w.order[h.undecided] = slot
    key = w.keys[h.undecided]
    key.ordinal = h.ordinal
    key.frame = frame
    key.time = time
    key.velocity = share
    key.strength = np.nan
    key.kind = kind
    key.standing = 1
    key.before = NOT_STANDING
    key.rev = rev
    here = h.ordinal % (h.capacity + 2)
    for i in range(w.counts.shape[1]):
        w.counts[i, here] = 0
        w.counts[here, i] = 0
        w.counts[w.counts.shape[1], here] = 0
    h.undecided += 1
    h.ordinal += 1
    put_key_frame(h, events, CONFIRMED, kind, frame, frame, time, share, UNKNOWN_STRENGTH, rev, UNDECIDED)


@kernel
def rank(h, w, params, open_slot):
    """Compute the strengths of the undecided key frames; without an open slot the newest takes no part."""
    count = h.undecided if open_slot != NO_SLOT else h.undecided - 1
    if count <= 0:
        return
    h.pace = pace(h)
    w.bounds[0] = h.left_ordinal
    for i in range(count + 1):
        w.places[i] = w.order[i] if i < h.undecided else open_slot
        w.bounds[i + 1] = w.keys[i].ordinal if i < h.undecided else UNKNOWN
    fall(
        params,
        w.slots,
        w.places,
        w.scratch[NODES:],
        count,
        w.bounds,
        w.memo,
        w.scratch[BOTH],
        w.links,
        w.costs,
        h.pace,
        w.strengths,
        w.fallen,
    )
    for i in range(count):
        w.keys[i].strength = w.strengths[i]
        w.keys[w.fallen[i]].place = i


@kernel
def relabel(h, w, params, events):
    """Let every undecided key frame stand or not at the level as it is now, and say what changed."""
    for i in range(h.undecided):
        key = w.keys[i]
        kept = h.keep > 0 and key.place >= h.undecided - h.keep
        standing = 0 if key.strength < h.level and not kept else 1
        if standing != key.standing:
            key.standing = standing
            key.rev += 1
            status = RESTORED if standing == 1 else MERGED
            put_key_frame(
                h,
                events,
                status,
                key.kind,
                key.frame,
                key.frame,
                key.time,
                key.velocity,
                key.strength,
                key.rev,
                UNDECIDED,
            )
    if h.offline == 0:
        _update_segments(h, w, params, events, SEGMENT_WITHDRAWN)
        _update_segments(h, w, params, events, SEGMENT_CLOSED)


@inline_kernel
def _update_segments(h, w, params, events, status):
    """Withdraw the segments whose ends no longer follow each other, or close those that now do."""
    left = h.left_ordinal
    for i in range(h.undecided):
        key = w.keys[i]
        was = key.before
        now = left if key.standing == 1 else NOT_STANDING
        if was != now:
            if status == SEGMENT_WITHDRAWN:
                if was != NOT_STANDING:
                    put_segment(h, w, params, events, was, i, status)
            else:
                if now != NOT_STANDING:
                    put_segment(h, w, params, events, now, i, status)
                key.before = now
        if key.standing == 1:
            left = key.ordinal


@kernel
def span(h, w, params, begin, end, open_slot, target):
    """Set a row of the scratch to the closed summary of the window's segments begin … end together.

    Args:
        h: Header of the row.
        w: Views of the row's window.
        params: Parameters of the similarity measure.
        begin: Place of the first segment; segment i ends at key frame i.
        end: Place of the last one; the number of undecided key frames means the open segment.
        open_slot: Slot of the open segment.
        target: Row of the scratch.
    """
    _join(h, w, params, begin, end, open_slot, target, h.slot)
    close(params, w.scratch[target])


@inline_kernel
def _join(h, w, params, begin, end, open_slot, target, size):
    """Do the same, but leave the summary open; `size` is that of the whole summary, or of what all measures add."""
    own = w.scratch[target]
    slot = w.order[begin] if begin < h.undecided else open_slot
    for d in range(size):
        own[d] = w.slots[slot, d]
    for i in range(begin + 1, end + 1):
        slot = w.order[i] if i < h.undecided else open_slot
        if size == h.slot:
            merge_into(params, own, w.slots[slot])
        else:
            for d in range(size):
                own[d] += w.slots[slot, d]


@kernel
def put_segment(h, w, params, events, start, end, status):
    """Put a message about the segment between two key frames of the window into the outbox.

    Args:
        h: Header of the row.
        w: Views of the row's window.
        params: Parameters of the similarity measure.
        events: Outbox.
        start: Ordinal of the earlier key frame, or that of the left end.
        end: Place of the later one in the window.
        status: Index into SEGMENT_STATUSES.
    """
    first = h.ordinal - h.undecided
    from_left = start == h.left_ordinal
    begin = 0 if from_left else start - first + 1
    event = next_event(h, events, SEGMENT)
    event.id = h.left_id if from_left else w.keys[begin - 1].frame
    event.frame = h.left_frame if from_left else w.keys[begin - 1].frame
    event.time = h.left_time if from_left else w.keys[begin - 1].time
    event.end_id = w.keys[end].frame
    event.until_frame = w.keys[end].frame
    event.until_time = w.keys[end].time
    left, right = BEFORE, w.keys[end].ordinal
    before = 0
    if not from_left:
        earlier = w.keys[begin - 1].before
        before = 0 if earlier in (NOT_STANDING, h.left_ordinal) else earlier - first + 1
        left = h.left_ordinal if before == 0 else earlier
    has_previous = not from_left or h.has_before == 1
    # Where the cost is remembered, what people are told needs no more than the heads of the summaries.
    size = PATH + h.lanes if is_known(w.memo, left, start, right) else h.slot
    _join(h, w, params, begin, end, NO_SLOT, OWN, size)
    if not from_left:
        _join(h, w, params, before, begin - 1, NO_SLOT, PREVIOUS, size)
    elif has_previous:
        for d in range(size):
            w.scratch[PREVIOUS, d] = w.slots[h.slot_before, d]
    describe(h, w, params, event, has_previous, status, left, start, right)
    places = h.capacity + 2
    line = places if from_left else start % places
    column = (first + end) % places
    event.rev = 1
    if h.offline == 0:
        w.counts[line, column] += 1
        event.rev = w.counts[line, column]


@inline_kernel
def describe(h, w, params, event, has_previous, status, left, middle, right):
    """Fill in status, state, active joints and similarity of the segment in the scratch.

    Args:
        h: Header of the row.
        w: Views of the row's window; OWN and, if there is one, PREVIOUS are the summaries, not closed.
        params: Parameters of the similarity measure.
        event: To be filled in.
        has_previous: Whether there is a segment before.
        status: Index into SEGMENT_STATUSES.
        left: Identity of the boundary where the previous segment begins, as in remerging.py.
        middle: Of the one between them.
        right: Of the one where the segment ends.
    """
    own = w.scratch[OWN]
    event.status = status
    event.nature = 1 if 2.0 * own[MOVING] > own[FRAMES] else 0
    event.decided = 1 if status == SEGMENT_FINAL else 0
    event.strength = np.nan
    if has_previous:
        previous = w.scratch[PREVIOUS]
        if right == UNKNOWN or not is_known(w.memo, left, middle, right):
            close(params, own)
            close(params, previous)
            remember(w.memo, left, middle, right, merge_cost(params, previous, own, w.scratch[BOTH]))
        event.strength = similarity(params, recall(w.memo, left, middle, right), previous, own)
    _find_active(own[PATH : PATH + h.joints], w.active)
    event.joint0, event.joint1, event.joint2 = w.active[0], w.active[1], w.active[2]
    event.joint3, event.joint4 = w.active[3], w.active[4]


@inline_kernel
def _find_active(paths, active):
    """Set the joints with the longest paths, -1 where no more of them moved; of equal ones the first come first."""
    for place in range(PATH_JOINTS):
        active[place] = NO_JOINT
    least = 0.0
    for j in range(len(paths)):
        if paths[j] > least:
            place = PATH_JOINTS - 1
            while place > 0 and (active[place - 1] == NO_JOINT or paths[active[place - 1]] < paths[j]):
                active[place] = active[place - 1]
                place -= 1
            active[place] = j
            last = active[PATH_JOINTS - 1]
            least = paths[last] if last != NO_JOINT else 0.0
