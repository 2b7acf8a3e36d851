"""Measure: the memory, files and threads of a process."""

import ctypes
import gc
import os
import statistics
import threading
from pathlib import Path

import msgspec

_MOST_HEAPS = -8  # M_ARENA_MAX of malloc.h
_PAGE = os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else 4096


class Sample(msgspec.Struct, frozen=True):
    """Resources of the process at a moment.

    Args:
        seconds: Since the start.
        frames: Taken by the pipeline.
        memory: Bytes.
        files: Open file handles.
        threads: Running threads.
        median_ms: Latency, ms.
        high_ms: Its 99th percentile, ms.
    """

    seconds: float
    frames: int
    memory: int
    files: int
    threads: int
    median_ms: float
    high_ms: float


def measure_exactly() -> None:
    """Let all threads of glibc share one heap: with one each, holes come and go by megabytes. Before any thread starts."""
    allow = getattr(ctypes.CDLL(None), "mallopt", None)
    if allow is not None:
        allow(_MOST_HEAPS, 1)


def memory() -> int:
    """Return the memory that the process holds (resident set), without glibc's unused reserve, bytes."""
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * _PAGE


def files() -> int:
    """Return the number of open file handles."""
    return len(list(Path("/proc/self/fd").iterdir()))


def threads() -> int:
    """Return the number of running threads."""
    return threading.active_count()


class Held(msgspec.Struct, frozen=True):
    """Resources of a process during a part of the time.

    Memory and threads are medians, as both come and go. Of file handles it is the most: a server that hangs up on its
    idle clients frees dozens for a moment, and a busy machine may see many such moments.
    """

    memory: int
    files: int
    threads: int


def early_and_late(samples: list[Sample]) -> tuple[Held, Held]:
    """Return the resources in the second fifth of the time and in the last; in the first one caches fill."""
    fifth = max(1, len(samples) // 5)
    return _held(samples[fifth : 2 * fifth] or samples), _held(samples[-fifth:])


def _held(samples: list[Sample]) -> Held:
    return Held(
        memory=statistics.median_low([sample.memory for sample in samples]),
        files=max(sample.files for sample in samples),
        threads=statistics.median_low([sample.threads for sample in samples]),
    )
