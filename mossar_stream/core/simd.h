/* Sums and products over many joints at once, in an order that no compiler and no machine changes.

   A floating-point sum depends on its order. A C compiler carries out a loop that adds up number by number, which is
   slow; with permission to reorder, it adds up in the order that suits the machine, and the result differs from
   machine to machine. Here the order is written down, so that it is fast and the same everywhere:

   - A page's line of 32 numbers is added in halves: the second half is added to the first, number by number, until one
     number is left.
   - Longer lines are added in 8 sums side by side: sum d takes the numbers d, d + 8, d + 16 ... in this order. At the
     end these 8 sums are added in halves, too. Products of variances are multiplied the same way.
   - `weighted_sums` and `spread_product` add lines one after the other, in the order of the lines.

   Sums side by side do not depend on each other. A machine may therefore compute 1, 2, 4 or 8 of them in one
   instruction, and every number comes out the same in every bit. Two conditions remain: the compiler must not contract
   a product and a sum into one rounding (-ffp-contract=off), and must not reorder (no -ffast-math).

   Vectors are those of gcc and clang, as wide as the machine's: gcc 12 makes wider ones five times slower. Other
   compilers take vectors of one number, which are plain numbers; the code below is the same for them.

   Spans are a pointer and positions or lengths in numbers, never in bytes. Nothing is checked. */

#ifndef MOSSAR_STREAM_SIMD_H
#define MOSSAR_STREAM_SIMD_H

#include <stdint.h>
#include <string.h>

#if defined(__FAST_MATH__)
#error "-ffast-math reorders sums"
#elif defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif

#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(_MSC_VER)
#include <intrin.h>
#endif

enum {
    WIDTH = 32,         /* numbers of a page's line */
    FACTORS = 8,        /* sums or products side by side */
    MATRIX_ROWS = 4,    /* of a matrix that are worked on at once, */
    MATRIX_COLUMNS = 3, /* with at most so many lines of another one, */
    VECTORS = 3,        /* or with so many vectors: twelve sums side by side fill the registers */
};

#if defined(__GNUC__) || defined(__clang__)

#if defined(__AVX2__)
#define VECTOR_BYTES 32
#else
#define VECTOR_BYTES 16
#endif
typedef float floats __attribute__((vector_size(VECTOR_BYTES)));
typedef double doubles __attribute__((vector_size(VECTOR_BYTES)));
typedef int32_t float_flags __attribute__((vector_size(VECTOR_BYTES))); /* -1 where a comparison holds, else 0 */
typedef int64_t double_flags __attribute__((vector_size(VECTOR_BYTES)));

/* Replace numbers below 0 by 0. NaN stays. */
static inline doubles without_negative(doubles numbers) {
    return (doubles)((double_flags)numbers & ~(double_flags)(numbers < 0.0));
}

/* Replace numbers that are not above 0, and NaN, by 0. */
static inline doubles only_positive(doubles numbers) {
    return (doubles)((double_flags)numbers & (double_flags)(numbers > 0.0));
}

static inline int all_hold(float_flags flags) {
    int64_t words[VECTOR_BYTES / 8], all = -1;
    memcpy(words, &flags, sizeof words);
    for (int k = 0; k < VECTOR_BYTES / 8; k++) all &= words[k];
    return all == -1;
}

/* Load as many floats as `doubles` has numbers, and convert them. The intrinsics are there because gcc 12 converts
   number by number if left to itself. */
#if defined(__AVX2__)
typedef __m128 halves;
static inline halves load_halves(const float *from) { return _mm_loadu_ps(from); }
static inline doubles to_doubles(halves numbers) { return (doubles)_mm256_cvtps_pd(numbers); }
#elif defined(__SSE2__)
typedef __m128 halves;
static inline halves load_halves(const float *from) { return _mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)from)); }
static inline doubles to_doubles(halves numbers) { return (doubles)_mm_cvtps_pd(numbers); }
#else
typedef float halves __attribute__((vector_size(VECTOR_BYTES / 2)));
static inline halves load_halves(const float *from) {
    halves numbers;
    memcpy(&numbers, from, sizeof numbers);
    return numbers;
}
static inline doubles to_doubles(halves numbers) { return __builtin_convertvector(numbers, doubles); }
#endif

