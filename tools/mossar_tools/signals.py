"""Signals: Ctrl-C and SIGTERM stop a run in an orderly way; a second one stops it at once.

A handler that raises does so wherever the main thread happens to be. In an import, in numba, or in a callback from
LLVM that loses the signal, becomes an error of another kind, or ends the process in a crash; where a thread starts it
becomes one of Python's own locks. So handlers wait until the main thread has left such a place, and what stays there
for long, compiling, is done by another thread.
"""

import _thread
import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Final, TypeVar

from mossar_tools.errors import DONE, INTERRUPTED, TERMINATED, Terminated

T = TypeVar("T")

_AGAIN: Final = 0.02  # s until a signal is looked at again that came at a delicate moment
_LOOK: Final = (
    0.1  # s between two checks whether other work is done; some systems do not wake a waiting thread
)
_STACK: Final = 2**26  # bytes; compilers are recursive, and other threads have little room by default
_DELICATE: Final = ("numba", "llvmlite", "importlib", "_frozen_importlib", "_frozen_importlib_external")
_deferred: list[int] = []  # signals that are looked at again
_abandoned: list[object] = []  # other threads' work that a signal did not wait for


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
    with _handled(_raise):
        try:
            yield
            if _deferred:
                raise _exception(_deferred[0])
        finally:
            _deferred.clear()


def interruptibly(work: Callable[[], T]) -> T:
    """Do something that compiles, in another thread, so that a signal ends the wait for it at once.

    What it returns is returned, what it raises is raised here. A program whose wait was ended must end with `leave`.
    """
    results: list[T] = []
    failures: list[BaseException] = []
    done = threading.Lock()
    done.acquire()

    def run() -> None:
        try:
            results.append(work())
        except BaseException as error:  # noqa: BLE001 - for the thread that waits
            failures.append(error)
        finally:
            _abandoned.remove(run)
            done.release()

    _abandoned.append(run)  # before it starts: a signal may come at any line
    before = threading.stack_size(_STACK)
    try:
        threading.Thread(target=run, daemon=True).start()
    finally:
        threading.stack_size(before)
    while not done.acquire(timeout=_LOOK):
        pass
    if failures:
        raise failures[0]
    return results[0]


def leave(status: int) -> int:
    """Return an exit status; end the process with it if a thread still compiles, which would crash at the usual end."""
    if _abandoned:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
        os._exit(status)
    return status


def _raise(number: int, frame: FrameType | None) -> None:
    if number in _deferred:
        _deferred.remove(number)
    if _is_delicate(frame):
        _deferred.append(number)
        _thread.start_new_thread(
            _signal_again, (number,)
        )  # no lock is taken, which the main thread might hold
        return
    raise _exception(number)


def _exception(number: int) -> BaseException:
    return Terminated() if number == signal.SIGTERM else KeyboardInterrupt()


def _signal_again(number: int) -> None:
    time.sleep(_AGAIN)
    if number not in _deferred:
        return
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, number)  # wakes what waits
    else:
        _thread.interrupt_main(signal.Signals(number))


def _is_delicate(frame: FrameType | None) -> bool:
    """Tell whether an exception in a frame could be lost, or harm a library that calls it."""
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
