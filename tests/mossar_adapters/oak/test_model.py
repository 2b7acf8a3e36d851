"""The pose model: fetched by the genuine SDK from a hub on this machine, or given as an archive."""

import io
import json
import os
import tarfile
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from mossar_adapters.oak import camera as oak_camera
from mossar_adapters.oak.camera import model_folder
from mossar_adapters.oak.types import CameraError

os.environ.setdefault("DEPTHAI_LEVEL", "off")  # looked at when it is imported
dai = pytest.importorskip("depthai")

MODEL, _ = oak_camera.MODELS["RVC2"]
SHAPE = [1, 3, 288, 512]
CONFIG = {
    "config_version": "1.0",
    "model": {
        "metadata": {"name": "pose", "path": "pose.onnx", "precision": "float32"},
        "inputs": [
            {
                "name": "image",
                "dtype": "float32",
                "input_type": "image",
                "shape": SHAPE,
                "layout": "NCHW",
                "preprocessing": {
                    "mean": None,
                    "scale": None,
                    "reverse_channels": None,
                    "interleaved_to_planar": None,
                },
            }
        ],
        "outputs": [{"name": "joints", "dtype": "float32"}],
        "heads": [],
    },
}


class Hub:
    """The maker's hub, on this machine.

    Args:
        answer: Status of its answers to a model's name; 0 to give none.
    """

    def __init__(self, answer=200):
        self.asked = []
        hub = self

        class Hub(BaseHTTPRequestHandler):
            def do_GET(self):
                hub.asked.append(self.path.partition("?")[0])
                if hub.asked[-1] == "/models" and not answer:
                    hub.closed.wait()
                    return
                self.send_response(answer if hub.asked[-1] == "/models" else 200)
                self.end_headers()
                self.wfile.write(hub.content(hub.asked[-1]))

            def log_message(self, *_):
                pass

        self.closed = threading.Event()
        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Hub)
        self.place = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, args=(0.01,), daemon=True).start()

    def content(self, path):
        if path == "/models":
            return json.dumps({"hash": "1", "download_links": [f"{self.place}/pose.tar.xz"]}).encode()
        return archive() if path == "/pose.tar.xz" else b"{}"

    def close(self):
        self.closed.set()
        self.server.shutdown()
        self.server.server_close()


def archive():
    """Return a model archive without a network in it."""
    written = io.BytesIO()
    with tarfile.open(fileobj=written, mode="w:xz") as tar:
        for name, content in (("config.json", json.dumps(CONFIG).encode()), ("pose.onnx", b"none")):
            entry = tarfile.TarInfo(name)
            entry.size = len(content)
            tar.addfile(entry, io.BytesIO(content))
    return written.getvalue()


@pytest.fixture
def hub(monkeypatch, tmp_path):
    """Return a callable that opens a hub which the SDK of a new process asks instead of the maker's."""
    opened = []

    def open_hub(**options):
        opened.append(Hub(**options))
        place = opened[-1].place
        (tmp_path / "sitecustomize.py").write_text(
            "import depthai.modelzoo as zoo\n"
            f"zoo.setDownloadEndpoint({place + '/models'!r})\nzoo.setHealthEndpoint({place + '/health'!r})\n"
        )
        return opened[-1]

    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("DEPTHAI_ZOO_CACHE_PATH", str(tmp_path / "models"))
    yield open_hub
    for one in opened:
        one.close()


def fetched(model=MODEL, say=str, over=lambda: False):
    return oak_camera._archive(model, "RVC2", say, over)


def test_the_first_run_downloads_the_model_and_says_where_it_is_kept_the_next_runs_need_no_network(
    hub, tmp_path
):
    said, first = [], hub()
    assert fetched(say=said.append).getInputWidth() == SHAPE[3]
    assert said == [f"downloading the pose model {MODEL}, once; it is kept in {tmp_path / 'models'}"]
    assert model_folder() == tmp_path / "models"
    assert first.asked.count("/pose.tar.xz") == 1
    first.close()
    assert fetched(say=said.append).getInputWidth() == SHAPE[3]
    assert len(said) == 1


@pytest.mark.parametrize("answer", [0, 404, 500])
def test_a_model_that_is_kept_does_not_wait_for_the_hub_nor_fail_with_it(hub, answer):
    hub()
    fetched()
    later = hub(answer=answer)
    assert fetched().getInputWidth() == SHAPE[3]
    assert later.asked == []


def test_a_download_that_does_not_end_is_given_up_when_the_source_is_closed(hub):
    silent = hub(answer=0)
    asked_at = []

    def over():
        if "/models" in silent.asked:
            asked_at.append(time.monotonic())
        return bool(asked_at)

    with pytest.raises(CameraError, match="was not waited for"):
        fetched(over=over)
    assert time.monotonic() - asked_at[0] < 1


def test_a_model_that_the_hub_does_not_have_is_named(hub):
    hub(answer=404)
    with pytest.raises(CameraError, match=f"the pose model {MODEL} cannot be had .*404") as error:
        fetched()
    assert "\n" not in str(error.value)


def test_without_a_network_it_says_what_to_do(hub):
    hub().close()
    with pytest.raises(
        CameraError, match=r"cannot be had .*; connect to the internet .* oak:\?model=FILE.tar.xz"
    ):
        fetched()


def test_a_folder_that_cannot_be_written_is_named(hub, monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("DEPTHAI_ZOO_CACHE_PATH", str(tmp_path / "file"))
    hub()
    with pytest.raises(
        CameraError, match=rf"cannot be had .*; make {tmp_path}/file a folder that can be written"
    ):
        fetched()


@pytest.mark.parametrize("content", [b"no archive", b""])
def test_a_damaged_model_archive_is_named(tmp_path, content):
    path = tmp_path / "pose.tar.xz"
    path.write_bytes(content)
    with pytest.raises(CameraError, match=r"pose\.tar\.xz cannot be read as a model archive") as error:
        fetched(str(path))
    assert "\n" not in str(error.value)


def test_a_model_archive_of_the_users_own_is_taken(tmp_path):
    path = tmp_path / "pose.tar.xz"
    path.write_bytes(archive())
    assert fetched(str(path)).getInputHeight() == SHAPE[2]
