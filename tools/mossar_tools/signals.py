"""Signals: Ctrl-C and SIGTERM stop a run in an orderly way; a second one stops it at once.

A handler that raises does so wherever the main thread happens to be. In an import or a finalizer that loses the signal,
or becomes an error of another kind; where a thread starts it breaks one of Python's own locks. So handlers wait until the
main thread has left such a place. Exceptions that are raised elsewhere can be discarded: Python discards those of callbacks
of weak references and of the garbage collector. Extensions in C discard those of Python code that they call, such as the
hash of a key. Then the signal comes again.
"""

import _thread
import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Final

from mossar_tools.errors import DONE, INTERRUPTED, TERMINATED, Terminated

_AGAIN: Final = 0.02  # s until a signal that came at a delicate moment is handled
_DELICATE: Final = ("importlib", "_frozen_importlib", "_frozen_importlib_external")
_deferred: list[int] = []  # signals that are to be handled again
_awaited: list[None] = []  # one for each block that waits for the exceptions of signals


class _Raised(BaseException):
    """An exception of a signal; the signal comes again if it is discarded before it leaves the block that awaits it."""

    number: int

    def __del__(self) -> None:
        if _awaited:
            _defer(self.number)


class _Interrupted(KeyboardInterrupt, _Raised):
    number = signal.SIGINT


class _Terminated(Terminated, _Raised):
    number = signal.SIGTERM


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
        if self.status != DONE:
            _raise(number, frame)
            return
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
    with _handled(_raise), _discarded_in_silence():
        _awaited.append(None)
        try:
            yield
            if _deferred:
                raise _exception(_deferred[0])
        finally:
            _awaited.pop()
            _deferred.clear()


def _raise(number: int, frame: FrameType | None) -> None:
    if number in _deferred:
        _deferred.remove(number)
    if _is_delicate(frame):
        _defer(number)
        return
    raise _exception(number)


def _defer(number: int) -> None:
    _deferred.append(number)
    _thread.start_new_thread(_signal_again, (number,))  # no lock is taken, which the main thread might hold


@contextlib.contextmanager
def _discarded_in_silence() -> Iterator[None]:
    """Say nothing of exceptions of signals that Python discards, while the block runs."""
    before = sys.unraisablehook

    def hook(unraisable: "sys.UnraisableHookArgs") -> None:
        if not issubclass(unraisable.exc_type, _Raised):
            before(unraisable)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


def _exception(number: int) -> BaseException:
    return _Terminated() if number == signal.SIGTERM else _Interrupted()


def _signal_again(number: int) -> None:
    time.sleep(_AGAIN)
    if number not in _deferred:
        return
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, number)  # wakes waiting calls
    else:
        _thread.interrupt_main(signal.Signals(number))


def _is_delicate(frame: FrameType | None) -> bool:
    """Return whether an exception in a frame could be lost, or harm a library that calls it."""
    while frame is not None:
        module = frame.f_globals.get("__name__") or ""
        name = frame.f_code.co_name
        if (
            module.partition(".")[0] in _DELICATE
            or name == "__del__"
            or (module, name) == ("threading", "start")
        ):
            return True
        frame = frame.f_back
    return False


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