#else

typedef float floats, halves;
typedef double doubles;
typedef int float_flags;

static inline halves load_halves(const float *from) { return *from; }
static inline doubles to_doubles(halves numbers) { return numbers; }
static inline doubles without_negative(doubles numbers) { return numbers < 0.0 ? 0.0 : numbers; }
static inline doubles only_positive(doubles numbers) { return numbers > 0.0 ? numbers : 0.0; }
static inline int all_hold(float_flags flags) { return flags; }

#endif

enum { FLOATS = sizeof(floats) / sizeof(float), DOUBLES = sizeof(doubles) / sizeof(double) };

static inline floats load_floats(const float *from) {
    floats numbers;
    memcpy(&numbers, from, sizeof numbers);
    return numbers;
}

static inline doubles load_doubles(const double *from) {
    doubles numbers;
    memcpy(&numbers, from, sizeof numbers);
    return numbers;
}

/* Add `FACTORS` numbers in halves. */
static inline float folded(const float *numbers) {
    const float a = numbers[0] + numbers[4], b = numbers[1] + numbers[5];
    const float c = numbers[2] + numbers[6], d = numbers[3] + numbers[7];
    return (a + c) + (b + d);
}

/* Add the 32 numbers of a line in halves; `line` is overwritten. */
static inline double page_folded(doubles *line) {
    double last[FACTORS / 2];
    for (int k = 0; k < 16 / DOUBLES; k++) line[k] += line[k + 16 / DOUBLES];
    for (int k = 0; k < 8 / DOUBLES; k++) line[k] += line[k + 8 / DOUBLES];
    for (int k = 0; k < 4 / DOUBLES; k++) line[k] += line[k + 4 / DOUBLES];
    memcpy(last, line, sizeof last);
    return (last[0] + last[2]) + (last[1] + last[3]);
}

/* Sum a line of a page in double precision. */
static inline double page_sum(const float *page, int64_t line) {
    doubles numbers[WIDTH / DOUBLES];
    for (int k = 0; k < WIDTH / DOUBLES; k++) numbers[k] = to_doubles(load_halves(page + line + DOUBLES * k));
    return page_folded(numbers);
}

/* Sum the products of two lines of a page: each is rounded to single precision, their sum to double precision. */
static inline double page_product(const float *page, int64_t one, int64_t other) {
    doubles numbers[WIDTH / DOUBLES];
    for (int k = 0; k < WIDTH / DOUBLES; k++)
        numbers[k] = to_doubles(load_halves(page + one + DOUBLES * k) * load_halves(page + other + DOUBLES * k));
    return page_folded(numbers);
}

/* Tell whether a line of a page has no number above `limit`, and none that is NaN. */
static inline int page_within(const float *page, int64_t line, float limit) {
    float_flags within = load_floats(page + line) <= limit;
    for (int j = FLOATS; j < WIDTH; j += FLOATS) within &= load_floats(page + line + j) <= limit;
    return all_hold(within);
}

/* Sum the products of two lines of `count` numbers, a multiple of `FACTORS`, in single precision. */
static inline float line_product(const float *one, const float *other, int64_t count) {
    floats sums[FACTORS / FLOATS] = {0};
    float last[FACTORS];
    for (int64_t at = 0; at < count; at += FACTORS)
        for (int k = 0; k < FACTORS / FLOATS; k++)
            sums[k] += load_floats(one + at + FLOATS * k) * load_floats(other + at + FLOATS * k);
    memcpy(last, sums, sizeof last);
    return folded(last);
}

