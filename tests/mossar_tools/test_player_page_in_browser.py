"""The page for players and clients in a real browser: without a camera, with one of this computer, and on a phone."""

import os
import re
import threading
import time

import numpy as np
import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.files.msk import MskWriter
from mossar_stream import Moves

from .test_dashboard import ARGUMENTS, CHROMIUM, SOON, address, press, until

SIZES = ((1400, 900), (900, 700), (420, 860))
BRIGHT = """
place => {
    const canvas = document.getElementById("picture")
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data
    const found = [0, 0]
    for (let at = 0; at < pixels.length; at += 4)
        if (pixels[at + place] > 150 && pixels[at + 1] < 90 && pixels[at + 2 - place] < 90)
            found[(at / 4) % canvas.width < canvas.width / 2 ? 0 : 1]++
    return found
}
"""
# Where things lie while the longest texts stand there; the page replaces them soon.
BOXES = """
places => {
    const texts = {note: "only 4 pictures a second", tempo: "112 a minute", time: "1:02:03"}
    for (const [place, text] of Object.entries(texts)) document.getElementById(place).textContent = text
    return Object.fromEntries(places.map(place => [place, document.querySelector(place).getBoundingClientRect().toJSON()]))
}
"""
# Where the figure's own colours lie, as shares of the stage: left, top, right, bottom.
FIGURE = """
() => {
    const canvas = document.getElementById("picture")
    const pen = canvas.getContext("2d")
    const pixels = pen.getImageData(0, 0, canvas.width, canvas.height).data
    const edge = [1, 1, 0, 0]
    for (let y = 0; y < canvas.height; y += 3)
        for (let x = 0; x < canvas.width; x += 3) {
            const at = 4 * (y * canvas.width + x)
            const [red, , blue] = pixels.slice(at, at + 3)
            if (blue - red < 30) continue
            edge[0] = Math.min(edge[0], x / canvas.width)
            edge[1] = Math.min(edge[1], y / canvas.height)
            edge[2] = Math.max(edge[2], x / canvas.width)
            edge[3] = Math.max(edge[3], y / canvas.height)
        }
    return edge
}
"""


@pytest.fixture(scope="module")
def playwright():
    if CHROMIUM is None:
        pytest.skip("needs a browser: apt-get install chromium")
    api = pytest.importorskip("playwright.sync_api", reason="needs pip install playwright")
    with api.sync_playwright() as running:
        yield running


@pytest.fixture(scope="module")
def browser(playwright):
    """A browser without WebGL: emulated by the processor, it would draw the page twice a second."""
    running = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
    yield running
    running.close()


@pytest.fixture
def window_at(browser):
    """Open the page in a new window, and note what goes wrong in it, and where it asks."""
    opened = []

    def open_at(url, size=SIZES[0], scheme="light"):
        context = browser.new_context(
            viewport={"width": size[0], "height": size[1]}, color_scheme=scheme, reduced_motion="reduce"
        )
        window = context.new_page()
        window.problems, window.asked = [], []
        window.on("pageerror", lambda error: window.problems.append(str(error)))
        window.on("request", lambda request: window.asked.append(request.url))
        window.goto(url)
        opened.append(context)
        return window

    yield open_at
    for context in opened:
        context.close()


@pytest.fixture(scope="module")
def squats(tmp_path_factory):
    """A recording of squats, one at a time, for a sender that repeats it."""
    path = tmp_path_factory.mktemp("squats") / "squats.msk"
    url = "demo:?seed=2&moves=" + ",".join(["rest:1", *["squat"] * 100]) + "&seconds=150"
    with MskWriter(path) as writer:
        for item in DemoSource.from_url(url, speed="max").items():
            writer.write(item)
    return path


@pytest.fixture
def taught(mossar, tmp_path):
    source = "demo:?seed=2&moves=rest:2,squat,squat,squat,squat,rest:2"
    given = ("--name", "squat", "--from", "3.4", "--until", "4.6")
    assert mossar("teach", tmp_path / "moves.json", source, *given)[0] == 0
    return tmp_path / "moves.json"


@pytest.fixture
def sent(process, squats, tmp_path):
    """Send squats over OSC to `mossar view`, and return the page's address and what the program says."""

    def start(*given):
        from socket import SOCK_DGRAM, socket

        with socket(type=SOCK_DGRAM) as taken:
            taken.bind(("127.0.0.1", 0))
            port = taken.getsockname()[1]
        url = f"osc://127.0.0.1:{port}"
        running = process("view", url, "--port", "0", "--no-browser", *given, cwd=tmp_path)
        found = address(running)
        threading.Thread(target=running.stderr.read, daemon=True).start()
        process("replay", squats, "--to", f"{url}?profile=mossar", "--loop", stderr=None, stdout=None)
        return found

    return start


def count(window):
    return int(window.text_content("#count") or 0)


