"""Spans: arrays for kernels: the address of the first number, and the number of them.

A span owns nothing; the memory is that of a performer, of an example, or of the scratch. Rows follow each other without gaps,
so that number j of row i is `rows.at[i * rows.columns + j]`. A part never reaches beyond its span, like a slice in Python.
"""

cdef struct Doubles:
    double* at
    int64_t count


cdef struct DoubleRows:
    double* at
    int64_t rows
    int64_t columns


cdef struct DoublePlanes:
    double* at
    int64_t planes
    int64_t rows
    int64_t columns


cdef struct Floats:
    float* at
    int64_t count


cdef struct FloatRows:
    float* at
    int64_t rows
    int64_t columns


cdef struct FloatPlanes:
    float* at
    int64_t planes
    int64_t rows
    int64_t columns


cdef struct Ints:
    int64_t* at
    int64_t count


cdef struct IntRows:
    int64_t* at
    int64_t rows
    int64_t columns


cdef struct Ints32:
    int32_t* at
    int64_t count


cdef struct Int32Rows:
    int32_t* at
    int64_t rows
    int64_t columns


cdef struct Shorts:
    int16_t* at
    int64_t count


cdef struct ShortRows:
    int16_t* at
    int64_t rows
    int64_t columns


cdef struct ShortPlanes:
    int16_t* at
    int64_t planes
    int64_t rows
    int64_t columns


cdef struct Bytes:
    uint8_t* at
    int64_t count


cdef struct ByteRows:
    uint8_t* at
    int64_t rows
    int64_t columns


cdef struct BytePlanes:
    uint8_t* at
    int64_t planes
    int64_t rows
    int64_t columns


cdef inline Doubles doubles(double* at, int64_t count) noexcept nogil:
    """Return so many numbers from an address on."""
    cdef Doubles found
    found.at, found.count = at, count
    return found


cdef inline Doubles part_of_doubles(Doubles span, int64_t begin, int64_t end) noexcept nogil:
    """Return numbers begin … end - 1, as far as there are any."""
    end = min(end, span.count)
    return doubles(span.at + begin, max(end - begin, 0))


cdef inline DoubleRows doubles_in_rows(double* at, int64_t rows, int64_t columns) noexcept nogil:
    """Return rows of so many numbers each from an address on."""
    cdef DoubleRows found
    found.at, found.rows, found.columns = at, rows, columns
    return found


cdef inline Doubles row_of_doubles(DoubleRows rows, int64_t i) noexcept nogil:
    """Return row i."""
    return doubles(rows.at + i * rows.columns, rows.columns)


cdef inline DoubleRows rows_of_doubles(DoubleRows rows, int64_t begin, int64_t end) noexcept nogil:
    """Return rows begin … end - 1, as far as there are any."""
    end = min(end, rows.rows)
    return doubles_in_rows(rows.at + begin * rows.columns, max(end - begin, 0), rows.columns)


cdef inline Floats floats(float* at, int64_t count) noexcept nogil:
    """Return so many numbers from an address on."""
    cdef Floats found
    found.at, found.count = at, count
    return found


cdef inline Floats part_of_floats(Floats span, int64_t begin, int64_t end) noexcept nogil:
    """Return numbers begin … end - 1, as far as there are any."""
    end = min(end, span.count)
    return floats(span.at + begin, max(end - begin, 0))


cdef inline Floats from_floats(Floats span, int64_t begin) noexcept nogil:
    """Return all numbers from `begin` on."""
    return floats(span.at + begin, max(span.count - begin, 0))


cdef inline FloatRows floats_in_rows(float* at, int64_t rows, int64_t columns) noexcept nogil:
    """Return rows of so many numbers each from an address on."""
    cdef FloatRows found
    found.at, found.rows, found.columns = at, rows, columns
    return found


cdef inline Floats row_of_floats(FloatRows rows, int64_t i) noexcept nogil:
    """Return row i."""
    return floats(rows.at + i * rows.columns, rows.columns)


cdef inline FloatRows rows_of_floats(FloatRows rows, int64_t begin, int64_t end) noexcept nogil:
    """Return rows begin … end - 1, as far as there are any."""
    end = min(end, rows.rows)
    return floats_in_rows(rows.at + begin * rows.columns, max(end - begin, 0), rows.columns)


cdef inline FloatRows plane_of_floats(FloatPlanes planes, int64_t i) noexcept nogil:
    """Return plane i."""
    return floats_in_rows(planes.at + i * planes.rows * planes.columns, planes.rows, planes.columns)


cdef inline Ints ints(int64_t* at, int64_t count) noexcept nogil:
    """Return so many numbers from an address on."""
    cdef Ints found
    found.at, found.count = at, count
    return found


cdef inline IntRows ints_in_rows(int64_t* at, int64_t rows, int64_t columns) noexcept nogil:
    """Return rows of so many numbers each from an address on."""
    cdef IntRows found
    found.at, found.rows, found.columns = at, rows, columns
    return found


cdef inline Ints row_of_ints(IntRows rows, int64_t i) noexcept nogil:
    """Return row i."""
    return ints(rows.at + i * rows.columns, rows.columns)


cdef inline Ints32 ints32(int32_t* at, int64_t count) noexcept nogil:
    """Return so many numbers from an address on."""
    cdef Ints32 found
    found.at, found.count = at, count
    return found


cdef inline Int32Rows ints32_in_rows(int32_t* at, int64_t rows, int64_t columns) noexcept nogil:
    """Return rows of so many numbers each from an address on."""
    cdef Int32Rows found
    found.at, found.rows, found.columns = at, rows, columns
    return found


cdef inline Shorts shorts(int16_t* at, int64_t count) noexcept nogil:
    """Return so many numbers from an address on."""
    cdef Shorts found
    found.at, found.count = at, count
    return found


cdef inline Shorts part_of_shorts(Shorts span, int64_t begin, int64_t end) noexcept nogil:
    """Return numbers begin … end - 1, as far as there are any."""
    end = min(end, span.count)
    return shorts(span.at + begin, max(end - begin, 0))


cdef inline Shorts from_shorts(Shorts span, int64_t begin) noexcept nogil:
    """Return all numbers from `begin` on."""
    return shorts(span.at + begin, max(span.count - begin, 0))


cdef inline ShortRows shorts_in_rows(int16_t* at, int64_t rows, int64_t columns) noexcept nogil:
    """Return rows of so many numbers each from an address on."""
    cdef ShortRows found
    found.at, found.rows, found.columns = at, rows, columns
    return found


cdef inline Shorts row_of_shorts(ShortRows rows, int64_t i) noexcept nogil:
    """Return row i."""
    return shorts(rows.at + i * rows.columns, rows.columns)


cdef inline ShortRows plane_of_shorts(ShortPlanes planes, int64_t i) noexcept nogil:
    """Return plane i."""
    return shorts_in_rows(planes.at + i * planes.rows * planes.columns, planes.rows, planes.columns)


cdef inline Bytes bytes_(uint8_t* at, int64_t count) noexcept nogil:
    """Return so many numbers from an address on."""
    cdef Bytes found
    found.at, found.count = at, count
    return found


cdef inline ByteRows bytes_in_rows(uint8_t* at, int64_t rows, int64_t columns) noexcept nogil:
    """Return rows of so many numbers each from an address on."""
    cdef ByteRows found
    found.at, found.rows, found.columns = at, rows, columns
    return found
