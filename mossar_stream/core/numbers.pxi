"""Numbers: small functions of one number."""


cdef inline double squared(double x) noexcept nogil:
    return x * x


cdef inline int32_t bits_of(float x) noexcept nogil:
    """Return the bits of a number as a whole number."""
    cdef int32_t bits
    memcpy(&bits, &x, 4)
    return bits


cdef inline float float_of(int32_t bits) noexcept nogil:
    """Return the number that has these bits."""
    cdef float x
    memcpy(&x, &bits, 4)
    return x


cdef inline float along((float, float, float) vector, int64_t axis) noexcept nogil:
    """Return the coordinate of a vector along an axis."""
    return vector[0] if axis == 0 else (vector[1] if axis == 1 else vector[2])


cdef inline float squared_float(float x) noexcept nogil:
    return x * x


cdef inline int64_t magnitude(int64_t x) noexcept nogil:
    return -x if x < 0 else x
