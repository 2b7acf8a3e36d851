"""The camera behind `oak:`: every call into the depthai SDK stands in this file.

None of our code runs inside the SDK: no callback, no host node. An exception there would abort the process. A lost
camera is noticed by asking (`Camera.get`), in any SDK version, whether or not it announces losses.

On board: colour picture -> pose network -> joints in the picture; stereo pair -> depth, brought into the view of the
colour camera. On the host, in nodes of the SDK: joints are matched with the depth of the same moment, and the depth
around each joint gives its position in space. On the host, because code there is tested without a camera.
"""

import logging
import os
import re
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from datetime import timedelta
from ipaddress import ip_address
from pathlib import Path
from typing import Any, Final

import numpy as np

from mossar_adapters.extras import install_line, needed
from mossar_adapters.files.options import METRES
from mossar_adapters.oak.separate_process import run_separately
from mossar_adapters.oak.types import CameraError, CameraLost, OakOptions, Picture
from mossar_stream import FrameError

NEEDED: Final = "depthai>=3.6,<4"  # measures joints on the host since 3.6
INSTALL: Final = install_line("oak")
UDEV_RULE: Final = (
    """echo 'SUBSYSTEM=="usb", ATTRS{idVendor}=="03e7", MODE="0666"' | sudo tee /etc/udev/rules.d/80-movidius.rules"""
    " && sudo udevadm control --reload-rules && sudo udevadm trigger"
)
# A model called like this is a file, not one of the hub.
ARCHIVES: Final = (".tar.xz", ".tar.gz", ".tar", ".zip")

# Per platform: the pose model of the maker's hub, and the rate that it reaches, Hz.
MODELS: Final = {
    "RVC2": ("luxonis/yolov8-nano-pose-estimation:coco-512x288", 10.0),
    "RVC4": ("luxonis/yolov8-large-pose-estimation:coco-640x352", 24.0),
}
_SDK_UNITS: Final = {"METER": 1.0, "CENTIMETER": 0.01, "MILLIMETER": 0.001, "INCH": 0.0254, "FOOT": 0.3048}

# Pixels around a joint whose median depth is taken. At 3 m a wrist is 8 to 10 pixels wide: a larger circle would
# hold more background than arm, and the median would be the wall.
_RADIUS: Final = 4
_STEREO_SIZE: Final = (640, 400)
_QUEUE_SIZE: Final = 4  # messages; when full the SDK drops the oldest, and the gap is counted
# Of the time between two pictures; the cameras need not be in step, half is the worst.
_SAME_MOMENT: Final = 0.6
_DEPTH_KEPT: Final = 64  # depth pictures, 23 MB; the network may be half a second behind them at any rate
_FIRST_PICTURE: Final = 30.0  # s from the start; loading the network takes a while
_SILENCE: Final = 5.0  # s without a message, which every picture causes, even an empty one

# The bindings' types for exceptions of the SDK.
_SDK_ERRORS: Final = (RuntimeError, ValueError, TypeError, IndexError, OSError)

_log = logging.getLogger("mossar.oak")
Say = Callable[[str], None]
Over = Callable[[], bool]


class Measurement:
    """Measures where joints are, from people found in a picture and the depth picture of the same moment.

    The node of the SDK that does it takes both in the order in which they come. A network drops the pictures that it
    has no time for, and each would make the depth older. So they are matched by their times first.

    Args:
        pipeline: Not yet started.
        fps: Pictures per second.

    Attributes:
        depth: Input for depth pictures, to be linked.
        people: Input for `ImgDetections`, to be linked.
    """

    def __init__(self, pipeline: Any, fps: float) -> None:
        node = load_sdk().node
        match = pipeline.create(node.Sync)
        match.setRunOnHost(True)
        match.setSyncThreshold(timedelta(seconds=_SAME_MOMENT / fps))
        self.depth, self.people = match.inputs["depth"], match.inputs["people"]
        self.depth.setMaxSize(_DEPTH_KEPT)
        places = pipeline.create(node.SpatialLocationCalculator)
        places.setRunOnHost(True)
        places.initialConfig.setCalculateSpatialKeypoints(True)
        places.initialConfig.setKeypointRadius(_RADIUS)
        self._pairs = match.out.createOutputQueue(maxSize=_QUEUE_SIZE, blocking=False)
        self._given = (
            ("depth", places.inputDepth.createInputQueue()),
            ("people", places.inputDetections.createInputQueue()),
        )
        self._places = places.outputDetections.createOutputQueue(maxSize=_QUEUE_SIZE, blocking=False)
        self._is_measuring = False  # takes a millisecond, on a busy machine more than `get` may wait

    def get(self, timeout: float) -> Any:
        """Return the next `SpatialImgDetections`, None after `timeout` seconds without."""
        patience = timedelta(seconds=timeout)
        if not self._is_measuring and (pair := self._pairs.get(patience)) is not None:
            for name, queue in self._given:
                queue.send(pair[name])
            self._is_measuring = True
        found = self._places.get(patience) if self._is_measuring else None
        self._is_measuring &= found is None
        return found


