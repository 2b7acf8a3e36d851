"""The square of a picture in which one person is: as large as the body, turned so that it stands upright."""

import math
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

# The maker's `RectTransformationCalculator` in pose_detection_to_roi and pose_landmarks_to_roi: 1.25 times the square
# around the circle whose centre is the middle of the hips and on which the second point lies.
_MARGIN: Final = 1.25
# Of the size, which is about 2.5 m: two people side by side are farther apart, one person found twice is not.
_APART: Final = 0.12


class Region(msgspec.Struct, frozen=True):
    """A turned square.

    Args:
        x: Of the middle, pixels.
        y: Of the middle, pixels, downwards.
        size: Length of a side, pixels.
        angle: By which the body is turned clockwise from upright, rad.
    """

    x: float
    y: float
    size: float
    angle: float

    @classmethod
    def around(cls, centre: NDArray[np.floating], end: NDArray[np.floating]) -> "Region":
        """Return the region of a body whose middle is `centre`, and of which `end` is the far end, above it if upright.

        Args:
            centre: (2,) pixels.
            end: (2,) pixels.
        """
        x, y = float(centre[0]), float(centre[1])
        dx, dy = float(end[0]) - x, float(end[1]) - y
        return cls(x, y, 2 * math.hypot(dx, dy) * _MARGIN, math.pi / 2 - math.atan2(-dy, dx))

    def to_picture(self, side: int) -> NDArray[np.float32]:
        """Return the (2, 3) matrix from pixels of a crop with this side to pixels of the picture."""
        c = math.cos(self.angle) * self.size / side
        s = math.sin(self.angle) * self.size / side
        half = side / 2
        return np.array(
            [[c, -s, self.x - half * c + half * s], [s, c, self.y - half * s - half * c]], np.float32
        )

    def is_of_same_person(self, other: "Region") -> bool:
        """Return whether two regions hold the same person: hips and the far end of the body are at the same places."""
        largest = max(self.size, other.size)
        return all(
            math.dist(a, b) < _APART * largest for a, b in zip(self.points(), other.points(), strict=True)
        )

    def points(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the middle of the body and its far end, pixels."""
        reach = self.size / (2 * _MARGIN)
        end = self.x + reach * math.sin(self.angle), self.y - reach * math.cos(self.angle)
        return (self.x, self.y), end
