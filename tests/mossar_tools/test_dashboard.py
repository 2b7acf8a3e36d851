"""The dashboard as people meet it: real processes, a real browser."""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import tomllib
from pathlib import Path

import msgspec
import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.files import open_recording
from mossar_adapters.files.msk import MskWriter
from mossar_adapters.pipeline import Pipeline
from mossar_stream import Settings
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.page import Page

ROOT = Path(__file__).parents[2]
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
ARGUMENTS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
COARSE = "/?fixedDpr=0.25"  # draws few pixels, because here the processor draws them
PRESS_AND_READ = """
mark => {
    mark.dispatchEvent(new PointerEvent("pointerdown", {bubbles: true}))
    return mark.querySelector("title").textContent
}
"""
SOON = 90_000  # ms, for what the page does after a touch; the first picture takes half a minute on a busy machine


@pytest.fixture(scope="module")
def browser():
    if CHROMIUM is None:
        pytest.skip("needs a browser: apt-get install chromium")
    api = pytest.importorskip("playwright.sync_api", reason="needs pip install playwright")
    with api.sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield running
        running.close()


@pytest.fixture
def opened(browser):
    """Open the dashboard in a new window and wait until it shows something."""
    windows = []

    def open_at(url):
        window = browser.new_page(viewport={"width": 840, "height": 680})
        windows.append(window)
        window.goto(url + COARSE)
        window.wait_for_selector("#mossar-kept", timeout=SOON)
        return window

    yield open_at
    for window in windows:
        window.close()


def address(running):
    """Return where a process says that its dashboard is, and what it said before."""
    said = []
    for line in running.stderr:
        said.append(line.decode())
        if found := re.search(r"http://\S+", said[-1]):
            return found[0], said
    raise AssertionError(said)


def number(window, place):
    return int(window.text_content(place))


def frames(window):
    """Return how many frames the statistics tell of."""
    return int(re.search(r"frames([\d,]+)", window.text_content("#mossar-facts"))[1].replace(",", ""))