def boxes_of(window, *places):
    return {place: box for place, box in window.evaluate(BOXES, places).items() if box["height"] > 0}


def apart(one, other):
    return (
        one["x"] + one["width"] <= other["x"] + 1
        or other["x"] + other["width"] <= one["x"] + 1
        or one["y"] + one["height"] <= other["y"] + 1
        or other["y"] + other["height"] <= one["y"] + 1
    )


def test_a_sender_is_shown_with_one_count_a_ring_and_a_verdict(sent, taught, window_at, tmp_path):
    url, _ = sent("--moves", taught, "--follow", "squat", "--repetitions")
    window = window_at(url)
    until(window, lambda: count(window) >= 1)
    before = count(window)
    until(window, lambda: count(window) > before + 1)
    shares = set()

    def progress():
        shares.add(window.locator("#ring .share").get_attribute("stroke-dasharray").split()[0])
        return len(shares) > 3

    until(window, progress)
    assert window.text_content("#title") == "squat"
    until(window, lambda: re.fullmatch(r"good|.+ \d+° off", window.text_content("#verdict")))
    assert re.fullmatch(r"\d\.\d ×", window.text_content("#tempo"))  # noqa: RUF001 - as it is shown
    assert re.fullmatch(r"\d+:\d\d", window.text_content("#time"))
    text = window.inner_text("body")
    for unwanted in ("times", "done", "stalled", "resumed"):
        assert unwanted not in text
    left, top, right, bottom = window.evaluate(FIGURE)
    assert 0 < left < right < 1  # the whole figure is in view
    assert 0 < top < bottom < 1
    assert bottom - top > 0.4  # and large
    assert window.problems == []
    assert {re.match(r"\w+://([^/:]*)", one)[1] for one in window.asked} == {"127.0.0.1"}
    window.screenshot(path=tmp_path / "page.png")


def test_nothing_lies_over_anything_at_any_size_in_light_and_dark(sent, taught, window_at):
    url, _ = sent("--moves", taught, "--follow", "squat")
    grounds = {}
    for scheme in ("light", "dark"):
        window = window_at(url, scheme=scheme)
        until(window, lambda window=window: count(window) >= 1)
        for width, height in (*SIZES, (360, 740)):
            window.set_viewport_size({"width": width, "height": height})
            boxes = boxes_of(
                window,
                "#stage",
                "#title",
                "#ring",
                "#verdict",
                "#tempo",
                "#time",
                "#note",
                "#teaching",
                "#examples",
                "footer",
            )
            assert {"#stage", "#ring", "#verdict", "#teaching"} <= set(boxes)
            places = list(boxes)
            for k, place in enumerate(places):
                box = boxes[place]
                assert box["x"] >= 0, (width, place)
                assert box["x"] + box["width"] <= width + 1, (width, place)
                for other in places[k + 1 :]:
                    assert apart(box, boxes[other]), (width, scheme, place, other)
            size = window.evaluate(
                "parseFloat(getComputedStyle(document.getElementById('verdict')).fontSize)"
            )
            assert size >= 32
            assert boxes["#ring"]["width"] >= 130
            assert window.evaluate("document.documentElement.scrollWidth") <= width
        grounds[scheme] = window.evaluate("getComputedStyle(document.body).backgroundColor")
    assert grounds["light"] == "rgb(255, 255, 255)"
    assert grounds["dark"] != grounds["light"]
    window.click("#theme")
    assert window.evaluate("getComputedStyle(document.body).backgroundColor") == grounds["light"]


def test_the_dashboard_is_one_click_away_and_the_count_begins_again(sent, taught, window_at, playwright):
    pytest.importorskip("viser", reason="the extra view is not installed")
    url, _ = sent("--moves", taught, "--follow", "squat")
    window = window_at(url)
    until(window, lambda: count(window) >= 8)
    press(window, "Start again")
    until(window, lambda: count(window) < 8)  # a busy machine may miss the 0
    link = window.locator("#dashboard")
    assert link.is_visible()
    drawing = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
    dashboard = drawing.new_page()
    dashboard.goto(link.evaluate("link => link.href"), timeout=SOON)
    dashboard.wait_for_selector("#mossar-chart", timeout=SOON)
    dashboard.wait_for_selector(".m-ring", timeout=SOON)
    drawing.close()
    until(window, lambda: count(window) >= 1)  # the page goes on


