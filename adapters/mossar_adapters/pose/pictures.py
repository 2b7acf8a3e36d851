"""Pictures of a video file, each with its own time."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, cast

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.extras import needed
from mossar_adapters.pose.types import PoseError

# The library writes its errors to standard error, which we report in one line; -8 is its level "quiet".
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
os.environ.setdefault("OPENCV_LOG_LEVEL", "OFF")

USUAL_RATE: Final = 30.0  # Hz, of files that state none
_RATES: Final = (0.1, 1000.0)  # Hz; other rates in a file are damage
Picture = NDArray[np.uint8]


class Video(msgspec.Struct, frozen=True):
    """The metadata of a video file.

    Args:
        count: Pictures that it should have; 0 if it states none.
        fps: Mean rate, Hz.
    """

    count: int
    fps: float


def load_opencv() -> Any:
    """Return the module of OpenCV.

    Raises:
        MossarError: If it is not installed; names the extra.
    """
    needed("cv2", "webcam", "reading pictures")
    import cv2

    return cv2


def describe(path: Path) -> Video:
    """Return the metadata of a video file.

    Raises:
        PoseError: If it cannot be opened as a video.
    """
    cv2 = load_opencv()
    capture = _opened(path)
    try:
        count, fps = capture.get(cv2.CAP_PROP_FRAME_COUNT), capture.get(cv2.CAP_PROP_FPS)
    finally:
        capture.release()
    return Video(int(count) if 0 < count < 1e9 else 0, fps if _RATES[0] <= fps <= _RATES[1] else USUAL_RATE)


def pictures(path: Path) -> Iterator[tuple[Picture, float]]:
    """Yield the pictures of a video, (h, w, 3) BGR, turned as the video states, with their times, s.

    Times increase; where a file gives none, or one that does not, the mean rate goes on.

    Raises:
        PoseError: If it cannot be opened as a video.
    """
    cv2 = load_opencv()
    step = 1.0 / describe(path).fps
    capture = _opened(path)
    last = -step
    try:
        while True:
            is_there, picture = capture.read()
            if not is_there:
                return
            time = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
            last = time if time > last else last + step
            yield cast("Picture", picture), last
    finally:
        capture.release()


def _opened(path: Path) -> Any:
    cv2 = load_opencv()
    try:
        capture = cv2.VideoCapture(str(path))
    except cv2.error as error:
        raise PoseError(f"{path}: cannot be opened as a video ({error.err})") from None
    if not capture.isOpened():
        raise PoseError(
            f"{path}: cannot be opened as a video: it is damaged, cut off, or coded in an unknown way"
        )
    return capture
