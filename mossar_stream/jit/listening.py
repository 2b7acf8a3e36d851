"""Tells when kernels are compiled, which takes seconds; what comes from the disk is loaded without a word."""

import contextlib
from collections.abc import Callable, Iterator

from numba.core import event


class _Listener(event.Listener):
    """Calls once, when compiling begins."""

    def __init__(self, say: Callable[[], None]) -> None:
        self._say: Callable[[], None] | None = say

    def on_start(self, _: object) -> None:
        say, self._say = self._say, None
        if say is not None:
            say()

    def on_end(self, _: object) -> None:
        pass


@contextlib.contextmanager
def on_first_compile(say: Callable[[], None]) -> Iterator[None]:
    """Call `say` once if a kernel is compiled while the block runs, which takes seconds, and as it begins."""
    with event.install_listener("numba:compile", _Listener(say)):
        yield
