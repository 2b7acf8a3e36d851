"""`webcam:` with a pipe of pictures for a camera: frames at the pace of the camera, errors, unplugging."""

import errno
import os
import sys
import threading
import time

import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.pose.camera import Camera, refusal
from mossar_adapters.pose.source import wanted
from mossar_adapters.pose.types import MAX_PEOPLE, SKELETON, CameraLost, CameraOptions, PoseError
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_source
from mossar_stream import Frames, MossarError, SettingsError

pytestmark = pytest.mark.skipif(
    not hasattr(os, "mkfifo"), reason="pipes stand in for cameras; not on Windows"
)
needs_weights = pytest.mark.usefixtures("weights")
RATE = 25.0


cv2 = pytest.importorskip("cv2", reason="the extra webcam is not installed")


class Device:
    """A camera: a pipe into which pictures are written at a rate."""

    def __init__(self, path):
        self.path = path
        os.mkfifo(path)

    def play(self, pictures, rate=RATE):
        """Write pictures on a thread; at the end the camera is gone."""
        coded = [cv2.imencode(".jpg", picture)[1].tobytes() for picture in pictures]

        def write():
            try:
                with self.path.open("wb", buffering=0) as pipe:
                    begin = time.monotonic()
                    for k, picture in enumerate(coded):
                        time.sleep(max(0.0, begin + k / rate - time.monotonic()))
                        pipe.write(picture)
            except BrokenPipeError:
                return

        thread = threading.Thread(target=write, daemon=True)
        thread.start()
        return thread


@pytest.fixture
def device(tmp_path, monkeypatch):
    # A real camera says what it sends; of a pipe OpenCV would read 5 MB first to find out.
    monkeypatch.setenv("OPENCV_FFMPEG_CAPTURE_OPTIONS", "probesize;32768|analyzeduration;0")
    return Device(tmp_path / "camera.mjpeg")


def read(source, enough, limit=30.0):
    """Return what a source gives until it is enough."""
    items, until = [], time.monotonic() + limit
    try:
        for item in source.items():
            if item is not None:
                items.append(item)
            if enough(items) or time.monotonic() > until:
                return items
    finally:
        source.close()
    return items


def frames(items):
    return [item for item in items if isinstance(item, Frames)]


@needs_weights
def test_a_person_before_the_camera_gives_frames(device, pan):
    device.play(pan * 4)
    items = read(open_source(f"webcam:{device.path}"), lambda items: len(frames(items)) >= 20)
    assert isinstance(items[0], Meta)
    assert items[0].skeleton == SKELETON
    times = np.concatenate([item.times for item in frames(items)])
    assert (np.diff(times) > 0).all()
    assert abs(time.monotonic() - times[-1]) < 5.0  # the clock at the grab
    assert frames(items)[0].positions.shape == (1, 33, 3)
    assert frames(items)[0].confidence.shape == (1, 33)


@pytest.mark.parametrize(
    ("url", "slots", "people"),
    [
        ("webcam:", None, 1),
        ("webcam:", 2, 2),
        ("webcam:", 9, MAX_PEOPLE),
        ("webcam:", "nearest", MAX_PEOPLE),
        ("webcam:?people=3", "first", 3),
    ],
)
def test_as_many_people_are_looked_for_as_there_are_slots(url, slots, people):
    assert wanted(parse_url(url), None, slots)[2] == people


@needs_weights
def test_two_people_before_the_camera_have_two_slots(device, pan):
    # The second is somebody of another size, beside the first: a picture of 960 x 480.
    pictures = [np.hstack([one, cv2.copyMakeBorder(one[::2, ::2], 120, 120, 120, 120, 0)]) for one in pan]
    device.play(pictures * 6, rate=15.0)
    source = open_source(f"webcam:{device.path}", people=2)
    found = frames(read(source, lambda items: sum(f.performer == "p2" for f in frames(items)) >= 10))
    assert {item.performer for item in found} == {"p1", "p2"}
    first, second = ({float(f.times[0]) for f in found if f.performer == name} for name in ("p1", "p2"))
    assert len(first & second) >= 9  # in the same pictures
    assert [row["slot"] for row in source.table()] == ["p1", "p2"]


@needs_weights
def test_an_empty_room_gives_no_frame(device, pan):
    device.play([np.zeros_like(pan[0])] * 900)  # half a minute: a busy machine sees few pictures a second
    source = open_source(f"webcam:{device.path}")
    items = read(source, lambda _: source.counters.received >= 10)
    assert items == []
    assert "pictures came without a person" in source.explain()


