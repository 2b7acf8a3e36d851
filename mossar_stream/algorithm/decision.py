"""Decision: when the oldest undecided key frame is due, and how it leaves the window for good."""

import numpy as np

from mossar_stream.algorithm.location import (
    LOCATION_CANDIDATES,
    LOCATION_FREE,
    LOCATION_NONE,
    best_candidate,
    best_pose,
    move_poses,
)
from mossar_stream.algorithm.pose_history import place_back
from mossar_stream.algorithm.remerging import forget
from mossar_stream.algorithm.repetition_labels import (
    LABELLED_AFTER,
    LABELLED_LATE,
    UNLABELLED,
    due_label,
    label_candidate,
)
from mossar_stream.algorithm.window import note_span, point_of, put_segment
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.memory.event_buffer import (
    DECIDED,
    KEY_FINAL,
    KEY_MERGED,
    KEY_WITHDRAWN,
    SEGMENT_FINAL,
    put_key_frame,
)
from mossar_stream.memory.slots import free
from mossar_stream.similarity.protocol import close, merge_into

OLDEST_KEY, ONE = np.arange(2)


@inline_kernel
def set_due_time(w):
    """Set when the oldest undecided key frame must be decided, or a label of a candidate is due."""
    due = np.inf
    if w.state.undecided > 0 and w.plan.offline == 0:
        due = w.keys[0].time + w.plan.hold
    w.state.due_time = min(due, due_label(w.labels, label_delay(w.plan)))


@inline_kernel
def label_delay(plan):
    """Return how old a candidate is when it is judged, s: decided it is not earlier; see repetition_labels.py."""
    return LABELLED_LATE if plan.labels_late == 1 else min(plan.hold, LABELLED_AFTER)


@kernel
def judge_candidates(w, until):
    """Judge the candidates that are due until some time, s, and let their key frames know."""
    first = w.state.ordinal - w.state.undecided
    while due_label(w.labels, label_delay(w.plan)) <= until:
        ordinal = w.labels.state.labelled
        label = label_candidate(w.labels)
        if ordinal >= first and label != UNLABELLED:
            w.keys[ordinal - first].label = label
            w.state.ranked = 0


@inline_kernel
def is_due(w):
    """Tell whether the oldest key frame must be decided now."""
    state = w.state
    if state.undecided == 0:
        return False
    return state.undecided > w.plan.capacity or w.clock.time >= w.keys[0].time + w.plan.hold


@kernel
def decide_oldest(w, settled, open_slot, end_frame):
    """Decide the oldest key frame: final where it is kept at the level, merged if not.

    Args:
        w: Window.
        settled: Slot of the open segment that follows the newest key frame.
        open_slot: Slot with the summary of everything since the newest key frame.
        end_frame: A final key frame moves to a frame before this one, up to which the settled slot is complete.

    Returns:
        The slot of the open segment that follows the newest key frame from now on.
    """
    key, state = w.keys[0], w.state
    if key.kept == 0:
        if key.reported == 1:
            _put_decided(w, OLDEST_KEY, KEY_MERGED, key.at_frame, key.at_time)
        elif key.rev > 0:
            _put_decided(w, OLDEST_KEY, KEY_WITHDRAWN, key.frame, key.time)
        following = w.order[1] if state.undecided > 1 else settled
        # The earlier segment takes the later one in, and then its place.
        merge_into(w.params, w.summaries[w.order[0]], w.summaries[following])
        close(w.params, w.summaries[w.order[0]])
        free(w.slots, w.unused, following)
        if state.undecided > 1:
            w.order[1] = w.order[0]
        else:
            settled = w.order[0]
        _shift(w, ONE)
        return settled
    frame, time, passed = _locate(w, open_slot, end_frame)
    _put_decided(w, OLDEST_KEY, KEY_FINAL, frame, time)
    for i in range(1, passed + 1):
        _put_decided(w, i, KEY_MERGED, w.keys[i].at_frame, w.keys[i].at_time)
    put_segment(w, state.left_ordinal, OLDEST_KEY, SEGMENT_FINAL)
    segment = w.events[w.events[0].row]
    segment.until_frame = frame
    segment.until_time = time
    note_span(w, segment)
    _leave(w, settled, passed, frame, time)
    return settled


@inline_kernel
def _locate(w, open_slot, end_frame):
    """Return frame and time where the oldest key frame had better be, and how many others it passes."""
    key, location = w.keys[0], w.plan.location
    if location == LOCATION_CANDIDATES:
        passed = best_candidate(w, open_slot)
        return w.keys[passed].frame, w.keys[passed].time, passed
    if location == LOCATION_FREE:
        back = best_pose(w, open_slot, end_frame)
        if back >= 0:
            mark = w.history.marks[place_back(w.history, back)]
            passed = 0
            while passed + 1 < w.state.undecided and w.keys[passed + 1].frame <= mark.frame:
                passed += 1
            return mark.frame, mark.time, passed
    return key.at_frame, key.at_time, 0


@kernel
def _put_decided(w, place, status, frame, time):
    """Put the last message about a key frame into the event buffer."""
    key = w.keys[place]
    key.rev += 1
    put_key_frame(w.clock, w.events, point_of(key, frame, time, key.strength), status, key.rev, DECIDED)


@inline_kernel
def _leave(w, settled, passed, frame, time):
    """Let the oldest key frame be the window's left end, at its new place, with `passed` others merged."""
    state, summaries = w.state, w.summaries
    oldest, ordinal, origin = w.keys[0].frame, w.keys[0].ordinal, w.keys[passed].frame
    moves = w.plan.location != LOCATION_NONE
    ended = w.order[0]
    for i in range(1, passed + 1):
        merge_into(w.params, summaries[ended], summaries[w.order[i]])
        free(w.slots, w.unused, w.order[i])
    close(w.params, summaries[ended])
    _shift(w, passed + 1)
    following = w.order[0] if state.undecided > 0 else settled
    if moves and frame < oldest:
        move_poses(w, ended, following, frame, oldest)
    elif moves and frame > origin:
        move_poses(w, following, ended, origin, frame)
    if state.has_before == 1:
        free(w.slots, w.unused, state.before)
    state.before = ended
    state.has_before = 1
    state.left_frame = frame
    state.left_id = oldest
    state.left_time = time
    state.left_ordinal = ordinal
    places = w.plan.capacity + 2
    for i in range(w.counts.shape[1]):
        w.counts[places, i] = w.counts[ordinal % places, i]
    if moves and frame != oldest:
        # The first segment is no longer what it was; what was remembered of it is void.
        forget(w.memo, ordinal)


@kernel
def _shift(w, count):
    """Drop the leftmost key frames and segments; if none is left, the newest key frame stays in place 0."""
    undecided = w.state.undecided
    if count == undecided:
        w.keys[0] = w.keys[count - 1]
    for i in range(undecided - count):
        w.keys[i] = w.keys[i + count]
        w.order[i] = w.order[i + count]
    w.state.undecided -= count
