"""A webcam: found by number, path or name, read on a thread that keeps the newest picture only.

An estimate may take longer than the camera needs for a picture. A queue would then grow old: the body would be
segmented a second after it moved. A picture that was not taken in time therefore makes room for the next, and is counted.
"""

import errno
import os
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, cast

import msgspec

from mossar_adapters.extras import installed
from mossar_adapters.pose.pictures import Picture, load_opencv
from mossar_adapters.pose.types import CameraLost, CameraOptions, PoseError

_SYSTEM: Final = Path("/sys/class/video4linux")  # where Linux names its cameras
_FAILURES: Final = 10  # consecutive grabs that may fail before a camera counts as lost
_BETWEEN: Final = 0.02  # s between them
_FAREWELL: Final = 2.0  # s that `close` waits for a grab to return
_MOST: Final = 10  # numbers that are tried where the system lists no cameras


class Found(msgspec.Struct, frozen=True):
    """A camera that the system lists.

    Args:
        number: By which OpenCV opens it.
        name: As the system calls it; empty if it does not.
    """

    number: int
    name: str = ""


class Taken(msgspec.Struct, frozen=True):
    """A picture of a camera.

    Args:
        number: From 0, counted by the thread that grabs.
        picture: (h, w, 3), BGR.
        time: s on the monotonic clock when it was grabbed.
    """

    number: int
    picture: Picture
    time: float