def until(window, condition, *, seconds=SOON / 1000):
    """Wait until a condition of the page holds."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, window.text_content("body")
        window.wait_for_timeout(100)


def box_of(window, place):
    """Return where something is on the page; again while it is being drawn anew."""
    boxes = []
    until(window, lambda: boxes.append(window.locator(place).first.bounding_box()) or boxes[-1])
    return boxes[-1]


def drag(window, name, share):
    """Drag the slider called so to a share of its width; again if the page moved under the pointer."""
    box = window.locator(f"label:text-is('{name}')").locator("xpath=ancestor::*[.//*[@role='slider']][1]")
    until(window, lambda: drag_once(window, box, share))


def drag_once(window, box, share):
    """Drag a slider and return whether it came along."""
    track = box.locator("[class*=Slider-trackContainer], [class*=Slider-root]").first.bounding_box()
    thumb = box.locator("[role=slider]").first.bounding_box()
    if not (track and thumb):
        return False
    y = thumb["y"] + thumb["height"] / 2
    window.mouse.move(thumb["x"] + thumb["width"] / 2, y)
    window.mouse.down()
    window.mouse.move(track["x"] + share * track["width"], y, steps=8)
    window.mouse.up()
    value, low, high = (
        float(box.locator("[role=slider]").first.get_attribute(f"aria-value{part}"))
        for part in ("now", "min", "max")
    )
    return abs(value - low - share * (high - low)) < 0.1 * (high - low)


def press(window, name):
    # As an event: a click with the pointer waits for two pictures, which take seconds on a busy machine.
    window.locator(f"button:visible:has-text('{name}')").first.dispatch_event("click")


def test_a_live_page_from_the_first_key_frames_to_the_end(process, opened, tmp_path):
    running = process("view", "demo:?seed=3", "--speed", "4", "--port", "0", "--no-browser", cwd=tmp_path)
    window = opened(address(running)[0])
    until(window, lambda: number(window, "#mossar-known") >= 12)
    assert re.search(r"own time\d\.\d\d s", window.text_content("#mossar-facts"))

    press(window, "posture")
    until(window, lambda: number(window, "#mossar-kept") > 8)
    many, before = number(window, "#mossar-kept"), frames(window)
    drag(window, "strength", 0.9)
    until(window, lambda: number(window, "#mossar-kept") < many / 2)
    until(window, lambda: frames(window) > before)
    few = number(window, "#mossar-kept")
    press(window, "posture")
    until(window, lambda: number(window, "#mossar-kept") > few)
    press(window, "motion")
    until(window, lambda: window.locator("button:visible:has-text('● motion')").count())

    press(window, "Record")
    until(window, lambda: window.locator("#mossar-frames").count() and number(window, "#mossar-frames") > 20)
    press(window, "Stop recording")
    recording = open_recording(tmp_path / "recording-1.msk")
    assert sum(len(chunk) for chunk in recording.chunks()) > 20
    assert "Hips" in recording.skeleton.names

    press(window, "Save settings")
    until(window, lambda: "saved" in window.text_content("#mossar-note"))
    saved = tomllib.loads((tmp_path / "mossar-1.toml").read_text())
    assert Settings.build(overrides={**saved["settings"], "level": saved["level"]}).window == 0.1

    assert len(window.screenshot(path=tmp_path / "page.png")) > 20_000
    press(window, "Pause")
    window.wait_for_selector("button:visible:has-text('Go on')", timeout=SOON)
    window.wait_for_timeout(500)
    still = window.inner_html("#mossar-chart svg.plot")
    window.wait_for_timeout(500)
    assert window.inner_html("#mossar-chart svg.plot") == still
    press(window, "Go on")
    until(window, lambda: window.inner_html("#mossar-chart svg.plot") != still)

    running.send_signal(signal.SIGTERM)
    out, err = running.communicate(timeout=20)
    assert (running.returncode, out) == (143, b"")
    assert b"Traceback" not in err


def test_a_recording_has_a_playhead_and_a_number_of_key_frames(process, opened, tmp_path):
    with MskWriter(tmp_path / "take.msk") as writer:
        for item in DemoSource.from_url("demo:?seconds=30&seed=3", speed="max").items():
            writer.write(item)
    running = process("view", tmp_path / "take.msk", "--port", "0", "--no-browser", cwd=tmp_path)
    window = opened(address(running)[0])
    press(window, "Pause")
    window.wait_for_selector("button:visible:has-text('Play')", timeout=SOON)
    window.mouse.click(200, 200)
    for word in ("Pause", "Play"):
        window.keyboard.press("Space")
        window.wait_for_selector(f"button:visible:has-text('{word}')", timeout=SOON)
    drag(window, "position (s)", 0.6)
    until(window, lambda: 12 < float(window.locator(".mossar .big").text_content().split()[0]) < 24)

    box = window.locator("label:text-is('key frames')").locator("xpath=ancestor::*[.//input][1]")
    count = box.locator("input").first
    chosen = int(count.input_value())
    window.mouse.click(200, 200)
    window.keyboard.press("+")
    window.keyboard.press("+")
    until(window, lambda: int(count.input_value()) == chosen + 2)
    window.keyboard.press("-")
    until(window, lambda: int(count.input_value()) == chosen + 1)
    before = number(window, "#mossar-kept")
    drag(window, "key frames", 1.0)
    until(window, lambda: number(window, "#mossar-kept") > before)
    press(window, "cluster")
    until(window, lambda: number(window, "#mossar-kept") <= before)


def test_a_move_that_was_shown_is_followed_with_a_ring_a_count_and_the_example_over_the_body(
    process, opened, tmp_path, mossar
):
    squats = "demo:?seed=2&moves=rest:2,squat,squat,squat,squat,rest:2"
    assert (
        mossar("teach", tmp_path / "m.json", squats, "--name", "squat", "--from", "3.4", "--until", "4.6")[0]
        == 0
    )
    source = "demo:?seed=2&moves=" + ",".join(["rest:1", *["squat"] * 200])
    given = ("--moves", "m.json", "--follow", "squat", "--speed", "0.5", "--port", "0", "--no-browser")
    running = process("view", source, *given, cwd=tmp_path)
    window = opened(address(running)[0])

    def count():
        return int(window.locator(".m-ring text").first.text_content())

    before = count()
    until(window, lambda: count() > before + 1)
    shares = set()

    def progress():
        shares.add(round(float(window.locator(".m-ring").first.get_attribute("data-progress")), 1))
        return len(shares) > 3

    until(window, progress)
    until(window, lambda: "squat" in window.text_content("#mossar-followed"))
    assert window.locator("label:text-is('name')").count()  # further examples may be taught
    assert len(window.screenshot(path=tmp_path / "page.png")) > 20_000


def test_a_recording_on_a_phone_is_seen_and_touched(process, browser, tmp_path):
    with MskWriter(tmp_path / "take.msk") as writer:
        for item in DemoSource.from_url("demo:?seconds=40&seed=3", speed="max").items():
            writer.write(item)
    running = process("view", tmp_path / "take.msk", "--port", "0", "--no-browser", cwd=tmp_path)
    window = browser.new_page(viewport={"width": 390, "height": 800}, accept_downloads=True)
    try:
        window.goto(address(running)[0] + COARSE)
        window.wait_for_selector("#mossar-whole", timeout=SOON)
        for name in ("#mossar-whole", "#mossar-chart"):  # below 760 px the curve was gone
            box = box_of(window, name)
            assert box["x"] >= 0
            assert box["x"] + box["width"] <= 391
            assert 0 <= box["y"] < box["y"] + box["height"] < 400
        press(window, "Pause")
        window.wait_for_selector("button:visible:has-text('Play')", timeout=SOON)
        touch(window, "#mossar-whole svg", 0.75)
        until(window, lambda: 29 <= playhead(window) <= 31)
        touch(window, "#mossar-whole svg", 0.5)
        until(window, lambda: 19 <= playhead(window) <= 21)
        touch(window, "#mossar-chart svg.plot", 0.25)  # the chart shows 5 to 25 s
        until(window, lambda: 9.5 <= playhead(window) <= 10.5)

        press(window, "Play")
        window.wait_for_selector("button:visible:has-text('Pause')", timeout=SOON)
        mark = window.locator("#mossar-chart svg.plot > svg[onpointerdown]:has(.final)").nth(2)
        said = mark.evaluate(PRESS_AND_READ)  # at once: the chart moves on
        time = float(re.search(r"at ([\d.]+) s", said)[1])
        window.wait_for_selector("button:visible:has-text('Play')", timeout=SOON)  # it has stopped there
        until(window, lambda: abs(playhead(window) - time) <= 0.051)

        with window.expect_download(timeout=SOON) as coming:
            press(window, "CSV")
        rows = Path(coming.value.path()).read_text().splitlines()
        assert coming.value.suggested_filename == "take-key-frames.csv"
        assert rows[0].startswith("performer,time,frame")
        assert len(rows) > 40
    finally:
        window.close()


def playhead(window):
    """Return the time that the page says it shows, s."""
    return float(window.locator(".mossar .big").text_content().split()[0])


def touch(window, place, share):
    """Press on a picture at a share of its width; low, because viser's notice of slow graphics hides its upper part."""
    box = box_of(window, place)
    window.mouse.click(box["x"] + share * box["width"], box["y"] + 0.9 * box["height"])


