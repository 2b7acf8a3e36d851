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

from mossar_stream.compiled import compiled, entry_point
from mossar_stream.joints import filter_joints, first_joints, step_joints
from mossar_stream.layout import HEADER, HEADER_BYTES, MARK, MEMO
from mossar_stream.noise import calm_noise
from mossar_stream.ranges import normalise
from mossar_stream.similarity import add_pose
from mossar_stream.splitter import start_curve
from mossar_stream.take import open_take, split
from mossar_stream.tempo import follow_tempo, start_tempo
from mossar_stream.trail import keep_pose, set_log_speeds
from mossar_stream.velocity import moving_average, ring_is_full, travel

DONE, HAPPENED, TAKE_ENDS, RING_FULL = range(4)
STOPS = 4
AVERAGED, FILTERED = 1, 2  # in h.smoothing
LIVE = np.int64(0)  # no kept pose is later than this one
MARK_BYTES, MEMO_BYTES = MARK.itemsize, MEMO.itemsize


@entry_point
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
    good = row[h.at_good : h.at_good + 24 * lanes].view(np.float64).reshape(3, lanes)
    filtered = (
        row[h.at_filtered : h.at_filtered + 48 * h.filter_lanes].view(np.float64).reshape(6, h.filter_lanes)
    )
    past = row[h.at_past : h.at_past + 72 * h.noise_lanes].view(np.float64).reshape(9, h.noise_lanes)
    step = row[h.at_step : h.at_step + 24 * lanes].view(np.float64).reshape(3, lanes)
    pose = row[h.at_pose : h.at_pose + 32 * lanes].view(np.float64).reshape(4, lanes)
    ring_time = row[h.at_ring_time : h.at_ring_time + 8 * h.ring].view(np.float64)
    ring_step = row[h.at_ring_step : h.at_ring_step + 8 * h.ring].view(np.int64)
    average = row[h.at_average : h.at_average + 8 * h.average_size].view(np.int64)
    mean_pose = (
        row[h.at_mean_pose : h.at_mean_pose + 24 * h.tempo_lanes].view(np.float64).reshape(3, h.tempo_lanes)
    )
    slots = row[h.at_slots : h.at_slots + 8 * size * h.slot].view(np.float64).reshape(size, h.slot)
    free = row[h.at_free : h.at_free + 8 * size].view(np.int64)
    marks = row[h.at_marks : h.at_marks + h.trail_size * MARK_BYTES].view(MARK)
    trail = (
        row[h.at_trail : h.at_trail + 6 * h.trail_size * lanes].view(np.int16).reshape(h.trail_size, 3, lanes)
    )
    body = filtered if h.smoothing == FILTERED else good
    for i in range(len(times)):
        time = times[i]
        dt = time - h.time
        is_time = abs(time) < np.inf
        if h.open == 1 and is_time and (dt > h.max_pause or dt < -h.max_pause):
            return STOPS * i + TAKE_ENDS
        if not is_time or (h.open == 1 and dt <= 0.0):
            h.out_of_order += 1
            h.next_frame += 1
            h.frames += 1
            continue
        if h.open == 1 and ring_is_full(h, ring_time, time):
            return STOPS * i + RING_FULL
        first = h.open == 0
        weight = 0.0 if first else min(dt, h.max_gap)
        displacement = 0.0
        if first:
            open_take(h, free, slots, row[h.at_memo : h.at_memo + h.memo_size * MEMO_BYTES].view(MEMO), time)
            first_joints(h, seen, good, step[0], positions[i], time)
        else:
            h.gaps += 1 if dt > h.max_gap else 0
            displacement = step_joints(h, seen, good, step[0], positions[i], time)
        if h.smoothing == FILTERED:
            displacement = filter_joints(h, good, filtered, step[0], weight)
        if h.noise_lanes > 0:
            displacement = calm_noise(h, body, past, step[0], displacement, weight)
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
            split(h, free, slots, params[0], pose, step[1], value, scale)
        _localise(h, body, pose)
        set_log_speeds(h, marks, trail, pose, pose[3], time, LIVE)
        if h.tempo == 1:
            if first:
                start_tempo(h, mean_pose, pose)
            follow_tempo(h, mean_pose, pose, step[0], step[2], weight)
        if first and h.pre_roll > 0.0:
            add_pose(params[0], slots[h.slot_settled], pose, h.joints, time, h.pre_roll)
        keep_pose(h, marks, trail, pose, weight)
        for j in range(lanes):
            step[1, j] = step[0, j]
        h.pending_time = time
        h.pending_weight = weight
        h.pending_moving = h.moving
        if h.happened != 0 or time >= h.due_time:
            return STOPS * (i + 1) + HAPPENED
    return STOPS * len(times) + DONE


@compiled
def _localise(h, body, pose):
    """Set the positions relative to the centre (paper 3.1.1); joints never seen lie in the origin."""
    for axis in range(3):
        center = 0.0
        if h.center >= 0:
            center = body[axis, h.center]
        else:
            for j in range(h.joints):
                center += body[axis, j]
            center /= h.joints
        for j in range(h.joints):
            pose[axis, j] = body[axis, j] - center
