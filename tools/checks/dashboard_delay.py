"""Dashboard delay: the cost of the dashboard for a stream, measured. `python -m checks.dashboard_delay`.

Three runs of the built-in performer at 60 fps: without a page, with a page without a browser, and with a browser,
kept on another core where the system allows it. The delay of a frame is the time from its leaving the
source until it has been segmented and handed to a sink.
"""

import argparse
import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from mossar_adapters.demo import DemoSource
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.source import Meta
from mossar_stream import Frames, MossarError, Settings
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.page import Page

SECONDS = 20.0  # of each run
SETTLED = 3.0  # s at the beginning that are not counted
_START = 60.0  # s that the browser, and the stream, may take to begin
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
    """Return median and 99th percentile of the delays, and the losses, as a line.

    Args:
        seconds: How long to measure.
        page: Whether there is a dashboard.
        browser: Program that shows it; None for none.
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
                _wait(lambda: served.viewers > 0, "the browser opens the dashboard")
        stream = threading.Thread(target=pipeline.run)
        stream.start()
        _wait(lambda: bool(watch.delays), "frames come")
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


def _wait(condition: Callable[[], bool], what: str) -> None:
    """Wait until a condition holds, so that the measurement begins in the stated state."""
    end = time.monotonic() + _START
    while not condition():
        if time.monotonic() > end:
            raise MossarError(f"{_START:.0f} s were not enough until {what}")
        time.sleep(0.05)


def _keep_to(cores: list[int]) -> None:
    """Keep all threads of this process to some cores; those to come inherit it."""
    for thread in Path("/proc/self/task").iterdir():
        with contextlib.suppress(ProcessLookupError):
            os.sched_setaffinity(int(thread.name), cores)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=SECONDS, metavar="S", help="of each run")
    seconds = parser.parse_args().seconds
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    print("no page:            ", measure(seconds, page=False))
    print("page, nobody looks: ", measure(seconds, page=True))
    if browser is None:
        print("page in a browser:   not measured, no chromium is installed")
    else:
        print("page in a browser:  ", measure(seconds, page=True, browser=browser))


if __name__ == "__main__":
    main()
