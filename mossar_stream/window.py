"""Window: Algorithm 3 over the key frames that are still undecided.

    left end   key 0   key 1        key m-1        now
       │ segment │ segment │   …   │ segment │ open │
       └ the last final key frame

When a key frame is confirmed the hierarchy of the window is brought up to date. The newest one takes part once
its right segment is closed, or when the oldest must be decided. The oldest is decided for good when more than W
are undecided or it is older than `remerge_seconds`: final if it stands at the level, merged if not. What it costs
is bounded by W and the number of joints, whatever the length of the stream.
"""

import numpy as np

from mossar_stream.compiled import compiled
from mossar_stream.hierarchy import UNKNOWN, fall
from mossar_stream.layout import KEY, MEMO, PATH_JOINTS
from mossar_stream.outbox import (
    CONFIRMED,
    FINAL,
    MERGED,
    RESTORED,
    SEGMENT,
    SEGMENT_CLOSED,
    SEGMENT_FINAL,
    SEGMENT_WITHDRAWN,
    next_event,
    put_key_frame,
)
from mossar_stream.similarity import close, merge_into, similarity
from mossar_stream.summary import DURATION, FRAMES, MOVING, PATH

NOT_STANDING = -2  # in KEY.before
KEY_BYTES = KEY.itemsize
MEMO_BYTES = MEMO.itemsize


@compiled
def keys_of(h, row):
    """Return the undecided key frames, (W + 2,) KEY."""
    return row[h.at_keys : h.at_keys + (h.capacity + 2) * KEY_BYTES].view(KEY)


@compiled
def slots_of(h, row):
    """Return all summaries, (slots, slot)."""
    flat = row[h.at_slots : h.at_slots + 8 * h.slot_count * h.slot].view(np.float64)
    return flat.reshape(h.slot_count, h.slot)


@compiled
def order_of(h, row):
    """Return the slots of the window's closed segments, from left to right, (W + 2,)."""
    return row[h.at_order : h.at_order + 8 * (h.capacity + 2)].view(np.int64)


@compiled
def memo_of(h, row):
    """Return the remembered costs."""
    return row[h.at_memo : h.at_memo + h.memo_size * MEMO_BYTES].view(MEMO)


@compiled
def forget_costs(h, row):
    """Forget the remembered costs: segments are no longer what they were."""
    memo = memo_of(h, row)
    for i in range(len(memo)):
        memo[i].middle = UNKNOWN


@compiled
def counts_of(h, row):
    """Return the messages sent about each segment, by start (the left end last) and end."""
    places = h.capacity + 2
    return (
        row[h.at_counts : h.at_counts + 8 * places * (places + 1)].view(np.int64).reshape(places + 1, places)
    )


@compiled
def take_slot(h, row):
    """Return an unused slot, emptied."""
    free = row[h.at_free : h.at_free + 8 * h.slot_count].view(np.int64)
    h.free_count -= 1
    slot = free[h.free_count]
    slots_of(h, row)[slot, :] = 0.0
    return slot


@compiled
def give_slot(h, row, slot):
    """Take back a slot that is no longer needed."""
    free = row[h.at_free : h.at_free + 8 * h.slot_count].view(np.int64)
    free[h.free_count] = slot
    h.free_count += 1


@compiled
def add_key(h, row, events, params, slot, kind, frame, time, share, rev):
    """Add a confirmed key frame and the segment that it ends.

    Args:
        slot: Slot of that segment; it belongs to the window from now on.
        rev: Messages sent about this key frame before.
    """
    keys, order = keys_of(h, row), order_of(h, row)
    close(params, slots_of(h, row)[slot])
    place = h.undecided
    order[place] = slot
    key = keys[place]
    key.ordinal = h.ordinal
    key.frame = frame
    key.time = time
    key.velocity = share
    key.strength = np.nan
    key.kind = kind
    key.standing = 1
    key.before = NOT_STANDING
    key.rev = rev + 1
    counts = counts_of(h, row)
    here = h.ordinal % (h.capacity + 2)
    counts[:, here] = 0
    counts[here, :] = 0
    h.undecided += 1
    h.ordinal += 1
    put_key_frame(h, events, CONFIRMED, kind, frame, frame, time, share, np.nan, key.rev, 0)


@compiled
def rank(h, row, params, open_slot):
    """Compute the strengths of the undecided key frames; without an open slot the newest takes no part."""
    count = h.undecided if open_slot >= 0 else h.undecided - 1
    if count <= 0:
        return
    keys, order, slots, memo = keys_of(h, row), order_of(h, row), slots_of(h, row), memo_of(h, row)
    nodes = np.empty((count + 1, h.slot))
    bounds = np.empty(count + 2, np.int64)
    bounds[0] = h.left_ordinal
    for i in range(count + 1):
        nodes[i, :] = slots[order[i] if i < h.undecided else open_slot]
        bounds[i + 1] = keys[i].ordinal if i < h.undecided else UNKNOWN
    strengths = np.empty(count)
    fall_order = np.empty(count, np.int64)
    fall(params, nodes, count, bounds, memo, h.pace, strengths, fall_order)
    for i in range(count):
        keys[i].strength = strengths[i]


