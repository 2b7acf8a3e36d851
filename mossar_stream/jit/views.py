"""How compiled code looks at a row of bytes as numbers and records."""

from typing import Any

import numpy as np
from numba import types
from numba.extending import overload, register_jitable
from numpy.typing import NDArray

from mossar_stream.jit.acceleration import is_accelerated


@register_jitable
def part_twin(memory: NDArray[Any], begin: int, kind: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    """Return what `part` returns, in plain Python."""
    count = 1
    for length in shape:
        count *= length
    numbers = memory.reshape(memory.size).view(np.uint8)
    found: NDArray[Any] = numbers[begin : begin + count * _item_size(kind)].view(kind).reshape(shape)
    return found


def _item_size(kind):  # without types, which numba would compare with those of the function below
    return np.dtype(kind).itemsize


@overload(_item_size)
def _item_size_of_type(kind):
    size = kind.dtype.size if isinstance(kind.dtype, types.Record) else kind.dtype.bitwidth // 8
    return lambda kind: size  # noqa: ARG005 - numba compares the parameters


def _part() -> Any:
    if not is_accelerated():
        return part_twin
    from mossar_stream.jit.instructions import part as accelerated  # noqa: PLC0415 - private parts

    return accelerated


part = _part()
