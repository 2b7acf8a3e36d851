"""Take: the open segment, and what splitter and window do to it.

Frames since the last key frame lie in three summaries: those up to the candidate (`settled`), those after it
(`since`), and those of a plateau that may yet become a candidate (`run`). The last frame waits outside, because
the next one tells whether it was a minimum. When a candidate is confirmed, `settled` is the segment before it and
`since` the beginning of the one after it; nothing is replayed.
"""

import numpy as np

from mossar_stream.compiled import compiled
from mossar_stream.decision import decide_oldest
from mossar_stream.outbox import (
    CANDIDATE,
    MINIMUM,
    OFFSET,
    ONSET,
    SEGMENT,
    SEGMENT_FINAL,
    WITHDRAWN,
    next_event,
    put_key_frame,
)
from mossar_stream.similarity import add_frame, add_pose, close, merge_into, similarity
from mossar_stream.splitter import CONFIRMED, CROSSED, PROMOTED, REPLACED, follow_curve
from mossar_stream.splitter import WITHDRAWN as FORGOTTEN
from mossar_stream.trail import SPEED_OFFSET
from mossar_stream.window import (
    add_key,
    describe,
    keys_of,
    forget_costs,
    rank,
    relabel,
    slots_of,
    give_slot,
    take_slot,
)

REST = np.log(SPEED_OFFSET)  # log speed of a joint at rest


@compiled
def open_take(h, row, time):
    """Empty everything that belongs to a take; the running range survives."""
    h.open = 1
    h.filled = 0
    h.head = 0
    h.travelled = 0
    h.average_filled = 0
    h.average_head = 0
    h.average_sum = 0
    h.trail_head = 0
    h.trail_filled = 0
    h.trail_debt = 0.0
    h.undecided = 0
    h.ordinal = 0
    h.has_before = 0
    h.left_ordinal = -1
    h.left_frame = h.next_frame
    h.left_id = h.next_frame
    h.left_time = time
    h.start_time = time
    h.due_time = np.inf
    h.pace = 1.0
    h.closed = -1
    forget_costs(h, row)
    free = row[h.at_free : h.at_free + 8 * h.slot_count].view(np.int64)
    for i in range(h.slot_count):
        free[i] = i
    h.free_count = h.slot_count
    h.slot_settled = take_slot(h, row)
    h.slot_since = take_slot(h, row)
    h.slot_run = take_slot(h, row)


@compiled
def split(h, row, params, pose, step, value, scale, events):
    """Take the next velocity in, give the last frame to its summary, and carry out what the splitter says.

    Args:
        pose: (4, lanes) of the last frame.
        step: (lanes,) m, of the last frame.
        value: V[t].
        scale: What 1 is on the scale of V.
    """
    frame, time, share = h.candidate, h.candidate_time, h.candidate_share
    run_length = h.run_length
    happened = follow_curve(h, value, scale, h.used_frame, h.time)
    goes_on = h.run_length > run_length and happened & CROSSED == 0
    if happened & PROMOTED:
        if happened & REPLACED:
            put_key_frame(h, events, WITHDRAWN, MINIMUM, frame, frame, time, share, np.nan, 2, 1)
            _settle(h, row, params)
        put_key_frame(
            h,
            events,
            CANDIDATE,
            MINIMUM,
            h.candidate,
            h.candidate,
            h.candidate_time,
            h.candidate_share,
            np.nan,
            1,
            0,
        )
    _place_last_frame(h, row, params, pose, step, run_length, goes_on)
    if happened & CROSSED:
        if happened & FORGOTTEN:
            _forget_candidate(h, row, params, events)
        kind = ONSET if h.moving == 1 else OFFSET
        _end_segment(h, row, params, kind, h.used_frame, h.time, h.share, 0, events)
    elif happened & CONFIRMED:
        _end_segment(h, row, params, MINIMUM, h.candidate, h.candidate_time, h.candidate_share, 1, events)
        h.candidate = -1


