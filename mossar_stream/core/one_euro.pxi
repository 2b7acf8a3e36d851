"""One-Euro filter: smooths each joint before its path is measured, for sources with jitter.

Casiez, Roussel and Vogel (2012): a low-pass filter whose cut-off rises with the speed of the joint, so that it is
smooth at rest and quick in motion.
"""

cdef double DERIVATIVE_CUTOFF = 1.0  # Hz, of the speeds


cdef double filter_joints(Plan* plan, Floats body, DoubleRows filtered, double dt) noexcept nogil:
    """Pass the joints through the filter and set displacements and steps from the filtered positions.

    Args:
        plan: PLAN.
        body: Places of the joints, which the filter moves; displacements and their lengths are set.
        filtered: (6, padded_joints) m and m/s, filtered positions and derivatives.
        dt: s since the last frame; 0 or less at the start of a take.

    Returns:
        Path summed over the joints, m.
    """
    cdef int64_t j, axis
    cdef double speed, now, slope, cutoff
    cdef double* position
    cdef double* rate
    for j in range(plan.joints):
        speed = 0.0
        for axis in range(3):
            now = body.at[place(j) + axis * Y]
            position = filtered.at + axis * filtered.columns + j
            rate = filtered.at + (3 + axis) * filtered.columns + j
            if dt <= 0.0:
                position[0] = now
                rate[0] = 0.0
                continue
            slope = (now - position[0]) / dt
            rate[0] += _smoothing(DERIVATIVE_CUTOFF, dt) * (slope - rate[0])
            speed += squared(rate[0])
        cutoff = plan.one_euro_cutoff + plan.one_euro_beta * sqrt(speed)
        body.at[place(j) + STEP] = _smoothing(cutoff, dt) if dt > 0.0 else 0.0
    return _filtered_sum(plan, body, filtered)


cdef double _smoothing(double cutoff, double dt) noexcept nogil:
    """Weight of a new sample for a cut-off frequency in Hz."""
    cdef double rate
    rate = 2.0 * M_PI * cutoff * dt
    return rate / (rate + 1.0)


cdef (double, double, double) _step_of(Floats body, DoubleRows filtered, int64_t j) noexcept nogil:
    """Return the step of a joint's filtered position."""
    cdef int64_t k
    cdef float weight
    cdef double x, y, z
    k = place(j)
    weight = body.at[k + STEP]
    x = weight * (body.at[k + X] - filtered.at[j])
    y = weight * (body.at[k + Y] - filtered.at[filtered.columns + j])
    z = weight * (body.at[k + Z] - filtered.at[2 * filtered.columns + j])
    return x, y, z


cdef double _filtered_sum(Plan* plan, Floats body, DoubleRows filtered) noexcept nogil:
    """Move the filtered positions by the weights in STEP, and turn these into paths."""
    cdef double cx, cy, cz, live, share, x, y, z
    cdef int64_t j, k
    cx = cy = cz = live = 0.0
    for j in range(plan.joints):
        if (plan.center < 0 or j == plan.center) and body.at[place(j) + LIVE] > 0.0:
            x, y, z = _step_of(body, filtered, j)
            cx, cy, cz, live = cx + x, cy + y, cz + z, live + 1.0
    share = 1.0 / max(live, 1.0)
    for j in range(plan.joints):
        x, y, z = _step_of(body, filtered, j)
        filtered.at[j] += x
        filtered.at[filtered.columns + j] += y
        filtered.at[2 * filtered.columns + j] += z
        k = place(j)
        body.at[k + X] = filtered.at[j]
        body.at[k + Y] = filtered.at[filtered.columns + j]
        body.at[k + Z] = filtered.at[2 * filtered.columns + j]
        x, y, z = x - cx * share, y - cy * share, z - cz * share
        if body.at[k + LIVE] == 0.0:
            x = y = z = 0.0
        body.at[k + MOVED_X], body.at[k + MOVED_Y], body.at[k + MOVED_Z] = x, y, z
        body.at[k + STEP] = sqrt(x * x + y * y + z * z)
    return line_sum(body, STEP)


cdef void begin_filter(Floats body, DoubleRows filtered, int64_t j) noexcept nogil:
    """Restart the filter for a joint, at its present place."""
    cdef int64_t k, axis
    k = place(j)
    for axis in range(3):
        filtered.at[axis * filtered.columns + j] = body.at[k + X + axis * Y] = body.at[k + GOOD_X + axis * Y]
        filtered.at[(3 + axis) * filtered.columns + j] = 0.0