class Camera:
    """A camera that runs, opened and read by a thread of its own: opening may take long, that of a pipe for ever.

    Args:
        options: Which one.
        clock: Monotonic, s.

    Attributes:
        fps: Nominal rate, Hz; None if the camera states none, or is not open yet.

    Raises:
        PoseError: If it is not there or forbidden; the message has the reason and the remedy.
    """

    def __init__(self, options: CameraOptions, clock: Callable[[], float] = time.monotonic) -> None:
        self.device = numbered(options)
        check_camera(options)
        self.fps: float | None = None
        self._options, self._clock = options, clock
        self._newest: Taken | None = None
        self._problem: PoseError | None = None  # why no more pictures come
        self._is_closing = threading.Event()
        self._changed = threading.Condition()
        # A daemon: a grab from a pipe without a writer never returns.
        self._thread = threading.Thread(target=self._run, name="webcam", daemon=True)
        self._thread.start()

    def newest(self, timeout: float) -> Taken | None:
        """Return the newest picture that was not returned before, None after `timeout` seconds without one.

        Raises:
            PoseError: If it cannot be opened.
            CameraLost: If no more pictures come.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._newest is not None or self._problem is not None, timeout)
            taken, self._newest = self._newest, None
            if taken is None and self._problem is not None:
                raise self._problem
            return taken

    def close(self) -> None:
        """Release the camera. May be called twice."""
        self._is_closing.set()
        self._thread.join(_FAREWELL)

    def _run(self) -> None:
        problem: PoseError = CameraLost("it gives no more pictures")
        try:
            capture = _opened(self.device, self._options)
            try:
                fps = float(capture.get(load_opencv().CAP_PROP_FPS))
                self.fps = fps if 1.0 <= fps <= 1000.0 else self._options.fps
                self._grab(capture)
            finally:
                capture.release()
        except PoseError as error:
            problem = error
        finally:
            with self._changed:
                self._problem = problem
                self._changed.notify_all()

    def _grab(self, capture: Any) -> None:
        """Keep the newest picture until the camera fails or is closed."""
        number = failures = 0
        while not self._is_closing.is_set() and failures < _FAILURES:
            if not capture.grab():
                failures += 1
                self._is_closing.wait(_BETWEEN)
                continue
            moment = self._clock()
            is_there, picture = capture.retrieve()
            if not is_there or picture is None or picture.ndim != 3:
                failures += 1
                continue
            failures = 0
            with self._changed:
                self._newest = Taken(number, cast("Picture", picture), moment)
                self._changed.notify_all()
            number += 1


def cameras() -> list[Found]:
    """Return the cameras that the system lists: with names on Linux, elsewhere with `cv2-enumerate-cameras`."""
    if installed("cv2_enumerate_cameras"):
        from cv2_enumerate_cameras import enumerate_cameras

        listed = {int(info.index) % 100: str(info.name) for info in enumerate_cameras()}
        return [Found(number, name) for number, name in sorted(listed.items())]
    if sys.platform == "linux":
        numbers = sorted(int(path.name.removeprefix("video")) for path in Path("/dev").glob("video[0-9]*"))
        return [Found(number, _system_name(number)) for number in numbers]
    return [Found(number) for number in range(_MOST) if _is_there(number)]


def _system_name(number: int) -> str:
    try:
        return (_SYSTEM / f"video{number}" / "name").read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""


def _is_there(number: int) -> bool:
    capture = load_opencv().VideoCapture(number)
    try:
        return bool(capture.isOpened())
    finally:
        capture.release()


def numbered(options: CameraOptions) -> str:
    """Return the number or path of the camera that is wanted.

    Raises:
        PoseError: If there is no camera of that name.
    """
    if not options.name:
        return options.device
    seen = cameras()
    for found in seen:
        if options.name.lower() in found.name.lower():
            return str(found.number)
    names = ", ".join(found.name or str(found.number) for found in seen) or "none"
    raise PoseError(f"no camera is called {options.name[:40]!r}; there are: {names}")


def check_camera(options: CameraOptions) -> None:
    """Check, without opening it, that a camera is there and this user may use it, as far as the system shows.

    Raises:
        PoseError: If not; the message has the reason and the remedy.
    """
    obstacle = _obstacle(numbered(options))
    if obstacle:
        raise PoseError(obstacle)


def _opened(device: str, options: CameraOptions) -> Any:
    """Open a camera and have it give the size and rate that are wanted, if it can."""
    cv2 = load_opencv()
    try:
        capture = cv2.VideoCapture(int(device) if device.isdecimal() else device)
    except cv2.error as error:
        raise PoseError(f"camera {device}: {error.err}") from None
    if not capture.isOpened():
        capture.release()
        raise PoseError(f"camera {device}: {_REFUSED}")
    if options.size is not None:
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, options.size[0])
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, options.size[1])
    if options.fps is not None:
        capture.set(cv2.CAP_PROP_FPS, options.fps)
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # older pictures are of no use
    return capture


_FORBIDDEN: Final = {
    "linux": "run: sudo usermod -aG video $USER, and log in again",
    "darwin": "allow the terminal under System Settings, Privacy & Security, Camera",
    "win32": "allow desktop apps under Settings, Privacy, Camera",
}
_REFUSED: Final = (
    "it cannot be opened: another program uses it, or it gives no pictures; close that program, or name another camera"
    if sys.platform == "linux"
    else "it cannot be opened: it is not connected, another program uses it, or it is forbidden; "
    + _FORBIDDEN.get(sys.platform, "")
)


def _obstacle(device: str) -> str:
    """Return the system's reason why a camera cannot be opened; empty if unknown."""
    if device.isdecimal() and sys.platform != "linux":
        return ""
    path = f"/dev/video{device}" if device.isdecimal() else device
    if Path(path).is_fifo():  # opening it would wait for the other end
        return ""
    try:
        os.close(os.open(path, os.O_RDONLY))
    except OSError as error:
        return refusal(device, error)
    return ""


def refusal(device: str, error: OSError) -> str:
    """Return the reason why a camera cannot be opened, and the remedy.

    Args:
        device: Its number or path.
        error: Of the system.
    """
    if error.errno in {errno.EACCES, errno.EPERM}:
        return f"camera {device}: this user may not use it; {_FORBIDDEN.get(sys.platform, '')}"
    if error.errno in {errno.EBUSY, errno.ETXTBSY}:
        return f"camera {device}: another program uses it; close that program"
    if error.errno in {errno.ENOENT, errno.ENODEV, errno.ENXIO}:
        seen = [found for found in cameras() if str(found.number) != device]
        others = ", ".join(f"{found.number} {found.name}".strip() for found in seen)
        return f"no camera {device} found: plug one in" + (
            f", or take another one; there are {others}" if others else ""
        )
    return f"camera {device}: cannot be opened: {error.strerror or error}"
