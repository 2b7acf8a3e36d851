"""Placing: the place of a performer in a take, and positions relative to it.

Kernels calculate in single precision, which 10 km from the origin is a millimetre. A performer's place is therefore taken
off in double precision before positions are narrowed. It is the multiple of `CELL` nearest to the first position in a take.
On a usual stage that is 0, and positions stay as they are.
"""

cdef double CELL = 16.0  # m; half of it from there, single precision is half a micrometre


cdef inline bint is_far_off(Row* row) noexcept:
    """Return whether anything is taken off positions in this take."""
    return row.joints.origin_x != 0.0 or row.joints.origin_y != 0.0 or row.joints.origin_z != 0.0


cdef inline double _number_at(cnp.ndarray positions, int64_t i) noexcept:
    """Return number i of positions in single or double precision."""
    if cnp.PyArray_TYPE(positions) == cnp.NPY_FLOAT32:
        return (<float*>cnp.PyArray_DATA(positions))[i]
    return (<double*>cnp.PyArray_DATA(positions))[i]


cdef void narrow_positions(cnp.ndarray positions, int64_t begin, int64_t count, double* origin, float* narrowed) noexcept:
    """Set numbers in single precision to positions less the origin.

    Args:
        positions: (…, 3) m, in single or double precision.
        begin: First number, a multiple of 3.
        count: Their number.
        origin: (3,) m.
        narrowed: (count,) m, set.
    """
    cdef int64_t i
    for i in range(count):
        narrowed[i] = <float>(_number_at(positions, begin + i) - origin[i % 3])


cdef cnp.ndarray less_origin(Row* row, cnp.ndarray positions, int64_t begin, int64_t end):
    """Return frames of (n, J, 3) positions in single precision, less the origin; all of the positions if nothing need be done.

    Those of a recording are relative to the origin already; see `placed`.
    """
    cdef int64_t numbers = 3 * row.plan.joints
    cdef cnp.npy_intp count = (end - begin) * numbers
    cdef cnp.ndarray narrowed
    if row.plan.offline == 1 or (cnp.PyArray_TYPE(positions) == cnp.NPY_FLOAT32 and not is_far_off(row)):
        return positions
    narrowed = cnp.PyArray_EMPTY(1, &count, cnp.NPY_FLOAT32, 0)
    narrow_positions(
        positions, begin * numbers, count, &row.joints.origin_x, <float*>cnp.PyArray_DATA(narrowed)
    )
    return narrowed


cdef int64_t settle_row(Row* row, cnp.ndarray positions, int64_t begin, int64_t count) noexcept:
    """Find the performer's place in the frames from `begin` on; the search is repeated if the first frame has no joint.

    Returns:
        Number of frames to process then: those before the first visible joint, or all if the first frame has one.
    """
    cdef double origin[3]
    cdef int64_t first = find_place(positions, begin, count, row.plan.center, origin)
    cdef bint is_found = first == begin
    row.joints.placed = is_found
    row.joints.origin_x = origin[0] if is_found else 0.0
    row.joints.origin_y = origin[1] if is_found else 0.0
    row.joints.origin_z = origin[2] if is_found else 0.0
    return count - begin if is_found else first - begin


cdef int64_t find_place(cnp.ndarray positions, int64_t begin, int64_t count, int64_t center, double* origin) noexcept:
    """Set the offset to take off positions, m, and return the first frame with a visible joint; `count` if there is none.

    Args:
        positions: (n, J, 3) m, in single or double precision.
        begin: First frame to search.
        count: End of these frames.
        center: Index of the root, -1 for the centroid.
        origin: (3,) m, set.
    """
    cdef int64_t joints = cnp.PyArray_DIM(positions, 1), i, j, k, axis, chosen
    cdef bint is_position, is_anybody
    origin[0] = origin[1] = origin[2] = 0.0
    for i in range(begin, count):
        chosen, is_anybody = -1, False
        for j in range(joints):
            k, is_position = 3 * (i * joints + j), True
            for axis in range(3):
                is_position = is_position and abs(_number_at(positions, k + axis)) <= FARTHEST
            if not is_position:
                continue
            chosen = k if chosen < 0 or j == center else chosen
            for axis in range(3):  # some senders put all joints of an absent person at the origin
                is_anybody = is_anybody or _number_at(positions, k + axis) != 0.0
        if is_anybody:
            for axis in range(3):
                origin[axis] = CELL * rint(_number_at(positions, chosen + axis) / CELL)
            return i
    return count


def placed(cnp.ndarray positions, int64_t center, /):
    """Return positions in single precision, relative to the performer's first place, and that place.

    Args:
        positions: (n, J, 3) m, in single or double precision, C-contiguous.
        center: Index of the root, -1 for the centroid.
    """
    cdef double origin[3]
    cdef cnp.ndarray narrowed = positions
    find_place(positions, 0, cnp.PyArray_DIM(positions, 0), center, origin)
    if cnp.PyArray_TYPE(positions) != cnp.NPY_FLOAT32 or origin[0] != 0.0 or origin[1] != 0.0 or origin[2] != 0.0:
        narrowed = cnp.PyArray_EMPTY(3, cnp.PyArray_DIMS(positions), cnp.NPY_FLOAT32, 0)
        narrow_positions(positions, 0, cnp.PyArray_SIZE(positions), origin, <float*>cnp.PyArray_DATA(narrowed))
    return narrowed, (origin[0], origin[1], origin[2])
