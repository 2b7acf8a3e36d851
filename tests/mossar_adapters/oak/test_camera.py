"""What stands between a user and a camera, told in one line each; the SDK is genuine, the devices are records of it."""

import os
import subprocess
import sys

import pytest

from mossar_adapters.oak import camera as oak_camera
from mossar_adapters.oak.camera import find_camera, load_sdk, obstacle
from mossar_adapters.oak.check import check, summary, tell
from mossar_adapters.oak.types import CameraError
from mossar_stream import SettingsError

os.environ.setdefault("DEPTHAI_LEVEL", "off")  # looked at when it is imported
dai = pytest.importorskip("depthai")


def device(name, state="X_LINK_UNBOOTED", status="X_LINK_SUCCESS", identity=""):
    return dai.DeviceInfo(
        name,
        identity,
        getattr(dai.XLinkDeviceState, state),
        dai.XLinkProtocol.X_LINK_USB_VSC,
        dai.XLinkPlatform.X_LINK_MYRIAD_X,
        getattr(dai.XLinkError_t, status),
    )


FREE = device("1.2", identity="18443010A1")
BUSY = device("1.3", state="X_LINK_BOOTED", identity="18443010B2")
FORBIDDEN = device("1.4", status="X_LINK_INSUFFICIENT_PERMISSIONS")


@pytest.fixture
def in_sight(monkeypatch):
    def show(*devices):
        monkeypatch.setattr(oak_camera, "cameras", lambda: list(devices))

    return show


def test_the_first_camera_that_can_be_used_is_taken(in_sight):
    in_sight(FORBIDDEN, BUSY, FREE)
    assert find_camera() is FREE


def test_a_camera_is_found_by_id_and_by_port(in_sight):
    in_sight(BUSY, FREE)
    assert find_camera("18443010A1") is find_camera("1.2") is FREE


def test_an_address_that_nothing_announced_is_tried_anyway(in_sight):
    in_sight(FREE)
    assert find_camera("10.1.2.3").name == "10.1.2.3"


def test_another_id_names_the_cameras_in_sight(in_sight):
    in_sight(FREE, BUSY)
    with pytest.raises(CameraError, match="called '1844' found; there are 18443010A1, 18443010B2"):
        find_camera("1844")


def test_a_busy_camera_says_so(in_sight):
    in_sight(BUSY)
    with pytest.raises(CameraError, match="OAK camera 18443010B2: another program uses it"):
        find_camera()


def test_a_missing_permission_comes_with_the_rule_to_add(in_sight):
    in_sight(FORBIDDEN)
    with pytest.raises(CameraError, match=r"udev/rules\.d/80-movidius\.rules") as error:
        find_camera()
    assert "\n" not in str(error.value)
    assert obstacle(FREE) == ""


@pytest.mark.parametrize(
    ("given", "kept"), [({}, "off 0"), ({"DEPTHAI_LEVEL": "warn", "DEPTHAI_TELEMETRY": "1"}, "warn 1")]
)
def test_the_sdk_keeps_quiet_and_reports_nothing_to_its_maker_unless_the_user_wants_it(given, kept):
    program = (
        "import os; from mossar_adapters.oak.camera import load_sdk; load_sdk()\n"
        "print(os.environ['DEPTHAI_LEVEL'], os.environ['DEPTHAI_TELEMETRY'])"
    )
    places = {name: value for name, value in os.environ.items() if not name.startswith("DEPTHAI_")}
    places |= {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), **given}
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True, env=places
    )
    assert done.stdout.splitlines()[-1] == kept


@pytest.mark.parametrize("version", ["2.31.0.0", "3.5.0", "4.0.0"])
def test_other_versions_of_the_sdk_are_refused_with_the_one_to_install(monkeypatch, version):
    monkeypatch.setattr(dai, "__version__", version)
    with pytest.raises(
        CameraError, match=rf"depthai {version} does not fit, depthai>=3.6,<4 does: pip install"
    ):
        load_sdk()


def test_versions_from_3_6_on_are_taken(monkeypatch):
    for version in ("3.6.1", "3.12.0rc1"):
        monkeypatch.setattr(dai, "__version__", version)
        assert load_sdk() is dai


