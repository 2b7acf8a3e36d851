"""Sums and products over many joints at once, as LLVM's vectors say them, in an order that no machine changes.

A loop that adds up is carried out number by number, unless the compiler may reorder sums, and then the result
depends on the machine. Here the order is written down: halves are combined with halves until one number is left.
`tools/checks/reference/simd.py` computes the same in plain Python; tests compare the two bit by bit.
"""

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

from llvmlite import ir
from numba import extending, types
from numba.core import cgutils

WIDTH = 32  # numbers of a line that are added up at once
FACTORS = 8  # numbers that are multiplied at once
MATRIX_ROWS = 4  # of a matrix that are worked on at once,
MATRIX_COLUMNS = 3  # with so many of another one,
VECTORS = 3  # or with so many times `FACTORS` numbers: twelve sums side by side, each number read once
FRACTION_BITS, EXPONENT_BIAS = 52, 1023  # of a float64
FRACTION, BITS_OF_ONE = (1 << FRACTION_BITS) - 1, EXPONENT_BIAS << FRACTION_BITS

_float, _double, _int, _index = ir.FloatType(), ir.DoubleType(), ir.IntType(64), ir.IntType(32)

intrinsic: Any = extending.intrinsic  # whose types hide the parameters from mypy


def padded(count: int) -> int:
    """Return how many numbers a line of `count` takes with the zeros with which its length is a multiple of `FACTORS`."""
    return -(-count // FACTORS) * FACTORS


@intrinsic
def page_sum(_context, page, line):
    """Sum a line of a page of the body in double precision."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return _sum(builder, _load(context, builder, signature, values, 0, values[1], WIDTH))

    return types.float64(page, line), generate


@intrinsic
def page_product(_context, page, one, other):
    """Sum the products of two lines of a page in double precision."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        lines = [_load(context, builder, signature, values, 0, line, WIDTH) for line in values[1:]]
        return _sum(builder, builder.fmul(*lines))

    return types.float64(page, one, other), generate


@intrinsic
def line_product(_context, one, other):
    """Sum the products of two lines of float32 of one length, a multiple of `FACTORS`, in single precision."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        total = cgutils.alloca_once_value(builder, _all(ir.Constant(_float, 0.0), FACTORS))
        size = context.make_array(signature.args[0])(context, builder, values[0]).nitems
        with cgutils.for_range_slice(builder, _int(0), size, _int(FACTORS), _int) as (place, _):
            a, b = (_load(context, builder, signature, values, which, place, FACTORS) for which in (0, 1))
            builder.store(builder.fadd(builder.load(total), builder.fmul(a, b)), total)
        return _fold(builder, builder.load(total), builder.fadd)

    return types.float32(one, other), generate


@intrinsic
def line_products(_context, goal, lines, others, count):
    """Set goal[k, j] to the sum of the products of two lines of float32, one of `MATRIX_ROWS` and another one, in single precision.

    Args:
        _context: Given by the compiler.
        goal: (MATRIX_ROWS, D) float32, set.
        lines: (MATRIX_ROWS, n) float32; n is a multiple of `FACTORS`.
        others: (D, n) float32; D is a multiple of `MATRIX_COLUMNS`.
        count: Up to where lines are not 0.
    """

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        goal, lines, others = (_matrix(context, builder, signature, values, which) for which in range(3))
        none = _all(ir.Constant(_float, 0.0), FACTORS)
        sums = [
            [cgutils.alloca_once_value(builder, none) for _ in range(MATRIX_COLUMNS)]
            for _ in range(MATRIX_ROWS)
        ]
        with cgutils.for_range_slice(builder, _int(0), others.rows, _int(MATRIX_COLUMNS), _int) as (first, _):
            for total in itertools.chain(*sums):
                builder.store(none, total)
            with cgutils.for_range_slice(builder, _int(0), values[3], _int(FACTORS), _int) as (at, _):
                each = [others.load(builder.add(first, _int(j)), at) for j in range(MATRIX_COLUMNS)]
                for k in range(MATRIX_ROWS):
                    line = lines.load(_int(k), at)
                    for total, other in zip(sums[k], each, strict=True):
                        builder.store(builder.fadd(builder.load(total), builder.fmul(line, other)), total)
            for k, j in itertools.product(range(MATRIX_ROWS), range(MATRIX_COLUMNS)):
                found = _fold(builder, builder.load(sums[k][j]), builder.fadd)
                builder.store(found, goal.at(_int(k), builder.add(first, _int(j))))
        return context.get_dummy_value()

    return types.void(goal, lines, others, count), generate


@intrinsic
def weighted_sums(_context, goal, weights, lines, count):
    """Set goal[k, i] to the sum of lines of float32, each with the weight weights[k, j], in their order.

    Args:
        _context: Given by the compiler.
        goal: (MATRIX_ROWS, n) float32, set; n is a multiple of `VECTORS` times `FACTORS`.
        weights: (MATRIX_ROWS, D) float32.
        lines: (D, n) float32.
        count: Up to where sums are wanted, rounded up to `VECTORS` times `FACTORS`.
    """

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        goal, weights, lines = (_matrix(context, builder, signature, values, which) for which in range(3))
        none = _all(ir.Constant(_float, 0.0), FACTORS)
        sums = [
            [cgutils.alloca_once_value(builder, none) for _ in range(VECTORS)] for _ in range(MATRIX_ROWS)
        ]
        step = _int(VECTORS * FACTORS)
        with cgutils.for_range_slice(builder, _int(0), values[3], step, _int) as (first, _):
            places = [builder.add(first, _int(q * FACTORS)) for q in range(VECTORS)]
            for total in itertools.chain(*sums):
                builder.store(none, total)
            with cgutils.for_range(builder, lines.rows) as loop:
                each = [lines.load(loop.index, at) for at in places]
                for k in range(MATRIX_ROWS):
                    weight = _spread(builder, builder.load(weights.at(_int(k), loop.index)), FACTORS)
                    for total, line in zip(sums[k], each, strict=True):
                        builder.store(builder.fadd(builder.load(total), builder.fmul(weight, line)), total)
            for k, q in itertools.product(range(MATRIX_ROWS), range(VECTORS)):
                goal.store(builder.load(sums[k][q]), _int(k), places[q])
        return context.get_dummy_value()

    return types.void(goal, weights, lines, count), generate


@intrinsic
def page_within(_context, page, line, limit):
    """Tell whether a line of a page has no number above `limit`, and none that is NaN."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        numbers = _load(context, builder, signature, values, 0, values[1], WIDTH)
        most = context.cast(builder, values[2], signature.args[2], types.float32)
        beyond = builder.fcmp_unordered(">", numbers, _spread(builder, most, WIDTH))
        return builder.icmp_signed("==", builder.bitcast(beyond, ir.IntType(WIDTH)), ir.IntType(WIDTH)(0))

    return types.boolean(page, line, limit), generate


@intrinsic
def variance_product(_context, sums, squares, begin, end, scale, floor):
    """Multiply variances: Π max(q_d · scale - (s_d · scale)², 0) + floor for d = begin … end - 1.

    Args:
        _context: Given by the compiler.
        sums: (any,) float64, s.
        squares: (any,) float64, q.
        begin: First of them.
        end: The last one plus 1; so many blocks of `FACTORS`, with no product of every eighth beyond a float64.
        scale: What turns a sum into a mean.
        floor: > 0.

    Returns:
        Mantissa, product of `FACTORS` numbers in 1..2, and exponent: the product is mantissa · 2^exponent.
    """
    found = types.Tuple((types.float64, types.int64))

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        begin, end, scale, floor = values[2:]
        scales, floors = _spread(builder, scale, FACTORS), _spread(builder, floor, FACTORS)
        product = cgutils.alloca_once_value(builder, _all(ir.Constant(_double, 1.0), FACTORS))
        with cgutils.for_range_slice(builder, begin, end, _int(FACTORS), _int) as (place, _):
            s, q = (_load(context, builder, signature, values, which, place, FACTORS) for which in (0, 1))
            mean = builder.fmul(s, scales)
            variance = builder.fsub(builder.fmul(q, scales), builder.fmul(mean, mean))
            none = _all(ir.Constant(_double, 0.0), FACTORS)
            variance = builder.select(builder.fcmp_ordered(">", variance, none), variance, none)
            factor = builder.fadd(variance, floors)
            builder.store(builder.fmul(builder.load(product), factor), product)
        bits = builder.bitcast(builder.load(product), ir.VectorType(_int, FACTORS))
        fractions = builder.or_(
            builder.and_(bits, _all(_int(FRACTION), FACTORS)), _all(_int(BITS_OF_ONE), FACTORS)
        )
        mantissas = builder.bitcast(fractions, ir.VectorType(_double, FACTORS))
        exponents = builder.sub(
            builder.ashr(bits, _all(_int(FRACTION_BITS), FACTORS)), _all(_int(EXPONENT_BIAS), FACTORS)
        )
        both = _fold(builder, mantissas, builder.fmul), _fold(builder, exponents, builder.add)
        return context.make_tuple(builder, found, both)

    return found(sums, squares, begin, end, scale, floor), generate


@intrinsic
def spread_product(_context, sums, squares, begin, end, lines, stride, scale, floor):
    """Multiply how far joints are spread: Π Σ_i max(q_i · scale - (s_i · scale)², 0) / lines + floor over joints.

    Args:
        _context: Given by the compiler.
        sums: (any,) float64: lines of `stride` numbers, s_i of all joints in each.
        squares: (any,) float64, lines of q_i.
        begin: First joint.
        end: The last one plus 1; so many blocks of `FACTORS`, with no product beyond a float64.
        lines: How many.
        stride: Between them.
        scale: What turns a sum into a mean.
        floor: > 0.

    Returns:
        The product: first in each of `FACTORS` places, then of these, one after the other.
    """

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        begin, end, lines, stride, scale, floor = values[2:]
        scales, floors = _spread(builder, scale, FACTORS), _spread(builder, floor, FACTORS)
        none = _all(ir.Constant(_double, 0.0), FACTORS)
        counts = _spread(builder, builder.sitofp(lines, _double), FACTORS)
        product = cgutils.alloca_once_value(builder, _all(ir.Constant(_double, 1.0), FACTORS))
        total = cgutils.alloca_once_value(builder, none)
        with cgutils.for_range_slice(builder, begin, end, _int(FACTORS), _int) as (joint, _):
            builder.store(none, total)
            with cgutils.for_range(builder, lines) as line:
                place = builder.add(joint, builder.mul(line.index, stride))
                s, q = (_load(context, builder, signature, values, which, place, FACTORS) for which in (0, 1))
                mean = builder.fmul(s, scales)
                variance = builder.fsub(builder.fmul(q, scales), builder.fmul(mean, mean))
                variance = builder.select(builder.fcmp_ordered("<", variance, none), none, variance)
                builder.store(builder.fadd(builder.load(total), variance), total)
            factor = builder.fadd(builder.fdiv(builder.load(total), counts), floors)
            builder.store(builder.fmul(builder.load(product), factor), product)
        found, every = ir.Constant(_double, 1.0), builder.load(product)
        for place in range(FACTORS):
            found = builder.fmul(found, builder.extract_element(every, _index(place)))
        return found

    return types.float64(sums, squares, begin, end, lines, stride, scale, floor), generate


@intrinsic
def lowest_bit(_context, _mask):
    """Return the position of the lowest set bit of an int64 other than 0: one instruction numba lacks."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 1))

    return types.int64(types.int64), generate


class _Matrix(NamedTuple):
    """A (rows, columns) array of float32 among the arguments, with lines one after the other."""

    builder: Any
    data: Any
    rows: Any
    columns: Any

    def at(self, row: Any, column: Any) -> Any:
        """Return where a number is."""
        return self.builder.gep(
            self.data, [self.builder.add(self.builder.mul(row, self.columns), column)], inbounds=True
        )

    def load(self, row: Any, column: Any) -> Any:
        """Return `FACTORS` numbers of a line."""
        return self.builder.load(self._vector(row, column), align=4)

    def store(self, numbers: Any, row: Any, column: Any) -> None:
        """Set `FACTORS` numbers of a line."""
        self.builder.store(numbers, self._vector(row, column), align=4)

    def _vector(self, row: Any, column: Any) -> Any:
        return self.builder.bitcast(self.at(row, column), ir.VectorType(_float, FACTORS).as_pointer())


def _matrix(context: Any, builder: Any, signature: Any, values: Any, which: int) -> _Matrix:
    """Return a matrix among the arguments."""
    array = context.make_array(signature.args[which])(context, builder, values[which])
    return _Matrix(builder, array.data, *cgutils.unpack_tuple(builder, array.shape, 2))


def _load(context: Any, builder: Any, signature: Any, values: Any, which: int, begin: Any, count: int) -> Any:
    """Return `count` numbers of an array among the arguments as one vector."""
    array = context.make_array(signature.args[which])(context, builder, values[which])
    kind = ir.VectorType(context.get_data_type(signature.args[which].dtype), count)
    return builder.load(
        builder.bitcast(builder.gep(array.data, [begin]), kind.as_pointer()),
        align=4 if kind.element == _float else 8,
    )


def _sum(builder: Any, numbers: Any) -> Any:
    return _fold(builder, builder.fpext(numbers, ir.VectorType(_double, WIDTH)), builder.fadd)


def _fold(builder: Any, numbers: Any, combine: Callable[[Any, Any], Any]) -> Any:
    """Combine the first half of a vector with the second until one number is left."""
    size = numbers.type.count
    while size > 1:
        size //= 2
        halves = (
            builder.shuffle_vector(numbers, numbers, ir.Constant(ir.VectorType(_index, size), list(part)))
            for part in (range(size), range(size, 2 * size))
        )
        numbers = combine(*halves)
    return builder.extract_element(numbers, _index(0))


def _spread(builder: Any, value: Any, count: int) -> Any:
    """Return a vector of one number."""
    one = builder.insert_element(
        ir.Constant(ir.VectorType(value.type, count), ir.Undefined), value, _index(0)
    )
    return builder.shuffle_vector(one, one, _all(_index(0), count))


def _all(constant: Any, count: int) -> Any:
    return ir.Constant(ir.VectorType(constant.type, count), [constant] * count)
