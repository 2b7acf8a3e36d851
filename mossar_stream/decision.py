"""Decision: the oldest undecided key frame leaves the window for good."""

from mossar_stream.compiled import compiled
from mossar_stream.location import CANDIDATES, FREE, best_candidate, best_pose, move_poses
from mossar_stream.outbox import FINAL, MERGED, SEGMENT_FINAL, put_key_frame
from mossar_stream.similarity import close, merge_into
from mossar_stream.trail import frames_of, times_of
from mossar_stream.window import counts_of, forget_costs, give_slot, keys_of, order_of, put_segment, slots_of


@compiled
def decide_oldest(h, row, events, params, open_slot, end_frame):
    """Decide the oldest key frame: final where it stands at the level, merged if not.

    Args:
        open_slot: Slot with the summary of everything since the newest key frame.
        end_frame: A final key frame moves to a frame before this one, up to which the settled slot is complete.
    """
    if keys_of(h, row)[0].standing == 0:
        _put_decided(h, row, events, 0, MERGED, keys_of(h, row)[0].frame, keys_of(h, row)[0].time)
        _absorb(h, row, params)
        return
    _finish_oldest(h, row, events, params, open_slot, end_frame)


@compiled
def _finish_oldest(h, row, events, params, open_slot, end_frame):
    """Make the oldest key frame final, after the location step."""
    keys = keys_of(h, row)
    frame, time, passed = keys[0].frame, keys[0].time, 0
    if h.location == CANDIDATES:
        passed = best_candidate(h, row, params, open_slot)
        frame, time = keys[passed].frame, keys[passed].time
    elif h.location == FREE:
        limit = end_frame
        for i in range(h.undecided - 1, 0, -1):
            if keys[i].standing == 1:
                limit = min(limit, keys[i].frame)
        back = best_pose(h, row, params, open_slot, limit)
        if back >= 0:
            at = (h.trail_head - 1 - back) % h.trail_size
            frame, time = frames_of(h, row)[at], times_of(h, row)[at]
            while passed + 1 < h.undecided and keys[passed + 1].frame <= frame:
                passed += 1
    _put_decided(h, row, events, 0, FINAL, frame, time)
    for i in range(1, passed + 1):
        _put_decided(h, row, events, i, MERGED, keys[i].frame, keys[i].time)
    put_segment(h, row, events, params, h.left_ordinal, keys[0].ordinal, SEGMENT_FINAL)
    events[events[0].row].until_frame = frame
    events[events[0].row].until_time = time
    _leave(h, row, params, passed, frame, time)


@compiled
def _put_decided(h, row, events, place, status, frame, time):
    """Put the last message about a key frame into the outbox."""
    key = keys_of(h, row)[place]
    key.rev += 1
    put_key_frame(h, events, status, key.kind, key.frame, frame, time, key.velocity, key.strength, key.rev, 1)


@compiled
def _leave(h, row, params, passed, frame, time):
    """Let the oldest key frame be the window's left end, at its new place, with `passed` others merged."""
    keys, order, slots = keys_of(h, row), order_of(h, row), slots_of(h, row)
    oldest = keys[0].frame
    ordinal = keys[0].ordinal
    origin = keys[passed].frame
    for i in range(1, passed + 1):
        merge_into(params, slots[order[0]], slots[order[i]])
        give_slot(h, row, order[i])
    ended = order[0]
    _shift(h, row, passed + 1)
    following = order[0] if h.undecided > 0 else h.slot_settled
    if frame < oldest:
        move_poses(h, row, params, following, frame, oldest, 1)
        move_poses(h, row, params, ended, frame, oldest, -1)
    elif frame > origin:
        move_poses(h, row, params, following, origin, frame, -1)
        move_poses(h, row, params, ended, origin, frame, 1)
    close(params, slots[ended])
    if h.has_before == 1:
        give_slot(h, row, h.slot_before)
    h.slot_before = ended
    h.has_before = 1
    h.left_frame, h.left_id, h.left_time, h.left_ordinal = frame, oldest, time, ordinal
    _inherit_left(h, row, ordinal)
    if frame != oldest or passed > 0:
        forget_costs(h, row)


@compiled
def _inherit_left(h, row, ordinal):
    """Keep the message counts of segments that began at the key frame which is now the left end."""
    places = h.capacity + 2
    counts = counts_of(h, row)
    counts[places, :] = counts[ordinal % places, :]


@compiled
def _absorb(h, row, params):
    """Remove the oldest key frame; its segment becomes part of the one that follows."""
    order, slots = order_of(h, row), slots_of(h, row)
    following = order[1] if h.undecided > 1 else h.slot_settled
    merge_into(params, slots[following], slots[order[0]])
    close(params, slots[following])
    give_slot(h, row, order[0])
    _shift(h, row, 1)


@compiled
def _shift(h, row, count):
    """Drop the leftmost key frames and segments from the window's lists."""
    keys, order = keys_of(h, row), order_of(h, row)
    for i in range(h.undecided - count):
        keys[i] = keys[i + count]
        order[i] = order[i + count]
    h.undecided -= count
