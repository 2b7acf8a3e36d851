"""Start: how long a user waits for an import, and for the first event with an empty and with a warm cache."""

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from mossar_stream import MossarError
from mossar_tools.bench.measurement import Measurement, Timing, duration
from mossar_tools.bench.work import Work

PACKAGES = ("mossar_stream", "mossar_adapters", "mossar_tools")
IMPORT, WARM, COLD = 0.1, 1.0, 15.0  # s, targets
_PROGRAM = """
import time
cpu, wall = time.process_time(), time.perf_counter()
import mossar_stream
print(time.perf_counter() - wall, time.process_time() - cpu)
"""
_DEMO = ("-m", "mossar_tools", "demo", "--speed", "max", "--seconds", "5")


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the import, and the first events; processes of their own, on a copy of the packages without a cache."""
    with copied() as folder:
        first_import(folder)  # makes Python's own caches
        runs = [first_import(folder) for _ in range(work.some(7, 2))]
        yield duration("start", "import mossar_stream", "s", runs, IMPORT)
        if work.quick:
            return
        work.on_progress("start: compiling from an empty cache")
        cold, said = first_event(folder)
        note = said or "it does not say what it is doing"
        yield duration("start", "first event of mossar demo, empty cache", "s", [cold], COLD, note)
        warm = [first_event(folder)[0] for _ in range(work.repeats)]
        yield duration("start", "first event of mossar demo, warm cache", "s", warm, WARM)


@contextlib.contextmanager
def copied() -> Iterator[Path]:
    """Make a copy of the packages, which therefore has kernel caches of its own."""
    with tempfile.TemporaryDirectory(prefix="mossar-bench-") as name:
        folder = Path(name)
        for package in PACKAGES:
            home = Path(import_module(package).__file__ or "").parent
            shutil.copytree(home, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
        yield folder


def first_import(folder: Path) -> Timing:
    """Return what importing the core takes in a new interpreter."""
    done = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", _PROGRAM],
        cwd=folder,  # where Python looks first
        env=_environment(folder),
        capture_output=True,
        text=True,
        check=True,
    )
    wall, cpu = map(float, done.stdout.split())
    return Timing(wall, cpu)


def first_event(folder: Path) -> tuple[Timing, str]:
    """Return what it takes from starting `mossar demo` to its first line, and what it said meanwhile.

    Raises:
        MossarError: If it puts nothing out.
    """
    before, began = _children(), time.perf_counter()
    pipe = subprocess.PIPE
    with subprocess.Popen(  # noqa: S603 - our own interpreter
        [sys.executable, *_DEMO], cwd=folder, env=_environment(folder), stdout=pipe, stderr=pipe
    ) as demo:
        line = demo.stdout.readline() if demo.stdout else b""
        wall = time.perf_counter() - began
        demo.kill()
        said = demo.stderr.read().decode(errors="replace").strip() if demo.stderr else ""
    if not line:
        raise MossarError(f"mossar demo puts nothing out: {said[-200:]}")
    return Timing(wall, _children() - before), said.partition("\n")[0]


def _children() -> float:
    """Return the processor time of children that have ended, s."""
    used = os.times()
    return used.children_user + used.children_system


def _environment(folder: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}
