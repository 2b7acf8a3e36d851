"""Joints of one frame: the visible ones, and the displacement of each relative to the body centre.

Localisation is step 1 of the paper's preprocessing (3.1.1): positions relative to the body centre, so that the
place of the performer does not matter. Displacements of localised joints are differences of displacements; this file
computes these.

Live joints come and go. A joint that is missing, or faster than `max_speed`, is held where it was for `max_gap`
seconds. Then it is left out, and moves with the centre until it is back, without a displacement across the gap. A
joint that was not yet seen in this take does not count (`LIVE` is 0, and its pose, too); no joint counts before the
root was seen. `arrival.pxi` includes a joint when it is seen.

In the first frame of a take, a joint that is far from all others is missing: with the centroid as centre it would move
all joints. Later, every frame within reach confirms the place of a joint; every outlier contradicts it. A place
that is contradicted more often than confirmed was wrong: the joint is then treated as left out, and is back at the
place of the outlier.
"""

# In the first frame of a take a joint is stray, and missing, if it is so many times as far from the middle of the joints as
# their median is (hands and feet: 4 times at most), and farther than this, m.
cdef double STRAY = 20.0
cdef double STRAY_FLOOR = 1.0
cdef enum:
    FEWEST_OF_BODY = 5  # joints; among fewer, the stray one is unknown
    HALVINGS = 40  # that find a median
    MOST_TRACKED = 255  # frames; more than `max_gap` has, and few enough to be contradicted within seconds

cdef struct JointsState:
    int64_t complete  # whether all joints were there in the last frame
    int64_t arrived  # whether one is there for the first time in this take
    int64_t returned  # whether one is there again after it was left out; WORK says which
    int64_t present  # number of those in the last frame
    int64_t unbroken  # complete frames that `tracked` does not have yet
    int64_t moving  # joints seen in this take that can move relative to the centre, at least 1
    # m, from the mean of the joints seen in this take to the centroid: arriving joints must not move it.
    double offset_x
    double offset_y
    double offset_z
    double unseen_time  # s, of the last frame that showed no movement of joints
    int64_t placed  # whether the following is known
    # m, offset taken off the source's coordinates before they became single precision; see placing.pxi.
    double origin_x
    double origin_y
    double origin_z


cdef struct Joints:  # A performer's joints, as the functions below need them.
    Plan* plan  # PLAN
    JointsState* state  # JOINTS
    Counters* counters  # COUNTERS
    Doubles seen  # (padded_joints,) s, when each joint was last there
    Ints32 tracked  # (padded_joints,) frames that confirm its place, less those that contradict it
    Floats body  # see joint_pages.pxi


cdef void start_joints(Joints* joints, PositionSpan frame, double time) noexcept nogil:
    """Process the first frame of a take: no joint has moved yet, and the state of the take before is cleared.

    Args:
        joints: Joints.
        frame: (J,) POINT, m, NaN where missing.
        time: s.
    """
    cdef int64_t found, j, k
    cdef double farthest
    cdef Floats body
    cdef JointsState* state
    body = joints.body
    state = joints.state
    state.complete = 1
    state.arrived = 0
    state.returned = 0
    state.unbroken = 0
    state.unseen_time = -INFINITY
    state.offset_x = state.offset_y = state.offset_z = 0.0
    found = 0
    farthest = _measure_distances(joints, frame)
    for j in range(joints.plan.joints):
        k = place(j)
        body.at[k + STEP] = body.at[k + MOVED_X] = body.at[k + MOVED_Y] = body.at[k + MOVED_Z] = 0.0
        body.at[k + GOOD_X] = body.at[k + GOOD_Y] = body.at[k + GOOD_Z] = 0.0
        joints.tracked.at[j] = 0
        if body.at[k + WORK] <= farthest:
            joints.seen.at[j] = time
            _keep(body, k, &frame.at[j])
            found += 1
        else:
            joints.seen.at[j] = -INFINITY
            state.complete = 0
            joints.counters.outliers += 1 if _is_far(&frame.at[j]) or body.at[k + WORK] > farthest else 0
        _hold(body, k)
    joints.state.present = found
    joints.counters.unseen += 1 if found == 0 else 0
    for j in range(joints.plan.joints):
        body.at[place(j) + LIVE] = 1.0 if counts(joints, j) else 0.0
    count_moving(joints)


