"""`mossar webcam`: the page in a real browser with a camera that is a file; requests, key frames, refusals."""

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
PATIENCE = 60.0  # s, for a browser on a busy machine


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
        for line in process.stderr:
            if found := re.search(r"http://127\.0\.0\.1:\d+/", line):
                break
        else:
            pytest.fail("it ended without a page")
        yield found[0], events
    finally:
        process.terminate()
        process.wait(20)
        process.stderr.close()


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
    assert b"mossar webcam" in body
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
        window = browser.new_page()
        window.on("request", lambda request: asked.append(request.url))
        window.on("websocket", lambda socket: sockets.append(socket.url))
        window.on("pageerror", lambda error: problems.append(str(error)))
        window.goto(url)
        window.locator("#events", has_text="key frame").wait_for(timeout=PATIENCE * 1e3)
        assert window.locator("#camera option").count() >= 1
        assert "a person is in the picture" in window.locator("#state").text_content()
        mirrored = window.evaluate("getComputedStyle(document.querySelector('figure')).transform")
        assert mirrored.startswith("matrix(-1")
        browser.close()
    assert problems == []
    hosts = {
        re.match(r"\w+:(?://)?([^/:]*)", one)[1]
        for one in (*asked, *sockets)
        if not one.startswith(("blob:", "data:"))
    }
    assert hosts == {"127.0.0.1"}
    until = time.monotonic() + 10
    while time.monotonic() < until and '"confirmed"' not in events.read_text():
        time.sleep(0.1)
    told = [json.loads(line) for line in events.read_text().splitlines()]
    assert any(event["type"] == "key_frame" and event["status"] == "confirmed" for event in told)


@pytest.mark.skipif(CHROMIUM is None, reason="needs a browser: apt-get install chromium")
def test_the_page_lists_followed_moves_poses_and_steps(page):
    api = pytest.importorskip("playwright.sync_api", reason="needs pip install playwright")
    url, _ = page
    sent = [
        {"type": "follow", "status": "going", "name": "squat", "count": 2},
        {"type": "follow", "status": "done", "name": "squat", "count": 3, "score": 0.61},
        {"type": "pose", "status": "held", "name": "plank"},
        {"type": "step", "status": "strike", "side": "left"},
    ]
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        window = browser.new_page()
        receives_events = json.loads(get(url + "about.json")[2])["events"]
        window.route_web_socket(
            re.compile(re.escape(receives_events)),
            lambda socket: [socket.send(json.dumps(event)) for event in sent],
        )
        window.goto(url)
        window.locator("#events", has_text="step").wait_for(timeout=PATIENCE * 1e3)
        assert window.locator("#events li").all_text_contents() == [
            "step: left",
            "pose held: plank",
            "squat 3: score 0.61",
        ]
        browser.close()


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
def test_get_model_says_where_the_weights_are(mossar):
    from mossar_adapters.pose.weights import folder

    status, out, _ = mossar("webcam", "--get-model")
    assert status == 0
    assert str(folder()) in out
    assert Path(folder()).is_dir()
