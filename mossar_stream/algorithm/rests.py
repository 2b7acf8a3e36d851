"""Rests: which key frames begin and end a hold or a rest, with the setting `rests=keep`.

A rest is the time between two bouts of movement (activity.py) if it lasts `SHORTEST_REST`. The candidate of Algorithm 2
nearest to its begin, and the one nearest to its end, are key frames at every named level; those between them are not.
What is decided before a rest has lasted `SHORTEST_REST` stays so. Where the sensor's noise alone is as fast as a
movement no rest is judged: what looks like a rest may be slow movement. With 5 mm of white noise that noise is 0.07 to
0.18 m/s on the labelled sets, as recorded at most 0.052.
"""

import numpy as np

from mossar_stream.algorithm.activity import UPPER_LINE, noises_of_speed
from mossar_stream.algorithm.pose_history import MARGIN
from mossar_stream.algorithm.repetition_labels import ENDS, WITHIN
from mossar_stream.jit.decorators import kernel
from mossar_stream.memory.event_buffer import KIND_OFFSET, KIND_ONSET

SHORTEST_REST = 0.6  # s; shorter rests are part of the movement
# s, by which the activity shows the end, and the begin, of a movement later than key frames: by the holds that were made
LATE_REST, LATE_BOUT = 0.05, 0.17
NEAR_REST = 0.35  # s, from there to a key frame
OTHER_KIND = 0.1  # s, that a key frame which is no crossing counts as farther off
UNSURE = 0.5  # s; while a rest goes on, key frames as new as this may belong to the next movement
LEFT_END, NO_KEY = np.int64(-1), np.int64(-2)  # in place of a key frame: the window's left end; none


@kernel
def label_rests(w, count):
    """Set the labels of the first `count` key frames of a window that begin or end rests, or lie within one.

    Args:
        w: Window; `scratch.labels` is set.
        count: Number of key frames.
    """
    state, bouts = w.activity.state, w.activity.bouts
    quietest, _ = noises_of_speed(w.noise, w.plan.moving_joints, True)
    if quietest > UPPER_LINE:
        return
    for b in range(-1, state.bouts):
        begin = w.state.left_time if b < 0 else bouts[b].end
        if b < 0 and w.state.left_ordinal >= 0:  # the take began earlier
            continue
        end = np.inf
        if b + 1 < state.bouts:
            end = bouts[b + 1].begin
        elif state.moving == 1:
            end = state.since
        begin, end = begin - LATE_REST, end - LATE_BOUT
        if (
            min(end, w.clock.time) - begin >= SHORTEST_REST - MARGIN
            and end + NEAR_REST >= w.state.left_time - MARGIN
        ):
            _judge_rest(w, count, begin, end, b < 0)


@kernel
def _judge_rest(w, count, begin, end, is_first):
    """Set the labels of the key frames of one rest; the one that a take begins with has no key frame at its begin."""
    first = NO_KEY if is_first else _nearest(w, count, begin, KIND_OFFSET)
    last = _nearest(w, count, end, KIND_ONSET) if end < np.inf else NO_KEY
    after = _time_of(w, first, begin)
    before = _time_of(w, last, min(end, w.clock.time - UNSURE))
    for i in range(count):
        if after + MARGIN < w.keys[i].at_time < before - MARGIN:
            w.scratch.labels[i] = WITHIN
    if first >= 0:
        w.scratch.labels[first] = ENDS
    if last >= 0:
        w.scratch.labels[last] = ENDS


@kernel
def _nearest(w, count, time, kind):
    """Return the key frame that is nearest to a time, s, if there is one near; of two at the same distance the first."""
    best, least = NO_KEY, NEAR_REST
    if w.state.left_ordinal >= 0 and abs(w.state.left_time - time) < least - MARGIN:
        best, least = LEFT_END, abs(w.state.left_time - time)
    for i in range(count):
        distance = abs(w.keys[i].at_time - time)
        if w.keys[i].kind != kind:
            distance += OTHER_KIND
        if distance < least - MARGIN:
            best, least = np.int64(i), distance
    return best


@kernel
def _time_of(w, place, otherwise):
    """Return the reported time of a key frame, s; some other time where there is none."""
    if place >= 0:
        return w.keys[place].at_time
    return w.state.left_time if place == LEFT_END else otherwise
