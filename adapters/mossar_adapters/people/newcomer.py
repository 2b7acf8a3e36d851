"""Newcomer: an id without a slot."""

from typing import Any

import msgspec
from numpy.typing import NDArray

from mossar_adapters.people.samples import Samples
from mossar_stream import Skeleton


class Newcomer(msgspec.Struct):
    """An id without a slot."""

    id: str
    first: float  # s
    last: float
    due: float  # s, time of the next comparison
    samples: Samples
    seen: NDArray[Any]  # (J, 3) metres, at first
    pose: NDArray[Any]  # now
    skeleton: Skeleton | None
    refused: bool = False