@compiled
def _place_last_frame(h, row, params, pose, step, run_length, goes_on):
    """Give the last frame to the summary it belongs to."""
    slots = slots_of(h, row)
    target = h.slot_since if h.candidate >= 0 else h.slot_settled
    slot = h.slot_run if goes_on or run_length > 1 else target
    add_frame(params, slots[slot], pose, step, h.joints, h.pending_weight, h.pending_moving)
    if slot != target and not goes_on:
        merge_into(params, slots[target], slots[slot])
        slots[slot, :] = 0.0


@compiled
def _settle(h, row, params):
    """Give what came since the candidate to what came before it."""
    slots = slots_of(h, row)
    merge_into(params, slots[h.slot_settled], slots[h.slot_since])
    slots[h.slot_since, :] = 0.0


@compiled
def _forget_candidate(h, row, params, events):
    """Withdraw the candidate: the curve crossed the threshold, or the take ends."""
    put_key_frame(
        h,
        events,
        WITHDRAWN,
        MINIMUM,
        h.candidate,
        h.candidate,
        h.candidate_time,
        h.candidate_share,
        np.nan,
        2,
        1,
    )
    h.candidate = -1
    _settle(h, row, params)


@compiled
def _end_segment(h, row, params, kind, frame, time, share, rev, events):
    """Confirm a key frame: the settled summary becomes a segment of the window."""
    closed = h.slot_settled
    h.slot_settled = h.slot_since
    h.slot_since = take_slot(h, row)
    add_key(h, row, events, params, closed, kind, frame, time, share, rev)
    if h.collect == 1:
        h.closed = closed
        h.undecided = 0
        return
    rank(h, row, params, -1)
    relabel(h, row, events, params)
    h.due_time = keys_of(h, row)[0].time + h.hold


@compiled
def decide(h, row, params, pose, step, events):
    """Decide the oldest key frames while there are more than W or they are older than `remerge_seconds`."""
    slots = slots_of(h, row)
    open_slot = take_slot(h, row)
    slots[open_slot, :] = slots[h.slot_settled]
    merge_into(params, slots[open_slot], slots[h.slot_since])
    merge_into(params, slots[open_slot], slots[h.slot_run])
    add_frame(params, slots[open_slot], pose, step, h.joints, h.pending_weight, h.pending_moving)
    close(params, slots[open_slot])
    keys = keys_of(h, row)
    end_frame = h.candidate if h.candidate >= 0 else h.run_frame
    while h.undecided > 0 and (h.undecided > h.capacity or h.time >= keys[0].time + h.hold):
        rank(h, row, params, open_slot)
        relabel(h, row, events, params)
        decide_oldest(h, row, events, params, open_slot, end_frame)
    give_slot(h, row, open_slot)
    h.due_time = keys[0].time + h.hold if h.undecided > 0 else np.inf


@compiled
def end_take(h, row, params, pose, step, events):
    """Decide everything, by one hierarchy over all undecided key frames, and close the last segment."""
    _place_last_frame(h, row, params, pose, step, h.run_length, False)
    if h.candidate >= 0:
        _forget_candidate(h, row, params, events)
    settled = slots_of(h, row)[h.slot_settled]
    if h.post_roll > 0.0:
        pose[3] = REST
        add_pose(params, settled, pose, h.joints, h.post_roll)
    close(params, settled)
    if h.collect == 0:
        rank(h, row, params, h.slot_settled)
        relabel(h, row, events, params)
        while h.undecided > 0:
            decide_oldest(h, row, events, params, h.slot_settled, h.used_frame + 1)
        _put_last_segment(h, row, params, events)
    h.open = 0
    h.take += 1
    h.next_frame = 0


@compiled
def _put_last_segment(h, row, params, events):
    """Put the final message about the segment from the last final key frame to the end into the outbox."""
    slots = slots_of(h, row)
    own = slots[h.slot_settled]
    alike = np.nan
    if h.has_before == 1:
        alike = similarity(params, slots[h.slot_before], own, np.empty(h.slot))
    event = next_event(h, events, SEGMENT)
    event.id = h.left_id
    event.frame = h.left_frame
    event.time = h.left_time
    event.end_id = h.used_frame
    event.until_frame = h.used_frame
    event.until_time = h.time
    event.rev = 1
    describe(event, own, alike, SEGMENT_FINAL, h.joints)