class Camera:
    """A pipeline that runs.

    Args:
        pipeline: Started here; stopped by `close`.
        measurement: Part of the pipeline.
        device: The camera; None where the pipeline runs on the host alone.
        name: For messages.
        fps: Nominal rate, Hz.
        unit: See `OakOptions`.
    """

    def __init__(
        self,
        pipeline: Any,
        measurement: Measurement,
        device: Any = None,
        *,
        name: str,
        fps: float,
        unit: str = "auto",
    ) -> None:
        self.name = name
        self.fps = fps
        self._sdk = load_sdk()
        self._unit = unit
        self._pipeline = pipeline
        self._measurement = measurement
        self._device = device
        pipeline.start()
        self._patience = time.monotonic() + _FIRST_PICTURE  # monotonic s; silent beyond it means lost

    @classmethod
    def open(cls, options: OakOptions, say: Say, over: Over) -> "Camera":
        """Find, boot and start a camera; takes seconds, and longer where the model must be downloaded.

        Args:
            options: The user's options.
            say: Gets the current step.
            over: Asked whether to give up.

        Raises:
            CameraError: If there is no camera, it is not ours to use, the model cannot be had, or it is over.
        """
        sdk = load_sdk()
        info = find_camera(options.device)
        name = info.deviceId or info.name
        say(f"starting camera {name}")
        device = None
        try:
            device = sdk.Device(info)
            # Reconnecting is our own business: the SDK's would leave a queue that is silent for ever.
            device.setMaxReconnectionAttempts(0)
            platform = device.getPlatformAsString()
            usual_model, usual_fps = MODELS.get(platform, MODELS["RVC2"])
            archive = _archive(options.model or usual_model, platform, say, over)
            fps = options.fps or usual_fps
            say(f"loading the pose model into camera {name}")
            pipeline = sdk.Pipeline(device)
            measurement = _build(sdk, pipeline, archive, fps)
            return cls(pipeline, measurement, device, name=name, fps=fps, unit=options.unit)
        except (CameraError, *_SDK_ERRORS) as error:
            if device is not None:
                with suppress(*_SDK_ERRORS):
                    device.close()
            raise error if isinstance(error, CameraError) else _refusal(name, error) from None

    def get(self, timeout: float) -> Picture | None:
        """Return the people in the next picture, None after `timeout` seconds without one.

        Raises:
            CameraLost: If the camera is gone.
            FrameError: If the message has another form than the pipeline's.
        """
        try:
            message = self._measurement.get(timeout)
        except (self._sdk.MessageQueue.QueueException, *_SDK_ERRORS) as error:
            raise CameraLost(f"its stream ended: {_line(error)}") from None
        if message is not None:
            self._patience = time.monotonic() + _SILENCE
            try:
                return self._read(message)
            except FrameError:
                raise
            except _SDK_ERRORS as error:
                raise FrameError(f"a message that cannot be read: {_line(error)}") from None
        if not self._pipeline.isRunning() or (self._device is not None and self._device.isClosed()):
            raise CameraLost("it was disconnected")
        if time.monotonic() > self._patience:
            raise CameraLost("it sends no pictures")
        return None

    def close(self) -> None:
        """Stop the pipeline and release the camera; failures now are ignored.

        The SDK's threads are waited for here: its destructor would hold Python's lock, which they may need.
        """
        closing = () if self._device is None else (self._device.close,)
        for step in (self._pipeline.stop, *closing, self._pipeline.wait):
            try:
                step()
            except _SDK_ERRORS:
                _log.debug("closing camera %s", self.name, exc_info=True)

    def _read(self, message: Any) -> Picture:
        unit = getattr(getattr(message, "unit", None), "name", "MILLIMETER")  # older SDKs: always millimetres
        scale = _SDK_UNITS.get(unit) if self._unit == "auto" else METRES[self._unit]
        if scale is None:
            raise FrameError(f"coordinates in the unit {unit}; say which with oak:?unit=mm")
        people = []
        for detection in message.detections:
            rows = [
                (p.spatialCoordinates.x, p.spatialCoordinates.y, p.spatialCoordinates.z, p.confidence)
                for p in detection.getKeypoints()
            ]
            people.append(np.array(rows, np.float64).reshape(-1, 4) * (scale, scale, scale, 1.0))
        return Picture(message.getSequenceNum(), message.getTimestamp().total_seconds(), tuple(people))


