"""Location: a final key frame may move to the likeliest place near where Algorithm 2 found it.

Half of the error at motion level is location, not detection (`sig_threshold` finds the pause, not its middle).
`free` tries every kept pose within `refine` seconds, `candidates` the undecided key frames to the right that do
not stand. The new place lies strictly between the neighbouring key frames; undecided key frames that it passes
are merged for good.
"""

import numpy as np

from mossar_stream.algorithm.pose_history import load_pose, place_back
from mossar_stream.algorithm.window import BOTH, LEFT, RIGHT, span
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.similarity.protocol import add_pose, close, merge_cost, merge_into, strength

NONE, FREE, CANDIDATES = np.arange(3)
LOCATIONS = ("none", "free", "candidates")
MARGIN = 1e-6  # s, for the rounding of timestamps
NEXT = np.int64(1)
STAY = np.int64(-1)
DIRECTIONS = (
    np.int64(1),
    np.int64(-1),
)  # to earlier poses, and to later ones: the trail counts back from the newest


@kernel
def right_neighbour(h, w):
    """Return the place in the window of the next standing key frame after the oldest, or their number."""
    for i in range(1, h.undecided):
        if w.keys[i].standing == 1:
            return i
    return h.undecided


@kernel
def _load_left(h, w):
    """Set the scratch's LEFT to the segment that ends at the oldest key frame."""
    for d in range(h.slot):
        w.scratch[LEFT, d] = w.slots[w.order[0], d]


@kernel
def best_candidate(h, w, params, open_slot):
    """Return the place of the undecided key frame that the oldest had better move to; 0 to stay."""
    neighbour = right_neighbour(h, w)
    left, right, both = w.scratch[LEFT], w.scratch[RIGHT], w.scratch[BOTH]
    _load_left(h, w)
    best, place = -1.0, 0
    for i in range(neighbour):
        if w.keys[i].time - w.keys[0].time > h.refine + MARGIN:
            break
        if i > 0:
            merge_into(params, left, w.slots[w.order[i]])
            close(params, left)
        span(h, w, params, i + 1, neighbour, open_slot, RIGHT)
        cost = strength(params, left, right, both)
        if cost > best:
            best, place = cost, i
    return place


@inline_kernel
def best_pose(h, w, params, open_slot, end_frame):
    """Return how far back in the trail the likeliest place for the oldest key frame lies; -1 to stay.

    Args:
        h: Header of the row.
        w: Views of the row's window.
        params: Parameters of the similarity measure.
        open_slot: Slot of the open segment.
        end_frame: The new place lies before this frame.
    """
    home = STAY
    for back in range(h.trail_filled):
        if w.marks[place_back(h, back)].frame < w.keys[0].frame:
            break
        home = back  # type: ignore[assignment]
    neighbour = right_neighbour(h, w)
    limit = w.keys[neighbour].frame if neighbour < h.undecided else end_frame
    place, most = STAY, -1.0
    for direction in DIRECTIONS:
        there, cost = _search(h, w, params, open_slot, home, direction, limit)
        if cost > most:
            place, most = there, cost
    return place


@inline_kernel
def _search(h, w, params, open_slot, home, direction, limit):
    """Move the border pose by pose away from `home`; return the best place, -1 for home, and its cost."""
    span(h, w, params, NEXT, right_neighbour(h, w), open_slot, RIGHT)
    _load_left(h, w)
    left, right, both = w.scratch[LEFT], w.scratch[RIGHT], w.scratch[BOTH]
    best, place = strength(params, left, right, both), STAY
    border = home
    while home >= 0 and 0 <= border + direction < h.trail_filled:
        passed = border + direction if direction > 0 else border
        border += direction
        mark = w.marks[place_back(h, border)]
        if abs(mark.time - w.keys[0].time) > h.refine + MARGIN or not h.left_frame < mark.frame < limit:
            break
        load_pose(h, w.marks, w.trail, w.kept, passed)
        mark = w.marks[place_back(h, passed)]
        add_pose(params, right, w.kept, h.joints, mark.time, mark.weight * direction)
        add_pose(params, left, w.kept, h.joints, mark.time, -mark.weight * direction)
        close(params, left)
        close(params, right)
        cost = merge_cost(params, left, right, both)  # what lies left and right together stays the same
        if cost > best:
            best, place = cost, border
    return place, best


@kernel
def move_poses(h, w, params, source, target, begin_frame, end_frame):
    """Move the kept poses of frames begin … end - 1 from one slot to another."""
    for back in range(h.trail_filled):
        mark = w.marks[place_back(h, back)]
        if begin_frame <= mark.frame < end_frame:
            load_pose(h, w.marks, w.trail, w.kept, back)
            add_pose(params, w.slots[source], w.kept, h.joints, mark.time, -mark.weight)
            add_pose(params, w.slots[target], w.kept, h.joints, mark.time, mark.weight)
    close(params, w.slots[source])
    close(params, w.slots[target])
