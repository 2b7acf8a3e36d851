"""Sums and products over many joints against what plain Python computes, bit by bit, for odd numbers, too."""

import numpy as np
import pytest

from checks.reference import simd as reference
from mossar_stream.core.kernels import (
    PAGE,
    PAGE_SIZE,
    STEP,
    WORK,
    simd_line_product,
    simd_line_products,
    simd_lowest_bit,
    simd_page_product,
    simd_page_sum,
    simd_page_within,
    simd_quantise,
    simd_spread_product,
    simd_variance_product,
    simd_weighted_sums,
)

ODD = np.float32(
    [0.0, -0.0, 1e-45, -1e-38, 1e-20, 1.0, -1.0, 1 + 2**-23, 3e38, -3e38, np.inf, -np.inf, np.nan]
)
MATRIX_ROWS, STEP_OF_SUMS = 4, 24  # lines at once; what `count` is rounded up to in `weighted_sums`


def page_with(line, values):
    page = np.full(PAGE_SIZE, np.float32(7.0))
    page[line : line + PAGE] = values
    return page


def odd_lines(count):
    rng = np.random.default_rng(count)
    for share in (0.0, 0.03, 0.5):
        for _ in range(20):
            values = rng.normal(0, 10.0 ** rng.integers(-6, 6), PAGE).astype(np.float32)
            odd = rng.random(PAGE) < share
            values[odd] = rng.choice(ODD, odd.sum())
            yield values


def same(found, expected):
    np.testing.assert_array_equal(np.float64(found), np.float64(expected), strict=True)


@np.errstate(all="ignore")
def test_sums_and_products_are_those_of_the_reference():
    for one, other in zip(odd_lines(1), odd_lines(2), strict=True):
        page = page_with(STEP, one)
        page[WORK : WORK + PAGE] = other
        same(simd_page_sum(page, STEP), reference.page_sum(page, STEP))
        same(simd_page_product(page, STEP, WORK), reference.page_product(page, STEP, WORK))


