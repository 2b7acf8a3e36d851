"""Landmarks: the joints of the person in a region, in the picture and in metres.

The maker's pose_landmark: 39 points in the crop (x, y, z in pixels, visibility and presence as logits), of which the
last six are not joints; points 33 and 34 are the middle and the end of the next region. The points are refined by the
heat maps. The world landmarks are metres from the middle of the hips, in a body that stands upright in its region.
"""

import math
from pathlib import Path
from typing import Final

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.pose.crop import crop
from mossar_adapters.pose.network import Network
from mossar_adapters.pose.region import Region
from mossar_adapters.pose.types import JOINTS

_POINTS: Final = 39
_CENTRE, _END = 33, 34  # of the next region: pose_landmarks_to_roi.pbtxt
_PRESENT: Final = 0.5  # `min_tracking_confidence`: below it the region has no person
# Ours, for the first picture of a person: 0.96 and more in clips of people, up to 0.73 where the detector saw one in a test card.
_FOUND: Final = 0.85
# `RefineLandmarksFromHeatmapCalculator` of tensors_to_pose_landmarks_and_segmentation.pbtxt.
_KERNEL: Final = 9  # cells of the 64 x 64 that are averaged; with 9 the points are the maker's within 0.1 pixels, not with 7
_LEAST: Final = 0.5  # `min_confidence_to_refine`


class Landmarks(msgspec.Struct, frozen=True):
    """The output of the network for one person.

    Args:
        pixels: (39, 2) float64, pixels of the picture.
        world: (33, 3) float64, metres from the middle of the hips: x right, y down, z away from the camera.
        visible: (33,) float64, 0 to 1.
    """

    pixels: NDArray[np.float64]
    world: NDArray[np.float64]
    visible: NDArray[np.float64]

    def next_region(self) -> Region:
        """Return the region of the person, if slow, in the next picture."""
        return Region.around(self.pixels[_CENTRE], self.pixels[_END])


class Landmarker:
    """Finds the joints of the person in a region.

    Args:
        path: `pose_landmark_lite.tflite`, `full` or `heavy`.
    """

    def __init__(self, path: Path) -> None:
        self._network = Network(path)

    def read(self, picture: NDArray[np.uint8], region: Region, *, is_new: bool = False) -> Landmarks | None:
        """Return the landmarks, None if there is no person.

        Args:
            picture: (h, w, 3), BGR.
            region: Region to search.
            is_new: Whether only the detector reports a person there.
        """
        side = self._network.side
        matrix = region.to_picture(side)
        # Beyond the picture its edge is repeated, as in the maker's code; black moves legs that are out of sight.
        part = crop(picture, matrix, side, border=cv2.BORDER_REPLICATE)
        self._network.run(part / np.float32(255.0))
        if not self._network.output(1)[0] > (_FOUND if is_new else _PRESENT):
            return None
        found = self._network.output(5 * _POINTS).reshape(_POINTS, 5).astype(np.float64)
        points = _refined(found[:, :2] / side, self._network.output(64, 64, _POINTS)) * side
        world = self._network.output(3 * _POINTS).reshape(_POINTS, 3)[:JOINTS].astype(np.float64)
        if not (np.isfinite(points).all() and np.isfinite(world).all()):
            return None
        return Landmarks(
            points @ matrix[:, :2].T + matrix[:, 2], _turned(world, region.angle), _sigmoid(found[:JOINTS, 3])
        )


def _sigmoid(x: NDArray[np.float64]) -> NDArray[np.float64]:
    return 1.0 / (1.0 + np.exp(-np.clip(x, -100.0, 100.0)))


def _turned(world: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """Return world landmarks as in the picture: `WorldLandmarkProjectionCalculator`."""
    c, s = math.cos(angle), math.sin(angle)
    return np.column_stack(
        (c * world[:, 0] - s * world[:, 1], s * world[:, 0] + c * world[:, 1], world[:, 2])
    )


def _refined(points: NDArray[np.float64], heat: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return points moved to the middle of the heat around them, where there is enough.

    Args:
        points: (39, 2), shares of the crop.
        heat: (rows, columns, 39), logits.
    """
    rows, columns = heat.shape[:2]
    reach = _KERNEL // 2
    refined = points.copy()
    cells = np.floor(points * (columns, rows)).astype(np.int64)
    for k, (column, row) in enumerate(cells.tolist()):
        if not (0 <= column < columns and 0 <= row < rows):
            continue
        top, left = max(0, row - reach), max(0, column - reach)
        part = _sigmoid(heat[top : row + reach + 1, left : column + reach + 1, k].astype(np.float64))
        total = part.sum()
        if part.max() >= _LEAST and total > 0:
            across = (part.sum(0) @ np.arange(left, left + part.shape[1])) / total / columns
            down = (part.sum(1) @ np.arange(top, top + part.shape[0])) / total / rows
            refined[k] = across, down
    return refined
