"""Measure: what a process holds on to."""

import gc
import os
import threading
from pathlib import Path

import msgspec

_PAGE = os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else 4096


class Sample(msgspec.Struct, frozen=True):
    """What the process held at a moment.

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


def memory() -> int:
    """Return the memory that the process holds (resident set), bytes."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * _PAGE


def files() -> int:
    """Return the number of open file handles."""
    return len(list(Path("/proc/self/fd").iterdir()))


def threads() -> int:
    """Return the number of running threads."""
    return threading.active_count()


def growth(samples: list[Sample]) -> float:
    """Return by how many bytes the memory grew, from the second fifth of the time to the last.

    In the first fifth caches and queues fill.
    """
    fifth = max(1, len(samples) // 5)
    early, late = samples[fifth : 2 * fifth] or samples, samples[-fifth:]
    return _median([s.memory for s in late]) - _median([s.memory for s in early])


def _median(values: list[int]) -> float:
    return float(sorted(values)[len(values) // 2])