def test_only_the_newest_picture_is_estimated(device, pan):
    device.play(pan * 4, rate=50.0)
    camera = Camera(CameraOptions(str(device.path)))
    try:
        first = camera.newest(10.0)
        time.sleep(0.5)
        second = camera.newest(1.0)
    finally:
        camera.close()
    assert second.number > first.number + 3
    assert second.time > first.time


@needs_weights
def test_a_camera_that_is_unplugged_comes_back(device, pan, caplog):
    device.play(pan[:30])
    source = open_source(f"webcam:{device.path}")

    def enough(items):
        if "was lost" in caplog.text and not again:
            again.append(device.play(pan * 4))
            before.append(len(frames(items)))
        return bool(before) and len(frames(items)) > before[0] + 5

    again, before = [], []
    with caplog.at_level("WARNING", logger="mossar"):
        items = read(source, enough)
    assert before
    assert len(frames(items)) > before[0] + 5
    assert "the camera is back" in caplog.text


def test_a_camera_that_is_not_there_is_said_in_one_line(tmp_path):
    with pytest.raises(MossarError, match=r"no camera .*/none found: plug one in"):
        open_source(f"webcam:{tmp_path}/none")


@pytest.mark.parametrize(
    ("number", "said"),
    [
        (errno.EBUSY, "another program uses it; close that program"),
        (errno.EACCES, "this user may not use it"),
        (errno.ENODEV, "no camera 3 found: plug one in"),
        (errno.EIO, "cannot be opened"),
    ],
)
def test_what_the_system_says_becomes_advice(number, said):
    assert said in refusal("3", OSError(number, os.strerror(number)))


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() == 0, reason="root may use every device")
def test_a_camera_that_is_forbidden_is_said(tmp_path):
    path = tmp_path / "camera"
    path.touch(mode=0o000)
    with pytest.raises(MossarError, match="this user may not use it"):
        open_source(f"webcam:{path}")


@needs_weights
def test_a_file_that_is_no_camera_is_said(tmp_path):
    path = tmp_path / "camera"
    path.write_bytes(bytes(5000))
    with pytest.raises(PoseError, match="cannot be opened"):
        read(open_source(f"webcam:{path}"), lambda _: False)


def test_a_camera_that_ends_is_lost(device, pan):
    device.play(pan[:10], rate=200.0)
    camera = Camera(CameraOptions(str(device.path)))
    with pytest.raises(CameraLost):
        all(camera.newest(1.0) for _ in range(100))
    camera.close()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("?model=huge", "model must be one of lite, full, heavy"),
        ("?size=640", "size is WIDTHxHEIGHT"),
        ("?size=640x9999999", "size is WIDTHxHEIGHT"),
        ("?people=5", "people must be one of 1, 2, 3, 4"),
        ("?fps=500", "fps must lie in 1 to 240"),
        ("?zoom=3", "there is no option 'zoom'"),
        ("1?name=Logi", "by its number or by name=, not by both"),
        ("//host/0", "a camera is a number or a path"),
        ("?name=nobody-has-this-one", "no camera is called 'nobody-has-this-one'"),
    ],
)
def test_options_that_cannot_be_are_refused(options, said):
    with pytest.raises((SettingsError, PoseError), match=said.replace("?", r"\?")):
        open_source(f"webcam:{options}")


@needs_weights
def test_nothing_is_sent_and_nothing_is_stored(device, pan, tmp_path):
    opened, written = [], []

    def watch(event, arguments):
        if is_watching and event in {"socket.connect", "socket.bind", "socket.sendto", "socket.getaddrinfo"}:
            opened.append((event, arguments))
        if (
            is_watching
            and event == "open"
            and isinstance(arguments[1], str)
            and set(arguments[1]) & set("wax+")
        ):
            written.append(arguments[0])

    is_watching = True
    sys.addaudithook(watch)
    try:
        device.play(pan * 4)
        inside = {path.name for path in tmp_path.iterdir()}
        items = read(open_source(f"webcam:{device.path}"), lambda items: len(frames(items)) >= 10)
    finally:
        is_watching = False
    assert len(frames(items)) >= 10
    assert opened == []
    assert [path for path in written if str(path) not in {str(device.path), os.devnull}] == []
    assert {path.name for path in tmp_path.iterdir()} == inside