/* Set goal[k, j] to the sum of the products of lines[k] and others[j], in single precision.

   goal            (MATRIX_ROWS, goal_columns), set for j < rows.
   lines           (MATRIX_ROWS, columns); `columns` is a multiple of `FACTORS`.
   others          (rows, columns); `rows` is a multiple of `MATRIX_COLUMNS`.
   count           Up to where lines are not 0. */
static inline void line_products(
    float *restrict goal, int64_t goal_columns, const float *restrict lines, const float *restrict others,
    int64_t rows, int64_t columns, int64_t count
) {
    /* What registers hold: SSE2 has half as many numbers in each. */
    enum { PARTS = FACTORS / FLOATS, COLUMNS = PARTS == 1 ? MATRIX_COLUMNS : 1 };
    for (int64_t first = 0; first < rows; first += COLUMNS) {
        floats sums[MATRIX_ROWS][COLUMNS][PARTS];
        float last[MATRIX_ROWS][COLUMNS][FACTORS];
        for (int k = 0; k < MATRIX_ROWS; k++)
            for (int j = 0; j < COLUMNS; j++)
                for (int p = 0; p < PARTS; p++) sums[k][j][p] = (floats){0};
        for (int64_t at = 0; at < count; at += FACTORS)
            for (int p = 0; p < PARTS; p++) {
                floats each[COLUMNS];
                for (int j = 0; j < COLUMNS; j++)
                    each[j] = load_floats(others + (first + j) * columns + at + p * FLOATS);
                for (int k = 0; k < MATRIX_ROWS; k++) {
                    const floats line = load_floats(lines + k * columns + at + p * FLOATS);
                    for (int j = 0; j < COLUMNS; j++) sums[k][j][p] += line * each[j];
                }
            }
        memcpy(last, sums, sizeof last);
        for (int k = 0; k < MATRIX_ROWS; k++)
            for (int j = 0; j < COLUMNS; j++) goal[k * goal_columns + first + j] = folded(last[k][j]);
    }
}

/* Set goal[k, i] to the sum of weights[k, j] * lines[j, i] over j, in this order, in single precision.

   goal            (MATRIX_ROWS, columns), set for i < count, rounded up to a multiple of `VECTORS` * `FACTORS`.
   weights         (MATRIX_ROWS, weights_columns).
   lines           (rows, columns); `columns` is a multiple of `VECTORS` * `FACTORS`.
   count           Up to where sums are wanted. */
static inline void weighted_sums(
    float *restrict goal, const float *restrict weights, int64_t weights_columns, const float *restrict lines,
    int64_t rows, int64_t columns, int64_t count
) {
    const int64_t step = VECTORS * FACTORS, end = (count + step - 1) / step * step;
    for (int64_t first = 0; first < end; first += VECTORS * FLOATS) {
        floats sums[MATRIX_ROWS][VECTORS];
        for (int k = 0; k < MATRIX_ROWS; k++)
            for (int q = 0; q < VECTORS; q++) sums[k][q] = (floats){0};
        for (int64_t j = 0; j < rows; j++) {
            floats each[VECTORS];
            for (int q = 0; q < VECTORS; q++) each[q] = load_floats(lines + j * columns + first + q * FLOATS);
            for (int k = 0; k < MATRIX_ROWS; k++) {
                const float weight = weights[k * weights_columns + j];
                for (int q = 0; q < VECTORS; q++) sums[k][q] += weight * each[q];
            }
        }
        for (int k = 0; k < MATRIX_ROWS; k++) memcpy(goal + k * columns + first, sums[k], sizeof sums[k]);
    }
}

/* Multiply variances: max(squares[d] * scale - (sums[d] * scale)^2, 0) + floor for d = begin ... end - 1.

   begin, end      So many blocks of `FACTORS`, with no product of every eighth beyond a double.
   scale           What turns a sum into a mean.
   floor           > 0.
   exponent        Set.

   Return the mantissa, a product of `FACTORS` numbers in 1..2. The product is mantissa * 2^exponent. */
