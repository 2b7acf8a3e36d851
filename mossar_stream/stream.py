"""Stream: what happens to each frame, in order.

    time      in order? or does the take end here?
    joints    present, held, left out; path of each relative to the centre
    velocity  equation 1, smoothing, range
    splitter  Algorithms 1 and 2: candidates, key frames
    summary   the frame before joins the open segment, now that it is known on which side of a candidate it lies
    window    Algorithm 3 over the undecided key frames; the oldest may be decided

One compiled call takes a chunk of frames in; it stops early only to ask something of its caller (`h.stop`).
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.body import (
    LIVE,
    PAGE,
    POINT,
    POSE_X,
    POSE_Y,
    POSE_Z,
    STEP,
    STEP_BEFORE,
    X,
    Y,
    Z,
    center_of,
    flatten,
    page_of,
)
from mossar_stream.compiled import frame_entry_point, inlined
from mossar_stream.joints import first_joints, step_joints
from mossar_stream.layout import HEADER, MARK, MEMO
from mossar_stream.noise import calm_noise
from mossar_stream.one_euro import filter_joints
from mossar_stream.parts import part
from mossar_stream.ranges import normalise
from mossar_stream.similarity import add_pose
from mossar_stream.splitter import start_curve
from mossar_stream.take import open_take, split
from mossar_stream.tempo import follow_mean, follow_speed, start_tempo
from mossar_stream.trail import follow_speeds, keep_pose
from mossar_stream.velocity import moving_average, ring_is_full, travel

DONE, HAPPENED, TAKE_ENDS, RING_FULL = range(4)
STOPS = 4
# In the velocity window; a clock that gives more is wrong, and frames that are too many are dropped.
MOST_STEPS = 1 << 14
AVERAGED, FILTERED = 1, 2  # in h.smoothing


@frame_entry_point
def advance(
    memory: NDArray[np.uint8],
    index: int,
    params: NDArray[np.void],
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
) -> int:
    """Take frames of one performer in until they are used up or something happens.

    Args:
        memory: (P, row) bytes, the pool.
        index: Row of the performer.
        params: One-element record array of the similarity measure.
        positions: (n, J, 3) float32 m.
        times: (n,) s.

    Returns:
        STOPS times the number of frames used, plus what the caller must do: DONE nothing, HAPPENED `act`,
        TAKE_ENDS end the take before the next frame, RING_FULL make the velocity ring larger before the next
        frame. One number, because a second one would cost as much as the frame.
    """
    row = memory[index]
    h = part(row, 0, HEADER, (1,))[0]
    lanes, size = h.lanes, h.slot_count
    seen = part(row, h.at_seen, np.float64, (lanes,))
    body = part(row, h.at_body, np.float32, ((h.at_seen - h.at_body) // 4,))
    filtered = part(row, h.at_filtered, np.float64, (6, h.filter_lanes))
    pose = part(row, h.at_pose, np.float32, (4, lanes))
    ring_time = part(row, h.at_ring_time, np.float64, (h.ring,))
    ring_step = part(row, h.at_ring_step, np.int64, (h.ring,))
    average = part(row, h.at_average, np.int64, (h.average_size,))
    slots = part(row, h.at_slots, np.float64, (size, h.slot))
    free = part(row, h.at_free, np.int64, (size,))
    marks = part(row, h.at_marks, MARK, (h.trail_size,))
    trail = part(row, h.at_trail, np.int16, (h.trail_size, 3, lanes))
    points = part(positions, 0, POINT, (len(times) * h.joints,))
    for i in range(len(times)):
        time = times[i]
        dt = time - h.time
        is_time = abs(time) < np.inf
        if h.open == 1 and is_time and (dt > h.max_pause or dt < -h.max_pause):
            return STOPS * i + TAKE_ENDS
        full = h.open == 1 and dt > 0.0 and ring_is_full(h, ring_time, time)
        if not is_time or (h.open == 1 and dt <= 0.0) or (full and h.ring >= MOST_STEPS):
            h.out_of_order += 1
            h.next_frame += 1
            h.frames += 1
            continue
        if full:
            return STOPS * i + RING_FULL
        first = h.open == 0
        frame = points[i * h.joints : (i + 1) * h.joints]
        weight = 0.0 if first else min(dt, h.max_gap)
        displacement = 0.0
        if first:
            memo = part(row, h.at_memo, MEMO, (h.memo_size,))
            open_take(h, body, free, slots, memo, time)
            first_joints(h, seen, body, frame, time)
        else:
            h.gaps += 1 if dt > h.max_gap else 0
            displacement = step_joints(h, seen, body, frame, time)
        if h.smoothing == FILTERED:
            displacement = filter_joints(h, body, filtered, weight)
        if h.noise_margin > 0.0:
            displacement = calm_noise(h, body, displacement, weight)
        velocity = travel(h, ring_time, ring_step, time, displacement)
        if h.smoothing == AVERAGED:
            velocity = moving_average(h, average, velocity)
        value, scale = normalise(h, velocity, weight)
        h.time = time
        h.used_frame = h.next_frame
        h.next_frame += 1
        h.frames += 1
        if first:
            start_curve(h, value, scale)
        else:
            split(h, body, free, slots, params[0], pose, value, scale)
        _localise(h, body)
        follow_speeds(h, body, marks, trail, time)
        if h.flat == 1 or first:
            flatten(h, body, pose)
        if h.tempo == 1:
            if first:
                start_tempo(h, body)
            follow_speed(h, body, weight)
        if first and h.pre_roll > 0.0:
            add_pose(params[0], slots[h.slot_settled], pose, h.joints, time, h.pre_roll)
        stood_for = keep_pose(h, body, marks, trail, weight)
        if h.tempo == 1 and stood_for > 0.0:
            follow_mean(h, body, stood_for)
        h.pending_time = time
        h.pending_weight = weight
        h.pending_moving = h.moving
        if h.happened != 0 or time >= h.due_time:
            return STOPS * (i + 1) + HAPPENED
    return STOPS * len(times) + DONE


@inlined
def _localise(h, body):
    """Set the positions relative to the centre (paper 3.1.1); joints never seen lie in the origin."""
    cx, cy, cz = center_of(h, body)
    for first in range(0, h.lanes, PAGE):
        _shift(page_of(body, first), cx, cy, cz)


@inlined
def _shift(page, cx, cy, cz):
    for j in range(PAGE):
        page[j + POSE_X] = (page[j + X] - cx) * page[j + LIVE]
        page[j + POSE_Y] = (page[j + Y] - cy) * page[j + LIVE]
        page[j + POSE_Z] = (page[j + Z] - cz) * page[j + LIVE]
        page[j + STEP_BEFORE] = page[j + STEP]
