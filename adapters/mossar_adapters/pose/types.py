"""Results of a picture, and errors of the estimation."""

from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.joint_sets import BLAZEPOSE_33
from mossar_stream import MossarError

JOINTS: Final = len(BLAZEPOSE_33)
# Of videos, their archives, cameras and the page alike, so that all give the same key frames. The hips are the origin of
# the estimate, so the one that the others hang on is always there; the centroid comes and goes with hidden joints.
SKELETON: Final = BLAZEPOSE_33.with_root("left_hip")
HIPS: Final = (BLAZEPOSE_33.index("left_hip"), BLAZEPOSE_33.index("right_hip"))
MAX_PEOPLE: Final = 4


class PoseError(MossarError):
    """Pictures cannot be had or estimated; the message has the reason and the remedy."""


class Body(msgspec.Struct, frozen=True):
    """One person in one picture.

    Args:
        number: From 1; stays while the person is followed.
        positions: (33, 3) float32, metres: x to the right of the picture, y up, z towards the camera; the camera is
            the origin.
        confidence: (33,) float32, probability that each joint is visible, 0 to 1.
        pixels: (33, 2) float32, where the joints are in the picture.
    """

    number: int
    positions: NDArray[np.float32]
    confidence: NDArray[np.float32]
    pixels: NDArray[np.float32]


class CameraLost(PoseError):  # noqa: N818 - it names the event
    """A camera that worked gives no more pictures."""


class CameraOptions(msgspec.Struct, frozen=True):
    """A camera and its options.

    Args:
        device: Number, or path of a device; a file or a pipe with video stands in for one.
        name: Part of the camera's name; empty takes `device`.
        size: Width and height, pixels; None for the camera's own.
        fps: Pictures per second; None for the camera's own.
    """

    device: str = "0"
    name: str = ""
    size: tuple[int, int] | None = None
    fps: float | None = None
