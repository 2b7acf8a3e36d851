"""Act: what follows from a frame in which something happened.

The stream stops after such a frame; this compiled call then says what the splitter found, brings the window up to
date and decides what is due. Few frames come here, and it is compiled apart from what every frame goes through.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.decision import decide_oldest
from mossar_stream.algorithm.open_segment import place_last_frame, pour_waiting, settle
from mossar_stream.algorithm.pose_history import SPEED_OFFSET
from mossar_stream.algorithm.remerging import UNKNOWN
from mossar_stream.algorithm.splitter import CONFIRMED, CROSSED, PROMOTED, REPLACED
from mossar_stream.algorithm.splitter import WITHDRAWN as FORGOTTEN
from mossar_stream.algorithm.window import (
    BEFORE,
    NO_SLOT,
    NOT_STANDING,
    OWN,
    PREVIOUS,
    SCRATCH_ROWS,
    add_key,
    describe,
    put_segment,
    rank,
    relabel,
)
from mossar_stream.engine.plan import Plan
from mossar_stream.jit.decorators import entry_point, inline_kernel, kernel
from mossar_stream.jit.views import part
from mossar_stream.memory.event_buffer import (
    CANDIDATE,
    DECIDED,
    EVENT,
    EVENT_BYTES,
    FIRST,
    MINIMUM,
    OFFSET,
    ONSET,
    SECOND,
    SEGMENT,
    SEGMENT_FINAL,
    SEGMENT_WITHDRAWN,
    UNDECIDED,
    UNKNOWN_STRENGTH,
    WITHDRAWN,
    next_event,
    put_key_frame,
)
from mossar_stream.memory.joint_pages import flatten
from mossar_stream.memory.row import HEADER, KEY, MARK, MEMO
from mossar_stream.memory.slots import give_slot, take_slot
from mossar_stream.similarity.protocol import add_frame, add_pose, close, flush_sums, merge_into
from mossar_stream.similarity.summary import SummaryFrame

FOLLOW, LEVEL, END, RANK, DECIDE = range(5)  # why `act` is called
CLEAR = 2.0  # a strength so many times the level, or less than one part in so many of it, is a clear verdict
REST = float(np.log(SPEED_OFFSET))  # log speed of a joint at rest


class Window(NamedTuple):
    """Views of a row and of the room to work in, as the window's functions need them."""

    body: NDArray[np.float32]
    keys: NDArray[np.void]  # (W + 2,) KEY
    order: NDArray[np.int64]  # (W + 2,)
    free: NDArray[np.int64]  # (slots,)
    slots: NDArray[np.float64]  # (slots, slot)
    counts: NDArray[np.int64]  # (W + 3, W + 2)
    memo: NDArray[np.void]  # (memo,) MEMO
    marks: NDArray[np.void]  # (trail,) MARK
    trail: NDArray[np.int16]  # (trail, 3, lanes)
    kept: NDArray[np.float32]  # (4, lanes), a pose from the trail
    scratch: NDArray[np.float64]  # (W + SCRATCH_ROWS, slot)
    bounds: NDArray[np.int64]  # (W + 4,), see remerging.py
    fallen: NDArray[np.int64]  # (W + 4,)
    active: NDArray[np.int64]  # (W + 4,)
    places: NDArray[np.int64]  # (W + 4,), see remerging.py
    links: NDArray[np.int64]  # (5, W + 4)
    costs: NDArray[np.float64]  # (W + 4,)
    strengths: NDArray[np.float64]  # (W + 4,)


def make_room(plan: Plan) -> NDArray[np.uint8]:
    """Return room to work in, shared by all rows of a plan.

    Bytes like the rows themselves, because arrays of another kind would make numba compile everything twice.
    """
    window, slot, lanes = plan.shape.window, plan.shape.slot, plan.shape.lanes
    numbers = (window + SCRATCH_ROWS) * slot + 2 * lanes + 11 * (window + 4)
    return np.zeros(8 * numbers, np.uint8)


