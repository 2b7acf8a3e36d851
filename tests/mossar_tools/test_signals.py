"""Signals end what waits, never harm what imports or compiles, and are never lost."""

import os
import signal
import subprocess
import sys
import threading
import time
import types

import pytest

from mossar_tools.errors import Terminated
from mossar_tools.signals import interruptibly, leave, raising

NUMBERS = [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)]


def signal_after(seconds, number):
    threading.Timer(seconds, os.kill, (os.getpid(), number)).start()


def delicate(module, seconds, passed, name="work"):
    """Return a function, so named, of a module so named, that takes its time."""
    home = types.ModuleType(module)
    body = f"import time\ndef {name}():\n    time.sleep(seconds)\n    passed.append(True)"
    home.__dict__.update(seconds=seconds, passed=passed)
    exec(body, home.__dict__)
    return home.__dict__[name]


@pytest.mark.parametrize(("number", "error"), NUMBERS)
@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("numba.core.compiler", "work"),
        ("llvmlite.binding.ffi", "work"),
        ("importlib._bootstrap", "work"),
        ("threading", "start"),
    ],
)
def test_a_signal_in_a_delicate_place_waits_until_it_is_left(module, name, number, error):
    passed = []
    with pytest.raises(error), raising():  # noqa: PT012
        signal_after(0.1, number)
        delicate(module, 0.4, passed, name)()
        assert passed
        left = time.perf_counter()
        time.sleep(20)
    assert passed
    assert time.perf_counter() - left < 10  # it wakes what waits


def test_a_signal_that_waits_when_the_block_ends_is_not_lost():
    passed = []
    with pytest.raises(Terminated), raising():  # noqa: PT012
        signal_after(0.1, signal.SIGTERM)
        delicate("numba.core", 0.4, passed)()
    assert passed


def test_what_comes_of_it_is_returned():
    assert interruptibly(lambda: 3) == 3


COMPILES = """
import sys, time, types
import mossar_stream
from mossar_tools import batch, cli, discovering
from mossar_tools.evaluation import trial
compiler = types.ModuleType("numba.core.compiler")
exec("import time\\ndef work(*_, **__):\\n print('works', flush=True)\\n time.sleep(60)", compiler.__dict__)
mossar_stream.Segmenter = discovering.discover = compiler.work
trial.trial = batch.segment_whole = mossar_stream.segment_recording = compiler.work
sys.exit(cli.main(sys.argv[1:]))
"""


@pytest.mark.parametrize(
    "command",
    [
        ["evaluate", "demo:", "--seeds", "1"],
        ["segment", "demo:"],
        ["tune", "demo:"],
        ["run", "demo:", "--repetitions"],
        ["teach", "moves.json", "demo:", "--discover"],
    ],
)
def test_ctrl_c_ends_commands_while_they_compile(command):
    with subprocess.Popen(
        [sys.executable, "-c", COMPILES, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as running:
        assert running.stdout.readline() == b"works\n"
        began = time.perf_counter()
        running.send_signal(signal.SIGINT)
        _, err = running.communicate(timeout=50)
        assert time.perf_counter() - began < 30
    assert (running.returncode, err) == (130, b"")


@pytest.mark.parametrize(("number", "error"), NUMBERS)
def test_what_takes_long_is_done_elsewhere_and_no_longer_waited_for(number, error):
    ended = threading.Event()
    began = time.perf_counter()
    with pytest.raises(error), raising():  # noqa: PT012
        signal_after(0.1, number)
        interruptibly(lambda: ended.wait(20))
    assert time.perf_counter() - began < 5
    ended.set()


def test_what_is_done_elsewhere_raises_here():
    def fail():
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        interruptibly(fail)


def test_a_program_that_no_longer_waits_ends_at_once():
    program = (
        "import sys, time\nfrom mossar_tools.signals import interruptibly, leave, raising\n"
        "try:\n    with raising():\n        print('ready', flush=True)\n        interruptibly(lambda: time.sleep(60))\n"
        "except KeyboardInterrupt:\n    print('interrupted')\n    sys.exit(leave(130))"
    )
    running = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert running.stdout.readline() == "ready\n"
    running.send_signal(signal.SIGINT)
    rest, _ = running.communicate(timeout=20)
    assert (running.returncode, rest) == (130, "interrupted\n")


def test_a_program_that_waits_for_nothing_ends_as_usual():
    assert leave(143) == 143
