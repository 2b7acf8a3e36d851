"""The browser's camera as the sensor of the page, in a real browser with a camera that is a file; its former name."""

import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import numpy as np
import pytest

cv2 = pytest.importorskip("cv2", reason="the extra webcam is not installed")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
PATIENCE = 120.0  # s, for a browser on a busy machine


@pytest.fixture(scope="module")
def provided():
    """Skip where the weights or the maker's library are not on this machine."""
    from mossar_adapters.pose import weights

    pytest.importorskip("ai_edge_litert", reason="the extra webcam is not installed")
    place = weights.folder()
    if weights.kept() is None or not all((place / one.file).exists() for one in weights.LIBRARY):
        pytest.skip("the weights or tasks-vision are not here: mossar webcam fetches them")


@pytest.fixture
def astronaut():
    data = pytest.importorskip("skimage.data", reason="scikit-image is not installed")
    return cv2.cvtColor(data.astronaut(), cv2.COLOR_RGB2BGR)


@pytest.fixture
def camera_file(astronaut, tmp_path):
    """Write what the fake camera shows: a person who is carried to and fro, and leans."""
    path = tmp_path / "camera.mjpeg"
    with path.open("wb") as file:
        for k in range(90):
            share = (1 - np.cos(2 * np.pi * k / 45)) / 2
            matrix = cv2.getRotationMatrix2D((256, 512), 24 * share - 12, 0.9)
            matrix[0, 2] += 64 + 60 * share
            picture = cv2.warpAffine(astronaut, matrix, (640, 480))
            file.write(cv2.imencode(".jpg", picture)[1].tobytes())
    return path


@pytest.fixture
def page(provided, tmp_path):  # noqa: ARG001
    """Run `mossar webcam` and return the page's address and the file of events."""
    events = tmp_path / "events.jsonl"
    command = [
        sys.executable,
        "-m",
        "mossar_tools",
        "webcam",
        "--no-browser",
        "--port",
        "0",
        "--to",
        str(events),
    ]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": "1"}
    )
    try:
        said = []
        for line in process.stderr:
            said.append(line)
            if found := re.search(r"http://127\.0\.0\.1:\d+/", line):
                break
        else:
            pytest.fail("it ended without a page")
        (tmp_path / "said.txt").write_text("".join(said))
        yield found[0], events
    finally:
        process.terminate()
        process.wait(20)
        process.stderr.close()


# Pixels of the colour of bones.
DRAWN = """
() => {
    const canvas = document.getElementById("picture")
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data
    let count = 0
    for (let at = 0; at < pixels.length; at += 4)
        count += Math.abs(pixels[at] - 79) + Math.abs(pixels[at + 1] - 195) + Math.abs(pixels[at + 2] - 247) < 12
    return count
}
"""


