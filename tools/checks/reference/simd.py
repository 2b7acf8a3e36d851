"""What `mossar_stream.jit.simd` computes, in plain Python, number by number and in the same order.

Tests compare the two bit by bit.
"""

import numpy as np
from numba.extending import register_jitable

from mossar_stream.jit.simd import (
    BITS_OF_ONE,
    EXPONENT_BIAS,
    FACTORS,
    FRACTION,
    FRACTION_BITS,
    MATRIX_ROWS,
    VECTORS,
    WIDTH,
)


@register_jitable
def page_sum(page, line):
    """Sum a line of a page in double precision, in halves; see `_sum`."""
    numbers = np.empty(WIDTH)
    for j in range(WIDTH):
        numbers[j] = page[line + j]
    return _sum(numbers)


@register_jitable
def page_product(page, one, other):
    """Sum the products of two lines of a page; each is rounded to float32, their sum to float64."""
    numbers = np.empty(WIDTH)
    for j in range(WIDTH):
        numbers[j] = page[one + j] * page[other + j]
    return _sum(numbers)


@register_jitable
def line_product(one, other):
    """Sum the products of two lines, in `FACTORS` sums side by side; see `jit.simd.line_product`."""
    sums = np.zeros(FACTORS, np.float32)
    for place in range(0, one.size, FACTORS):
        for d in range(FACTORS):
            sums[d] += one[place + d] * other[place + d]
    return _sum(sums)


@register_jitable
def line_products(goal, lines, others, count):
    """Set sums of products of lines, in `FACTORS` sums side by side; see `jit.simd.line_products`."""
    until = -(-count // FACTORS) * FACTORS
    for k in range(MATRIX_ROWS):
        for j in range(len(others)):
            goal[k, j] = line_product(lines[k, :until], others[j, :until])


@register_jitable
def weighted_sums(goal, weights, lines, count):
    """Set weighted sums of lines, in their order; see `jit.simd.weighted_sums`."""
    step = VECTORS * FACTORS
    for k in range(MATRIX_ROWS):
        for i in range(-(-count // step) * step):
            total = np.float32(0.0)
            for j in range(len(lines)):
                total += weights[k, j] * lines[j, i]
            goal[k, i] = total


@register_jitable
def page_within(page, line, limit):
    """Tell whether a line of a page has no number above `limit`, and none that is NaN."""
    most = np.float32(limit)
    for j in range(WIDTH):  # noqa: SIM110 - `all` does not compile
        if not page[line + j] <= most:
            return False
    return True


@register_jitable
def variance_product(sums, squares, begin, end, scale, floor):
    """Multiply variances, in `FACTORS` products side by side; see `jit.simd.variance_product`."""
    product = np.ones(FACTORS)
    for place in range(begin, end, FACTORS):
        for d in range(FACTORS):
            mean = sums[place + d] * scale
            variance = squares[place + d] * scale - mean * mean
            product[d] *= (max(0.0, variance)) + floor
    bits = product.view(np.int64)
    exponent = 0
    for d in range(FACTORS):
        exponent += (bits[d] >> FRACTION_BITS) - EXPONENT_BIAS
        bits[d] = (bits[d] & FRACTION) | BITS_OF_ONE
    size = FACTORS
    while size > 1:
        size //= 2
        for d in range(size):
            product[d] *= product[d + size]
    return product[0], exponent


@register_jitable
def spread_product(sums, squares, begin, end, lines, stride, scale, floor):
    """Multiply how far joints are spread, in `FACTORS` products side by side; see `jit.simd.spread_product`."""
    product = np.ones(FACTORS)
    for joint in range(begin, end, FACTORS):
        for d in range(FACTORS):
            total = 0.0
            for line in range(lines):
                place = joint + d + line * stride
                mean = sums[place] * scale
                total += max(squares[place] * scale - mean * mean, 0.0)
            product[d] *= total / lines + floor
    found = 1.0
    for d in range(FACTORS):
        found *= product[d]
    return found


@register_jitable
def lowest_bit(mask):
    """Return the position of the lowest set bit of an int64 other than 0."""
    position = 0
    while mask & 1 == 0:
        mask >>= 1
        position += 1
    return position


@register_jitable
def _sum(numbers):
    """Add the second half to the first until one number is left; `numbers` is overwritten."""
    size = len(numbers)
    while size > 1:
        size //= 2
        for j in range(size):
            numbers[j] += numbers[j + size]
    return numbers[0]
