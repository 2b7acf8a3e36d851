"""Location: a final key frame may move to the likeliest place near where Algorithm 2 found it.

Half of the error at motion level is location, not detection (`sig_threshold` finds the pause, not its middle).
`free` tries every kept pose within `refine` seconds, `candidates` the undecided key frames to the right that are
not kept. The new place lies strictly between the neighbouring key frames; undecided key frames that it passes
are merged for good.
"""

import numpy as np

from mossar_stream.algorithm.clock import TIME_ROUNDING
from mossar_stream.algorithm.pose_history import load_pose, place_back
from mossar_stream.algorithm.window import BOTH, LEFT_OF_KEY, RIGHT_OF_KEY, span
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.similarity.protocol import add_pose, close, merge_cost, merge_into, strength

LOCATION_NONE, LOCATION_FREE, LOCATION_CANDIDATES = np.arange(3)
LOCATIONS = ("none", "free", "candidates")
SECOND = np.int64(1)
UNMOVED = np.int64(-1)
BOTH_WAYS = (
    np.int64(1),
    np.int64(-1),
)  # to earlier poses, and to later ones: they are counted back from the newest


@kernel
def right_neighbour(w):
    """Return the place in the window of the next kept key frame after the oldest, or their number."""
    for i in range(1, w.state.undecided):
        if w.keys[i].kept == 1:
            return i
    return w.state.undecided


@kernel
def _load_left(w):
    """Set the scratch's LEFT to the segment that ends at the oldest key frame."""
    for d in range(w.plan.slot):
        w.scratch.summaries[LEFT_OF_KEY, d] = w.summaries[w.order[0], d]


@kernel
def best_candidate(w, open_slot):
    """Return the place of the undecided key frame that the oldest had better move to; 0 to stay."""
    neighbour = right_neighbour(w)
    left, right, both = (
        w.scratch.summaries[LEFT_OF_KEY],
        w.scratch.summaries[RIGHT_OF_KEY],
        w.scratch.summaries[BOTH],
    )
    _load_left(w)
    best, place = -1.0, 0
    for i in range(neighbour):
        if w.keys[i].time - w.keys[0].time > w.plan.refine + TIME_ROUNDING:
            break
        if i > 0:
            merge_into(w.params, left, w.summaries[w.order[i]])
            close(w.params, left)
        span(w, i + 1, neighbour, open_slot, RIGHT_OF_KEY)
        cost = strength(w.params, left, right, both)
        if cost > best:
            best, place = cost, i
    return place


@inline_kernel
def best_pose(w, open_slot, end_frame):
    """Return how far back among the kept poses the likeliest place for the oldest key frame lies; -1 to stay.

    Args:
        w: Window.
        open_slot: Slot of the open segment.
        end_frame: The new place lies before this frame.
    """
    unmoved = UNMOVED
    for back in range(w.history.state.filled):
        if w.history.marks[place_back(w.history, back)].frame < w.keys[0].frame:
            break
        unmoved = back  # type: ignore[assignment]
    neighbour = right_neighbour(w)
    limit = w.keys[neighbour].frame if neighbour < w.state.undecided else end_frame
    place, most = UNMOVED, -1.0
    for direction in BOTH_WAYS:
        there, cost = _search(w, open_slot, unmoved, direction, limit)
        if cost > most:
            place, most = there, cost
    return place


@inline_kernel
def _search(w, open_slot, unmoved, direction, limit):
    """Move the border pose by pose away from `unmoved`; return the best place, -1 for unmoved, and its cost."""
    span(w, SECOND, right_neighbour(w), open_slot, RIGHT_OF_KEY)
    _load_left(w)
    left, right, both = (
        w.scratch.summaries[LEFT_OF_KEY],
        w.scratch.summaries[RIGHT_OF_KEY],
        w.scratch.summaries[BOTH],
    )
    pose, marks = w.scratch.pose, w.history.marks
    best, place = strength(w.params, left, right, both), UNMOVED
    border = unmoved
    while unmoved >= 0 and 0 <= border + direction < w.history.state.filled:
        passed = border + direction if direction > 0 else border
        border += direction
        mark = marks[place_back(w.history, border)]
        if abs(mark.time - w.keys[0].time) > w.plan.refine + TIME_ROUNDING:
            break
        if not w.state.left_frame < mark.frame < limit:
            break
        load_pose(w.history, pose, passed)
        mark = marks[place_back(w.history, passed)]
        add_pose(w.params, right, pose, w.plan.joints, mark.time, mark.weight * direction)
        add_pose(w.params, left, pose, w.plan.joints, mark.time, -mark.weight * direction)
        close(w.params, left)
        close(w.params, right)
        cost = merge_cost(w.params, left, right, both)  # what lies left and right together stays the same
        if cost > best:
            best, place = cost, border
    return place, best


@kernel
def move_poses(w, source, target, begin_frame, end_frame):
    """Move the kept poses of frames begin … end - 1 from one slot to another."""
    pose = w.scratch.pose
    for back in range(w.history.state.filled):
        mark = w.history.marks[place_back(w.history, back)]
        if begin_frame <= mark.frame < end_frame:
            load_pose(w.history, pose, back)
            add_pose(w.params, w.summaries[source], pose, w.plan.joints, mark.time, -mark.weight)
            add_pose(w.params, w.summaries[target], pose, w.plan.joints, mark.time, mark.weight)
    close(w.params, w.summaries[source])
    close(w.params, w.summaries[target])
