"""One frame of one performer, as decoders find it and before it is batched."""

from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import FrameError, Skeleton

_LATEST = 1e19  # s, or units of a clock that counts nanoseconds since 1970


class Pose(msgspec.Struct):
    """Positions of the joints of one performer at one moment.

    Args:
        performer: Name.
        positions: (J, 3), metres, NaN where missing.
        arrival: Time of arrival, s.
        time: The sender's time, s, or None.
        confidence: (J,) or None.
        skeleton: Of these positions; None for the one announced before.
        unit: Assumed unit of the original.
        sender: Distinguishes the senders of a source, each with a clock of its own.
    """

    performer: str
    positions: NDArray[np.float64] | NDArray[np.float32]
    arrival: float
    time: float | None = None
    confidence: NDArray[np.float64] | NDArray[np.float32] | None = None
    skeleton: Skeleton | None = None
    unit: str = "m"
    sender: str = ""


def check_time(time: float | None) -> None:
    """Check the time that a sender gives.

    Raises:
        FrameError: If it is none.
    """
    if time is not None and not abs(time) < _LATEST:
        raise FrameError(f"t = {time} is no time")


def differ(one: NDArray[Any], other: NDArray[Any]) -> bool:
    """Return whether two poses, (J, 3), differ in a joint that both have."""
    if one.shape != other.shape:
        return True
    both = ~(np.isnan(one) | np.isnan(other))
    return bool((one != other)[both].any())
