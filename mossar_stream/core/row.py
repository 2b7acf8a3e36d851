"""Row: views of the memory of a body or a limb; row.pxi describes its layout."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import RECORDS, row_parts

ROW = RECORDS["Row"]


def records(row: NDArray[np.uint8]) -> Any:
    """Return a row's records as one numpy record that writes through to the row."""
    return row[: ROW.itemsize].view(ROW)[0]


def region(row: NDArray[np.uint8], name: str) -> NDArray[Any]:
    """Return one of a row's arrays, flat, as a view."""
    offset, kind, shape = row_parts(row)[name]
    return np.ndarray(shape, RECORDS.get(kind, kind), row, offset)
