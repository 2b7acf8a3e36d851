"""What `mossar_stream.jit.views` does, in plain Python."""

from typing import Any

import numpy as np
from numba import types
from numba.extending import overload, register_jitable
from numpy.typing import NDArray


@register_jitable
def part(memory: NDArray[Any], begin: int, kind: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    """Return what `jit.views.part` returns."""
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
