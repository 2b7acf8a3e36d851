"""Tasks: requests of people, carried out one after another.

viser calls back from a pool of threads, where two presses of a key may read the same number and both add one to it,
and an old place of a slider may overtake a newer one. Here one thread does all of it, in the order of arrival.
"""

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

from mossar_stream import MossarError
from mossar_tools.console import LOGGER


class Tasks:
    """Carries out tasks in the order of the requests. Any thread may call any method.

    Args:
        failed: Called with a line about an error.
    """

    def __init__(self, failed: Callable[[str], None]) -> None:
        self._failed = failed
        self._thread = ThreadPoolExecutor(1, "dashboard tasks")
        self._latest: dict[object, Callable[[], None]] = {}
        self._lock = threading.Lock()

    def ask(self, task: Callable[[], None]) -> "Future[None]":
        """Add a task behind all earlier ones."""
        return self._thread.submit(self._carry_out, task)

    def ask_latest(self, key: object, task: Callable[[], None]) -> "Future[None]":
        """Add a task in place of one with the same key that has not begun."""
        with self._lock:
            self._latest[key] = task
        return self._thread.submit(self._carry_out_latest, key)

    def waits(self, key: object) -> bool:
        """Return whether a task with this key has not begun."""
        return key in self._latest

    def close(self) -> None:
        """Forget tasks that have not begun."""
        self._thread.shutdown(wait=False, cancel_futures=True)

    def _carry_out_latest(self, key: object) -> None:
        with self._lock:
            task = self._latest.pop(key, None)
        if task is not None:
            self._carry_out(task)

    def _carry_out(self, task: Callable[[], None]) -> None:
        try:
            task()
        except MossarError as error:
            self._failed(str(error))
            LOGGER.warning("%s", error)
        except Exception as error:  # noqa: BLE001 - the page goes on, whatever one button does
            self._failed(f"that went wrong: {error}")
            LOGGER.exception("dashboard: %s", error)
