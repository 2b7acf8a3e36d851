"""Travel: where in the room the hips are.

World landmarks have the hips at the origin. Where these are relative to the camera follows from the picture: a body
that takes up fewer pixels for each of its metres is farther away (weak perspective), and the place of the hips in the
picture gives the direction.

No camera states its field of view. `FIELD` is that of usual webcams; with another one the distance is wrong by a constant
factor, sideways and upward travel is not, for it depends on pixels for each metre alone.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.pose.landmarks import Landmarks
from mossar_adapters.pose.smoothing import OneEuro
from mossar_adapters.pose.types import HIPS

FIELD: Final = math.radians(60.0)  # across the longer side of the picture
# The scale depends on the estimated length of the body in each picture; an error of 1 % is 3 cm at 3 m. It therefore follows
# slowly: no person comes nearer or goes away by more than a few percent in a tenth of a second.
_SCALE: Final = (0.3, 1.0)  # Hz, Hz for each e-fold/s, of a One-Euro filter
_NEAREST: Final = 1.0  # pixels for each metre; less is damage


class Travel:
    """Follows one person through the room."""

    def __init__(self) -> None:
        self._scale = OneEuro(*_SCALE)

    def hips(self, found: Landmarks, time: float, size: tuple[int, int]) -> NDArray[np.float64]:
        """Return the middle of the hips, (3,) metres: x right, y down, z away from the camera.

        Args:
            found: Of the person.
            time: s.
            size: Height and width of the picture, pixels.
        """
        raw = math.log(max(_NEAREST, pixels_a_metre(found)))
        scale = math.exp(float(self._scale(np.array(raw), time)))
        height, width = size
        middle = found.pixels[HIPS, :].mean(0) - (width / 2, height / 2)
        focal = max(size) / 2 / math.tan(FIELD / 2)
        return np.append(middle / scale, focal / scale)


def pixels_a_metre(found: Landmarks) -> float:
    """Return the pixels that a metre of the body takes up: least squares over its joints, weighted by visibility."""
    weight = found.visible[:, None]
    total = max(float(weight.sum()), 1e-9)
    pixels, world = found.pixels[: len(weight)], found.world[:, :2]
    pixels = pixels - (weight * pixels).sum(0) / total
    world = world - (weight * world).sum(0) / total
    squares = float((weight * world * world).sum())
    return float((weight * pixels * world).sum()) / squares if squares > 0.0 else 0.0
