"""Joints of one frame: who is there, how far each moved relative to the body centre.

Localisation is step 1 of the paper's preprocessing (3.1.1): positions relative to the body centre, so that the
place where the performer stands does not matter. Displacements of localised joints are differences of
displacements, which is what is computed here.

Live joints come and go. A joint that is missing, or faster than `max_speed`, is held where it was for `max_gap`
seconds; after that it is left out, and carried along by the centre, until it is back, without a displacement across
the gap. One that was not seen in this take yet does not count at all (`LIVE` is 0, and its pose, too); nor does
anybody while the root was not seen. `arrival.py` tells what happens when it is.

In the first frame of a take, a joint that is far from all others is missing: with the centroid as centre it would move
everybody. From then on, every frame within reach bears out where a joint was; every outlier contradicts it. A place
that is contradicted more often than borne out was wrong: the joint is then treated as left out, and is back where the
outlier is.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.simd import page_within
from mossar_stream.memory.joint_pages import (
    FARTHEST,
    GOOD_X,
    GOOD_Y,
    GOOD_Z,
    LIVE,
    MOVED_X,
    MOVED_Y,
    MOVED_Z,
    PAGE,
    STEP,
    WORK,
    X,
    Y,
    Z,
    line_sum,
    page_of,
    place,
)

# In the first frame of a take a joint is stray, and missing, if it is so many times as far from the middle of the joints as
# their median is (hands and feet: 4 times at most), and farther than this, m.
STRAY, STRAY_FLOOR = 20.0, 1.0
FEWEST_OF_BODY = 5  # joints; of fewer nobody knows which one is stray
HALVINGS = 40  # that find a median
MOST_TRACKED = 255  # frames; more than `max_gap` has, and few enough to be contradicted within seconds

JOINTS = np.dtype(
    [
        ("complete", "i8"),  # whether all joints were there in the last frame
        ("arrived", "i8"),  # whether one is there for the first time in this take
        ("returned", "i8"),  # whether one is there again after it was left out; WORK says which
        ("present", "i8"),  # how many were there in the last frame
        ("unbroken", "i8"),  # complete frames that `tracked` does not have yet
        ("moving", "i8"),  # joints seen in this take that can move relative to the centre, at least 1
        # m, from the mean of the joints seen in this take to the centroid: who arrives must not move it.
        ("offset_x", "f8"),
        ("offset_y", "f8"),
        ("offset_z", "f8"),
        ("unseen_time", "f8"),  # s, of the last frame in which nothing could be seen of how they move
        ("placed", "i8"),  # whether the following is known
        # m, what was taken off the source's coordinates before they became single precision; see intake.py.
        ("origin_x", "f8"),
        ("origin_y", "f8"),
        ("origin_z", "f8"),
    ],
)


class Joints(NamedTuple):
    """A performer's joints, as the functions below need them."""

    plan: np.void  # PLAN
    state: np.void  # JOINTS
    counters: np.void  # COUNTERS
    seen: NDArray[np.float64]  # (padded_joints,) s, when each joint was last there
    tracked: NDArray[np.int32]  # (padded_joints,) frames for where it was, less those against
    body: NDArray[np.float32]  # see joint_pages.py


@kernel
def start_joints(joints, frame, time):
    """Take the first frame of a take in: no joint has moved yet, and nothing is left of the take before.

    Args:
        joints: Joints.
        frame: (J,) POINT, m, NaN where missing.
        time: s.
    """
    body, state = joints.body, joints.state
    state.complete = 1
    state.arrived = 0
    state.returned = 0
    state.unbroken = 0
    state.unseen_time = -np.inf
    state.offset_x = state.offset_y = state.offset_z = 0.0
    found = 0
    farthest = _measure_distances(joints, frame)
    for j in range(joints.plan.joints):
        k = place(j)
        body[k + STEP] = body[k + MOVED_X] = body[k + MOVED_Y] = body[k + MOVED_Z] = 0.0
        body[k + GOOD_X] = body[k + GOOD_Y] = body[k + GOOD_Z] = 0.0
        joints.tracked[j] = 0
        if body[k + WORK] <= farthest:
            joints.seen[j] = time
            _keep(body, k, frame[j])
            found += 1
        else:
            joints.seen[j] = -np.inf
            state.complete = 0
            joints.counters.outliers += 1 if _is_far(frame[j]) or body[k + WORK] > farthest else 0
        _hold(body, k)
    joints.state.present = found
    joints.counters.unseen += 1 if found == 0 else 0
    for j in range(joints.plan.joints):
        body[place(j) + LIVE] = 1.0 if counts(joints, j) else 0.0
    count_moving(joints)


