"""Rounds: the thread that draws a page, again and again."""

import threading
import time
from collections.abc import Callable

from mossar_tools.console import LOGGER


class Rounds:
    """Calls a function until it is closed, in a thread of its own.

    An error is logged once, and the next round may succeed. A round is followed by a rest at least as long, so
    that drawing never takes more than half of a core.

    Args:
        draw: Called with the number of the round, from 0.
        rate: Rounds a second at most.
        name: Of the thread, and in messages.
    """

    def __init__(self, draw: Callable[[int], None], rate: float, name: str) -> None:
        self._draw, self._rate, self._name = draw, rate, name
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def close(self) -> None:
        """End after the round that is under way. May be called twice."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(2.0)

    def _run(self) -> None:
        rounds, failed = 0, False
        while not self._stop.is_set():
            began = time.monotonic()
            try:
                self._draw(rounds)
            except Exception as error:  # noqa: BLE001 - the stream matters more than its picture
                if not failed:
                    LOGGER.exception("%s: %s", self._name, error)
                failed = True
            rounds += 1
            taken = time.monotonic() - began
            self._stop.wait(max(1.0 / self._rate - taken, taken))
