"""Middle: the centroid of a performer's joints, on which limbs hang where the skeleton has no root.

The body's own centroid is taken: joints that are missing or too far off are held as the body holds them, and then carried
along. A mean of the joints that are there would move whenever a joint goes or comes.
"""


cdef inline void put_middle(Bytes body, Floats middle) noexcept nogil:
    """Set the middle of the joints of the frame that the body processed last.

    Args:
        body: Bytes of the performer.
        middle: (3,) m, set; NaN if no joint was there.
    """
    cdef Row* whole
    cdef Floats lines
    cdef bint nobody
    cdef float x, y, z
    # CHECK sign (C truncates): (whole.at.seen - whole.at.body) // 4
    # CHECK call of part: part(body, 0, ROW, (1,))
    # CHECK subscript part(body, 0, ROW, (1,))[0]
    # CHECK call of part: part(body, whole.at.body, np.float32, ((whole.at.seen - whole.at.body) // 4,))
    whole = part(body, 0, ROW, (1,))[0]
    lines = part(body, whole.at.body, np.float32, ((whole.at.seen - whole.at.body) // 4))
    x, y, z = center_of(&whole.plan, &whole.joints, lines)
    nobody = whole.joints.present == 0
    middle.at[0] = NAN if nobody else x
    middle.at[1] = NAN if nobody else y
    middle.at[2] = NAN if nobody else z


# ENTRY: called from Python
cdef void set_middle(Bytes body, Floats middle) noexcept nogil:
    """Do the same from Python."""
    put_middle(body, middle)
