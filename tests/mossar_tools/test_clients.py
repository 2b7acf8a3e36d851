"""The clients in `examples/clients` that can run here react to a real `mossar run`; the others say that they were not run."""

import contextlib
import itertools
import re
import shutil
import socket
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest

from checks.run_process import free_port

CLIENTS = Path(__file__).parents[2] / "examples" / "clients"
RUN_HERE = {"browser_game.html", "coach.html", "pure_data.pd"}


def _browser():
    """Return playwright and the browser, or skip."""
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if chromium is None:
        pytest.skip("needs a browser: apt-get install chromium")
    return pytest.importorskip("playwright.sync_api", reason="needs pip install playwright"), chromium


def test_clients_that_were_not_run_say_so():
    for path in CLIENTS.iterdir():
        if path.is_file() and path.suffix != ".md":
            assert ("ot run " in path.read_text()) == (path.name not in RUN_HERE), path
            assert f"`{path.name}`" in (CLIENTS / "README.md").read_text()


def test_every_client_reacts_to_moves_activity_and_steps():
    for path in CLIENTS.iterdir():
        if path.is_file() and path.suffix != ".md" and path.name != "coach.html":  # which is for exercises
            words = set(re.findall(r"\w+", path.read_text()))
            assert {"move", "activity", "key_frame", "step"} <= words, path
            if path.suffix != ".html":  # read by position
                assert {"follow", "pose"} <= words, path


@pytest.fixture
def punches(tmp_path, mossar):
    """A file of moves, and a recording in which the move is made twice; 20 s are repeated."""
    reach = np.zeros((150, 2, 3), np.float32)
    reach[60:90, 1, 0] = np.sin(np.pi * (0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 30))))
    noise = np.random.default_rng(1).normal(0, 0.0005, (600, 2, 3))
    take, moves = tmp_path / "take.npz", tmp_path / "moves.json"
    positions = (np.tile(reach, (4, 1, 1)) + noise).astype(np.float32)
    np.savez(take, positions=positions, fps=30.0, joint_names=["hip", "hand"], parents=[-1, 0])
    assert mossar("teach", moves, take, "--name", "punch", "--unit", "m")[0] == 0
    return ("run", str(take), "--moves", str(moves), "--unit", "m", "--speed", "2")


def test_the_browser_game_reacts_to_a_move(process, punches):
    api, browser_path = _browser()
    port = free_port()
    running = process(*punches, "--to", f"ws://127.0.0.1:{port}")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path, args=["--no-sandbox"])
        page = browser.new_page()
        page.goto(f"file://{CLIENTS / 'browser_game.html'}?ws://127.0.0.1:{port}")
        told = "document.getElementById('says').textContent.includes('punch with the hand')"
        page.wait_for_function(told, timeout=60_000, polling=5)
        browser.close()
    running.kill()


def test_the_browser_game_scores(process):
    api, chromium = _browser()
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


