"""Signals end what waits or works, never harm what imports, and are never lost."""

import ctypes
import os
import signal
import subprocess
import sys
import threading
import time
import types
import weakref

import pytest

from mossar_tools.errors import Terminated
from mossar_tools.signals import raising

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
@pytest.mark.parametrize(("module", "name"), [("importlib._bootstrap", "work"), ("threading", "start")])
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


class Thing:
    """Something that a weak reference can refer to."""


@pytest.mark.parametrize(("number", "error"), NUMBERS)
def test_a_signal_that_python_discards_comes_again(number, error):
    things = [Thing()]
    kept = weakref.ref(things[0], lambda _: os.kill(os.getpid(), number) or time.sleep(0))
    hook = sys.unraisablehook
    went_on = []
    with pytest.raises(error), raising():  # noqa: PT012
        things.clear()  # what the callback raises is discarded
        went_on.append(kept())
        time.sleep(20)
    assert went_on == [None]
    assert sys.unraisablehook is hook


class Key:
    """A key whose hash is computed when a signal comes."""

    def __init__(self, number):
        self.number = number

    def __hash__(self):
        os.kill(os.getpid(), self.number)
        time.sleep(0)
        return 0


@pytest.mark.parametrize(("number", "error"), NUMBERS)
def test_a_signal_that_an_extension_discards_comes_again(number, error):
    look_up = ctypes.pythonapi.PyDict_GetItem  # says of every error that there is no such key
    look_up.argtypes, look_up.restype = [ctypes.py_object, ctypes.py_object], ctypes.c_void_p
    found = []
    with pytest.raises(error), raising():  # noqa: PT012
        found.append(look_up({0: 1}, Key(number)))
        time.sleep(20)
    assert found == [None]


def test_a_signal_that_waits_when_the_block_ends_is_not_lost():
    passed = []
    with pytest.raises(Terminated), raising():  # noqa: PT012
        signal_after(0.1, signal.SIGTERM)
        delicate("importlib", 0.4, passed)()
    assert passed


WORKS = """
import sys, time
import mossar_stream
from mossar_tools import batch, cli, discovering
from mossar_tools.evaluation import trial

def work(*_, **__):
    print("works", flush=True)
    time.sleep(60)

mossar_stream.Segmenter = discovering.discover = work
trial.trial = batch.segment_whole = mossar_stream.segment_recording = work
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
def test_ctrl_c_ends_commands_while_they_work(command):
    with subprocess.Popen(
        [sys.executable, "-c", WORKS, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as running:
        assert running.stdout.readline() == b"works\n"
        began = time.perf_counter()
        running.send_signal(signal.SIGINT)
        _, err = running.communicate(timeout=50)
        assert time.perf_counter() - began < 30
    assert (running.returncode, err) == (130, b"")
