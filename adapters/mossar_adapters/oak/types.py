"""Requests to an OAK camera, its answers and its errors."""

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import MossarError


class CameraError(MossarError):
    """The camera cannot be used; the message has the reason and the remedy."""


class CameraLost(CameraError):  # noqa: N818 - it names the event
    """A camera that worked no longer answers."""


class OakOptions(msgspec.Struct, frozen=True):
    """The options of the camera.

    Args:
        model: Name at the maker's hub or path of an archive; empty for the platform's usual one.
        device: Id, address or USB port of one camera; empty for the first one found.
        fps: Pictures per second; None for the rate of the platform's usual model.
        unit: Unit of the coordinates; `auto` uses that of the messages.
    """

    model: str = ""
    device: str = ""
    fps: float | None = None
    unit: str = "auto"


class Picture(msgspec.Struct, frozen=True):
    """The results of one picture.

    Args:
        number: Sequence number of the picture.
        time: When it was taken, s on the host's monotonic clock.
        people: One (K, 4) array for each person: x to the right, y down, z away from the camera in metres, and
            the confidence; below 0 where the network gives none.
    """

    number: int
    time: float
    people: tuple[NDArray[np.float64], ...]
