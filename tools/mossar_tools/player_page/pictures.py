"""Pictures: those of a camera of this computer, each with the people in it, for a window of this computer."""

import struct
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from mossar_adapters.pose.types import SKELETON
from mossar_tools.player_page.outline import outline_of

if TYPE_CHECKING:
    from mossar_adapters.pose.source import Seen

WIDTH: Final = 1280  # px; wider pictures are made smaller
CAMERA: Final = outline_of(SKELETON).drawn()
_QUALITY: Final = 80  # of JPEG, percent
_VISIBLE: Final = 0.5
_LENGTH: Final = struct.Struct("<I")  # bytes of the text before the picture


def jpeg_of(seen: "Seen") -> bytes:
    """Return a picture as JPEG."""
    import cv2

    picture: Any = seen.picture
    if picture.shape[1] > WIDTH:
        scale = WIDTH / picture.shape[1]
        picture = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return bytes(cv2.imencode(".jpg", picture, (cv2.IMWRITE_JPEG_QUALITY, _QUALITY))[1])


def people_in(seen: "Seen") -> list[list[list[float] | None]]:
    """Return the points of each person in a picture, as shares of its width and height; None for hidden ones."""
    outline = outline_of(SKELETON)
    height, width = seen.picture.shape[:2]
    people = []
    for body in seen.bodies:
        pixels = np.where(body.confidence[:, None] >= _VISIBLE, body.pixels, np.nan)
        shares = outline.points(pixels) / (width, height)
        people.append(
            [[round(x, 4), round(y, 4)] if np.isfinite(x + y) else None for x, y in shares.tolist()]
        )
    return people


def with_text(picture: bytes, text: bytes) -> bytes:
    """Return one message of a picture and the text that belongs to it."""
    return _LENGTH.pack(len(text)) + text + picture