static inline double variance_product(
    const double *sums, const double *squares, int64_t begin, int64_t end, double scale, double floor, int64_t *exponent
) {
    doubles products[FACTORS / DOUBLES];
    double last[FACTORS];
    int64_t bits[FACTORS], exponents = 0;
    for (int d = 0; d < FACTORS; d++) last[d] = 1.0;
    memcpy(products, last, sizeof last);
    for (int64_t at = begin; at < end; at += FACTORS)
        for (int k = 0; k < FACTORS / DOUBLES; k++) {
            const doubles mean = load_doubles(sums + at + DOUBLES * k) * scale;
            const doubles variance = load_doubles(squares + at + DOUBLES * k) * scale - mean * mean;
            products[k] *= only_positive(variance) + floor;
        }
    memcpy(bits, products, sizeof bits);
    for (int d = 0; d < FACTORS; d++) {
        exponents += (bits[d] >> 52) - 1023;
        bits[d] = (bits[d] & ((INT64_C(1) << 52) - 1)) | INT64_C(1023) << 52;
    }
    *exponent = exponents;
    memcpy(last, bits, sizeof last);
    return ((last[0] * last[4]) * (last[2] * last[6])) * ((last[1] * last[5]) * (last[3] * last[7]));
}

/* Multiply how far joints are spread: the product over joints of

       sum over lines i of max(squares_i * scale - (sums_i * scale)^2, 0) / lines + floor.

   sums, squares   `lines` lines, `stride` numbers apart, with a number of each joint.
   begin, end      First joint and the last one plus 1: so many blocks of `FACTORS`, with no product beyond a double.
   scale           What turns a sum into a mean.
   floor           > 0.

   Return the product: first in each of `FACTORS` places, then of these, one after the other. */
static inline double spread_product(
    const double *sums, const double *squares, int64_t begin, int64_t end, int64_t lines, int64_t stride, double scale,
    double floor
) {
    doubles products[FACTORS / DOUBLES];
    double last[FACTORS], found = 1.0;
    for (int d = 0; d < FACTORS; d++) last[d] = 1.0;
    memcpy(products, last, sizeof last);
    for (int64_t joint = begin; joint < end; joint += FACTORS) {
        doubles totals[FACTORS / DOUBLES] = {0};
        for (int64_t i = 0; i < lines; i++)
            for (int k = 0; k < FACTORS / DOUBLES; k++) {
                const int64_t at = joint + i * stride + DOUBLES * k;
                const doubles mean = load_doubles(sums + at) * scale;
                totals[k] += without_negative(load_doubles(squares + at) * scale - mean * mean);
            }
        for (int k = 0; k < FACTORS / DOUBLES; k++) products[k] *= totals[k] / (double)lines + floor;
    }
    memcpy(last, products, sizeof last);
    for (int d = 0; d < FACTORS; d++) found *= last[d];
    return found;
}

/* Set target[j] to values[j] * scale, rounded to the nearest integer (even at ties), at most 32767 off 0.

   Adding 1.5 * 2^23 to a number that is small against it leaves no binary digit for fractions, so that the sum is
   rounded to an integer as `rint` does it, which gcc and clang call once a number where there is only SSE2.
   NaN becomes -32767. */
static inline void quantise(const float *restrict values, int16_t *restrict target, int64_t count, float scale) {
    const float most = 32767.0f, rounding = 12582912.0f;
    for (int64_t j = 0; j < count; j++) {
        float value = values[j] * scale;
        value = value > -most ? value : -most;
        value = value < most ? value : most;
        target[j] = (int16_t)(int32_t)((value + rounding) - rounding);
    }
}

/* Return the position of the lowest bit of a mask other than 0. */
static inline int64_t lowest_bit(int64_t mask) {
#if defined(__GNUC__) || defined(__clang__)
    return __builtin_ctzll((unsigned long long)mask);
#else
    unsigned long position;
    _BitScanForward64(&position, (unsigned __int64)mask);
    return position;
#endif
}

#endif
