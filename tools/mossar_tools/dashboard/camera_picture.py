"""Camera picture: the picture of a webcam, mirrored, with the skeleton on it, with `?picture=yes`."""

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.joint_sets import BLAZEPOSE_33

if TYPE_CHECKING:
    from mossar_adapters.pose.source import Seen

WIDTH: Final = 320  # px; the panel is not wider
_VISIBLE: Final = 0.5
_COLOUR: Final = (247, 195, 79)  # BGR


def camera_picture(seen: "Seen") -> NDArray[np.uint8]:
    """Return a picture for the page, (h, `WIDTH`, 3) RGB, mirrored as people expect of one of themselves.

    Args:
        seen: The latest picture and the people in it.
    """
    import cv2

    scale = WIDTH / seen.picture.shape[1]
    small: Any = cv2.resize(seen.picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    for body in seen.bodies:
        points = np.clip(body.pixels * scale, -WIDTH, 4 * WIDTH).round().astype(int).tolist()
        for joint, parent in enumerate(BLAZEPOSE_33.parents):
            if parent >= 0 and min(body.confidence[joint], body.confidence[parent]) >= _VISIBLE:
                cv2.line(small, points[joint], points[parent], _COLOUR, 2, cv2.LINE_AA)
    return np.ascontiguousarray(small[:, ::-1, ::-1])
