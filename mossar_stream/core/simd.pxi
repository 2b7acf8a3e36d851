# Declarations of simd.h: sums and products over many joints, in an order that no compiler changes.
#
# Arrays are given as a pointer to their first number; positions, lengths and columns count numbers. Nothing is checked.
# A page is one of the body's (joint_pages.pxi); `line` is the place of a line in it, such as STEP.

from libc.stdint cimport int16_t, int64_t


cdef extern from "simd.h" nogil:
    # Sum of a page's line, and of the products of two lines, in double precision.
    double page_sum(const float* page, int64_t line)
    double page_product(const float* page, int64_t one, int64_t other)

    # Whether no number of a page's line is above `limit` or NaN.
    bint page_within(const float* page, int64_t line, float limit)

    # Sum of the products of two lines of `count` numbers, a multiple of 8, in single precision.
    float line_product(const float* one, const float* other, int64_t count)

    # goal[k, j] = sum over i < count of lines[k, i] * others[j, i], for 4 lines and `rows` others, a multiple of 3.
    # Lines and others have `columns` numbers, a multiple of 8, with 0 from `count` on.
    void line_products(
        float* goal, int64_t goal_columns, const float* lines, const float* others,
        int64_t rows, int64_t columns, int64_t count,
    )

    # goal[k, i] = sum over j < rows of weights[k, j] * lines[j, i], for 4 rows of weights and i < count, rounded up
    # to a multiple of 24. Goal and lines have `columns` numbers, a multiple of 24.
    void weighted_sums(
        float* goal, const float* weights, int64_t weights_columns, const float* lines,
        int64_t rows, int64_t columns, int64_t count,
    )

    # Product over d = begin ... end - 1 of max(squares[d] * scale - (sums[d] * scale)**2, 0) + floor: as a mantissa,
    # which is returned, times 2**exponent, which is set. end - begin is a multiple of 8.
    double variance_product(
        const double* sums, const double* squares, int64_t begin, int64_t end,
        double scale, double floor, int64_t* exponent,
    )

    # Product over joints of the mean of such variances over `lines` lines, `stride` numbers apart, plus `floor`.
    double spread_product(
        const double* sums, const double* squares, int64_t begin, int64_t end,
        int64_t lines, int64_t stride, double scale, double floor,
    )

    # target[j] = values[j] * scale, rounded to the nearest integer, within -32767 ... 32767.
    void quantise(const float* values, int16_t* target, int64_t count, float scale)

    # Position of the lowest bit of a mask other than 0.
    int64_t lowest_bit(int64_t mask)
