"""Programs run in this process through `main`, or as processes of their own."""

import contextlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.pipeline import Pipeline
from mossar_stream import Settings
from mossar_tools.cli import main
from mossar_tools.dashboard.live import LiveShow

ROOT = Path(__file__).parents[2]


@pytest.fixture
def mossar(capsys):
    """Run `mossar` in this process; returns exit status, output and messages."""

    def run(*arguments):
        status = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run


class Ran(NamedTuple):
    """How a command ended, and what it wrote."""

    status: int
    out: str
    err: str


@pytest.fixture
def run(mossar):
    """Run `mossar` in this process; returns the same with names."""
    return lambda *arguments: Ran(*mossar(*arguments))


@pytest.fixture
def events(mossar):
    """Run `mossar` and return the events on standard output; the runs are called the same."""

    def run(*arguments):
        status, out, err = mossar(*arguments, "--run-id", "test")
        assert status == 0, err
        return [json.loads(line) for line in out.splitlines()]

    return run


@pytest.fixture
def small_disk():
    """Return a context in which files cannot become longer than so many bytes."""
    resource = pytest.importorskip("resource")  # not on Windows

    @contextlib.contextmanager
    def limited(size):
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # some libraries take it for a crash
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN if handler is None else handler)

    return limited


@pytest.fixture
def process():
    """Start `mossar` as a process of its own; it is killed at the end if it still runs."""
    started = []

    def start(*arguments, **options):
        places = [ROOT, ROOT / "adapters", ROOT / "tools"]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, places))}
        pipe = subprocess.PIPE
        command = [sys.executable, "-m", "mossar_tools", *map(str, arguments)]
        options = {"stdin": subprocess.DEVNULL, "stdout": pipe, "stderr": pipe, **options}
        started.append(subprocess.Popen(command, env=environment, **options))
        return started[-1]

    yield start
    for running in started:
        if running.poll() is None:
            running.kill()
        running.wait()
        for stream in (running.stdin, running.stdout, running.stderr):
            if stream is not None:
                stream.close()


@pytest.fixture
def swing(tmp_path):
    """A recording: a hand that swings for some of the time; 240 frames at 30 Hz."""
    return recording(tmp_path / "swing.npz", swinging(240))


def swinging(count, joints=4):
    times = np.arange(count) / 30
    positions = np.zeros((count, joints, 3), np.float32)
    positions[:, :, 1] = np.linspace(1.7, 0, joints)
    positions[:, -1, 0] += np.sin(2 * np.pi * times) * (np.sin(times) > 0)
    return positions


def recording(path, positions):
    joints = positions.shape[1]
    names = np.array([f"j{i}" for i in range(joints)])
    np.savez(path, positions=positions, fps=30, joint_names=names, parents=np.arange(-1, joints - 1))
    return path


@pytest.fixture(scope="module")
def seen():
    """Return a live show after a minute of the built-in performer."""
    show = LiveShow(Settings())
    source = DemoSource.from_url("demo:?seconds=40&seed=3", speed=40)
    pipeline = Pipeline([source], [], Settings(), views=[show], tick=lambda: show.tick(pipeline))
    pipeline.run()
    return show