@pytest.fixture
def patch_on(tmp_path):
    """Run the patch on a port; return what it prints, as it comes."""
    pd = shutil.which("pd")
    if pd is None:
        pytest.skip("needs Pure Data: apt-get install puredata-core")
    patch = tmp_path / "patch.pd"

    @contextlib.contextmanager
    def run(port):
        text = (CLIENTS / "pure_data.pd").read_text()
        patch.write_text(text.replace("netreceive -u -b 9000", f"netreceive -u -b {port}"))
        hearing = subprocess.Popen(
            [pd, "-nogui", "-noaudio", "-stderr", "-open", str(patch)],
            stdin=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        watchdog = threading.Timer(100, hearing.kill)
        watchdog.start()
        try:
            yield (line.strip() for line in hearing.stderr)
        finally:
            watchdog.cancel()
            hearing.kill()
            hearing.communicate()

    return run


def test_the_pure_data_patch_hears_key_frames_and_activity(process, patch_on):
    port = free_port(socket.SOCK_DGRAM)
    with patch_on(port) as lines:
        running = process("run", "demo:?seconds=60", "--speed", "4", "--to", f"osc://127.0.0.1:{port}")
        heard = list(itertools.islice((line for line in lines if line.startswith("moved: ")), 4))
        active = next(line for line in lines if line.startswith("activity: "))
        running.kill()
    assert len(heard) == 4
    assert set(heard) <= {f"moved: symbol {kind}" for kind in ("onset", "offset", "minimum")}
    assert active in {"activity: symbol moving", "activity: symbol resting"}


def test_the_pure_data_patch_hears_moves(process, patch_on, punches):
    port = free_port(socket.SOCK_DGRAM)
    with patch_on(port) as lines:
        running = process(*punches, "--to", f"osc://127.0.0.1:{port}")
        heard = next(line for line in lines if line.startswith("move: "))
        running.kill()
    assert heard == "move: symbol punch"


def test_the_pure_data_patch_hears_followed_moves_and_poses(process, patch_on, tmp_path, mossar):
    demo, moves = f"demo:?moves={','.join(['rest:2', 'squat'] * 30)}", tmp_path / "moves.json"
    take = tmp_path / "take.msk"
    assert mossar("record", "demo:?seconds=9&moves=rest:2,squat", take)[0] == 0
    assert mossar("teach", moves, take, "--name", "squat", "--from", "1", "--until", "4.4")[0] == 0
    assert mossar("teach", moves, take, "--pose", "standing", "--from", "0", "--until", "1.5")[0] == 0
    port = free_port(socket.SOCK_DGRAM)
    with patch_on(port) as lines:
        more = ("--moves", str(moves), "--follow", "all", "--speed", "2", "--to", f"osc://127.0.0.1:{port}")
        running = process("run", demo, *more)
        heard = set()
        while len(heard) < 2:
            heard.add(next(line for line in lines if line.startswith(("follow: ", "pose: "))))
        running.kill()
    assert heard == {"follow: symbol squat", "pose: symbol standing"}


def test_the_pure_data_patch_hears_steps(process, patch_on):
    port = free_port(socket.SOCK_DGRAM)
    with patch_on(port) as lines:
        running = process(
            "run", "demo:?seconds=60", "--steps", "--speed", "4", "--to", f"osc://127.0.0.1:{port}"
        )
        heard = set(itertools.islice((line for line in lines if line.startswith("step: ")), 8))
        running.kill()
    assert heard == {"step: symbol left", "step: symbol right"}


def test_the_browser_game_sways_with_steps(process):
    api, chromium = _browser()
    port = free_port()
    running = process("run", "demo:?seconds=60", "--steps", "--speed", "4", "--to", f"ws://127.0.0.1:{port}")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page()
        page.goto(f"file://{CLIENTS / 'browser_game.html'}?ws://127.0.0.1:{port}")
        for margin in ("-12vmin", "-3vmin"):
            told = f"document.getElementById('ball').style.marginLeft === '{margin}'"
            page.wait_for_function(told, timeout=60_000, polling=5)
        browser.close()
    running.kill()


def test_the_coach_shows_ring_and_count_and_names_the_limb_that_strays(process, mossar, tmp_path):
    api, chromium = _browser()
    port, moves = free_port(), tmp_path / "moves.json"
    squats = "demo:?seed=2&moves=rest:1," + ",".join(["squat"] * 60)
    assert mossar("teach", moves, squats, "--name", "squat", "--from", "2.4", "--until", "3.6")[0] == 0
    given = ("--moves", moves, "--follow", "squat", "--speed", "2", "--to", f"ws://127.0.0.1:{port}")
    running = process("run", squats, *given)
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page()
        page.goto(f"file://{CLIENTS / 'coach.html'}?ws://127.0.0.1:{port}")
        page.wait_for_function("Number(document.getElementById('count').textContent) > 1", timeout=60_000)
        ring = "parseFloat(document.getElementById('ring').getAttribute('stroke-dasharray'))"
        for wanted in ("> 30", "=== 0"):
            page.wait_for_function(f"{ring} {wanted}", timeout=60_000, polling=5)
        page.wait_for_function(
            "document.getElementById('says').textContent.includes('score')", timeout=60_000
        )
        assert "p1: squat" in page.text_content("#says")
        limbs = {"left_arm": 4.0, "right_leg": 17.2}
        page.evaluate(
            "limbs => react({type: 'follow', status: 'progress', progress: 0.5, count: 3, limbs})", limbs
        )
        page.screenshot(path=tmp_path / "coach.png")
        browser.close()
    running.kill()
