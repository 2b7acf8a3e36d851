"""Middle: the centroid of a performer's joints, on which limbs hang where the skeleton has no root.

It is the body's own centroid: joints that are missing or too far off are held as the body holds them, and then carried
along. A mean of the visible joints would move whenever a joint goes or comes.
"""


cdef void put_middle(Row* body, float* middle) noexcept nogil:
    """Set the middle of the joints of the frame that the body processed last.

    Args:
        body: The performer's.
        middle: (3,) m, set; NaN if no joint was there.
    """
    middle[0], middle[1], middle[2] = center_of(&body.plan, &body.joints, body_of(body))
    if body.joints.present == 0:
        middle[0] = middle[1] = middle[2] = NAN
