"""The folder People of the dashboard: who is in which slot, pinned and exchanged in a browser."""

import json
import threading

import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.demo import DemoSource
from mossar_adapters.demo.body import SKELETON
from mossar_adapters.source import Meta
from mossar_adapters.zeromq.sink import ZmqFrameSink
from mossar_stream import Frames, Settings
from mossar_tools.dashboard.live import LiveShow

from .test_dashboard import address, browser, opened, press, until  # noqa: F401 - fixtures
from .test_dashboard_teaching import DRAW_NOTHING

FPS = 60


@pytest.fixture
def two_people():
    """Return the address of two people who move, as `p7` and `p9`, until the test ends."""
    sink = ZmqFrameSink(parse_url("zmq+bind://127.0.0.1:0?encoding=json"))
    found = []
    for seed in (1, 2):
        source = DemoSource.from_url(f"demo:?seed={seed}&seconds=300", speed="max")
        motion = np.concatenate([f.positions for f in source.items() if isinstance(f, Frames)])
        found.append((0.9, 1.1)[seed - 1] * motion + np.float32([2 * seed, 0, 3]))
    over = threading.Event()

    def perform():
        names = ("p7", "p9")
        for i in range(0, len(found[0]), 3):
            if i % 30 == 0:  # who subscribes late hears it as well
                for name in names:
                    sink.announce(Meta(name, SKELETON, FPS))
            for name, motion in zip(names, found, strict=True):
                sink.send_frames(Frames(motion[i : i + 3], np.arange(i, i + 3) / FPS, performer=name))
            if over.wait(3 / FPS):
                return

    thread = threading.Thread(target=perform)
    thread.start()
    yield sink.endpoint.replace("tcp://", "zmq://")
    over.set()
    thread.join()
    sink.close()


def test_a_browser_pins_and_exchanges_slots(process, opened, two_people, tmp_path):  # noqa: F811
    events = tmp_path / "events.jsonl"
    arguments = ("view", two_people, "--people", "2", "--port", "0", "--no-browser", "--to", events)
    window = opened(address(process(*arguments, cwd=tmp_path))[0])
    window.evaluate(DRAW_NOTHING)

    def people():
        return window.locator("#mossar-people").inner_text().splitlines()

    until(window, lambda: len(people()) == 2)
    before = dict(line.split(": ") for line in people())
    assert {*before} == {"p1", "p2"}
    assert {*before.values()} == {"id 7", "id 9"}

    press(window, "Pin")
    until(window, lambda: people()[0] == f"p1: {before['p1']}, pinned")
    press(window, "Unpin")
    until(window, lambda: people()[0] == f"p1: {before['p1']}")

    press(window, "Exchange")
    until(window, lambda: people() == [f"p1: {before['p2']}", f"p2: {before['p1']}"])

    def reasons():
        found = [json.loads(line) for line in events.read_text().splitlines()]
        return [
            (event["performer"], event["reason"])
            for event in found
            if event["type"] == "stream" and event["event"] == "started"
        ]

    until(window, lambda: len(reasons()) == 4)
    assert sorted(reasons()[:2]) == [("p1", before["p1"]), ("p2", before["p2"])]
    assert sorted(slot for slot, _ in reasons()[2:]) == ["p1", "p2"]
    assert all(before["p2" if slot == "p1" else "p1"] in reason for slot, reason in reasons()[2:])


def test_slots_of_several_sources_are_listed_in_order(monkeypatch):
    found = {"one": [{"slot": "p10"}, {"slot": "p2"}], "other": [{"slot": "p1"}]}
    monkeypatch.setattr("mossar_tools.dashboard.live.slots_by_source", lambda _: found)
    show = LiveShow(Settings(), has_people=True)
    assert show.people == [], "before there is a pipeline"
    show._pipeline = object()
    assert [row["slot"] for row in show.people] == ["p1", "p2", "p10"]
