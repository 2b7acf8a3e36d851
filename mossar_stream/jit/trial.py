"""The trial of the accelerated path: small kernels that use each of numba's private parts that it stands on.

It is imported by a process that finds no accelerated kernels on disk, which is about to compile for many seconds.
"""

from typing import Any

import numba
import numpy as np
from numba.core.caching import _Cache

from mossar_stream.jit import instructions, simd_twin
from mossar_stream.jit.linked_calls import callable_by_name, make_known
from mossar_stream.jit.options import entry_options, inner_options
from mossar_stream.jit.sturdy_cache import SturdyCache

_own: Any = instructions  # as kernels call it
_INNER = inner_options(accelerated=True)
_INLINE = inner_options(accelerated=True, inline=True)
_ENTRY = entry_options(accelerated=True, makes_arrays=True)
_FRAME = entry_options(accelerated=True, makes_arrays=False)
_RECORD = np.dtype([("step", "f8"), ("count", "i8")])
_NAME, _KIND = "mossar.trial", numba.float64(numba.float64[::1])


@numba.njit(**_ENTRY)
def _mean(values):
    """Make an array, and fail if there is nothing to average."""
    if len(values) == 0:
        raise ValueError("nothing")
    return (values + np.zeros(len(values))).mean()


_mean_by_name = callable_by_name(_NAME, _mean, _KIND)


@numba.njit(**_INNER)
def _count(record, by):
    record.count += by
    return record.step


@numba.njit(**_INLINE)
def _stepped(record, by):
    return _count(record, by) * by


@numba.njit(**_FRAME)
def _try_all(memory, page, values):
    record: Any = _own.part(memory, 8, _RECORD, (1,))[0]
    found = _stepped(record, 3)
    found += _own.page_sum(page, 32) + _own.page_product(page, 0, 32)
    mantissa, exponent = _own.variance_product(values, values, 0, 8, 0.5, 1.0)
    return (
        found + _mean_by_name(values),
        _own.page_within(page, 32, 1.0),
        mantissa * 2.0**exponent,
        _own.lowest_bit(record.count << 4),
    )


def succeeds() -> bool:
    """Tell whether the trial kernels compute what they should, and fail as they should."""
    _mean.compile(_KIND.args)
    make_known(_NAME, _mean, _KIND.args)
    memory, page = np.zeros(40, np.uint8), np.arange(64, dtype=np.float32) / np.float32(7.0)
    record = memory[8:24].view(_RECORD)[0]
    record["step"] = 0.25
    values = np.arange(8.0)
    found = _try_all(memory, page, values)
    return bool(
        found == _expected(page, values)
        and record["count"] == 3
        and isinstance(_mean._cache, _Cache)  # noqa: SLF001 - what `cached` replaces
        and issubclass(SturdyCache, _Cache)
        and _fails(memory, page)
    )


def _expected(page: Any, values: Any) -> tuple[float, bool, float, int]:
    mantissa, exponent = simd_twin.variance_product(values, values, 0, 8, 0.5, 1.0)
    total = 0.75 + simd_twin.page_sum(page, 32) + simd_twin.page_product(page, 0, 32)
    return total + values.mean(), simd_twin.page_within(page, 32, 1.0), mantissa * 2.0**exponent, 4


def _fails(memory: Any, page: Any) -> bool:
    """Tell whether the error of a kernel that is called by name reaches Python."""
    try:
        _try_all(memory, page, np.empty(0))
    except ValueError:
        return True
    return False
