"""Processes that compile on the plain path take turns, one kernel each.

Numba's own cache calls the files of a kernel 1, 2 and so on, as the index says when it looks: two processes that compile
a kernel for different types at the same time would take the same name, and one would later run the other one's code.
The accelerated path has names of its own (`sturdy_cache.py`); this one uses what numba documents and nothing else, the
event that tells when its compiler lock is taken. Numba holds that lock while it looks into the cache, compiles and
writes; so does a process its turn.
"""

import contextlib
import importlib
import os
import threading
import time
from pathlib import Path
from types import ModuleType
from typing import Any

from numba.core import event

LONGEST = 600.0  # s; who takes longer has been stopped, and is no longer waited for
_LOOK = 0.02  # s between two looks at whether it is our turn


def system_locks() -> ModuleType | None:
    """Return the module that locks files for this process, None where there is none."""
    try:
        return importlib.import_module("fcntl")
    except ImportError:  # Windows
        return None


def take_turns(folder: Path, locks: ModuleType, longest: float = LONGEST) -> None:
    """Let this process compile and load kernels only when no other one that shares a folder does, from now on.

    Args:
        folder: Of the kernels.
        locks: Of `system_locks`.
        longest: s that another process is waited for.
    """
    event.register("numba:compiler_lock", _Turn(folder / "turn", locks, longest))


class _Turn(event.Listener):
    """Holds a file locked while any thread of this process holds numba's compiler lock, or waits for it."""

    def __init__(self, path: Path, locks: ModuleType, longest: float) -> None:
        self._path, self._locks, self._longest = path, locks, longest
        self._depth = 0
        self._file = -1
        self._lock = threading.Lock()  # who waits for our turn keeps the other threads waiting

    def on_start(self, _: Any) -> None:
        with self._lock:
            self._depth += 1
            if self._depth == 1:
                self._begin()

    def on_end(self, _: Any) -> None:
        with self._lock:
            self._depth -= 1
            if self._depth == 0 and self._file >= 0:
                os.close(self._file)  # which unlocks it
                self._file = -1

    def _begin(self) -> None:
        # Without a lock (a disk that has none, a folder that is gone) kernels are compiled all the same.
        with contextlib.suppress(OSError):
            self._file = os.open(self._path, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
            give_up = time.monotonic() + self._longest
            while not self._is_ours():
                if time.monotonic() > give_up:
                    self._longest = 0.0  # nor for the next kernel
                    break
                time.sleep(_LOOK)

    def _is_ours(self) -> bool:
        try:
            self._locks.flock(self._file, self._locks.LOCK_EX | self._locks.LOCK_NB)
        except BlockingIOError:
            return False
        return True
