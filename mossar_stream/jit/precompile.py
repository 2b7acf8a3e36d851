"""Other processes that compile some kernels while this one compiles others, so that two cores are used.

Compiling holds the interpreter lock, so threads would not help. The others are plain interpreters that are told what
to compile; they leave the kernels in the cache on disk. Nothing depends on them: what they do not leave there is
compiled here.
"""

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from mossar_stream.jit.cache import Cache, open_cache
from mossar_stream.jit.listening import on_first_compile

LONGEST_WAIT = 120.0  # s; a process that takes longer is given up
_PROGRAM = """
import os, sys, _thread
def end_with_parent():
    os.read(0, 1)
    os._exit(1)
_thread.start_new_thread(end_with_parent, ())
sys.path[:] = sys.argv[3:]
import {module}
{module}.compile_part(sys.argv[1], sys.argv[2])
os._exit(0)
"""


@contextlib.contextmanager
def other_processes(module: str, parts: Sequence[str]) -> Iterator[None]:
    """Have parts compiled by other processes if, and as soon as, a kernel is compiled while the block runs.

    The block ends when the others have. If everything is loaded from the cache there are none.

    Args:
        module: That has `compile_part(folder, part)`.
        parts: One for each process.
    """
    others: list[subprocess.Popen[bytes]] = []
    cache = open_cache()

    def start() -> None:
        if is_possible(cache):
            with contextlib.suppress(OSError):  # processes may be forbidden
                others.extend(_interpreter(module, cache, part) for part in parts)

    try:
        with on_first_compile(start):
            yield
        for other in others:
            with contextlib.suppress(subprocess.TimeoutExpired):
                other.wait(LONGEST_WAIT)
    finally:
        for other in others:
            other.kill()
            other.communicate()


def is_possible(cache: Cache) -> bool:
    """Tell whether another process could help: a second core, a cache that it shares, an interpreter to run.

    In a program that embeds or freezes Python `sys.executable` is that program, which must not be started again.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    is_interpreter = Path(sys.executable or "").name.lower().startswith("python")
    return cores > 1 and cache.lasts and is_interpreter and not getattr(sys, "frozen", False)


def _interpreter(module: str, cache: Cache, part: str) -> subprocess.Popen[bytes]:
    """Start an interpreter that finds the same modules, says nothing, and ends when this process does."""
    return subprocess.Popen(  # noqa: S603 - our own interpreter
        [sys.executable, "-I", "-c", _PROGRAM.format(module=module), str(cache.folder), part, *sys.path],
        stdin=subprocess.PIPE,  # which closes however this process ends
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    )