@kernel
def _measure_distances(joints, frame):
    """Set WORK to each joint's squared distance from the middle of all, m², NaN if missing; return the largest that counts.

    The middle is the median of each coordinate, which a stray marker does not move.
    """
    body, count = joints.body, joints.plan.joints
    middle = (_middle(joints, frame, 0), _middle(joints, frame, 1), _middle(joints, frame, 2))
    for j in range(count):
        squares = 0.0
        for axis in range(3):
            off = _coordinate(frame[j], axis) - middle[axis]
            squares += off * off
        body[place(j) + WORK] = squares
    usual = _median(body, count)
    found = 0
    for j in range(count):
        found += 1 if body[place(j) + WORK] >= 0.0 else 0
    if found < FEWEST_OF_BODY or usual == 0.0:
        return np.inf
    return max(STRAY * STRAY * usual, STRAY_FLOOR * STRAY_FLOOR)


@kernel
def _middle(joints, frame, axis):
    """Return the median of a coordinate, m; uses WORK."""
    for j in range(joints.plan.joints):
        joints.body[place(j) + WORK] = _coordinate(frame[j], axis)
    return _median(joints.body, joints.plan.joints)


@inline_kernel
def _coordinate(joint, axis):
    """Return a coordinate, m; NaN if the joint is missing."""
    if not _is_position(joint):
        return np.float32(np.nan)
    return joint.x if axis == 0 else (joint.y if axis == 1 else joint.z)


@kernel
def _median(body, count):
    """Return the median of WORK, by halving the span that it lies in; NaN does not count."""
    low, high, known = np.inf, -np.inf, 0
    for j in range(count):
        value = body[place(j) + WORK]
        if not np.isnan(value):
            low, high, known = min(low, value), max(high, value), known + 1
    for _ in range(HALVINGS):
        at = 0.5 * (low + high)
        below = 0
        for j in range(count):
            below += 1 if body[place(j) + WORK] <= at else 0
        if 2 * below >= known:
            high = at
        else:
            low = at
    return high


@kernel
def last_seen(joints):
    """Return when the centre and a joint that can move relative to it were last there, s; -inf if never in this take.

    Args:
        joints: Joints; the last frame was not complete.
    """
    latest = -np.inf
    center = joints.plan.center
    for j in range(joints.plan.joints):
        if j != center:
            latest = max(latest, joints.seen[j])
    return min(latest, joints.seen[center]) if center >= 0 else latest


@kernel
def counts(joints, j):
    """Tell whether a joint was seen in this take, and the root, if that is the centre, too."""
    center = joints.plan.center
    return joints.seen[j] > -np.inf and (center < 0 or joints.seen[center] > -np.inf)


@kernel
def count_moving(joints):
    """Note how many joints count that can move relative to the centre."""
    moving = 0
    for j in range(joints.plan.joints):
        if j != joints.plan.center and joints.body[place(j) + LIVE] > 0.0:
            moving += 1
    joints.state.moving = max(moving, 1)


@inline_kernel
def step_joints(joints, frame, before, time):
    """Take one frame's joints in and set each joint's way relative to the centre.

    Args:
        joints: Joints; positions, displacements and their lengths are set.
        frame: (J,) POINT, m, NaN where missing.
        before: s, of the last frame.
        time: s, later.

    Returns:
        Path summed over the joints, scaled up for those left out, m.
    """
    plan = joints.plan
    if joints.state.complete == 1:
        dt = time - before
        if dt <= plan.max_gap and _step_complete(plan, joints.body, frame, plan.max_speed * dt):
            joints.state.unbroken += 1
            return line_sum(joints.body, STEP)
        for j in range(plan.joints):
            joints.seen[j] = before
            joints.tracked[j] = min(joints.tracked[j] + joints.state.unbroken, MOST_TRACKED)
        joints.state.unbroken = 0
    return _step_partial(joints, frame, time)