def test_products_are_rounded_once_and_summed_in_halves():
    page = page_with(STEP, np.linspace(0.1, 3.0, PAGE, dtype=np.float32))
    page[WORK : WORK + PAGE] = np.float32(1.1)
    values = (page[STEP : STEP + PAGE] * page[WORK : WORK + PAGE]).astype(np.float64)
    while len(values) > 1:
        values = values[: len(values) // 2] + values[len(values) // 2 :]
    same(simd_page_product(page, STEP, WORK), values[0])


def test_a_line_is_within_a_limit_that_it_reaches_and_never_with_nan():
    for values in odd_lines(3):
        page = page_with(WORK, values)
        for limit in (0.0, 1.0, 3e38, np.inf, -np.inf, np.nan, *np.float64(values[:3])):
            expected = (values <= np.float32(limit)).all()
            assert simd_page_within(page, WORK, limit) == reference.page_within(page, WORK, limit) == expected
    for place_of_nan in range(PAGE):
        page = page_with(WORK, np.zeros(PAGE))
        assert simd_page_within(page, WORK, 0.0)
        page[WORK + place_of_nan] = np.nan
        assert not simd_page_within(page, WORK, np.inf)


@np.errstate(all="ignore")
@pytest.mark.parametrize("odd", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("blocks", [0, 1, 2, 24])
def test_variances_are_multiplied_as_the_reference_does_and_never_below_the_floor(blocks, odd):
    rng = np.random.default_rng(blocks)
    size = 8 * blocks
    for floor in (1e-12, 1e-3, 1e3):
        sums, squares = rng.normal(0, 1, size + 16), rng.uniform(0, 1e3, size + 16)
        for values in (sums, squares):
            chosen = rng.random(len(values)) < odd
            values[chosen] = rng.choice(ODD.astype(np.float64), chosen.sum())
        found = simd_variance_product(sums, squares, 8, 8 + size, 0.25, floor)
        expected = reference.variance_product(sums, squares, 8, 8 + size, 0.25, floor)
        same(found[0], expected[0])
        assert found[1] == expected[1]
        if odd == 0.0:
            inner = slice(8, 8 + size)
            factors = np.maximum(squares[inner] * 0.25 - (sums[inner] * 0.25) ** 2, 0.0) + floor
            assert np.log(found[0]) + found[1] * np.log(2) == pytest.approx(np.log(factors).sum())


@np.errstate(all="ignore")
@pytest.mark.parametrize("odd", [0.0, 0.1])
@pytest.mark.parametrize("lines", [1, 3])
@pytest.mark.parametrize("joints", [8, 16, 24, 32])
def test_spreads_are_multiplied_as_the_reference_does(joints, lines, odd):
    rng = np.random.default_rng(joints)
    for begin in range(0, joints, 8):
        sums, squares = rng.normal(0, 1, lines * joints), rng.uniform(0, 1e2, lines * joints)
        for values in (sums, squares):
            chosen = rng.random(len(values)) < odd
            values[chosen] = rng.choice(ODD.astype(np.float64), chosen.sum())
        given = sums, squares, begin, joints, lines, joints, 0.25, 1e-3
        found = simd_spread_product(*given)
        same(found, reference.spread_product(*given))
        if odd == 0.0:
            spread = np.maximum(squares * 0.25 - (sums * 0.25) ** 2, 0.0).reshape(lines, joints).mean(axis=0)
            assert found == pytest.approx(np.prod(spread[begin:] + 1e-3), rel=1e-12)


def test_the_lowest_bit_is_found_wherever_it_is():
    for bit in range(64):
        for above in (0, -1, 0x5A5A5A5A5A5A5A5A):
            mask = int(np.array(1 << bit | (above << bit & (2**64 - 1)), np.uint64).astype(np.int64))
            assert simd_lowest_bit(mask) == reference.lowest_bit(mask) == bit


@pytest.mark.parametrize("length", [8, 16, 64, 192])
def test_products_of_lines_are_those_of_the_reference(length):
    rng = np.random.default_rng(length)
    one, other = rng.normal(0, 1, (2, length)).astype(np.float32)
    assert simd_line_product(one, other) == reference.line_product(one, other)
    assert simd_line_product(one, other) == pytest.approx(
        float(one.astype(float) @ other.astype(float)), abs=1e-4
    )


@pytest.mark.parametrize("count", [1, 8, 9, 24, 25, 100, 120])
@pytest.mark.parametrize("rows", [3, 60, 93])
def test_products_of_matrices_are_those_of_the_reference(rows, count):
    rng = np.random.default_rng(rows * count)
    lines, others = (rng.normal(0, 1, (n, 120)).astype(np.float32) for n in (MATRIX_ROWS, rows))
    lines[:, count:] = others[:, count:] = 0.0
    found, expected = np.full((2, MATRIX_ROWS, rows), np.float32(7.0))
    simd_line_products(found, lines, others, count)
    reference.line_products(expected, lines, others, count)
    assert found.tobytes() == expected.tobytes()
    assert found == pytest.approx(lines.astype(float) @ others.astype(float).T, abs=1e-4)
    weights = found
    found, expected = np.full((2, MATRIX_ROWS, 120), np.float32(7.0))
    simd_weighted_sums(found, weights, others, count)
    reference.weighted_sums(expected, weights, others, count)
    assert found.tobytes() == expected.tobytes()
    assert found[:, :count] == pytest.approx(weights.astype(float) @ others[:, :count], abs=1e-2)
    beyond = found[:, -(-count // STEP_OF_SUMS) * STEP_OF_SUMS :]
    assert (beyond == 7.0).all()  # left alone


@pytest.mark.parametrize("count", [1, 3, 8, 31, 32])
def test_numbers_are_quantised_to_the_nearest_even_and_never_beyond_the_range(count):
    ties = np.arange(-8 * PAGE, 8 * PAGE, dtype=np.float32) / np.float32(2 * 8192)
    rng = np.random.default_rng(count)
    wide = [rng.normal(0, 10.0**power, 8 * PAGE).astype(np.float32) for power in range(-5, 8)]
    odd = np.float32([4.0, -4.0, 3.9999, 1e-45, -0.0, 3e38, -3e38, np.inf, -np.inf] + [0.0] * (PAGE - 9))
    numbers = np.concatenate([ties, *wide, odd])
    for first in range(0, len(numbers) - count + 1, count):
        values = numbers[first : first + count]
        found = np.full(PAGE + 1, 7, np.int16)
        simd_quantise(values, found[:count], 8192.0)
        with np.errstate(over="ignore"):
            expected = np.clip(np.rint(values * np.float32(8192.0)), -32767, 32767).astype(np.int16)
        np.testing.assert_array_equal(found[:count], expected)
        assert (found[count:] == 7).all()