cdef double _measure_distances(Joints* joints, PositionSpan frame) noexcept nogil:
    """Set WORK to each joint's squared distance from the middle of all, m², NaN if missing; return the largest that counts.

    The middle is the median of each coordinate, which a stray marker does not move.
    """
    cdef double[3] middle
    cdef int64_t j, found, count, axis
    cdef double usual, squares, off
    cdef Floats body
    body = joints.body
    count = joints.plan.joints
    for axis in range(3):
        middle[axis] = _joints_middle(joints, frame, axis)
    for j in range(count):
        squares = 0.0
        for axis in range(3):
            off = _coordinate(&frame.at[j], axis) - middle[axis]
            squares += off * off
        body.at[place(j) + WORK] = squares
    usual = _median(body, count)
    found = 0
    for j in range(count):
        found += 1 if body.at[place(j) + WORK] >= 0.0 else 0
    if found < FEWEST_OF_BODY or usual == 0.0:
        return INFINITY
    return max(STRAY * STRAY * usual, STRAY_FLOOR * STRAY_FLOOR)


cdef double _joints_middle(Joints* joints, PositionSpan frame, int64_t axis) noexcept nogil:
    """Return the median of a coordinate, m; uses WORK."""
    cdef int64_t j
    for j in range(joints.plan.joints):
        joints.body.at[place(j) + WORK] = _coordinate(&frame.at[j], axis)
    return _median(joints.body, joints.plan.joints)


cdef inline float _coordinate(Position* joint, int64_t axis) noexcept nogil:
    """Return a coordinate, m; NaN if the joint is missing."""
    if not _is_position(joint):
        return NAN
    return joint.x if axis == 0 else (joint.y if axis == 1 else joint.z)


cdef double _median(Floats body, int64_t count) noexcept nogil:
    """Return the median of WORK, by halving the span that it lies in; NaN does not count."""
    cdef int64_t j, _, known, below
    cdef double high, low, at
    cdef float value
    low, high, known = INFINITY, -INFINITY, 0
    for j in range(count):
        value = body.at[place(j) + WORK]
        if not isnan(value):
            low, high, known = min(low, value), max(high, value), known + 1
    for _ in range(HALVINGS):
        at = 0.5 * (low + high)
        below = 0
        for j in range(count):
            below += 1 if body.at[place(j) + WORK] <= at else 0
        if 2 * below >= known:
            high = at
        else:
            low = at
    return high


cdef double last_seen(Joints* joints) noexcept nogil:
    """Return the time at which the centre and a joint that moves relative to it were last there, s; -inf if never in this take.

    Args:
        joints: Joints; the last frame was not complete.
    """
    cdef double latest
    cdef int64_t center, j
    latest = -INFINITY
    center = joints.plan.center
    for j in range(joints.plan.joints):
        if j != center:
            latest = max(latest, joints.seen.at[j])
    return min(latest, joints.seen.at[center]) if center >= 0 else latest


cdef bint counts(Joints* joints, int64_t j) noexcept nogil:
    """Return whether a joint was seen in this take, and the root, if that is the centre, too."""
    cdef int64_t center
    center = joints.plan.center
    return joints.seen.at[j] > -INFINITY and (center < 0 or joints.seen.at[center] > -INFINITY)


cdef void count_moving(Joints* joints) noexcept nogil:
    """Note the number of joints that count and can move relative to the centre."""
    cdef int64_t moving, j
    moving = 0
    for j in range(joints.plan.joints):
        if j != joints.plan.center and joints.body.at[place(j) + LIVE] > 0.0:
            moving += 1
    joints.state.moving = max(moving, 1)


cdef inline double step_joints(Joints* joints, PositionSpan frame, double before, double time) noexcept nogil:
    """Process the joints of one frame, and set each joint's way relative to the centre.

    Args:
        joints: Joints; positions, displacements and their lengths are set.
        frame: (J,) POINT, m, NaN where missing.
        before: s, of the last frame.
        time: s, later.

    Returns:
        Path summed over the joints, scaled up for those left out, m.
    """
    cdef Plan* plan
    cdef double dt
    cdef int64_t j
    plan = joints.plan
    if joints.state.complete == 1:
        dt = time - before
        if dt <= plan.max_gap and _step_complete(plan, joints.body, frame, plan.max_speed * dt):
            joints.state.unbroken += 1
            return line_sum(joints.body, STEP)
        for j in range(plan.joints):
            joints.seen.at[j] = before
            joints.tracked.at[j] = min(joints.tracked.at[j] + joints.state.unbroken, MOST_TRACKED)
        joints.state.unbroken = 0
    return _step_partial(joints, frame, time)


