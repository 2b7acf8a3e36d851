"""Decision: the oldest undecided key frame leaves the window for good."""

import numpy as np

from mossar_stream.algorithm.location import CANDIDATES, FREE, best_candidate, best_pose, move_poses
from mossar_stream.algorithm.pose_history import place_back
from mossar_stream.algorithm.remerging import forget
from mossar_stream.algorithm.window import put_segment
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.event_buffer import DECIDED, FINAL, MERGED, SEGMENT_FINAL, put_key_frame
from mossar_stream.memory.slots import give_slot
from mossar_stream.similarity.protocol import close, merge_into

OLDEST, ONE = np.arange(2)


@kernel
def decide_oldest(h, w, params, events, open_slot, end_frame):
    """Decide the oldest key frame: final where it stands at the level, merged if not.

    Args:
        h: Header of the row.
        w: Views of the row's window.
        params: Parameters of the similarity measure.
        events: Outbox.
        open_slot: Slot with the summary of everything since the newest key frame.
        end_frame: A final key frame moves to a frame before this one, up to which the settled slot is complete.
    """
    key = w.keys[0]
    if key.standing == 0:
        _put_decided(h, w, events, OLDEST, MERGED, key.frame, key.time)
        following = w.order[1] if h.undecided > 1 else h.slot_settled
        # The earlier segment takes the later one in, and then its place.
        merge_into(params, w.slots[w.order[0]], w.slots[following])
        close(params, w.slots[w.order[0]])
        give_slot(h, w.free, following)
        if h.undecided > 1:
            w.order[1] = w.order[0]
        else:
            h.slot_settled = w.order[0]
        _shift(h, w, ONE)
        return
    frame, time, passed = _locate(h, w, params, open_slot, end_frame)
    _put_decided(h, w, events, OLDEST, FINAL, frame, time)
    for i in range(1, passed + 1):
        _put_decided(h, w, events, i, MERGED, w.keys[i].frame, w.keys[i].time)
    put_segment(h, w, params, events, h.left_ordinal, OLDEST, SEGMENT_FINAL)
    events[events[0].row].until_frame = frame
    events[events[0].row].until_time = time
    _leave(h, w, params, passed, frame, time)


@inline_kernel
def _locate(h, w, params, open_slot, end_frame):
    """Return frame and time where the oldest key frame had better be, and how many others it passes."""
    key = w.keys[0]
    if h.location == CANDIDATES:
        passed = best_candidate(h, w, params, open_slot)
        return w.keys[passed].frame, w.keys[passed].time, passed
    if h.location == FREE:
        back = best_pose(h, w, params, open_slot, end_frame)
        if back >= 0:
            mark = w.marks[place_back(h, back)]
            passed = 0
            while passed + 1 < h.undecided and w.keys[passed + 1].frame <= mark.frame:
                passed += 1
            return mark.frame, mark.time, passed
    return key.frame, key.time, 0


@kernel
def _put_decided(h, w, events, place, status, frame, time):
    """Put the last message about a key frame into the outbox."""
    key = w.keys[place]
    key.rev += 1
    identity, share, rank = key.frame, key.velocity, key.strength
    put_key_frame(h, events, status, key.kind, identity, frame, time, share, rank, key.rev, DECIDED)


@inline_kernel
def _leave(h, w, params, passed, frame, time):
    """Let the oldest key frame be the window's left end, at its new place, with `passed` others merged."""
    oldest, ordinal, origin = w.keys[0].frame, w.keys[0].ordinal, w.keys[passed].frame
    ended = w.order[0]
    for i in range(1, passed + 1):
        merge_into(params, w.slots[ended], w.slots[w.order[i]])
        give_slot(h, w.free, w.order[i])
    close(params, w.slots[ended])
    _shift(h, w, passed + 1)
    following = w.order[0] if h.undecided > 0 else h.slot_settled
    if frame < oldest:
        move_poses(h, w, params, ended, following, frame, oldest)
    elif frame > origin:
        move_poses(h, w, params, following, ended, origin, frame)
    if h.has_before == 1:
        give_slot(h, w.free, h.slot_before)
    h.slot_before = ended
    h.has_before = 1
    h.left_frame = frame
    h.left_id = oldest
    h.left_time = time
    h.left_ordinal = ordinal
    places = h.capacity + 2
    for i in range(w.counts.shape[1]):
        w.counts[places, i] = w.counts[ordinal % places, i]
    if frame != oldest:
        # The first segment is no longer what it was; what was remembered of it is void.
        forget(w.memo, ordinal)


@kernel
def _shift(h, w, count):
    """Drop the leftmost key frames and segments; if none is left, the newest key frame stays in place 0."""
    if count == h.undecided:
        w.keys[0] = w.keys[count - 1]
    for i in range(h.undecided - count):
        w.keys[i] = w.keys[i + count]
        w.order[i] = w.order[i + count]
    h.undecided -= count
