# Declarations of simd.h: sums and products in a stated order; what each does is said there.

from libc.stdint cimport int64_t


cdef extern from "simd.h" nogil:
    double page_sum(const float* page, int64_t line)
    double page_product(const float* page, int64_t one, int64_t other)
    bint page_within(const float* page, int64_t line, float limit)
    float line_product(const float* one, const float* other, int64_t count)
    void line_products(
        float* goal, int64_t goal_columns, const float* lines, const float* others,
        int64_t rows, int64_t columns, int64_t count,
    )
    void weighted_sums(
        float* goal, const float* weights, int64_t weights_columns, const float* lines,
        int64_t rows, int64_t columns, int64_t count,
    )
    double variance_product(
        const double* sums, const double* squares, int64_t begin, int64_t end,
        double scale, double floor, int64_t* exponent,
    )
    double spread_product(
        const double* sums, const double* squares, int64_t begin, int64_t end,
        int64_t lines, int64_t stride, double scale, double floor,
    )
    int64_t lowest_bit(int64_t mask)