@inline_kernel
def _step_complete(plan, body, frame, reach):
    """Step when every joint was there in the last frame; False, with nothing kept, if one is not there now."""
    joints = plan.joints
    for first in range(0, joints, PAGE):
        page = page_of(body, first)
        points = frame[first : min(first + PAGE, joints)]
        for j in range(len(points)):
            page[j + X] = points[j].x
            page[j + Y] = points[j].y
            page[j + Z] = points[j].z
    for first in range(0, plan.padded_joints, PAGE):
        page = page_of(body, first)
        _measure(page)
        if not page_within(page, WORK, reach * reach):
            return False
    cx, cy, cz = _center_step(plan, body)
    for first in range(0, plan.padded_joints, PAGE):
        _displace(page_of(body, first), cx, cy, cz)
    return True


@inline_kernel
def _measure(page):
    """Set the squared distances of a page's joints from where they were last there; NaN for those missing."""
    for j in range(PAGE):
        x = page[j + X] - page[j + GOOD_X]
        y = page[j + Y] - page[j + GOOD_Y]
        z = page[j + Z] - page[j + GOOD_Z]
        page[j + WORK] = x * x + y * y + z * z


@inline_kernel
def _center_step(plan, body):
    """Return how far the centre moved when all joints are there."""
    if plan.center >= 0:
        return _way(body, place(plan.center))
    x = y = z = 0.0
    for j in range(plan.joints):
        u, v, w = _way(body, place(j))
        x += u
        y += v
        z += w
    return np.float32(x / plan.joints), np.float32(y / plan.joints), np.float32(z / plan.joints)


@inline_kernel
def _way(body, k):
    """Return how far a joint is from where it was last there."""
    return body[k + X] - body[k + GOOD_X], body[k + Y] - body[k + GOOD_Y], body[k + Z] - body[k + GOOD_Z]


@inline_kernel
def _displace(page, cx, cy, cz):
    """Set the displacements of a page's joints relative to the centre, and keep where the joints are."""
    for j in range(PAGE):
        x = (page[j + X] - page[j + GOOD_X] - cx) * page[j + LIVE]
        y = (page[j + Y] - page[j + GOOD_Y] - cy) * page[j + LIVE]
        z = (page[j + Z] - page[j + GOOD_Z] - cz) * page[j + LIVE]
        page[j + GOOD_X], page[j + GOOD_Y], page[j + GOOD_Z] = page[j + X], page[j + Y], page[j + Z]
        page[j + MOVED_X], page[j + MOVED_Y], page[j + MOVED_Z] = x, y, z
        page[j + STEP] = np.sqrt(x * x + y * y + z * z)


@kernel
def _is_position(joint):
    return abs(joint.x) <= FARTHEST and abs(joint.y) <= FARTHEST and abs(joint.z) <= FARTHEST


@kernel
def _is_far(joint):
    """Tell whether a joint was given, but too far off to be true."""
    return abs(joint.x) > FARTHEST or abs(joint.y) > FARTHEST or abs(joint.z) > FARTHEST


@kernel
def is_empty(frame):
    """Tell whether a frame is without a single joint.

    Args:
        frame: (J,) POINT, m.
    """
    found = 0
    for j in range(len(frame)):
        found += 1 if _is_position(frame[j]) else 0
    return found == 0


@kernel
def count_nobody(counters, frame):
    """Count a frame without any joint that no take takes in.

    Args:
        counters: COUNTERS.
        frame: (J,) POINT.
    """
    counters.unseen += 1
    for j in range(len(frame)):
        counters.outliers += 1 if _is_far(frame[j]) else 0


@kernel
def _keep(body, k, joint):
    """Note where a joint is."""
    body[k + GOOD_X], body[k + GOOD_Y], body[k + GOOD_Z] = joint.x, joint.y, joint.z