def load_sdk() -> Any:
    """Return the SDK's module.

    Raises:
        MossarError: If it is not installed, or in another version; names the extra.
    """
    # The SDK reads these when it is imported. It logs to standard output, where our events go, and since 3.7 it
    # reports its use to its maker, without the consent of the user of `mossar`.
    os.environ.setdefault("DEPTHAI_LEVEL", "off")
    os.environ.setdefault("DEPTHAI_TELEMETRY", "0")
    needed("depthai", "oak", "an OAK camera (oak:)")
    try:
        import depthai
    except ImportError as error:
        raise CameraError(f"depthai does not load ({_line(error)}); install it anew: {INSTALL}") from None
    version = tuple(int(part) for part in re.findall(r"\d+", str(depthai.__version__))[:2])
    if not (3, 6) <= version < (4,):
        raise CameraError(f"depthai {depthai.__version__} does not fit, {NEEDED} does: {INSTALL}")
    return depthai


def cameras() -> list[Any]:
    """Return the SDK's `DeviceInfo` of every camera in sight, also of those that cannot be used; takes 0.5 s.

    Raises:
        MossarError: If there is no SDK, or it cannot look.
    """
    sdk = load_sdk()
    try:
        return list(sdk.XLinkConnection.getAllConnectedDevices(skipInvalidDevices=False))
    except _SDK_ERRORS as error:
        raise CameraError(f"depthai cannot look for cameras: {_line(error)}") from None


def obstacle(info: Any) -> str:
    """Return the reason why a camera cannot be used, and the remedy; empty if it can."""
    if info.status.name == "X_LINK_INSUFFICIENT_PERMISSIONS":
        return f"no permission to use it over USB; run once, then plug it in again: {UDEV_RULE}"
    if info.status.name == "X_LINK_DEVICE_ALREADY_IN_USE" or info.state.name == "X_LINK_BOOTED":
        return "another program uses it; close that program"
    return ""


def description(info: Any) -> str:
    """Return one line about a camera: its id, where it is, and whether it can be used."""
    name = info.deviceId or info.name
    return f"camera {name} at {info.name} ({info.platform.name[7:]}): {obstacle(info) or 'ready'}"


def find_camera(wanted: str = "") -> Any:
    """Return the SDK's `DeviceInfo` of the camera to use.

    Args:
        wanted: Its id, address or USB port; empty for the first that can be used.

    Raises:
        CameraError: If it is not there or cannot be used.
    """
    seen = cameras()
    fitting = [info for info in seen if wanted in ("", info.deviceId, info.name)]
    if not fitting and _is_address(wanted):
        return load_sdk().DeviceInfo(wanted)  # in another subnet, where nothing announces it
    if not seen:
        raise CameraError(
            "No OAK camera found: plug one in (USB 3 cable, powered port), or give the address of one on the "
            "network, oak:?device=192.168.1.44"
        )
    if not fitting:
        names = ", ".join(info.deviceId or info.name for info in seen)
        raise CameraError(f"No OAK camera called {wanted[:40]!r} found; there are {names}")
    for info in fitting:
        if not obstacle(info):
            return info
    raise CameraError(f"OAK camera {fitting[0].deviceId or fitting[0].name}: {obstacle(fitting[0])}")