@pytest.mark.parametrize(
    ("call", "arguments"),
    [
        (dai.Device.__init__, ["deviceInfo: depthai.DeviceInfo"]),
        (dai.Device.setMaxReconnectionAttempts, ["maxAttempts: int"]),
        (dai.Device.getPlatformAsString, ["-> str"]),
        (dai.Device.isClosed, ["-> bool"]),
        (dai.Pipeline.__init__, ["defaultDevice: depthai.Device"]),
        (dai.Pipeline.isRunning, ["-> bool"]),
        (dai.node.Camera.build, ["boardSocket: depthai.CameraBoardSocket"]),
        (
            dai.node.DetectionNetwork.build,
            ["input: depthai.node.Camera, model", "capability: depthai.ImgFrameCapability"],
        ),
        (
            dai.node.StereoDepth.build,
            ["autoCreateCameras: bool", "size: tuple[int, int]", "fps: Optional[float]"],
        ),
        (dai.node.StereoDepth.setLeftRightCheck, ["enable: bool"]),
        (dai.node.StereoDepth.setSubpixel, ["enable: bool"]),
    ],
)
def test_the_sdk_knows_the_calls_that_only_a_camera_makes(call, arguments):
    """The pipeline of a camera cannot be built without one; at least its words are those of this SDK."""
    assert all(argument in call.__doc__ for argument in arguments), call.__doc__


def test_the_sdk_knows_the_nodes_and_ends_that_only_a_camera_has():
    assert {"out", "passthrough"} <= set(dir(dai.node.DetectionNetwork))
    assert {"input", "inputAlignTo", "outputAligned"} <= set(dir(dai.node.ImageAlign))
    assert "depth" in dir(dai.node.StereoDepth)
    assert dai.CameraBoardSocket.CAM_A
    capability = dai.ImgFrameCapability()
    capability.fps.fixed(10.0)
    capability.enableUndistortion = True


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("X_LINK_DEVICE_ALREADY_IN_USE", "close that program"),
        ("Insufficient permissions", "udev"),
        ("Camera socket CAM_A is not available", "stereo pair"),
        ("something\nelse", "something else"),
    ],
)
def test_refusals_of_the_sdk_become_one_line(text, words):
    error = oak_camera._refusal("X", RuntimeError(text))
    assert words in str(error)
    assert "\n" not in str(error)


def test_the_check_lists_the_sdk_every_camera_and_the_checklist(monkeypatch):
    monkeypatch.setattr("mossar_adapters.oak.check.cameras", lambda: [FREE, BUSY])
    monkeypatch.setattr(oak_camera, "cameras", lambda: [FREE, BUSY])
    text, usable = check()
    assert usable
    assert text.startswith(f"depthai {dai.__version__}; models are kept in ")
    assert "camera 18443010A1 at 1.2 (MYRIAD_X): ready" in text
    assert "camera 18443010B2 at 1.3 (MYRIAD_X): another program uses it" in text
    assert " 7. mossar record oak: take.msk" in text


def test_the_check_says_that_there_is_no_camera_or_not_the_one_that_is_wanted(in_sight):
    in_sight()
    text, usable = check()
    assert not usable
    assert "\nNo OAK camera found: plug one in" in text
    in_sight(FREE)
    assert "\nNo OAK camera called '1844' found; there are 18443010A1\n" in check("oak:?device=1844")[0]
    with pytest.raises(SettingsError, match="fps must be a number"):
        check("oak:?fps=fast")


def test_what_is_asked_for_the_summary_names_the_sdk_and_every_camera(monkeypatch, capfd):
    monkeypatch.setattr("mossar_adapters.oak.check.cameras", lambda: [FREE])
    tell()
    lines = [f"depthai {dai.__version__}", "camera 18443010A1 at 1.2 (MYRIAD_X): ready"]
    assert capfd.readouterr().out.splitlines() == lines


def test_an_sdk_that_cannot_look_is_said(monkeypatch, capfd):
    monkeypatch.setattr("mossar_adapters.oak.check.cameras", lambda: find_camera("nowhere"))
    monkeypatch.setattr(oak_camera, "cameras", list)
    tell()
    assert "No OAK camera found" in capfd.readouterr().out


def test_the_summary_comes_in_time_or_says_that_it_does_not():
    assert summary(60)[0] == f"depthai {dai.__version__}"
    (line,) = summary(0.01)
    assert "has not answered" in line


def test_measuring_that_takes_longer_than_anybody_waits_is_neither_lost_nor_taken_for_the_next(studio):
    stage, body = studio.Stage(), studio.standing()
    number = asked = 0
    # Until a measurement was not there at once, which on an idle machine may take more than 20 pictures.
    while number < 20 or (asked == number and number < 500):
        stage.send(number, studio.START + number / studio.FPS, [body])
        picture = None
        while picture is None:
            picture = stage.camera.get(0.0)
            asked += 1
        assert picture.number == number
        number += 1
    stage.camera.close()
    assert asked > number
