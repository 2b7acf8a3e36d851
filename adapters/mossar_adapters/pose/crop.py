"""Crops: the part of a picture that a network sees.

Pixels are interpolated in steps of 1/32, as in the maker's pipeline, which older versions of OpenCV did everywhere.
Exact interpolation, as by `warpAffine` since OpenCV 5, moves landmarks by 4 mm in a single picture. In the next ones it
moves them by more, because the region follows from them.
"""

import cv2
import numpy as np
from numpy.typing import NDArray


def crop(
    picture: NDArray[np.uint8], matrix: NDArray[np.floating], side: int, *, border: int
) -> NDArray[np.float32]:
    """Return a square part of a picture as RGB, (side, side, 3), 0 to 255.

    Args:
        picture: (h, w, 3), BGR.
        matrix: (2, 3), from pixels of the crop to pixels of the picture.
        side: Of the crop, pixels.
        border: The border of the picture, `cv2.BORDER_REPLICATE` or `cv2.BORDER_CONSTANT` (black).
    """
    at = np.arange(side)
    across, down = (np.add.outer(row[1] * at, row[0] * at + row[2]).astype(np.float32) for row in matrix)
    whole, parts = cv2.convertMaps(across, down, cv2.CV_16SC2)
    part = cv2.remap(picture, whole, parts, cv2.INTER_LINEAR, borderMode=border)
    return cv2.cvtColor(part, cv2.COLOR_BGR2RGB).astype(np.float32)