def until(condition, window):
    """Wait until a condition holds while a page runs."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, window.text_content("body")
        window.wait_for_timeout(100)


def get(url, **headers):
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=20) as answer:
            return answer.status, dict(answer.headers), answer.read()
    except urllib.error.HTTPError as error:
        return error.code, dict(error.headers), error.read()


def test_the_page_allows_nothing_outside_this_computer(page):
    url, _ = page
    status, headers, body = get(url)
    policy = headers["Content-Security-Policy"]
    assert status == 200
    assert b"/page.js" in body
    assert "default-src 'none'" in policy
    assert not re.search(r"https?://(?!127\.0\.0\.1)", policy)
    assert set(re.findall(r"ws://([\d.]+):", policy)) == {"127.0.0.1"}


def test_only_what_the_page_needs_is_served_and_only_to_this_computer(page):
    url, _ = page
    assert get(url + "about.json")[0] == 200
    assert get(url + "../../etc/passwd")[0] == 404
    assert get(url + "server.py")[0] == 404
    assert get(url, Host="evil.example:80")[0] == 403


@pytest.mark.skipif(CHROMIUM is None, reason="needs a browser: apt-get install chromium")
def test_a_browser_with_a_camera_brings_key_frames_and_asks_nobody_else(page, camera_file):
    api = pytest.importorskip("playwright.sync_api", reason="needs pip install playwright")
    url, events = page
    arguments = [
        "--no-sandbox",
        "--use-fake-ui-for-media-stream",
        "--use-fake-device-for-media-stream",
        f"--use-file-for-fake-video-capture={camera_file}",
    ]
    asked, sockets, problems = [], [], []
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=arguments)
        window = browser.new_context().new_page()
        window.on("request", lambda request: asked.append(request.url))
        window.on("websocket", lambda socket: sockets.append(socket.url))
        window.on("pageerror", lambda error: problems.append(str(error)))
        window.goto(url)
        window.locator("#time", has_text=re.compile("[1-9]")).wait_for(timeout=PATIENCE * 1e3)
        until(lambda: '"confirmed"' in events.read_text(), window)
        assert window.locator("#camera option").count() >= 1
        assert "nobody" not in window.locator("#note").text_content()
        assert "stalled" not in window.inner_text("body")
        drawn = window.evaluate(DRAWN)
        assert drawn > 100, "no skeleton is on the picture"
        second = window.context.new_page()  # shows the figure: two windows would send two bodies as one
        second.goto(url)
        until(lambda: "another window" in second.locator("#note").text_content(), second)
        window.close()
        until(lambda: "another window" not in second.locator("#note").text_content(), second)
        browser.close()
    assert problems == []
    hosts = {
        re.match(r"\w+:(?://)?([^/:]*)", one)[1]
        for one in (*asked, *sockets)
        if not one.startswith(("blob:", "data:"))
    }
    assert hosts == {"127.0.0.1"}
    told = [json.loads(line) for line in events.read_text().splitlines()]
    assert any(event["type"] == "key_frame" and event["status"] == "confirmed" for event in told)


@pytest.mark.usefixtures("provided")
def test_view_takes_the_camera_of_the_browser_where_this_computer_has_none_for_programs(monkeypatch, caplog):
    from mossar_adapters.pose import camera
    from mossar_adapters.pose.types import PoseError
    from mossar_tools.commands.run import Options
    from mossar_tools.player_page.opening import _eye_of

    def missing(_):
        raise PoseError("no camera 0 found: plug one in")

    monkeypatch.setattr(camera, "check_camera", missing)
    with caplog.at_level("INFO", "mossar"):
        assert _eye_of(Options(sources=("webcam:",))).about["model"] == "full"
    assert "the page uses the camera of the browser" in caplog.text
    # A named camera is used, or the reason is reported.
    assert _eye_of(Options(sources=("webcam:1",))) is None
    monkeypatch.setattr(camera, "check_camera", lambda _: None)
    assert _eye_of(Options(sources=("webcam:",))) is None
    assert _eye_of(Options(sources=("webcam:browser",))) is not None


def test_the_former_name_says_the_new_one_in_one_line(page):
    _, events = page
    said = (events.parent / "said.txt").read_text().splitlines()
    assert len([line for line in said if "mossar view webcam:browser" in line]) == 1


@pytest.mark.usefixtures("provided")
def test_the_bundle_for_browsers_is_made_of_the_weights(tmp_path):
    import zipfile

    from mossar_adapters.pose.task import write_task
    from mossar_adapters.pose.weights import kept

    path = tmp_path / "pose.task"
    write_task(kept(), path)
    with zipfile.ZipFile(path) as bundle:
        assert bundle.namelist() == ["pose_detector.tflite", "pose_landmarks_detector.tflite"]
        for name in bundle.namelist():
            assert bundle.getinfo(name).compress_type == zipfile.ZIP_STORED
            assert bundle.read(name)[4:8] == b"TFL3"
            assert b"TFLITE_METADATA" in bundle.read(name)
            assert b"M001" in bundle.read(name)


@pytest.mark.usefixtures("provided")
@pytest.mark.parametrize("command", ["adapters", "webcam"])
def test_get_model_says_where_the_weights_are(mossar, command):
    from mossar_adapters.pose.weights import folder

    status, out, err = mossar(command, "--get-model")
    assert status == 0
    assert ("is now: mossar adapters --get-model" in err) == (command == "webcam")
    assert str(folder()) in out
    assert Path(folder()).is_dir()
