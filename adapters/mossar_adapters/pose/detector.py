"""Detector: the places of people in a picture.

The maker's pose_detection: a single-shot detector over anchors on three grids. Each anchor gives a score, a box around
the face and four points. The first point is the middle of the hips, the second lies on a circle around the whole body.
Boxes that overlap are one person; their points are averaged by score.
"""

import math
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.pose.crop import crop
from mossar_adapters.pose.network import Network
from mossar_adapters.pose.region import Region

# Of pose_detection_cpu.pbtxt: `SsdAnchorsCalculator` with strides 8, 16, 32, 32, 32, two anchors for each layer.
_GRIDS: Final = ((28, 2), (14, 2), (7, 6))  # cells a side, anchors a cell
_VALUES: Final = 12  # of an anchor: box, then four points
_SCORE: Final = 0.5  # `min_score_thresh`
_OVERLAP: Final = 0.3  # `min_suppression_threshold` of the weighted `NonMaxSuppressionCalculator`
_CLIPPED: Final = 100.0  # `score_clipping_thresh`


class Detector:
    """Finds people.

    Args:
        path: `pose_detection.tflite`.
    """

    def __init__(self, path: Path) -> None:
        self._network = Network(path)
        self._anchors = _anchors()

    def find(self, picture: NDArray[np.uint8], most: int = 1) -> list[Region]:
        """Return the regions of people, the likeliest first.

        Args:
            picture: (h, w, 3), BGR.
            most: How many to return at most.
        """
        side = self._network.side
        height, width = picture.shape[:2]
        scale = side / max(height, width)
        left, top = (side - width * scale) / 2, (side - height * scale) / 2
        matrix = np.array([[1 / scale, 0, -left / scale], [0, 1 / scale, -top / scale]])
        part = crop(picture, matrix, side, border=cv2.BORDER_CONSTANT)
        self._network.run(part / np.float32(127.5) - np.float32(1.0))
        found = _people(
            self._network.output(len(self._anchors), _VALUES).astype(np.float64) / side,
            self._network.output(len(self._anchors), 1)[:, 0].astype(np.float64),
            self._anchors,
            most,
        )
        corner = np.array([left, top])
        return [
            Region.around((hips * side - corner) / scale, (end * side - corner) / scale)
            for hips, end in found
        ]


def _anchors() -> NDArray[np.float64]:
    """Return the middles of the anchors, (2254, 2), as shares of the picture."""
    return np.array(
        [
            ((x + 0.5) / cells, (y + 0.5) / cells)
            for cells, each in _GRIDS
            for y in range(cells)
            for x in range(cells)
            for _ in range(each)
        ]
    )


def _people(
    values: NDArray[np.float64], raw: NDArray[np.float64], anchors: NDArray[np.float64], most: int
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Return hips and end of each person, as shares of the picture: non-maximum suppression, weighted by score."""
    scores = 1.0 / (1.0 + np.exp(-np.clip(raw, -_CLIPPED, _CLIPPED)))
    kept = np.flatnonzero(scores >= _SCORE)
    left = kept[np.argsort(-scores[kept], kind="stable")]
    middles, sizes = values[:, :2] + anchors, values[:, 2:4]
    people: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
    while len(left) and len(people) < most:
        same = np.array([_shared(middles, sizes, left[0], other) > _OVERLAP for other in left])
        same[0] = True
        alike, left = left[same], left[~same]
        weights = scores[alike] / scores[alike].sum()
        points = (values[alike, 4:8].reshape(-1, 2, 2) + anchors[alike, None, :]) * weights[:, None, None]
        hips, end = points.sum(0)
        people.append((hips, end))
    return people


def _shared(middles: NDArray[np.float64], sizes: NDArray[np.float64], a: int, b: int) -> float:
    """Return the intersection of two boxes over their union."""
    sides = [
        min(middles[a, k] + sizes[a, k] / 2, middles[b, k] + sizes[b, k] / 2)
        - max(middles[a, k] - sizes[a, k] / 2, middles[b, k] - sizes[b, k] / 2)
        for k in (0, 1)
    ]
    if min(sides) <= 0:
        return 0.0
    both = math.prod(sides)
    return float(both / (sizes[a].prod() + sizes[b].prod() - both))
