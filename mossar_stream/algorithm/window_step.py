"""Window step: what follows from a frame in which something happened.

The frame step stops after such a frame; this compiled call then says what the splitter found, brings the window up to
date and decides what is due. Few frames come here, and it is compiled apart from what every frame goes through.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.activity import BOUT, Activity, put_activity, rests_at_end
from mossar_stream.algorithm.candidate_features import features_of, is_reported, noise_of_speed
from mossar_stream.algorithm.clock import end_take
from mossar_stream.algorithm.decision import ONE, decide_oldest, is_due, judge_candidates, set_due_time
from mossar_stream.algorithm.open_segment import (
    NO_SLOT,
    OpenSegment,
    add_last_frame,
    flush_waiting,
    place_last_frame,
    settle,
)
from mossar_stream.algorithm.pose_history import MARK, REST_SPEED, PoseHistory
from mossar_stream.algorithm.remerging import MEMO, UNKNOWN_BOUNDARY
from mossar_stream.algorithm.repetition_labels import (
    NOTE,
    RepetitionLabels,
    forget_newest,
    note_candidate,
)
from mossar_stream.algorithm.row import ROW
from mossar_stream.algorithm.scales import extent, usual_speed
from mossar_stream.algorithm.splitter import (
    ACCEPTED,
    CROSSED,
    FORGOTTEN,
    PROMOTED,
    REPLACED,
    forget_candidate,
)
from mossar_stream.algorithm.window import (
    BEFORE_WINDOW,
    KEY,
    NOT_KEPT,
    OWN,
    PREVIOUS,
    SPARE_SUMMARIES,
    Scratch,
    Window,
    add_key,
    describe,
    point_of,
    put_segment,
    rank,
    relabel,
    report_kept,
)
from mossar_stream.jit.decorators import entry_point, inline_kernel, kernel
from mossar_stream.jit.views import part
from mossar_stream.memory.event_buffer import (
    DECIDED,
    EVENT,
    EVENT_BYTES,
    FIRST_MESSAGE,
    KEY_CANDIDATE,
    KEY_WITHDRAWN,
    KIND_MINIMUM,
    KIND_OFFSET,
    KIND_ONSET,
    SECOND_MESSAGE,
    SEGMENT,
    SEGMENT_FINAL,
    SEGMENT_WITHDRAWN,
    UNDECIDED,
    UNKNOWN_STRENGTH,
    Point,
    next_event,
    put_key_frame,
)
from mossar_stream.memory.joint_pages import flatten
from mossar_stream.memory.slots import allocate, free
from mossar_stream.repetitions.state import PERIODS
from mossar_stream.similarity.protocol import add_pose, close, flush_sums, merge_into, write_features

FOLLOW, LEVEL, END, RANK, DECIDE = range(5)  # why `update_window` is called
REPORTED, UNREPORTED = np.int64(1), np.int64(0)
LAST_OF_ALL = np.float64(np.finfo(np.float64).max)  # s, when all labels are due
CLEAR = 2.0  # a strength so many times the level, or less than one part in so many of it, is a clear decision
LOG_REST_SPEED = float(np.log(REST_SPEED))  # log speed of a joint at rest


@entry_point(makes_arrays=False)
def update_window(
    row: NDArray[np.uint8],
    params: NDArray[np.void],
    scratch: NDArray[np.uint8],
    event_buffer: NDArray[np.uint8],
    reason: int,
) -> None:
    """Carry out what follows from the last frame.

    Args:
        row: Bytes of the performer.
        params: One-element record array of the similarity measure.
        scratch: Of `new_scratch`.
        event_buffer: With room for `most_events`.
        reason: FOLLOW after a frame at which the frame step stopped, LEVEL after the level moved, END to end the
            take: RANK to close its last segment and rank all key frames, then DECIDE.
    """
    state = part(row, 0, ROW, (1,))[0]
    if state.clock.open == 0:
        return
    w = _window_of(state, row, params, scratch, event_buffer)
    segment = _open_segment_of(state, row, w)
    if reason == LEVEL:
        relabel(w)
        set_due_time(w)
    elif reason == FOLLOW:
        begin = w.events[0].row
        if state.activity.changed == 1:
            put_activity(w.clock, w.events, state.activity)
        _say_what_was_found(w, segment, state)
        judge_candidates(w, w.clock.time)
        set_due_time(w)
        if w.plan.offline == 0 and is_due(w):
            _decide_what_is_due(w, segment, state.curve, begin)
    else:
        if reason != DECIDE:
            if rests_at_end(w.activity, w.clock.taken_time):
                put_activity(w.clock, w.events, state.activity)
            _close_take(w, segment, state.curve)
        if reason != RANK:
            _decide_all(w, segment)


@inline_kernel(returns_views=True)
def _window_of(state, row, params, scratch, event_buffer):
    """Return views of a row, the scratch and the event buffer, as long as the row's plan and `new_scratch` say."""
    plan, at = state.plan, state.at
    places = plan.capacity + 2
    counted = 0 if plan.offline == 1 else places
    repetitions = at.adopted if plan.adopts == 1 else at.periods
    return Window(
        plan,
        state.clock,
        state.joints,
        state.window,
        state.tempo,
        state.slots,
        params[0],
        PoseHistory(
            state.history,
            part(row, at.marks, MARK, (plan.history_size,)),
            part(row, at.poses, np.int16, (plan.history_size, 3, plan.padded_joints)),
            part(row, at.body, np.float32, ((at.seen - at.body) // 4,)),
        ),
        RepetitionLabels(
            state.labels,
            part(row, at.notes, NOTE, (plan.notes,)),
            part(row, repetitions, PERIODS, (plan.has_features,)),
        ),
        Activity(state.activity, part(row, at.bouts, BOUT, (plan.bouts,))),
        state.noise,
        part(row, at.keys, KEY, (places,)),
        part(row, at.order, np.int64, (places,)),
        part(row, at.unused, np.int64, (plan.slot_count,)),
        part(row, at.summaries, np.float64, (plan.slot_count, plan.slot)),
        part(row, at.counts, np.int32, (counted + 1, counted)),
        part(row, at.memo, MEMO, (plan.memo_size,)),
        part(event_buffer, 0, EVENT, (len(event_buffer) // EVENT_BYTES,)),
        _scratch_of(plan, scratch),
    )


@inline_kernel(returns_views=True)
def _scratch_of(plan, scratch):
    rows, long = plan.capacity + SPARE_SUMMARIES, plan.capacity + 4
    at_pose = 8 * rows * plan.slot
    at_integers = at_pose + 16 * plan.padded_joints
    integers = part(scratch, at_integers, np.int64, (10, long))
    numbers = part(scratch, at_integers + 8 * integers.size, np.float64, (2, long))
    return Scratch(
        part(scratch, 0, np.float64, (rows, plan.slot)),
        part(scratch, at_pose, np.float32, (4, plan.padded_joints)),
        integers[0],
        integers[1],
        integers[2],
        integers[3],
        integers[4],
        integers[5:],
        numbers[0],
        numbers[1],
    )


@inline_kernel(returns_views=True)
def _open_segment_of(state, row, w):
    plan, at = state.plan, state.at
    return OpenSegment(
        plan,
        state.open_segment,
        w.slots,
        w.params,
        w.unused,
        w.summaries,
        w.history.body,
        part(row, at.pose, np.float32, (4, plan.padded_joints)),
    )


@inline_kernel
def _say_what_was_found(w, segment, state):
    """Say what the splitter found, and add the key frame if there is one."""
    curve = state.curve
    found, clock = curve.found, w.clock
    happened = found.happened
    found.happened = 0
    if happened & REPLACED:
        _put_candidate(w, KEY_WITHDRAWN, found.former_frame, found.former_time, found.former_share)
    if happened & PROMOTED:
        _put_candidate(w, KEY_CANDIDATE, found.frame, found.time, found.share)
    if happened & FORGOTTEN:
        _put_candidate(w, KEY_WITHDRAWN, found.frame, found.time, found.share)
    if happened & (CROSSED | ACCEPTED) == 0:
        return
    flush_waiting(segment)
    slot = segment.state.closed
    segment.state.closed = NO_SLOT
    if happened & CROSSED:
        kind, frame = KIND_ONSET if curve.moving == 1 else KIND_OFFSET, clock.used_frame
        point = Point(kind, frame, frame, clock.time, curve.share, UNKNOWN_STRENGTH)
        _add_key(w, slot, state, point, FIRST_MESSAGE)
    else:
        point = Point(KIND_MINIMUM, found.frame, found.frame, found.time, found.share, UNKNOWN_STRENGTH)
        _add_key(w, slot, state, point, SECOND_MESSAGE)
    if w.plan.offline == 0:
        rank(w, NO_SLOT)
        relabel(w)
        w.state.ranked = 1
        set_due_time(w)


@kernel
def _add_key(w, slot, state, point, rev):
    """Add a key frame to the window, with its features if the measure asks for them."""
    if w.plan.has_features == 0:
        add_key(w, slot, point, point.time, rev, REPORTED)
        return
    candidate, scales = state.candidate, state.scales
    noise = noise_of_speed(state.noise, w.plan.moving_joints)
    write_features(w.params, w.summaries[slot], features_of(candidate, scales, noise, state.joints.moving))
    reported = UNREPORTED
    if is_reported(candidate, scales, point.time, noise):
        reported = REPORTED
        candidate.reported_time, candidate.reported_speed = point.time, candidate.speed
        candidate.peak = 0.0
    frame, time = point.frame, point.time
    if candidate.before < candidate.frame:
        frame, time = candidate.frame, candidate.time
    candidate.before = frame
    rest_distance, speed = candidate.rest_distance / extent(scales), candidate.speed / usual_speed(scales)
    note_candidate(w.labels, point.time, time, rest_distance, speed)
    placed = Point(point.kind, point.id, frame, time, point.velocity, point.strength)
    add_key(w, slot, placed, point.time, rev, reported)


@kernel
def _put_candidate(w, status, frame, time, share):
    rev = FIRST_MESSAGE if status == KEY_CANDIDATE else SECOND_MESSAGE
    decided = UNDECIDED if status == KEY_CANDIDATE else DECIDED
    point = Point(KIND_MINIMUM, frame, frame, time, share, UNKNOWN_STRENGTH)
    put_key_frame(w.clock, w.events, point, status, rev, decided)


@inline_kernel
def _decide_what_is_due(w, segment, curve, begin):
    """Decide the oldest key frames while there are more than W or they are older than `remerge_seconds`.

    If several are due and cause more than `most_events`, the rest is left for the next frame.
    """
    flush_waiting(segment)
    open_slot = NO_SLOT
    end_frame = curve.candidate if curve.candidate >= 0 else curve.run_frame
    last = begin + w.plan.most_events - (4 * w.plan.capacity + 12)  # with room for one more decision
    while is_due(w):
        if w.events[0].row >= last:
            break
        clear = _is_clear(w)
        if open_slot == NO_SLOT and (w.keys[0].kept == 1 or not clear):
            open_slot = _gather_open(w, segment)
        if not clear:
            rank(w, open_slot)
            relabel(w)
        report_kept(w, ONE)
        segment.state.settled = decide_oldest(w, segment.state.settled, open_slot, end_frame)
        w.state.ranked = 0
    if open_slot != NO_SLOT:
        free(w.slots, w.unused, open_slot)
    set_due_time(w)


@inline_kernel
def _is_clear(w):
    """Tell whether what came after the newest key frame hardly changes the decision on the oldest one."""
    if w.plan.has_features == 1 or w.plan.rests == 1:  # which changes with what follows
        return False
    strength, beta = w.keys[0].strength, w.plan.beta
    return w.state.ranked == 1 and (strength >= CLEAR * beta or CLEAR * strength <= beta)


@inline_kernel
def _gather_open(w, segment):
    """Return a slot with the closed summary of everything since the newest key frame."""
    open_slot = allocate(w.slots, w.unused, w.summaries)
    own = w.summaries[open_slot]
    merge_into(w.params, own, w.summaries[segment.state.settled])
    merge_into(w.params, own, w.summaries[segment.state.since])
    merge_into(w.params, own, w.summaries[segment.state.run])
    add_last_frame(segment, open_slot)
    flush_sums(w.params, own, segment.body, w.plan.padded_joints)
    close(w.params, own)
    return open_slot


@inline_kernel
def _close_take(w, segment, curve):
    """Close the last segment and rank all undecided key frames together."""
    place_last_frame(segment, curve.candidate, curve.run_length, curve.run_length < 0)
    flush_waiting(segment)
    if curve.candidate >= 0:
        _put_candidate(w, KEY_WITHDRAWN, curve.candidate, curve.candidate_time, curve.candidate_share)
        forget_candidate(curve)
        settle(segment)
    if curve.awaiting == 1 and w.state.undecided > 0:
        _withdraw_newest(w, segment)
    settled = w.summaries[segment.state.settled]
    if w.plan.post_roll > 0.0:
        flatten(segment.body, segment.pose)
        for j in range(w.plan.padded_joints):
            segment.pose[3, j] = LOG_REST_SPEED
        add_pose(w.params, settled, segment.pose, w.plan.joints, w.clock.time, w.plan.post_roll)
    judge_candidates(w, LAST_OF_ALL)
    close(w.params, settled)
    rank(w, segment.state.settled)


@inline_kernel
def _withdraw_newest(w, segment):
    """Take back the newest key frame, confirmed early, since the maximum that accepts it never came."""
    newest = w.state.undecided - 1
    key = w.keys[newest]
    if w.plan.offline == 0 and key.before != NOT_KEPT:
        put_segment(w, key.before, newest, SEGMENT_WITHDRAWN)
    point = point_of(key, key.at_frame, key.at_time, UNKNOWN_STRENGTH)
    put_key_frame(w.clock, w.events, point, KEY_WITHDRAWN, key.rev + 1, DECIDED)
    slot = w.order[newest]
    merge_into(w.params, w.summaries[slot], w.summaries[segment.state.settled])
    free(w.slots, w.unused, segment.state.settled)
    segment.state.settled = slot
    w.state.undecided -= 1
    w.state.ordinal -= 1
    if w.plan.has_features == 1:
        forget_newest(w.labels)


@inline_kernel
def _decide_all(w, segment):
    """Decide all undecided key frames by their strengths, and end the take."""
    relabel(w)
    report_kept(w, w.state.undecided)
    while w.state.undecided > 0:
        settled = segment.state.settled
        segment.state.settled = decide_oldest(w, settled, settled, w.clock.used_frame + 1)
    _put_last_segment(w, segment.state.settled)
    end_take(w.clock)


@inline_kernel
def _put_last_segment(w, settled):
    """Put the final message about the segment from the last final key frame to the end into the event buffer."""
    state, clock, summaries = w.state, w.clock, w.scratch.summaries
    for d in range(w.plan.slot):
        summaries[OWN, d] = w.summaries[settled, d]
        if state.has_before == 1:
            summaries[PREVIOUS, d] = w.summaries[state.before, d]
    event = next_event(clock, w.events, SEGMENT)
    event.id = state.left_id
    event.frame = state.left_frame
    event.time = state.left_time
    event.end_id = clock.used_frame
    event.until_frame = clock.used_frame
    event.until_time = clock.time
    event.rev = 1
    if w.plan.offline == 0 and state.ordinal > 0 and w.keys[0].frame == clock.used_frame:
        # A key frame in the last frame, merged: there were messages about a segment of the same name.
        places = w.plan.capacity + 2
        event.rev += w.counts[places, (state.ordinal - 1) % places]
    bounds = BEFORE_WINDOW, state.left_ordinal, UNKNOWN_BOUNDARY
    describe(w, event, state.has_before == 1, SEGMENT_FINAL, bounds)