def test_pages_come_go_and_sleep_while_nothing_grows_or_stalls():
    show = LiveShow(Settings())
    source = DemoSource.from_url("demo:?seed=5")
    pipeline = Pipeline([source], [], Settings(), views=[show], tick=lambda: show.tick(pipeline))
    page = Page(show, 0)
    stream = threading.Thread(target=pipeline.run)
    stream.start()
    page.start(open_browser=False)
    try:
        with visitor(page):  # takes what its buffers hold, and nothing after: it sleeps
            sizes = [come_and_go(page) for _ in range(6)]
        assert max(sizes) < sizes[0] + 40
        assert pipeline.inbox.dropped == [0]
        assert all(outlet.dropped == 0 for outlet in pipeline.outlets)
        wait_for(lambda: page.viewers == 0)
    finally:
        pipeline.stop()
        stream.join(20)
        page.close()
    assert not stream.is_alive()


def come_and_go(page):
    """Have two more look at the page for a while; return how many messages the server keeps for newcomers."""
    with visitor(page) as one, visitor(page) as other:
        for _ in range(30):  # all there is, and then what changes
            assert one.recv(timeout=20)
            assert other.recv(timeout=20)
        wait_for(lambda: page.viewers == 3)
    wait_for(lambda: page.viewers == 1)
    return len(page._server._websock_server._broadcast_buffer.message_from_id)


# What a page says first.
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (0.0, 0.0, 0.0),
    "fov": 1.0,
    "near": 0.1,
    "far": 100.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": (0.0, 0.0, -1.0),
    "up_direction": (0.0, 1.0, 0.0),
}


def visitor(page):
    """Return a WebSocket that gets what a page gets."""
    viser = pytest.importorskip("viser")
    client = pytest.importorskip("websockets.sync.client")
    found = client.connect(
        page.url.replace("http", "ws"),
        origin=page.url,
        subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None,
        max_queue=4,
        ping_interval=None,
        close_timeout=1,
    )
    found.send(msgspec.msgpack.encode(CAMERA))
    return found


