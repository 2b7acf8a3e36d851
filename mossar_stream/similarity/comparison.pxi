"""Comparison: the strength between the segments on both sides of a moment, at moments all over a recording.

Li and Leung's recursion, with which this package compares Mossar, needs it from the path kernel.
"""


cdef void fill_pieces(
    Measure* measure, FloatPlanes poses, const double* times, const int64_t* starts, DoubleRows summaries,
    int64_t joints,
) noexcept nogil:
    """Summarise the pieces of a recording.

    Args:
        measure: The measure.
        poses: (n, 4, padded joints) m relative to the centre.
        times: (n,) s.
        starts: (pieces,) first frame of each.
        summaries: (pieces, slot), zero; set.
        joints: J.
    """
    cdef int64_t i, frame, end
    cdef double weight
    cdef Doubles own
    for i in range(summaries.rows):
        own = row_of_doubles(summaries, i)
        end = starts[i + 1] if i + 1 < summaries.rows else poses.planes
        for frame in range(starts[i], end):
            weight = times[frame] - times[frame - 1] if frame > 0 else 0.0
            add_pose(measure, own, plane_of_floats(poses, frame), joints, times[frame], weight)


cdef void gather_pieces(
    Measure* measure, DoubleRows summaries, int64_t size, DoubleRows later
) noexcept nogil:
    """Set `later` (zero) to the summaries of `size` pieces from each piece on, closed."""
    cdef int64_t i, k
    for i in range(summaries.rows - size + 1):
        for k in range(i, i + size):
            merge_into(measure, row_of_doubles(later, i), row_of_doubles(summaries, k))
        close(measure, row_of_doubles(later, i))


cdef void compare_pieces(
    Measure* measure, DoubleRows summaries, DoubleRows later, int64_t first, int64_t size, int64_t longest,
    DoubleRows scratch, Doubles found,
) noexcept nogil:
    """Set the strengths at pieces from the first on.

    Args:
        measure: The measure.
        summaries: (pieces, slot).
        later: (pieces, slot), from `gather_pieces`.
        first: Piece where the earlier segments begin.
        size: Of the later segment, pieces.
        longest: Of the earlier segment, pieces.
        scratch: (3, slot), zero.
        found: The strengths; set where no segment is shorter than `size`.
    """
    cdef int64_t i, k, last = found.count - 1
    cdef Doubles earlier = row_of_doubles(scratch, 0), closed = row_of_doubles(scratch, 1)
    cdef Doubles both = row_of_doubles(scratch, 2)
    for i in range(found.count):
        if i > longest:
            memset(earlier.at, 0, earlier.count * sizeof(double))
            for k in range(first + i - longest, first + i - 1):
                merge_into(measure, earlier, row_of_doubles(summaries, k))
        if i > 0:
            merge_into(measure, earlier, row_of_doubles(summaries, first + i - 1))
        if size <= i <= last - size:
            memcpy(closed.at, earlier.at, earlier.count * sizeof(double))
            close(measure, closed)
            found.at[i] = strength(measure, closed, row_of_doubles(later, first + i), both)
