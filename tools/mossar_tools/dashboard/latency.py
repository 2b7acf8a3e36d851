"""Latency: what the dashboard costs a stream, measured. `python -m mossar_tools.dashboard.latency`.

Three runs of the built-in performer at 60 fps: without a page, with a page that nobody looks at, and with a browser
that does, kept on another core where the system lets us. The delay of a frame is the time from its leaving the
source until it has been segmented and handed to a sink.
"""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mossar_adapters.demo import DemoSource
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.source import Meta
from mossar_stream import Frames, MossarError, Settings
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.page import Page

SECONDS = 20.0  # of each run, unless the first argument says otherwise
SETTLED = 3.0  # s at the beginning that are not counted
_START = 60.0  # s given to the browser, at most
_BROWSERS = ("chromium", "chromium-browser", "google-chrome")
_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--window-size=1440,900",
)


class Stopwatch:
    """Stands on both sides of a pipeline: implements `Source` around another, and `FrameSink`."""

    def __init__(self, source: DemoSource) -> None:
        self.name, self.live = source.name, source.live
        self.delays: list[float] = []  # s, of each frame
        self._source = source
        self._left: deque[float] = deque()  # monotonic s at which frames left

    def items(self) -> Iterator[Meta | Frames | None]:
        """Pass items on and take the time."""
        for item in self._source.items():
            if isinstance(item, Frames):
                self._left.extend([time.monotonic()] * len(item))
            yield item

    def announce(self, meta: Meta) -> None:
        """Do nothing."""

    def send_frames(self, frames: Frames) -> None:
        """Take the time again."""
        now = time.monotonic()
        self.delays += [now - self._left.popleft() for _ in range(len(frames))]

    def close(self) -> None:
        """End the source."""
        self._source.close()


def measure(seconds: float, *, page: bool, browser: str | None = None) -> str:
    """Return median and 99th percentile of the delays, and what was lost, as a line.

    Args:
        seconds: How long to measure.
        page: Whether there is a dashboard.
        browser: Program that looks at it; None for nobody.
    """
    show = LiveShow(Settings())
    watch = Stopwatch(DemoSource.from_url("demo:?seed=3"))
    pipeline = Pipeline(
        [watch],
        [watch],
        Settings(),
        views=[show] if page else [],
        tick=lambda: show.tick(pipeline) if page else None,
    )
    with contextlib.ExitStack() as opened:
        if page:
            served = Page(show, 0)
            opened.callback(served.close)
            served.start(open_browser=False)
            if browser is not None:
                opened.enter_context(_looking(browser, served.url))
                _wait_for(served)
        stream = threading.Thread(target=pipeline.run)
        stream.start()
        time.sleep(SETTLED)
        first = len(watch.delays)
        time.sleep(seconds)
        viewers = served.viewers if page else 0
        pipeline.stop()
        stream.join()
    median, high = np.quantile(watch.delays[first:], (0.5, 0.99)) * 1000
    lost = pipeline.inbox.dropped[0] + sum(outlet.dropped for outlet in pipeline.outlets)
    return f"median {median:.3f} ms, 99 % {high:.2f} ms, {len(watch.delays) - first} frames, {lost} lost, {viewers} looking"


@contextlib.contextmanager
def _looking(browser: str, url: str) -> Iterator[None]:
    """Have a browser look at the page while the block runs, on the last core."""
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    pinned = ["taskset", "-c", str(cores[-1])] if len(cores) > 1 and shutil.which("taskset") else []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [*pinned, browser, *_FLAGS, f"--user-data-dir={profile}", url]
        running = subprocess.Popen(  # noqa: S603 - a browser found on this computer
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
        )
        if pinned:
            _keep_to(cores[:-1])
        try:
            yield
        finally:
            os.killpg(running.pid, signal.SIGTERM)
            running.wait()
            if pinned:
                _keep_to(cores)


def _wait_for(page: Page) -> None:
    """Wait until somebody looks, so that what is measured is what it says."""
    end = time.monotonic() + _START
    while not page.viewers:
        if time.monotonic() > end:
            raise MossarError(f"the browser did not open the dashboard within {_START:.0f} s")
        time.sleep(0.1)


def _keep_to(cores: list[int]) -> None:
    """Keep all threads of this process to some cores; those to come inherit it."""
    for thread in Path("/proc/self/task").iterdir():
        with contextlib.suppress(ProcessLookupError):
            os.sched_setaffinity(int(thread.name), cores)


def main() -> None:
    """Measure and print."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else SECONDS
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    print("no page:            ", measure(seconds, page=False))
    print("page, nobody looks: ", measure(seconds, page=True))
    if browser is None:
        print("page in a browser:   not measured, no chromium is installed")
    else:
        print("page in a browser:  ", measure(seconds, page=True, browser=browser))


if __name__ == "__main__":
    main()
