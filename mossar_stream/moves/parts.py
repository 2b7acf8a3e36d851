"""Parts: arrays in a block of bytes, at the places that the compiled core states."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import RECORDS

Place = tuple[int, str, tuple[int, ...]]  # offset in bytes, name of the record or number type, shape


def parts_of(block: NDArray[np.uint8], places: Mapping[str, Place]) -> dict[str, NDArray[Any]]:
    """Return views of the parts of a block by name.

    Args:
        block: A store, or the memory of a performer.
        places: From the core.
    """
    return {
        name: np.ndarray(shape, RECORDS.get(kind, kind), block, offset)
        for name, (offset, kind, shape) in places.items()
    }