@kernel
def _hold(body, k):
    """Let a joint be where it was last there."""
    body[k + X], body[k + Y], body[k + Z] = body[k + GOOD_X], body[k + GOOD_Y], body[k + GOOD_Z]


@kernel
def _step_partial(joints, frame, time):
    """Step joint by joint, when one is missing, is back, or is too fast."""
    plan, body, counters = joints.plan, joints.body, joints.counters
    joints.state.complete = 1
    cx = cy = cz = 0.0
    counted = found = 0
    for j in range(plan.joints):
        k = place(j)
        lasted = time - joints.seen[j]
        there = _is_position(frame[j])
        body[k + X], body[k + Y], body[k + Z] = frame[j].x, frame[j].y, frame[j].z
        x, y, z = _way(body, k)
        reach = plan.max_speed * lasted
        if there and lasted <= plan.max_gap and x * x + y * y + z * z > reach * reach:
            counters.outliers += 1
            joints.tracked[j] -= 1
            if joints.tracked[j] < 0:
                lasted = np.inf
            else:
                there = False
        elif not there and _is_far(frame[j]):
            counters.outliers += 1
        found += 1 if there else 0
        # In STEP: 1 moved, 0 held, -1 left out; the paths follow when the centre is known.
        body[k + STEP] = -1.0 if lasted > plan.max_gap else (1.0 if there else 0.0)
        if body[k + STEP] > 0.0 and (plan.center < 0 or j == plan.center):
            cx += x
            cy += y
            cz += z
        counted += 1 if body[k + STEP] >= 0.0 else 0
        if not there:
            joints.state.complete = 0
            counters.held += 1 if lasted <= plan.max_gap else 0
    joints.state.present = found
    counters.unseen += 1 if found == 0 else 0
    if plan.center < 0 and counted > 0:
        cx /= counted
        cy /= counted
        cz /= counted
    lost = counted == 0 or (plan.center >= 0 and body[place(plan.center) + STEP] < 0.0)
    return _partial_sum(joints, frame, time, (cx, cy, cz), lost)


@kernel
def _keep_centroid(joints, way, center_step):
    """Let the centroid stay where it is although a joint was carried along to another place than that where it is back."""
    state = joints.state
    state.offset_x -= (way[0] - center_step[0]) / state.moving
    state.offset_y -= (way[1] - center_step[1]) / state.moving
    state.offset_z -= (way[2] - center_step[2]) / state.moving


@kernel
def _partial_sum(joints, frame, time, center_step, lost):
    """Turn the marks in STEP into paths, keep the joints that are there, and return the scaled sum."""
    plan, body = joints.plan, joints.body
    cx, cy, cz = center_step
    moving = 0
    for j in range(plan.joints):
        k = place(j)
        mark = body[k + STEP]
        x = y = z = 0.0
        back = mark < 0.0 and _is_position(frame[j])
        body[k + WORK] = 0.0
        if mark > 0.0:
            x, y, z = _way(body, k)
        elif back and body[k + LIVE] > 0.0:
            joints.state.returned = 1
            body[k + WORK] = 1.0
            if plan.center < 0:
                _keep_centroid(joints, _way(body, k), center_step)
        if mark > 0.0 or back:
            joints.tracked[j] = 0 if back else min(joints.tracked[j] + 1, MOST_TRACKED)
            joints.seen[j] = time
            _keep(body, k, frame[j])
            if body[k + LIVE] == 0.0:
                joints.state.arrived = 1
        elif mark < 0.0 and not lost:
            body[k + GOOD_X] += cx
            body[k + GOOD_Y] += cy
            body[k + GOOD_Z] += cz
        body[k + STEP] = 0.0
        if mark >= 0.0 and j != plan.center and not lost:
            moving += 1
            x, y, z = x - cx, y - cy, z - cz
            body[k + STEP] = np.sqrt(x * x + y * y + z * z)
        else:
            x = y = z = 0.0
        body[k + MOVED_X], body[k + MOVED_Y], body[k + MOVED_Z] = x, y, z
        _hold(body, k)
    return line_sum(body, STEP) * plan.moving_joints / moving if moving > 0 else 0.0