def model_folder() -> Path:
    """Return the folder of the models that the SDK has downloaded."""
    return Path(
        os.environ.get("DEPTHAI_ZOO_CACHE_PATH") or load_sdk().modelzoo.getDefaultCachePath()
    ).absolute()


def _is_address(text: str) -> bool:
    try:
        ip_address(text)
    except ValueError:
        return False
    return True


def fetch(model: str, platform: str, ask: str) -> None:
    """Write the path of a model to standard output: the kept one, or if `ask` is "1" the hub's present one."""
    os.environ["DEPTHAI_ZOO_INTERNET_CHECK"] = ask
    sdk = load_sdk()
    try:
        path = sdk.getModelFromZoo(sdk.NNModelDescription(model, platform=platform))
    except _SDK_ERRORS as error:
        sys.exit(_line(error))
    sys.stdout.write(str(path))


def _archive(model: str, platform: str, say: Say, over: Over) -> Any:
    """Return the SDK's archive of a model."""
    path = model if model.endswith(ARCHIVES) else _fetched(model, platform, say, over)
    try:
        return load_sdk().NNArchive(path)
    except _SDK_ERRORS as error:
        raise CameraError(f"{path} cannot be read as a model archive: {_line(error)}") from None


def _fetched(model: str, platform: str, say: Say, over: Over) -> str:
    """Return the path of a model of the hub; another process fetches it, for the SDK's download has no timeout."""
    folder = model_folder()
    # The hub is asked only for a missing model: the SDK would wait for its answer for ever.
    done = run_separately(fetch, model, platform, "0", enough=over)
    if done is not None and done.returncode:
        say(f"downloading the pose model {model}, once; it is kept in {folder}")
        done = run_separately(fetch, model, platform, "1", enough=over)
    if done is None:
        raise CameraError(f"the pose model {model} was not waited for")
    if done.returncode:
        reason = done.stderr.strip().rpartition("\n")[2] or f"status {done.returncode}"
        raise CameraError(f"the pose model {model} cannot be had ({reason}); {_remedy(reason, folder)}")
    return done.stdout


def _remedy(reason: str, folder: Path) -> str:
    if "director" in reason or "filesystem" in reason:
        return f"make {folder} a folder that can be written, or name another in DEPTHAI_ZOO_CACHE_PATH"
    return (
        "connect to the internet for the first run, or download its archive elsewhere and give it as "
        "oak:?model=FILE.tar.xz"
    )


def _build(sdk: Any, pipeline: Any, archive: Any, fps: float) -> Measurement:
    """Link the pipeline of a real camera."""
    node, socket = sdk.node, sdk.CameraBoardSocket
    wanted = sdk.ImgFrameCapability()
    wanted.fps.fixed(fps)
    wanted.enableUndistortion = True
    colour = pipeline.create(node.Camera).build(socket.CAM_A)
    people = pipeline.create(node.DetectionNetwork).build(colour, archive, wanted)
    stereo = pipeline.create(node.StereoDepth).build(True, size=_STEREO_SIZE, fps=fps)
    stereo.setLeftRightCheck(True)  # holes instead of wrong depth beside the body
    stereo.setSubpixel(True)  # without it depth comes in steps of 20 cm at 2.5 m
    align = pipeline.create(node.ImageAlign)
    stereo.depth.link(align.input)
    people.passthrough.link(align.inputAlignTo)
    measurement = Measurement(pipeline, fps)
    align.outputAligned.link(measurement.depth)
    people.out.link(measurement.people)
    return measurement


def _refusal(name: str, error: Exception) -> CameraError:
    """Return an error of the SDK as one of ours."""
    text = _line(error)
    if "ALREADY_IN_USE" in text:
        text = "another program uses it; close that program"
    elif "PERMISSION" in text.upper():
        text = f"no permission to use it over USB; run once, then plug it in again: {UDEV_RULE}"
    elif "socket" in text.lower() or "stereo" in text.lower():
        text = f"it must have a colour camera and a stereo pair for depth ({text})"
    return CameraError(f"OAK camera {name}: {text}")


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