cdef inline bint _step_complete(Plan* plan, Floats body, PositionSpan frame, double reach) noexcept nogil:
    """Step when every joint was there in the last frame; False, with nothing kept, if one is not there now."""
    cdef int64_t joints, first, j
    cdef Floats page
    cdef PositionSpan points
    cdef float cx, cy, cz
    joints = plan.joints
    for first from 0 <= first < joints by PAGE:
        page = page_of(body, first)
        points = part_of_position_span(frame, first, min(first + PAGE, joints))
        for j in range(points.count):
            page.at[j + X] = points.at[j].x
            page.at[j + Y] = points.at[j].y
            page.at[j + Z] = points.at[j].z
    for first from 0 <= first < plan.padded_joints by PAGE:
        page = page_of(body, first)
        _joints_measure(page)
        if not page_within(page.at, WORK, <float>(reach * reach)):
            return False
    cx, cy, cz = _center_step(plan, body)
    for first from 0 <= first < plan.padded_joints by PAGE:
        _displace(page_of(body, first), cx, cy, cz)
    return True


cdef inline void _joints_measure(Floats page) noexcept nogil:
    """Set the squared distances of a page's joints from where they were last there; NaN for those missing."""
    cdef int64_t j
    cdef float x, y, z
    for j in range(PAGE):
        x = page.at[j + X] - page.at[j + GOOD_X]
        y = page.at[j + Y] - page.at[j + GOOD_Y]
        z = page.at[j + Z] - page.at[j + GOOD_Z]
        page.at[j + WORK] = x * x + y * y + z * z


cdef inline (float, float, float) _center_step(Plan* plan, Floats body) noexcept nogil:
    """Return the displacement of the centre when all joints are there."""
    cdef double x, y, z
    cdef int64_t j
    cdef float u, v, w
    if plan.center >= 0:
        return _way(body, place(plan.center))
    x = y = z = 0.0
    for j in range(plan.joints):
        u, v, w = _way(body, place(j))
        x += u
        y += v
        z += w
    return (<float>(x / plan.joints), <float>(y / plan.joints), <float>(z / plan.joints))


cdef inline (float, float, float) _way(Floats body, int64_t k) noexcept nogil:
    """Return the way of a joint from its last place."""
    return (body.at[k + X] - body.at[k + GOOD_X], body.at[k + Y] - body.at[k + GOOD_Y], body.at[k + Z] - body.at[k + GOOD_Z])


cdef inline void _displace(Floats page, float cx, float cy, float cz) noexcept nogil:
    """Set the displacements of a page's joints relative to the centre, and keep where the joints are."""
    cdef int64_t j
    cdef float x, y, z
    for j in range(PAGE):
        x = (page.at[j + X] - page.at[j + GOOD_X] - cx) * page.at[j + LIVE]
        y = (page.at[j + Y] - page.at[j + GOOD_Y] - cy) * page.at[j + LIVE]
        z = (page.at[j + Z] - page.at[j + GOOD_Z] - cz) * page.at[j + LIVE]
        page.at[j + GOOD_X], page.at[j + GOOD_Y], page.at[j + GOOD_Z] = page.at[j + X], page.at[j + Y], page.at[j + Z]
        page.at[j + MOVED_X], page.at[j + MOVED_Y], page.at[j + MOVED_Z] = x, y, z
        page.at[j + STEP] = sqrtf(x * x + y * y + z * z)


cdef bint _is_position(Position* joint) noexcept nogil:
    return abs(joint.x) <= FARTHEST and abs(joint.y) <= FARTHEST and abs(joint.z) <= FARTHEST


cdef bint _is_far(Position* joint) noexcept nogil:
    """Return whether a joint was given, but too far off to be true."""
    return abs(joint.x) > FARTHEST or abs(joint.y) > FARTHEST or abs(joint.z) > FARTHEST


cdef bint is_empty(PositionSpan frame) noexcept nogil:
    """Return whether a frame is without a single joint.

    Args:
        frame: (J,) POINT, m.
    """
    cdef int64_t found, j
    found = 0
    for j in range(frame.count):
        found += 1 if _is_position(&frame.at[j]) else 0
    return found == 0


cdef void count_nobody(Counters* counters, PositionSpan frame) noexcept nogil:
    """Count a frame without any joint that belongs to no take.

    Args:
        counters: COUNTERS.
        frame: (J,) POINT.
    """
    cdef int64_t j
    counters.unseen += 1
    for j in range(frame.count):
        counters.outliers += 1 if _is_far(&frame.at[j]) else 0


cdef void _keep(Floats body, int64_t k, Position* joint) noexcept nogil:
    """Note where a joint is."""
    body.at[k + GOOD_X], body.at[k + GOOD_Y], body.at[k + GOOD_Z] = joint.x, joint.y, joint.z


cdef void _hold(Floats body, int64_t k) noexcept nogil:
    """Hold a joint at its last place."""
    body.at[k + X], body.at[k + Y], body.at[k + Z] = body.at[k + GOOD_X], body.at[k + GOOD_Y], body.at[k + GOOD_Z]


