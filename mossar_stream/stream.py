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
    PAGE_SIZE,
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
)
from mossar_stream.compiled import frame_entry_point, inlined
from mossar_stream.joints import first_joints, step_joints
from mossar_stream.layout import HEADER, HEADER_BYTES, MARK, MEMO
from mossar_stream.noise import calm_noise
from mossar_stream.one_euro import filter_joints
from mossar_stream.ranges import normalise
from mossar_stream.similarity import add_pose
from mossar_stream.splitter import start_curve
from mossar_stream.take import open_take, split
from mossar_stream.tempo import follow_tempo, start_tempo
from mossar_stream.trail import follow_speeds, keep_pose
from mossar_stream.velocity import moving_average, ring_is_full, travel

DONE, HAPPENED, TAKE_ENDS, RING_FULL = range(4)
STOPS = 4
MOST_STEPS = (
    1 << 14
)  # in the velocity window; a clock that gives more is wrong, and frames that are too many are dropped
AVERAGED, FILTERED = 1, 2  # in h.smoothing
MARK_BYTES, MEMO_BYTES = MARK.itemsize, MEMO.itemsize


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
    h = row[:HEADER_BYTES].view(HEADER)[0]
    lanes, size = h.lanes, h.slot_count
    seen = row[h.at_seen : h.at_seen + 8 * lanes].view(np.float64)
    body = row[h.at_body : h.at_seen].view(np.float32)
    filtered = (
        row[h.at_filtered : h.at_filtered + 48 * h.filter_lanes].view(np.float64).reshape(6, h.filter_lanes)
    )
    pose = row[h.at_pose : h.at_pose + 16 * lanes].view(np.float32).reshape(4, lanes)
    ring_time = row[h.at_ring_time : h.at_ring_time + 8 * h.ring].view(np.float64)
    ring_step = row[h.at_ring_step : h.at_ring_step + 8 * h.ring].view(np.int64)
    average = row[h.at_average : h.at_average + 8 * h.average_size].view(np.int64)
    slots = row[h.at_slots : h.at_slots + 8 * size * h.slot].view(np.float64).reshape(size, h.slot)
    free = row[h.at_free : h.at_free + 8 * size].view(np.int64)
    marks = row[h.at_marks : h.at_marks + h.trail_size * MARK_BYTES].view(MARK)
    trail = (
        row[h.at_trail : h.at_trail + 6 * h.trail_size * lanes].view(np.int16).reshape(h.trail_size, 3, lanes)
    )
    points = positions.reshape(-1).view(POINT)
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
            memo = row[h.at_memo : h.at_memo + h.memo_size * MEMO_BYTES].view(MEMO)
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
            follow_tempo(h, body, weight)
        if first and h.pre_roll > 0.0:
            add_pose(params[0], slots[h.slot_settled], pose, h.joints, time, h.pre_roll)
        keep_pose(h, body, marks, trail, weight)
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
        _shift(body[first // PAGE * PAGE_SIZE :], cx, cy, cz)


@inlined
def _shift(page, cx, cy, cz):
    for j in range(PAGE):
        page[j + POSE_X] = (page[j + X] - cx) * page[j + LIVE]
        page[j + POSE_Y] = (page[j + Y] - cy) * page[j + LIVE]
        page[j + POSE_Z] = (page[j + Z] - cz) * page[j + LIVE]
        page[j + STEP_BEFORE] = page[j + STEP]
