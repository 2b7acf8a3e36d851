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

from mossar_stream.compiled import compiled
from mossar_stream.joints import filter_joints, first_joints, step_joints
from mossar_stream.layout import HEADER, HEADER_BYTES
from mossar_stream.outbox import EVENT
from mossar_stream.ranges import normalise
from mossar_stream.similarity import add_pose
from mossar_stream.splitter import start_curve
from mossar_stream.take import decide, end_take, open_take, split
from mossar_stream.tempo import follow_tempo, start_tempo
from mossar_stream.trail import keep_pose, set_log_speeds
from mossar_stream.velocity import moving_average, ring_is_full, travel
from mossar_stream.window import relabel, slots_of

DONE, OUTBOX_FULL, TAKE_ENDS, RING_FULL, COLLECTED = range(5)  # in h.stop
AVERAGED, FILTERED = 1, 2  # in h.smoothing


@compiled
def header_of(row):
    """Return the header of a row."""
    return row[:HEADER_BYTES].view(HEADER)[0]


@compiled
def advance(memory, index, params, positions, times, outbox):
    """Take frames of one performer in until they are used up or the caller is needed.

    Args:
        memory: (P, row) bytes, the pool.
        index: Row of the performer.
        params: One-element record array of the similarity measure.
        positions: (n, J, 3) float32 m.
        times: (n,) s.
        outbox: Bytes of an outbox; events are added.

    Returns:
        Number of frames used; `h.stop` says why it is less than n.
    """
    row = memory[index]
    h = header_of(row)
    events = outbox.view(EVENT)
    reserve = most_events(h.capacity)
    h.stop = DONE
    for i in range(len(times)):
        if events[0].row + reserve >= len(events):
            h.stop = OUTBOX_FULL
            return i
        time = times[i]
        if h.open == 1:
            ahead = time - h.time
            if ahead > h.max_pause or ahead < -h.max_pause:
                h.stop = TAKE_ENDS
                return i
            if not ahead > 0.0:
                h.frames += 1
                h.out_of_order += 1
                h.next_frame += 1
                continue
        elif not abs(time) < np.inf:
            h.frames += 1
            h.out_of_order += 1
            h.next_frame += 1
            continue
        if not _take_frame(h, row, params[0], positions[i], time, events):
            h.stop = RING_FULL
            return i
        if h.closed >= 0:
            h.stop = COLLECTED
            return i + 1
    return len(times)


@compiled
def most_events(capacity):
    """Return the most events that one frame, or the end of a take, can cause."""
    return 6 * capacity + 32


@compiled
def _take_frame(h, row, params, frame, time, events):
    """Take one frame in; False, with nothing changed, if the velocity ring must grow first."""
    lanes = h.lanes
    seen = row[h.at_seen : h.at_seen + 8 * lanes].view(np.float64)
    good = row[h.at_good : h.at_good + 24 * lanes].view(np.float64).reshape(3, lanes)
    step = row[h.at_step : h.at_step + 16 * lanes].view(np.float64).reshape(2, lanes)
    pose = row[h.at_pose : h.at_pose + 32 * lanes].view(np.float64).reshape(4, lanes)
    ring_time = row[h.at_ring_time : h.at_ring_time + 8 * h.ring].view(np.float64)
    ring_step = row[h.at_ring_step : h.at_ring_step + 8 * h.ring].view(np.int64)
    if h.open == 0:
        open_take(h, row, time)
        first_joints(h, seen, good, step[0], frame, time)
        _count_frame(h, time)
        value, scale = normalise(h, _velocity(h, row, ring_time, ring_step, time, 0.0), 0.0)
        start_curve(h, value, scale)
        _first_pose(h, row, params, seen, good, step, pose)
        return True
    if ring_is_full(h, ring_time, time):
        return False
    dt = time - h.time
    weight = min(dt, h.max_gap)
    h.gaps += 1 if dt > h.max_gap else 0
    displacement = step_joints(h, seen, good, step[0], frame, time)
    if h.smoothing == FILTERED:
        displacement = filter_joints(h, seen, good, filtered_of(h, row), step[0], dt)
    value, scale = normalise(h, _velocity(h, row, ring_time, ring_step, time, displacement), dt)
    _count_frame(h, time)
    split(h, row, params, pose, step[1], value, scale, events)
    _set_pose(h, row, good, pose)
    set_log_speeds(h, row, pose, time, 0)
    step[1] = step[0]
    if h.tempo == 1:
        follow_tempo(h, mean_pose_of(h, row), pose, step[0], weight)
    keep_pose(h, row, pose, weight)
    h.pending_weight = weight
    h.pending_moving = h.moving
    if h.undecided > h.capacity or time >= h.due_time:
        decide(h, row, params, pose, step[1], events)
    return True


@compiled
def filtered_of(h, row):
    """Return the One-Euro filter's state, (6, lanes) m and m/s."""
    return row[h.at_filtered : h.at_filtered + 48 * h.lanes].view(np.float64).reshape(6, h.lanes)


@compiled
def mean_pose_of(h, row):
    """Return the slow mean of the pose, (3, lanes) m."""
    return row[h.at_mean_pose : h.at_mean_pose + 24 * h.lanes].view(np.float64).reshape(3, h.lanes)


@compiled
def _count_frame(h, time):
    h.time = time
    h.used_frame = h.next_frame
    h.next_frame += 1
    h.frames += 1


@compiled
def _velocity(h, row, ring_time, ring_step, time, displacement):
    velocity = travel(h, ring_time, ring_step, time, displacement)
    if h.smoothing == AVERAGED:
        average = row[h.at_average : h.at_average + 8 * h.smoothing_window].view(np.int64)
        return moving_average(h, average, velocity)
    return velocity


@compiled
def _set_pose(h, row, good, pose):
    """Set the positions relative to the centre (localisation); joints never seen lie in the centre."""
    body = filtered_of(h, row)[:3] if h.smoothing == FILTERED else good
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


@compiled
def _first_pose(h, row, params, seen, good, step, pose):
    """Begin the take's poses: at rest, held for `pre_roll` seconds before."""
    if h.smoothing == FILTERED:
        filter_joints(h, seen, good, filtered_of(h, row), step[0], 0.0)
    step[:] = 0.0
    pose[:] = 0.0
    _set_pose(h, row, good, pose)
    set_log_speeds(h, row, pose, h.time, 0)
    if h.tempo == 1:
        start_tempo(h, mean_pose_of(h, row), pose)
    if h.pre_roll > 0.0:
        add_pose(params, slots_of(h, row)[h.slot_settled], pose, h.joints, h.pre_roll)
    keep_pose(h, row, pose, 0.0)
    h.pending_weight = 0.0
    h.pending_moving = h.moving


@compiled
def relabel_row(memory, index, params, outbox):
    """Bring the window up to date with a level that moved; nothing is computed again."""
    row = memory[index]
    h = header_of(row)
    if h.open == 1:
        relabel(h, row, outbox.view(EVENT), params[0])


@compiled
def finish(memory, index, params, outbox):
    """End the take: decide everything that is undecided. The outbox must be empty enough."""
    row = memory[index]
    h = header_of(row)
    if h.open == 0:
        return
    lanes = h.lanes
    step = row[h.at_step : h.at_step + 16 * lanes].view(np.float64).reshape(2, lanes)
    pose = row[h.at_pose : h.at_pose + 32 * lanes].view(np.float64).reshape(4, lanes)
    end_take(h, row, params[0], pose, step[1], outbox.view(EVENT))
