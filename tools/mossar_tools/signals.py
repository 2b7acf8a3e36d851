"""Signals: Ctrl-C and SIGTERM stop a run in an orderly way; a second one stops it at once."""

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType

from mossar_tools.errors import DONE, INTERRUPTED, TERMINATED, Terminated


class Stop:
    """Remembers which signal came.

    Args:
        ask: Called when the first one comes; must only set flags.
    """

    def __init__(self, ask: Callable[[], None]) -> None:
        self.status = DONE  # exit status that the signal stands for
        self._ask = ask

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal."""
        del frame
        if self.status != DONE:
            _raise(number, None)
        self.status = TERMINATED if number == signal.SIGTERM else INTERRUPTED
        self._ask()


@contextlib.contextmanager
def stopping(ask: Callable[[], None]) -> Iterator[Stop]:
    """Call `ask` on Ctrl-C or SIGTERM while the block runs."""
    stop = Stop(ask)
    with _handled(stop):
        yield stop


@contextlib.contextmanager
def raising() -> Iterator[None]:
    """Turn SIGTERM into an exception, as Ctrl-C is one, while the block runs."""
    with _handled(_raise):
        yield


def _raise(number: int, frame: FrameType | None) -> None:
    del frame
    raise Terminated if number == signal.SIGTERM else KeyboardInterrupt


@contextlib.contextmanager
def _handled(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, former in before.items():
            signal.signal(number, former)
