"""The picture of a webcam on the dashboard: mirrored, with the skeleton, on this computer only."""

import numpy as np
import pytest

from mossar_adapters.joint_sets import BLAZEPOSE_33
from mossar_adapters.pose.types import Body

pytest.importorskip("cv2", reason="the extra webcam is not installed")


def seen(*bodies):
    from mossar_adapters.pose.source import Seen

    picture = np.zeros((480, 640, 3), np.uint8)
    picture[:, :100] = (0, 0, 255)  # red, BGR, on the left
    return Seen(picture, bodies)


def body(confidence):
    pixels = np.full((33, 2), 400.0, np.float32)
    pixels[BLAZEPOSE_33.index("left_hip")] = (300, 240)
    pixels[BLAZEPOSE_33.index("left_knee")] = (300, 400)
    return Body(1, np.zeros((33, 3), np.float32), np.full(33, confidence, np.float32), pixels)


def test_it_is_mirrored_and_small():
    from mossar_tools.dashboard.camera_picture import camera_picture

    shown = camera_picture(seen())
    assert shown.shape == (240, 320, 3)
    assert shown[100, 310].tolist() == [255, 0, 0]  # red, RGB, on the right
    assert shown[100, 10].tolist() == [0, 0, 0]


def test_the_skeleton_is_on_it_where_joints_are_visible():
    from mossar_tools.dashboard.camera_picture import camera_picture

    thigh = (160, 320 - 150)  # half the size, mirrored
    assert camera_picture(seen(body(0.9)))[thigh].any()
    assert not camera_picture(seen(body(0.2)))[thigh].any()


def test_pictures_are_kept_only_where_they_were_asked_for(tmp_path):
    import os

    from mossar_adapters.pose.weights import kept
    from mossar_adapters.urls import open_source

    if not hasattr(os, "mkfifo") or kept() is None:
        pytest.skip("the weights are not here: mossar adapters --get-model")
    os.mkfifo(tmp_path / "camera.mjpeg")
    assert open_source(f"webcam:{tmp_path}/camera.mjpeg").preview is None
    assert open_source(f"webcam:{tmp_path}/camera.mjpeg?picture=yes").preview() is None  # not yet


def test_pictures_are_not_shown_to_other_devices(mossar, tmp_path):
    import os

    from mossar_adapters.pose.weights import kept

    pytest.importorskip("viser", reason="the extra view is not installed")
    if not hasattr(os, "mkfifo") or kept() is None:
        pytest.skip("the weights are not here: mossar adapters --get-model")
    os.mkfifo(tmp_path / "camera.mjpeg")
    url = f"webcam:{tmp_path}/camera.mjpeg?picture=yes"
    status, _, err = mossar("view", url, "--no-browser", "--port", "0", "--host", "0.0.0.0")
    assert status == 2
    assert "on this computer only" in err