cdef double _step_partial(Joints* joints, PositionSpan frame, double time) noexcept nogil:
    """Step joint by joint, when one is missing, is back, or is too fast."""
    cdef double cx, cy, cz, lasted, reach
    cdef int64_t counted, found, j, k
    cdef bint lost, there
    cdef Plan* plan
    cdef Floats body
    cdef Counters* counters
    cdef float x, y, z
    plan = joints.plan
    body = joints.body
    counters = joints.counters
    joints.state.complete = 1
    cx = cy = cz = 0.0
    counted = found = 0
    for j in range(plan.joints):
        k = place(j)
        lasted = time - joints.seen.at[j]
        there = _is_position(&frame.at[j])
        body.at[k + X], body.at[k + Y], body.at[k + Z] = frame.at[j].x, frame.at[j].y, frame.at[j].z
        x, y, z = _way(body, k)
        reach = plan.max_speed * lasted
        if there and lasted <= plan.max_gap and x * x + y * y + z * z > reach * reach:
            counters.outliers += 1
            joints.tracked.at[j] -= 1
            if joints.tracked.at[j] < 0:
                lasted = INFINITY
            else:
                there = False
        elif not there and _is_far(&frame.at[j]):
            counters.outliers += 1
        found += 1 if there else 0
        # In STEP: 1 moved, 0 held, -1 left out; the paths follow when the centre is known.
        body.at[k + STEP] = -1.0 if lasted > plan.max_gap else (1.0 if there else 0.0)
        if body.at[k + STEP] > 0.0 and (plan.center < 0 or j == plan.center):
            cx += x
            cy += y
            cz += z
        counted += 1 if body.at[k + STEP] >= 0.0 else 0
        if not there:
            joints.state.complete = 0
            counters.held += 1 if lasted <= plan.max_gap else 0
    joints.state.present = found
    counters.unseen += 1 if found == 0 else 0
    if plan.center < 0 and counted > 0:
        cx /= counted
        cy /= counted
        cz /= counted
    lost = counted == 0 or plan.center >= 0 and body.at[place(plan.center) + STEP] < 0.0
    return _partial_sum(joints, frame, time, (cx, cy, cz), lost)


cdef void _keep_centroid(
    Joints* joints, (float, float, float) way, (double, double, double) center_step
) noexcept nogil:
    """Keep the centroid where it is although a joint comes back at another place than the one it was carried to."""
    cdef JointsState* state
    state = joints.state
    state.offset_x -= (way[0] - center_step[0]) / state.moving
    state.offset_y -= (way[1] - center_step[1]) / state.moving
    state.offset_z -= (way[2] - center_step[2]) / state.moving


cdef double _partial_sum(
    Joints* joints, PositionSpan frame, double time, (double, double, double) center_step, bint lost
) noexcept nogil:
    """Turn the marks in STEP into paths, keep the joints that are there, and return the scaled sum."""
    cdef int64_t moving, j, k
    cdef Plan* plan
    cdef Floats body
    cdef double cx, cy, cz, x, y, z
    cdef float mark
    cdef bint back
    plan = joints.plan
    body = joints.body
    cx, cy, cz = center_step
    moving = 0
    for j in range(plan.joints):
        k = place(j)
        mark = body.at[k + STEP]
        x = y = z = 0.0
        back = mark < 0.0 and _is_position(&frame.at[j])
        body.at[k + WORK] = 0.0
        if mark > 0.0:
            x, y, z = _way(body, k)
        elif back and body.at[k + LIVE] > 0.0:
            joints.state.returned = 1
            body.at[k + WORK] = 1.0
            if plan.center < 0:
                _keep_centroid(joints, _way(body, k), center_step)
        if mark > 0.0 or back:
            joints.tracked.at[j] = 0 if back else min(joints.tracked.at[j] + 1, MOST_TRACKED)
            joints.seen.at[j] = time
            _keep(body, k, &frame.at[j])
            if body.at[k + LIVE] == 0.0:
                joints.state.arrived = 1
        elif mark < 0.0 and not lost:
            body.at[k + GOOD_X] += cx
            body.at[k + GOOD_Y] += cy
            body.at[k + GOOD_Z] += cz
        body.at[k + STEP] = 0.0
        if mark >= 0.0 and j != plan.center and not lost:
            moving += 1
            x, y, z = x - cx, y - cy, z - cz
            body.at[k + STEP] = sqrt(x * x + y * y + z * z)
        else:
            x = y = z = 0.0
        body.at[k + MOVED_X], body.at[k + MOVED_Y], body.at[k + MOVED_Z] = x, y, z
        _hold(body, k)
    return line_sum(body, STEP) * plan.moving_joints / moving if moving > 0 else 0.0
