"""Stream: what happens to each frame, in order.

    time      in order? or does the take end here?
    joints    present, held, left out; path of each relative to the centre
    velocity  equation 1, smoothing, range
    splitter  Algorithms 1 and 2: candidates, key frames
    summary   the frame before joins the open segment, now that it is known on which side of a candidate it lies
    window    Algorithm 3 over the undecided key frames; the oldest may be decided

One compiled call takes a chunk of frames in; it stops early only to ask something of its caller (`h.stop`).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.joints import first_joints, step_joints
from mossar_stream.algorithm.noise import calm_noise
from mossar_stream.algorithm.normalisation import normalise
from mossar_stream.algorithm.one_euro import filter_joints
from mossar_stream.algorithm.open_segment import open_take, split
from mossar_stream.algorithm.pose_history import follow_speeds, keep_pose
from mossar_stream.algorithm.splitter import start_curve
from mossar_stream.algorithm.tempo import follow_mean, follow_speed, start_tempo
from mossar_stream.algorithm.velocity import moving_average, ring_is_full, travel
from mossar_stream.jit.decorators import entry_point, inline_kernel
from mossar_stream.jit.views import part
from mossar_stream.memory.joint_pages import (
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
from mossar_stream.memory.row import HEADER, MARK, MEMO
from mossar_stream.similarity.protocol import add_pose

DONE, HAPPENED, TAKE_ENDS, RING_FULL = range(4)
STOPS = 4
IN_VAIN = 5  # a frame without a time, or not later than the last one
# In the velocity window; a clock that gives more is wrong, and frames that are too many are dropped.
MOST_STEPS = 1 << 14
AVERAGED, FILTERED = 1, 2  # in h.smoothing


class Views(NamedTuple):
    """Views of a row, as frames need them."""

    seen: NDArray[np.float64]  # (lanes,)
    body: NDArray[np.float32]
    filtered: NDArray[np.float64]  # (6, filter_lanes)
    pose: NDArray[np.float32]  # (4, lanes)
    ring_time: NDArray[np.float64]  # (ring,)
    ring_step: NDArray[np.int64]  # (ring,)
    average: NDArray[np.int64]  # (smoothing_window,)
    slots: NDArray[np.float64]  # (slots, slot)
    free: NDArray[np.int64]  # (slots,)
    memo: NDArray[np.void]  # (memo,) MEMO
    marks: NDArray[np.void]  # (trail,) MARK
    trail: NDArray[np.int16]  # (trail, 3, lanes)


@entry_point(makes_arrays=False)
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
    v = _views_of(h, row)
    points = part(positions, 0, POINT, (len(times) * h.joints,))
    for i in range(len(times)):
        time = times[i]
        place = _place_in_time(h, v, time)
        if place == IN_VAIN:
            h.out_of_order += 1
            h.next_frame += 1
            h.frames += 1
            continue
        if place != DONE:
            return STOPS * i + place  # type: ignore[no-any-return]
        frame = points[i * h.joints : (i + 1) * h.joints]
        _take_in(h, v, params[0], frame, time)
        if h.happened != 0 or time >= h.due_time:
            return STOPS * (i + 1) + HAPPENED
    return STOPS * len(times) + DONE


@inline_kernel(returns_views=True)
def _views_of(h, row):
    return Views(
        part(row, h.at_seen, np.float64, (h.lanes,)),
        part(row, h.at_body, np.float32, ((h.at_seen - h.at_body) // 4,)),
        part(row, h.at_filtered, np.float64, (6, h.filter_lanes)),
        part(row, h.at_pose, np.float32, (4, h.lanes)),
        part(row, h.at_ring_time, np.float64, (h.ring,)),
        part(row, h.at_ring_step, np.int64, (h.ring,)),
        part(row, h.at_average, np.int64, (h.average_size,)),
        part(row, h.at_slots, np.float64, (h.slot_count, h.slot)),
        part(row, h.at_free, np.int64, (h.slot_count,)),
        part(row, h.at_memo, MEMO, (h.memo_size,)),
        part(row, h.at_marks, MARK, (h.trail_size,)),
        part(row, h.at_trail, np.int16, (h.trail_size, 3, h.lanes)),
    )


@inline_kernel
def _place_in_time(h, v, time):
    """Return DONE for a frame that can be taken in, IN_VAIN for one that cannot, or what `advance` must stop for."""
    if not abs(time) < np.inf:
        return IN_VAIN
    if h.open == 0:
        return DONE
    dt = time - h.time
    if dt > h.max_pause or dt < -h.max_pause:
        return TAKE_ENDS
    if dt <= 0.0:
        return IN_VAIN
    if ring_is_full(h, v.ring_time, time):
        return IN_VAIN if h.ring >= MOST_STEPS else RING_FULL
    return DONE


@inline_kernel
def _take_in(h, v, params, frame, time):
    """Take one frame in, all the way to its summary."""
    first = h.open == 0
    weight = 0.0 if first else min(time - h.time, h.max_gap)
    displacement = 0.0
    if first:
        open_take(h, v.body, v.free, v.slots, v.memo, time)
        first_joints(h, v.seen, v.body, frame, time)
    else:
        h.gaps += 1 if time - h.time > h.max_gap else 0
        displacement = step_joints(h, v.seen, v.body, frame, time)
    if h.smoothing == FILTERED:
        displacement = filter_joints(h, v.body, v.filtered, weight)
    if h.noise_margin > 0.0:
        displacement = calm_noise(h, v.body, displacement, weight)
    velocity = travel(h, v.ring_time, v.ring_step, time, displacement)
    if h.smoothing == AVERAGED:
        velocity = moving_average(h, v.average, velocity)
    value, scale = normalise(h, velocity, weight)
    h.time = time
    h.used_frame = h.next_frame
    h.next_frame += 1
    h.frames += 1
    if first:
        start_curve(h, value, scale)
    else:
        split(h, v.body, v.free, v.slots, params, v.pose, value, scale)
    _describe(h, v, weight, first)
    if first and h.pre_roll > 0.0:
        add_pose(params, v.slots[h.slot_settled], v.pose, h.joints, time, h.pre_roll)
    h.pending_time = time
    h.pending_weight = weight
    h.pending_moving = h.moving


@inline_kernel
def _describe(h, v, weight, first):
    """Set the features of the frame, and let what is kept of the pose follow."""
    _localise(h, v.body)
    follow_speeds(h, v.body, v.marks, v.trail, h.time)
    if h.flat == 1 or first:
        flatten(h, v.body, v.pose)
    if h.tempo == 1:
        if first:
            start_tempo(h, v.body)
        follow_speed(h, v.body, weight)
    stood_for = keep_pose(h, v.body, v.marks, v.trail, weight)
    if h.tempo == 1 and stood_for > 0.0:
        follow_mean(h, v.body, stood_for)


@inline_kernel
def _localise(h, body):
    """Set the positions relative to the centre (paper 3.1.1); joints never seen lie in the origin."""
    cx, cy, cz = center_of(h, body)
    for first in range(0, h.lanes, PAGE):
        _shift(page_of(body, first), cx, cy, cz)


@inline_kernel
def _shift(page, cx, cy, cz):
    for j in range(PAGE):
        page[j + POSE_X] = (page[j + X] - cx) * page[j + LIVE]
        page[j + POSE_Y] = (page[j + Y] - cy) * page[j + LIVE]
        page[j + POSE_Z] = (page[j + Z] - cz) * page[j + LIVE]
        page[j + STEP_BEFORE] = page[j + STEP]
