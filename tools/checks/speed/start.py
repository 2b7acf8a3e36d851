"""Start: the time to import the core, and the time to the first event."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator

from mossar_stream import MossarError
from mossar_tools.bench.measurement import Measurement, Timing, duration
from mossar_tools.bench.work import Work

IMPORT, EVENT = 0.1, 1.0  # s, targets
_PROGRAM = """
import time
cpu, wall = time.process_time(), time.perf_counter()
import mossar_stream
print(time.perf_counter() - wall, time.process_time() - cpu)
"""
_DEMO = ("-m", "mossar_tools", "demo", "--speed", "max", "--seconds", "5")


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the import, and the first event, each in processes of their own."""
    runs = [first_import() for _ in range(work.some(7, 2))]
    yield duration("start", "import mossar_stream", "s", runs, IMPORT)
    runs = [first_event() for _ in range(work.repeats)]
    yield duration("start", "first event of mossar demo", "s", runs, EVENT)


def first_import() -> Timing:
    """Return the time to import the core in a new interpreter."""
    command = [sys.executable, "-c", _PROGRAM]
    done = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603 - our own interpreter
    wall, cpu = map(float, done.stdout.split())
    return Timing(wall, cpu)


def first_event() -> Timing:
    """Return the time from the start of `mossar demo` to its first line.

    Raises:
        MossarError: If it prints nothing.
    """
    before, began = _children(), time.perf_counter()
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, *_DEMO], stdout=pipe, stderr=pipe) as demo:  # noqa: S603 - our own interpreter
        line = demo.stdout.readline() if demo.stdout else b""
        wall = time.perf_counter() - began
        demo.kill()
        said = demo.stderr.read().decode(errors="replace").strip() if demo.stderr else ""
    if not line:
        raise MossarError(f"mossar demo puts nothing out: {said[-200:]}")
    return Timing(wall, _children() - before)


def _children() -> float:
    """Return the processor time of children that have ended, s."""
    used = os.times()
    return used.children_user + used.children_system
