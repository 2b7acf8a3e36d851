"""The functions of `simd.h` in plain Python, number by number and in the same order, for tests bit by bit."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

WIDTH: Final = 32  # numbers of a line that are added up at once
FACTORS: Final = 8  # numbers that are multiplied at once
MATRIX_ROWS: Final = 4  # of a matrix that are worked on at once
VECTORS: Final = 3  # times `FACTORS` numbers of another one
FRACTION_BITS, EXPONENT_BIAS = 52, 1023  # of a float64
FRACTION, BITS_OF_ONE = (1 << FRACTION_BITS) - 1, EXPONENT_BIAS << FRACTION_BITS


def page_sum(page: NDArray[Any], line: int) -> Any:
    """Sum a line of a page in double precision, in halves; see `_sum`."""
    numbers = np.empty(WIDTH)
    for j in range(WIDTH):
        numbers[j] = page[line + j]
    return _sum(numbers)


def page_product(page: NDArray[Any], one: int, other: int) -> Any:
    """Sum the products of two lines of a page; each is rounded to float32, their sum to float64."""
    numbers = np.empty(WIDTH)
    for j in range(WIDTH):
        numbers[j] = page[one + j] * page[other + j]
    return _sum(numbers)


def line_product(one: NDArray[Any], other: NDArray[Any]) -> Any:
    """Sum the products of two lines, in `FACTORS` sums side by side; see `line_product` of simd.pxi."""
    sums = np.zeros(FACTORS, np.float32)
    for place in range(0, one.size, FACTORS):
        for d in range(FACTORS):
            sums[d] += one[place + d] * other[place + d]
    return _sum(sums)


def line_products(goal: NDArray[Any], lines: NDArray[Any], others: NDArray[Any], count: int) -> None:
    """Set sums of products of lines, in `FACTORS` sums side by side; see `line_products` of simd.pxi."""
    until = -(-count // FACTORS) * FACTORS
    for k in range(MATRIX_ROWS):
        for j in range(len(others)):
            goal[k, j] = line_product(lines[k, :until], others[j, :until])


def weighted_sums(goal: NDArray[Any], weights: NDArray[Any], lines: NDArray[Any], count: int) -> None:
    """Set weighted sums of lines, in their order; see `weighted_sums` of simd.pxi."""
    step = VECTORS * FACTORS
    for k in range(MATRIX_ROWS):
        for i in range(-(-count // step) * step):
            total = np.float32(0.0)
            for j in range(len(lines)):
                total += weights[k, j] * lines[j, i]
            goal[k, i] = total


def page_within(page: NDArray[Any], line: int, limit: float) -> bool:
    """Return whether a line of a page has no number above `limit`, and none that is NaN."""
    most = np.float32(limit)
    return all(page[line + j] <= most for j in range(WIDTH))


def variance_product(
    sums: NDArray[Any], squares: NDArray[Any], begin: int, end: int, scale: float, floor: float
) -> tuple[Any, int]:
    """Multiply variances, in `FACTORS` products side by side; see `variance_product` of simd.pxi."""
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


def spread_product(
    sums: NDArray[Any],
    squares: NDArray[Any],
    begin: int,
    end: int,
    lines: int,
    stride: int,
    scale: float,
    floor: float,
) -> float:
    """Multiply the variances of joints, in `FACTORS` products side by side; see `spread_product` of simd.pxi."""
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


def lowest_bit(mask: int) -> int:
    """Return the position of the lowest set bit of an int64 other than 0."""
    position = 0
    while mask & 1 == 0:
        mask >>= 1
        position += 1
    return position


def _sum(numbers: NDArray[Any]) -> Any:
    """Add the second half to the first until one number is left; `numbers` is overwritten."""
    size = len(numbers)
    while size > 1:
        size //= 2
        for j in range(size):
            numbers[j] += numbers[j + size]
    return numbers[0]
