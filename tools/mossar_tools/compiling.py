"""Compiling: kernels are compiled before the work begins, and how far that is is logged."""

import contextlib
import threading
import time
from collections.abc import Callable, Iterator

import mossar_stream
from mossar_stream import Settings
from mossar_tools.console import LOGGER
from mossar_tools.signals import interruptibly

MEASURED = "20 to 60"  # s, for one set of options on two cores, idle and busy
_EVERY = 10.0  # s between two messages

Tell = Callable[[str], None]


def tell_nobody(_text: str) -> None:
    """Do nothing with what is logged."""


class Compiling:
    """Logs, from the first kernel that must be compiled on, which part of how many is being compiled.

    Args:
        tell: Gets what is logged, too, and an empty text at the end.

    Attributes:
        is_cold: Whether something had to be compiled.
    """

    def __init__(self, tell: Tell = tell_nobody) -> None:
        self._tell = tell
        self.is_cold = False
        self._part = ""
        self._began = 0.0  # monotonic s
        self._ended = threading.Event()

    def part(self, name: str, done: int, parts: int) -> None:
        """Take note of the next part; see `mossar_stream.precompile`."""
        self._part = f"{name}, part {done + 1} of {parts}"
        if self.is_cold:
            self._say()

    def begin(self) -> None:
        """Take note that a kernel must be compiled."""
        self.is_cold = True
        self._began = time.monotonic()
        self._log(f"compiling kernels (once for each installation, {MEASURED} s)")
        threading.Thread(target=self._go_on_saying, name="compiling", daemon=True).start()

    def end(self, *, is_complete: bool = True) -> None:
        """Say how long it took, if there was anything to compile and nothing interrupted it."""
        if self.is_cold and not self._ended.is_set():
            if is_complete:
                LOGGER.info("kernels compiled, %.0f s", time.monotonic() - self._began)
            self._tell("")
        self._ended.set()

    def _go_on_saying(self) -> None:
        while not self._ended.wait(_EVERY):
            self._say()

    def _say(self) -> None:
        self._log(f"compiling kernels: {self._part}, {time.monotonic() - self._began:.0f} s")

    def _log(self, text: str) -> None:
        LOGGER.info("%s", text)
        if not self._ended.is_set():
            self._tell(text)


@contextlib.contextmanager
def reporting_compilation(
    settings: Settings | None = None, *, moves: bool = False, tell: Tell = tell_nobody
) -> Iterator[Compiling]:
    """Compile, or load, the kernels before the block runs; log it if they, or others in the block, are compiled.

    Args:
        settings: See `mossar_stream.precompile`.
        moves: Whether moves are recognised.
        tell: See `Compiling`.
    """
    said = Compiling(tell)
    is_complete = False
    with mossar_stream.on_first_compile(said.begin):
        try:
            interruptibly(lambda: mossar_stream.precompile(settings, moves=moves, progress=said.part))
            is_complete = True
        finally:
            said.end(is_complete=is_complete)
        yield said