@compiled
def relabel(h, row, events, params):
    """Let every undecided key frame stand or not at the level as it is now, and say what changed."""
    keys = keys_of(h, row)
    for i in range(h.undecided):
        key = keys[i]
        standing = 1 if np.isnan(key.strength) or key.strength >= h.level else 0
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
                0,
            )
    _update_segments(h, row, events, params)


@compiled
def _update_segments(h, row, events, params):
    """Withdraw the segments whose ends no longer follow each other, and close those that now do."""
    keys = keys_of(h, row)
    first = h.ordinal - h.undecided
    left = h.left_ordinal
    for i in range(h.undecided):
        key = keys[i]
        was = key.before
        now = left if key.standing == 1 else NOT_STANDING
        if was != NOT_STANDING and was != now:
            put_segment(h, row, events, params, was, first + i, SEGMENT_WITHDRAWN)
        if key.standing == 1:
            left = key.ordinal
    left = h.left_ordinal
    for i in range(h.undecided):
        key = keys[i]
        now = left if key.standing == 1 else NOT_STANDING
        if now != NOT_STANDING and key.before != now:
            put_segment(h, row, events, params, now, first + i, SEGMENT_CLOSED)
        key.before = now
        if key.standing == 1:
            left = key.ordinal


@compiled
def span(h, row, params, begin, end, open_slot, target):
    """Set `target` to the summary of the window's segments begin … end together.

    Args:
        begin: Place of the first segment; segment i ends at key frame i.
        end: Place of the last one; the number of undecided key frames means the open segment.
        open_slot: Slot of the open segment.
    """
    order, slots = order_of(h, row), slots_of(h, row)
    target[:] = slots[order[begin] if begin < h.undecided else open_slot]
    for i in range(begin + 1, end + 1):
        merge_into(params, target, slots[order[i] if i < h.undecided else open_slot])
    close(params, target)


@compiled
def _segment_places(h, start, end):
    """Return the places of the first and last segment between two key frames given by ordinal."""
    first = h.ordinal - h.undecided
    return 0 if start == h.left_ordinal else start - first + 1, end - first


@compiled
def put_segment(h, row, events, params, start, end, status):
    """Put a message about the segment between two key frames of the window into the outbox."""
    slots = slots_of(h, row)
    keys = keys_of(h, row)
    first = h.ordinal - h.undecided
    own = np.empty(h.slot)
    begin, last = _segment_places(h, start, end)
    span(h, row, params, begin, last, -1, own)
    alike = np.nan
    if start == h.left_ordinal:
        if h.has_before == 1:
            alike = similarity(params, slots[h.slot_before], own, np.empty(h.slot))
    else:
        earlier = keys[start - first].before
        previous = np.empty(h.slot)
        begin, last = _segment_places(h, h.left_ordinal if earlier == NOT_STANDING else earlier, start)
        span(h, row, params, begin, last, -1, previous)
        alike = similarity(params, previous, own, np.empty(h.slot))
    key = keys[end - first]
    event = next_event(h, events, SEGMENT)
    if start == h.left_ordinal:
        event.id = h.left_id
        event.frame = h.left_frame
        event.time = h.left_time
    else:
        event.id = keys[start - first].frame
        event.frame = keys[start - first].frame
        event.time = keys[start - first].time
    event.end_id = key.frame
    event.until_frame = key.frame
    event.until_time = key.time
    event.rev = count_message(h, row, start, end)
    describe(event, own, alike, status, h.joints)


@compiled
def count_message(h, row, start, end):
    """Return the number of messages about a segment, this one included."""
    places = h.capacity + 2
    counts = counts_of(h, row)
    begin = places if start == h.left_ordinal else start % places
    counts[begin, end % places] += 1
    return counts[begin, end % places]


@compiled
def describe(event, slot, alike, status, joints):
    """Fill in status, state, active joints and similarity of a segment's message."""
    event.status = status
    event.nature = 1 if 2.0 * slot[MOVING] > slot[FRAMES] else 0
    event.strength = alike
    event.velocity = 0.0
    event.decided = 1 if status == SEGMENT_FINAL else 0
    chosen = np.full(PATH_JOINTS, -1)
    for place in range(min(PATH_JOINTS, joints)):
        best = -1
        for j in range(joints):
            taken = False
            for other in range(place):
                taken = taken or chosen[other] == j
            if not taken and slot[PATH + j] > 0.0 and (best < 0 or slot[PATH + j] > slot[PATH + best]):
                best = j
        chosen[place] = best
        if best < 0:
            break
    event.joint0, event.joint1, event.joint2 = chosen[0], chosen[1], chosen[2]
    event.joint3, event.joint4 = chosen[3], chosen[4]