@entry_point(makes_arrays=False)
def act(
    memory: NDArray[np.uint8],
    index: int,
    params: NDArray[np.void],
    room: NDArray[np.uint8],
    outbox: NDArray[np.uint8],
    reason: int,
) -> None:
    """Carry out what follows from the last frame.

    Args:
        memory: (P, row) bytes, the pool.
        index: Row of the performer.
        params: One-element record array of the similarity measure.
        room: Room to work in.
        outbox: Bytes of an outbox with room for `most_events`.
        reason: FOLLOW after a frame at which the stream stopped, LEVEL after the level moved, END to end the
            take: RANK to close its last segment and rank all key frames, then DECIDE.
    """
    row = memory[index]
    h = part(row, 0, HEADER, (1,))[0]
    if h.open == 0:
        return
    events = part(outbox, 0, EVENT, (len(outbox) // EVENT_BYTES,))
    begin = events[0].row
    pose = part(row, h.at_pose, np.float32, (4, h.lanes))
    w = _window(h, row, room)
    if reason == LEVEL:
        relabel(h, w, params[0], events)
        h.due_time = w.keys[0].time + h.hold if h.undecided > 0 else np.inf
    elif reason == FOLLOW:
        _follow(h, w, params[0], events)
        if h.offline == 0 and (h.undecided > h.capacity or h.time >= h.due_time):
            _decide(h, w, params[0], pose, events, begin)
    else:
        if reason != DECIDE:
            _close_take(h, w, params[0], pose, events)
        if reason != RANK:
            _decide_all(h, w, params[0], events)


@inline_kernel(returns_views=True)
def _window(h, row, room):
    """Return views of a row and of the room to work in, which are as long as its plan and `make_room` say."""
    lanes, places = h.lanes, h.capacity + 2
    counted = 0 if h.offline == 1 else places
    scratch, long = h.capacity + SCRATCH_ROWS, h.capacity + 4
    at_kept = 8 * scratch * h.slot
    at_integers = at_kept + 16 * lanes
    integers = part(room, at_integers, np.int64, (9, long))
    numbers = part(room, at_integers + 8 * integers.size, np.float64, (2, long))
    return Window(
        part(row, h.at_body, np.float32, ((h.at_seen - h.at_body) // 4,)),
        part(row, h.at_keys, KEY, (places,)),
        part(row, h.at_order, np.int64, (places,)),
        part(row, h.at_free, np.int64, (h.slot_count,)),
        part(row, h.at_slots, np.float64, (h.slot_count, h.slot)),
        part(row, h.at_counts, np.int64, (counted + 1, counted)),
        part(row, h.at_memo, MEMO, (h.memo_size,)),
        part(row, h.at_marks, MARK, (h.trail_size,)),
        part(row, h.at_trail, np.int16, (h.trail_size, 3, lanes)),
        part(room, at_kept, np.float32, (4, lanes)),
        part(room, 0, np.float64, (scratch, h.slot)),
        integers[0],
        integers[1],
        integers[2],
        integers[3],
        integers[4:],
        numbers[0],
        numbers[1],
    )


@inline_kernel
def _follow(h, w, params, events):
    """Say what the splitter found, and add the key frame if there is one."""
    happened = h.happened
    h.happened = 0
    if happened & REPLACED:
        _put_candidate(h, events, WITHDRAWN, h.former_frame, h.former_time, h.former_share)
    if happened & PROMOTED:
        _put_candidate(h, events, CANDIDATE, h.found_frame, h.found_time, h.found_share)
    if happened & FORGOTTEN:
        _put_candidate(h, events, WITHDRAWN, h.found_frame, h.found_time, h.found_share)
    if happened & (CROSSED | CONFIRMED) == 0:
        return
    pour_waiting(h, w.body, w.slots, params)
    slot = h.closed
    h.closed = -1
    if happened & CROSSED:
        kind = ONSET if h.moving == 1 else OFFSET
        add_key(h, w, params, events, slot, kind, h.used_frame, h.time, h.share, FIRST)
    else:
        add_key(h, w, params, events, slot, MINIMUM, h.found_frame, h.found_time, h.found_share, SECOND)
    if h.offline == 0:
        rank(h, w, params, NO_SLOT)
        relabel(h, w, params, events)
        h.ranked = 1
        h.due_time = w.keys[0].time + h.hold


@kernel
def _put_candidate(h, events, status, frame, time, share):
    rev = FIRST if status == CANDIDATE else SECOND
    decided = UNDECIDED if status == CANDIDATE else DECIDED
    put_key_frame(h, events, status, MINIMUM, frame, frame, time, share, UNKNOWN_STRENGTH, rev, decided)


@inline_kernel
def _decide(h, w, params, pose, events, begin):
    """Decide the oldest key frames while there are more than W or they are older than `remerge_seconds`.

    If several are due and cause more than `most_events`, the rest is left for the next frame.
    """
    pour_waiting(h, w.body, w.slots, params)
    open_slot = NO_SLOT
    end_frame = h.candidate if h.candidate >= 0 else h.run_frame
    last = begin + h.most_events - (4 * h.capacity + 12)  # with room for one more decision
    while h.undecided > 0 and (h.undecided > h.capacity or h.time >= w.keys[0].time + h.hold):
        if events[0].row >= last:
            break
        clear = _is_clear(h, w)
        if open_slot == NO_SLOT and (w.keys[0].standing == 1 or not clear):
            open_slot = _gather_open(h, w, params, pose)
        if not clear:
            rank(h, w, params, open_slot)
            relabel(h, w, params, events)
        decide_oldest(h, w, params, events, open_slot, end_frame)
        h.ranked = 0
    if open_slot != NO_SLOT:
        give_slot(h, w.free, open_slot)
    h.due_time = w.keys[0].time + h.hold if h.undecided > 0 else np.inf


@inline_kernel
def _is_clear(h, w):
    """Tell whether what came after the newest key frame hardly changes the verdict on the oldest one."""
    strength = w.keys[0].strength
    return h.ranked == 1 and (strength >= CLEAR * h.level or CLEAR * strength <= h.level)


@inline_kernel
def _gather_open(h, w, params, pose):
    """Return a slot with the closed summary of everything since the newest key frame."""
    open_slot = take_slot(h, w.free, w.slots)
    own = w.slots[open_slot]
    merge_into(params, own, w.slots[h.slot_settled])
    merge_into(params, own, w.slots[h.slot_since])
    merge_into(params, own, w.slots[h.slot_run])
    frame = SummaryFrame(w.body, pose, h.joints, h.pending_time, h.pending_weight, h.pending_moving)
    add_frame(params, own, frame)
    flush_sums(params, own, w.body, h.lanes)
    close(params, own)
    return open_slot


@inline_kernel
def _close_take(h, w, params, pose, events):
    """Close the last segment and rank all undecided key frames together."""
    place_last_frame(h, w.body, w.slots, params, pose, h.run_length, h.run_length < 0)
    pour_waiting(h, w.body, w.slots, params)
    if h.candidate >= 0:
        _put_candidate(h, events, WITHDRAWN, h.candidate, h.candidate_time, h.candidate_share)
        h.candidate = -1
        settle(h, w.body, w.slots, params)
    if h.awaiting == 1 and h.undecided > 0:
        _withdraw_newest(h, w, params, events)
    if h.post_roll > 0.0:
        flatten(h, w.body, pose)
        for j in range(h.lanes):
            pose[3, j] = REST
        add_pose(params, w.slots[h.slot_settled], pose, h.joints, h.time, h.post_roll)
    close(params, w.slots[h.slot_settled])
    rank(h, w, params, h.slot_settled)


@inline_kernel
def _withdraw_newest(h, w, params, events):
    """Take back the newest key frame, confirmed early, since the maximum that accepts it never came."""
    newest = h.undecided - 1
    key = w.keys[newest]
    if h.offline == 0 and key.before != NOT_STANDING:
        put_segment(h, w, params, events, key.before, newest, SEGMENT_WITHDRAWN)
    identity, share, rev = key.frame, key.velocity, key.rev + 1
    put_key_frame(
        h, events, WITHDRAWN, key.kind, identity, identity, key.time, share, UNKNOWN_STRENGTH, rev, DECIDED
    )
    slot = w.order[newest]
    merge_into(params, w.slots[slot], w.slots[h.slot_settled])
    give_slot(h, w.free, h.slot_settled)
    h.slot_settled = slot
    h.undecided -= 1
    h.ordinal -= 1


@inline_kernel
def _decide_all(h, w, params, events):
    """Decide all undecided key frames by their strengths, and end the take."""
    relabel(h, w, params, events)
    h.open = 0
    while h.undecided > 0:
        decide_oldest(h, w, params, events, h.slot_settled, h.used_frame + 1)
    _put_last_segment(h, w, params, events)
    h.take += 1
    h.next_frame = 0


@inline_kernel
def _put_last_segment(h, w, params, events):
    """Put the final message about the segment from the last final key frame to the end into the outbox."""
    for d in range(h.slot):
        w.scratch[OWN, d] = w.slots[h.slot_settled, d]
        if h.has_before == 1:
            w.scratch[PREVIOUS, d] = w.slots[h.slot_before, d]
    event = next_event(h, events, SEGMENT)
    event.id = h.left_id
    event.frame = h.left_frame
    event.time = h.left_time
    event.end_id = h.used_frame
    event.until_frame = h.used_frame
    event.until_time = h.time
    event.rev = 1
    if h.offline == 0 and h.ordinal > 0 and w.keys[0].frame == h.used_frame:
        # A key frame in the last frame, merged: there were messages about a segment of the same name.
        places = h.capacity + 2
        event.rev += w.counts[places, (h.ordinal - 1) % places]
    describe(h, w, params, event, h.has_before == 1, SEGMENT_FINAL, BEFORE, h.left_ordinal, UNKNOWN)
