"""What the tests of live adapters share: a way to hear a source out, third-party programs, recordings."""

import shutil
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.source import Meta
from mossar_stream import (
    ActivityEvent,
    Frames,
    KeyFrameEvent,
    MoveEvent,
    Moves,
    Segmenter,
    SegmentEvent,
    Settings,
)

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data"
PEERS = Path(__file__).parent / "peers"


class Heard:
    """What a source yielded."""

    def __init__(self):
        self.items = []
        self.quiet = 0

    @property
    def metas(self):
        return [item for item in self.items if isinstance(item, Meta)]

    def frames(self, performer="p1"):
        return [item for item in self.items if isinstance(item, Frames) and item.performer == performer]

    def positions(self, performer="p1"):
        return np.concatenate([item.positions for item in self.frames(performer)])

    def times(self, performer="p1"):
        return np.concatenate([item.times for item in self.frames(performer)])

    def count(self, performer="p1"):
        return sum(len(item) for item in self.frames(performer))

    def performers(self):
        return sorted({item.performer for item in self.items if item is not None})


@pytest.fixture
def hear():
    """Run a source on a thread while `send` sends; close it when nothing has come for a while."""

    def run(source, send: Callable[[], object], quiet: int = 2, limit: float = 20.0):
        heard = Heard()
        sent = threading.Event()
        failures = []

        def listen():
            try:
                for item in source.items():
                    heard.quiet = heard.quiet + 1 if item is None and sent.is_set() else 0
                    if item is not None:
                        heard.items.append(item)
                    if heard.quiet >= quiet:
                        return
            except Exception as error:  # noqa: BLE001 - the test's thread raises it again
                failures.append(error)

        thread = threading.Thread(target=listen, daemon=True)
        thread.start()
        try:
            send()
        finally:
            sent.set()
            deadline = time.monotonic() + limit
            thread.join(limit)
            source.close()
            thread.join(2)
        assert time.monotonic() < deadline, "the source did not become quiet"
        assert not thread.is_alive()
        if failures:
            raise failures[0]
        return heard

    return run


@pytest.fixture(scope="session")
def program():
    """Return the path of a program, or skip and say how to install it."""

    def find(name, package):
        path = shutil.which(name)
        if path is None:
            pytest.skip(f"{name} is not installed: apt-get install {package}")
        return path

    return find


@pytest.fixture(scope="session")
def node(program):
    """Return a function that runs a script of tests/mossar_adapters/peers with its npm packages."""
    runtime = program("node", "nodejs npm")
    if not (PEERS / "node_modules").is_dir():
        pytest.skip("npm packages are not installed: npm install --prefix tests/mossar_adapters/peers")

    def start(script, *arguments):
        return subprocess.Popen(
            [runtime, str(PEERS / script), *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    return start


@pytest.fixture(scope="session")
def data():
    """Return the folder of recordings, or skip."""
    if not DATA.is_dir():
        pytest.skip(f"no recordings at {DATA}")
    return DATA


@pytest.fixture(scope="session")
def told():
    """The events of a built-in performer with limbs and moves, key frames and segments of limbs and moves among them."""
    meta, *chunks = DemoSource.from_url("demo:?seconds=6", speed="max").items()
    positions = np.concatenate([chunk.positions for chunk in chunks])
    times = np.concatenate([chunk.times for chunk in chunks])
    moves = Moves(meta.skeleton)
    moves.add("some", positions[200:260], 60.0)
    segmenter = Segmenter(meta.skeleton, Settings(limbs=True), fps=60.0, moves=moves)
    events = [*segmenter.push(positions, times), *segmenter.end_take()]
    kinds = {(type(event), getattr(event, "channel", "body") != "body") for event in events}
    assert {(KeyFrameEvent, True), (SegmentEvent, True), (MoveEvent, False)} <= kinds
    assert {(ActivityEvent, False), (ActivityEvent, True)} <= kinds
    return events
