"""Take: the open segment, and what splitter and window do to it.

Frames since the last key frame lie in three summaries: those up to the candidate (`settled`), those after it
(`since`), and those of a plateau that may yet become a candidate (`run`). The last frame waits outside, because
the next one tells whether it was a minimum. When a candidate is confirmed, `settled` is the segment before it and
`since` the beginning of the one after it; nothing is replayed.
"""

import numpy as np

from mossar_stream.algorithm.splitter import CONFIRMED, CROSSED, REPLACED, WITHDRAWN, follow_curve
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.joint_pages import PAGE, PAGE_SIZE, SUM_PATH, SUM_X
from mossar_stream.memory.slots import empty_slot, take_slot
from mossar_stream.similarity.protocol import add_frame, flush_sums, merge_into
from mossar_stream.similarity.summary import SummaryFrame

MOST_WAITING = 32  # frames, in single precision: their sums are good to a millionth


@kernel
def open_take(h, body, row_free, slots, memo, time):
    """Empty everything that belongs to a take; the running range survives.

    Args:
        h: Header of the row.
        body: See joint_pages.py.
        row_free: (slots,) stack of unused slots.
        slots: (slots, slot) summaries.
        memo: Remembered costs.
        time: s, of the first frame.
    """
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
    h.noise_time = 0.0
    h.noise_span = 0.0
    h.noise_path = 0.0
    h.noise_turn = 0.0
    h.noise_squares = 0.0
    h.happened = 0
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
    for i in range(len(memo)):
        memo[i].middle = -9
    for first in range(0, len(body), PAGE_SIZE):
        sums = body[first + SUM_X : first + SUM_PATH + PAGE]
        for i in range(len(sums)):
            sums[i] = 0.0
    h.waiting = 0
    for i in range(h.slot_count):
        row_free[i] = i
    h.free_count = h.slot_count
    h.slot_settled = take_slot(h, row_free, slots)
    h.slot_since = take_slot(h, row_free, slots)
    h.slot_run = take_slot(h, row_free, slots)


@inline_kernel
def split(h, body, free, slots, params, pose, value, scale):
    """Take the next velocity in, give the last frame to its summary, and note what the splitter found.

    Args:
        h: Header of the row.
        body: See joint_pages.py; the features are still those of the last frame.
        free: (slots,) stack of unused slots.
        slots: (slots, slot) summaries.
        params: Parameters of the similarity measure.
        pose: (4, lanes) of the last frame, if the measure takes it.
        value: V[t].
        scale: What 1 is on the scale of V.
    """
    candidate, time, share = h.candidate, h.candidate_time, h.candidate_share
    run_length = h.run_length
    happened = follow_curve(h, value, scale, h.used_frame, h.time)
    goes_on = h.run_length > run_length and happened & CROSSED == 0
    if happened & REPLACED:
        h.former_frame, h.former_time, h.former_share = candidate, time, share
        settle(h, body, slots, params)
    place_last_frame(h, body, slots, params, pose, run_length, goes_on)
    h.happened = happened
    if happened == 0:
        return
    h.found_frame, h.found_time, h.found_share = h.candidate, h.candidate_time, h.candidate_share
    if happened & WITHDRAWN:
        settle(h, body, slots, params)
    if happened & (CROSSED | CONFIRMED):
        h.candidate = -1
        h.closed = h.slot_settled
        h.slot_settled = h.slot_since
        h.slot_since = take_slot(h, free, slots)


@inline_kernel
def place_last_frame(h, body, slots, params, pose, run_length, goes_on):
    """Give the last frame to the summary it belongs to, and the run with it if the run is over."""
    target = h.slot_since if h.candidate >= 0 else h.slot_settled
    slot = h.slot_run if goes_on or run_length > 1 else target
    if slot != h.fed or h.waiting >= MOST_WAITING:
        pour_waiting(h, body, slots, params)
        h.fed = slot
    frame = SummaryFrame(body, pose, h.joints, h.pending_time, h.pending_weight, h.pending_moving)
    add_frame(params, slots[slot], frame)
    h.waiting += 1
    if slot != target and not goes_on:
        pour_waiting(h, body, slots, params)
        merge_into(params, slots[target], slots[slot])
        empty_slot(slots[slot])


@inline_kernel
def pour_waiting(h, body, slots, params):
    """Add the sums that wait to the summary they belong to; before anything else is done with it."""
    if h.waiting > 0:
        flush_sums(params, slots[h.fed], body, h.lanes)
        h.waiting = 0


@kernel
def settle(h, body, slots, params):
    """Give what came since the candidate to what came before it."""
    pour_waiting(h, body, slots, params)
    merge_into(params, slots[h.slot_settled], slots[h.slot_since])
    empty_slot(slots[h.slot_since])