def wait_for(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture
def waiting(browser):
    """A page that waits for frames, and a window that shows it."""
    page = Page(LiveShow(Settings()), 0)
    page.start(open_browser=False)
    window = browser.new_page(viewport={"width": 1240, "height": 680})
    window.goto(page.url + COARSE)
    window.wait_for_selector("#mossar-level", timeout=SOON)
    yield page, window
    window.close()
    page.close()


def test_the_camera_follows_a_window_that_becomes_narrower(waiting):
    page, window = waiting
    camera = next(iter(page._server.get_clients().values())).camera
    for size in ((840, 680), (600, 680)):
        window.set_viewport_size({"width": size[0], "height": size[1]})
        wanted = page._scene._framed(size)[0]
        until(window, lambda wanted=wanted: camera.position == pytest.approx(wanted, abs=0.02))


def test_controls_follow_the_level_in_force_and_nothing_lies_under_the_scroll_bar(waiting):
    _, window = waiting
    assert window.title() == "mossar"
    active = (
        "() => [...document.querySelectorAll('button')].map(b => b.innerText).filter(t => t.startsWith('●'))"
    )
    until(window, lambda: window.evaluate(active) == ["● motion"])
    sliders = "() => [...document.querySelectorAll('[role=slider]')].map(e => Number(e.ariaValueNow))"
    before = window.evaluate(sliders)
    window.locator("button:has-text('cluster')").click()
    until(window, lambda: window.evaluate(active) == ["● cluster"])
    until(window, lambda: Settings(level="cluster").resolved().window in window.evaluate(sliders))
    assert Settings().resolved().window in before
    rights = """() => {
        const boxes = (where) => [...document.querySelectorAll(where)].map(e => e.getBoundingClientRect());
        const inside = boxes('button, input, .m-card').filter(box => box.width && box.left > innerWidth - 330);
        const bars = boxes('[class*=ScrollArea-thumb]').filter(box => box.left > 0);
        return [Math.max(...inside.map(box => box.right)), Math.min(...bars.map(box => box.left), innerWidth)];
    }"""
    right, bar = window.evaluate(rights)
    assert right <= bar


@pytest.mark.parametrize("rubbish", ["text", b"rubbish", b"\x81\xa4type\xa4None", b"\xc0"])
def test_a_visitor_who_sends_rubbish_is_hung_up_on_without_a_word(rubbish, capfd, caplog):
    page = Page(LiveShow(Settings()), 0)
    try:
        with visitor(page) as sender, visitor(page) as other:
            sender.send(rubbish)
            with pytest.raises(Exception, match="1011"):
                [sender.recv(timeout=20) for _ in range(100)]
            assert other.recv(timeout=20)
    finally:
        page.close()
    assert capfd.readouterr() == ("", "")
    assert caplog.records == []


def test_a_port_in_use_is_said_and_the_next_one_taken(process, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        running = process("view", "demo:", "--port", port, "--no-browser", cwd=tmp_path)
        url, said = address(running)
    assert f"port {port} is in use" in "".join(said)
    assert not url.endswith(f":{port}")


def test_run_with_a_page_keeps_standard_output_to_its_events(process, tmp_path):
    arguments = ("run", "demo:?seconds=2", "--speed", "max", "--view", "--port", "0", "--no-browser")
    out, err = process(*arguments, cwd=tmp_path).communicate(timeout=60)
    assert out.startswith(b'{"type":"stream"')
    assert b"viser" not in out + err


def test_speed_max_leaves_nothing_to_see(mossar, swing):
    status, _, err = mossar("view", swing, "--speed", "max")
    assert (status, err.count("\n")) == (2, 1)


def test_a_recording_whose_events_are_wanted_is_streamed(process, swing, tmp_path):
    arguments = ("view", swing, "--speed", "max", "--to", "events.jsonl", "--port", "0", "--no-browser")
    running = process(*arguments, cwd=tmp_path)
    out, _ = running.communicate(timeout=60)
    assert (running.returncode, out) == (0, b"")
    assert "key_frame" in (tmp_path / "events.jsonl").read_text()


def test_without_viser_one_line_says_what_to_install():
    program = """
import importlib.machinery, sys
found = importlib.machinery.PathFinder.find_spec
importlib.machinery.PathFinder.find_spec = lambda name, *rest: None if name == "viser" else found(name, *rest)
from mossar_tools.cli import main
sys.exit(main(["view", "demo:", "--no-browser"]))
"""
    paths = os.pathsep.join(str(ROOT / name) for name in ("", "adapters", "tools"))
    ended = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        check=False,
    )
    assert ended.returncode == 2
    assert ended.stderr == b"mossar: error: the dashboard needs an extra: pip install 'mossar-stream[view]'\n"
