"""Location: a final key frame may move to the likeliest place near where Algorithm 2 found it.

Half of the error at motion level is location, not detection (`sig_threshold` finds the pause, not its middle).
`free` tries every kept pose within `refine` seconds, `candidates` the undecided key frames to the right that do
not stand. The new place lies strictly between the neighbouring key frames; undecided key frames that it passes
are merged for good.
"""

import numpy as np

from mossar_stream.compiled import compiled
from mossar_stream.similarity import add_pose, close, merge_into, strength
from mossar_stream.trail import frames_of, load_pose, times_of, weights_of
from mossar_stream.window import keys_of, order_of, slots_of, span

NONE, FREE, CANDIDATES = range(3)
LOCATIONS = ("none", "free", "candidates")
MARGIN = 1e-6  # s, for the rounding of timestamps


@compiled
def right_neighbour(h, row):
    """Return the place in the window of the next standing key frame after the oldest, or their number."""
    keys = keys_of(h, row)
    for i in range(1, h.undecided):
        if keys[i].standing == 1:
            return i
    return h.undecided


@compiled
def best_candidate(h, row, params, open_slot):
    """Return the place of the undecided key frame that the oldest had better move to; 0 to stay."""
    keys, order, slots = keys_of(h, row), order_of(h, row), slots_of(h, row)
    both, right = np.empty(h.slot), np.empty(h.slot)
    left = slots[order[0]].copy()
    neighbour = right_neighbour(h, row)
    best, place = -1.0, 0
    for i in range(neighbour):
        if keys[i].time - keys[0].time > h.refine + MARGIN:
            break
        if i > 0:
            merge_into(params, left, slots[order[i]])
            close(params, left)
        span(h, row, params, i + 1, neighbour, open_slot, right)
        cost = strength(params, left, right, both)
        if cost > best:
            best, place = cost, i
    return place


@compiled
def best_pose(h, row, params, open_slot, end_frame):
    """Return how far back in the trail the likeliest place for the oldest key frame lies; -1 to stay.

    Args:
        open_slot: Slot of the open segment.
        end_frame: The new place lies before this frame.
    """
    key = keys_of(h, row)[0]
    home = _pose_at(h, row, key.frame)
    if home < 0:
        return -1
    left = slots_of(h, row)[order_of(h, row)[0]].copy()
    right, both = np.empty(h.slot), np.empty(h.slot)
    span(h, row, params, 1, right_neighbour(h, row), open_slot, right)
    stay = strength(params, left, right, both)
    earlier, cost_earlier = _search(h, row, params, left.copy(), right.copy(), both, home, 1, end_frame)
    later, cost_later = _search(h, row, params, left, right, both, home, -1, end_frame)
    if max(cost_earlier, cost_later) <= stay:
        return -1
    return earlier if cost_earlier >= cost_later else later


@compiled
def _pose_at(h, row, frame):
    """Return how far back in the trail the first pose at or after `frame` is, -1 if none."""
    frames = frames_of(h, row)
    found = -1
    for back in range(h.trail_filled):
        if frames[(h.trail_head - 1 - back) % h.trail_size] < frame:
            break
        found = back
    return found


@compiled
def _search(h, row, params, left, right, both, home, direction, end_frame):
    """Move the border pose by pose away from `home`; return the best place and its cost."""
    times, frames, weights = times_of(h, row), frames_of(h, row), weights_of(h, row)
    key = keys_of(h, row)[0]
    pose = np.empty((4, h.lanes))
    best, place = -1.0, -1
    border = home
    while 0 <= border + direction < h.trail_filled:
        passed = border + direction if direction > 0 else border
        border += direction
        at = (h.trail_head - 1 - border) % h.trail_size
        if abs(times[at] - key.time) > h.refine + MARGIN or not h.left_frame < frames[at] < end_frame:
            break
        load_pose(h, row, passed, pose)
        weight = weights[(h.trail_head - 1 - passed) % h.trail_size] * direction
        add_pose(params, right, pose, h.joints, weight)
        add_pose(params, left, pose, h.joints, -weight)
        close(params, left)
        close(params, right)
        cost = strength(params, left, right, both)
        if cost > best:
            best, place = cost, border
    return place, best


@compiled
def move_poses(h, row, params, slot, begin_frame, end_frame, sign):
    """Add (sign 1) or take out (-1) the kept poses of frames begin … end - 1 to or from a slot."""
    frames, weights = frames_of(h, row), weights_of(h, row)
    pose = np.empty((4, h.lanes))
    target = slots_of(h, row)[slot]
    for back in range(h.trail_filled):
        at = (h.trail_head - 1 - back) % h.trail_size
        if begin_frame <= frames[at] < end_frame:
            load_pose(h, row, back, pose)
            add_pose(params, target, pose, h.joints, sign * weights[at])
    close(params, target)
