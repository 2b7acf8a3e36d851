"""The clients in `examples/clients` that can run here react to a real `mossar run`; the others say that they were not run."""

import shutil
import socket
import subprocess
import threading
from pathlib import Path

import pytest

from checks.run_process import free_port

CLIENTS = Path(__file__).parents[2] / "examples" / "clients"
RUN_HERE = {"browser_game.html", "pure_data.pd"}


def test_clients_that_were_not_run_say_so():
    for path in CLIENTS.iterdir():
        if path.is_file() and path.suffix != ".md":
            assert ("ot run " in path.read_text()) == (path.name not in RUN_HERE), path
            assert f"`{path.name}`" in (CLIENTS / "README.md").read_text()


def test_the_browser_game_scores(process):
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if chromium is None:
        pytest.skip("needs a browser: apt-get install chromium")
    api = pytest.importorskip("playwright.sync_api", reason="needs pip install playwright")
    port = free_port()
    running = process("run", "demo:?seconds=60", "--speed", "4", "--to", f"ws://127.0.0.1:{port}")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page()
        page.goto(f"file://{CLIENTS / 'browser_game.html'}?ws://127.0.0.1:{port}")
        page.wait_for_function("Number(document.getElementById('score').textContent) > 0", timeout=100_000)
        assert "p1" in page.text_content("#says")
        browser.close()
    running.kill()


def test_the_pure_data_patch_hears_key_frames(process, tmp_path):
    pd = shutil.which("pd")
    if pd is None:
        pytest.skip("needs Pure Data: apt-get install puredata-core")
    port = free_port(socket.SOCK_DGRAM)
    patch = tmp_path / "patch.pd"
    patch.write_text(
        (CLIENTS / "pure_data.pd").read_text().replace("netreceive -u -b 9000", f"netreceive -u -b {port}")
    )
    hearing = subprocess.Popen(
        [pd, "-nogui", "-noaudio", "-stderr", "-open", str(patch)],
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    running = process("run", "demo:?seconds=60", "--speed", "4", "--to", f"osc://127.0.0.1:{port}")
    watchdog = threading.Timer(100, hearing.kill)
    watchdog.start()
    heard = []
    for line in hearing.stderr:
        heard += [line.strip()] if line.startswith("moved: ") else []
        if len(heard) == 4:
            break
    watchdog.cancel()
    running.kill()
    hearing.kill()
    hearing.communicate()
    assert len(heard) == 4
    assert set(heard) <= {f"moved: symbol {kind}" for kind in ("onset", "offset", "minimum")}