def test_a_move_is_taught_on_the_page_and_followed_from_then_on(process, window_at, tmp_path):
    beats = ",".join(["rest:3", "punch_left"] * 60)
    given = ("--page", "player", "--port", "0", "--no-browser", "--moves", "new.json", "--follow", "punch")
    running = process("view", f"demo:?moves={beats}&seed=2", *given, cwd=tmp_path)
    window = window_at(address(running)[0])
    until(window, lambda: window.input_value("#move") == "punch")
    window.evaluate(
        "window.large = new Set(); new MutationObserver(() => large.add(document.querySelector('#countdown b').textContent))"
        ".observe(document.getElementById('countdown'), {childList: true, subtree: true, characterData: true})"
    )
    press(window, "Teach")
    until(window, lambda: "example 1 taken" in window.text_content("#taught"))
    assert {"3", "2", "1"} & set(window.evaluate("[...large]"))  # a busy machine may miss some
    assert len(Moves.load(tmp_path / "new.json")) == 1
    until(window, lambda: window.locator("#examples figure:has(svg path)").count() == 1)
    until(window, lambda: window.text_content("#title") == "punch")  # it is followed
    until(window, lambda: count(window) >= 1)
    until(window, lambda: window.locator("#countdown").is_hidden())
    assert window.locator("#keep").is_hidden()  # nothing is unlike it
    window.locator("#undo").dispatch_event("click")
    until(window, lambda: window.locator("#examples figure").count() == 0)
    assert len(Moves.load(tmp_path / "new.json")) == 0
    assert window.locator("#undo").is_hidden()
    assert window.problems == []


def test_the_page_goes_on_when_the_program_is_started_again(process, window_at, tmp_path):
    source = ("view", "demo:?seed=2", "--page", "player", "--no-browser", "--repetitions")
    running = process(*source, "--port", "0", cwd=tmp_path)
    url = address(running)[0]
    window = window_at(url)
    until(window, lambda: window.text_content("#time") not in {"", "0:00"})
    running.terminate()
    running.wait(60)
    until(window, lambda: "start it again" in window.text_content("#note"))
    again = process(*source, "--port", re.search(r":(\d+)", url[6:])[1], cwd=tmp_path)
    assert address(again)[0] == url
    until(window, lambda: "start it again" not in window.text_content("#note"))


@pytest.fixture
def pipe(tmp_path):
    """A pipe that stands in for a camera: grey pictures, red on the left, with nobody in them."""
    cv2 = pytest.importorskip("cv2", reason="the extra webcam is not installed")
    pytest.importorskip("ai_edge_litert", reason="the extra webcam is not installed")
    from mossar_adapters.pose.weights import kept

    if not hasattr(os, "mkfifo") or kept() is None:
        pytest.skip("the weights are not here: mossar adapters --get-model")
    path = tmp_path / "camera.mjpeg"
    os.mkfifo(path)
    picture = np.full((360, 640, 3), 128, np.uint8)
    picture[:, :320] = (0, 0, 255)
    jpeg = cv2.imencode(".jpg", picture)[1].tobytes()
    ended = threading.Event()

    def write():
        try:
            with path.open("wb") as file:
                while not ended.wait(1 / 25):
                    file.write(jpeg)
                    file.flush()
        except OSError:
            return

    threading.Thread(target=write, daemon=True).start()
    yield path
    ended.set()


def test_a_camera_of_this_computer_is_shown_mirrored_and_only_here(process, pipe, window_at, tmp_path):
    running = process("view", f"webcam:{pipe}", "--port", "0", "--no-browser", cwd=tmp_path)
    window = window_at(address(running)[0])

    def red_on_the_right():
        left, right = window.evaluate(BRIGHT, 0)
        return right > 1000 and left < right / 20

    until(window, red_on_the_right)
    assert window.locator("#camera").is_hidden()  # the browser's own is not asked for
    about = window.evaluate("fetch('/about.json').then(answer => answer.json())")
    assert about["eye"] is None
    assert about["mirrored"]


def test_a_camera_is_shown_to_other_devices_as_a_figure(process, pipe, window_at, tmp_path):
    running = process(
        "view", f"webcam:{pipe}", "--host", "0.0.0.0", "--port", "0", "--no-browser", cwd=tmp_path
    )
    said = ""
    end = time.monotonic() + SOON / 1000
    while "lets in once" not in said:
        assert time.monotonic() < end
        said = running.stderr.readline().decode()
    invitation = re.search(r"http://\S+/\?key=\S+", said)[0]
    if "//127." in invitation:
        pytest.skip("this computer has no address that others reach")
    phone = window_at(invitation, SIZES[2])
    until(phone, lambda: phone.text_content("#note"))
    until(phone, lambda: phone.evaluate("document.getElementById('picture').width > 0"))
    phone.wait_for_timeout(2000)
    assert phone.evaluate(BRIGHT, 0) == [0, 0]  # no picture
    about = phone.evaluate("fetch('/about.json').then(answer => answer.json())")
    assert (about["here"], about["eye"]) == (False, None)
    port = re.search(r":(\d+)/", invitation)[1]
    here = window_at(f"http://127.0.0.1:{port}/")
    until(here, lambda: here.evaluate(BRIGHT, 0)[1] > 1000)
