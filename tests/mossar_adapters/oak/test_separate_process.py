"""Functions in a process of their own."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mossar_adapters.oak.separate_process import run_separately

PROGRAM = """
import os, sys, time
def say(*words):
    sys.stdout.write(" ".join(words))
def fail(word):
    sys.exit(word)
def abort():
    os.abort()
def hang(path):
    with open(path + "~", "w") as file:
        file.write(str(os.getpid()))
    os.replace(path + "~", path)
    time.sleep(60)
"""

HANGING = """
import sys
from asides_for_tests import hang
from mossar_adapters.oak.separate_process import run_separately
run_separately(hang, sys.argv[1], enough=lambda: False)
"""


@pytest.fixture
def functions(tmp_path, monkeypatch):
    """Return a module that another process can import, too."""
    (tmp_path / "asides_for_tests.py").write_text(PROGRAM)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "asides_for_tests", raising=False)
    import asides_for_tests

    return asides_for_tests


def never():
    return False


def test_what_a_function_writes_comes_back(functions):
    done = run_separately(functions.say, "a b", "'c'", enough=never)
    assert (done.returncode, done.stdout) == (0, "a b 'c'")


def test_a_function_that_fails_says_why(functions):
    done = run_separately(functions.fail, "no luck", enough=never)
    assert (done.returncode, done.stderr.strip()) == (1, "no luck")


def test_a_function_that_aborts_ends_only_its_own_process(functions):
    assert run_separately(functions.abort, enough=never).returncode != 0


def test_a_function_that_hangs_is_given_up(functions, tmp_path):
    begun = tmp_path / "begun"
    start = time.monotonic()
    assert run_separately(functions.hang, str(begun), enough=begun.exists) is None
    assert time.monotonic() - start < 30


@pytest.mark.usefixtures("functions")
def test_a_program_that_comes_through_a_pipe_can_ask_and_any_letter_comes_back():
    program = (
        "from asides_for_tests import say\nfrom mossar_adapters.oak.separate_process import run_separately\n"
    )
    program += "print(run_separately(say, 'ł', enough=bool).stdout)"
    places = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTHONUTF8": "1"}
    done = subprocess.run(
        [sys.executable, "-"],
        input=program,
        capture_output=True,
        encoding="utf-8",
        timeout=60,
        env=places,
        check=False,
    )
    assert (done.stdout, done.stderr) == ("ł\n", "")


@pytest.mark.skipif(sys.platform == "win32", reason="there a process does not see that its parent was killed")
@pytest.mark.usefixtures("functions")
@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM", "SIGKILL"])
def test_a_function_that_hangs_ends_with_the_program_however_that_ends(tmp_path, number):
    begun = tmp_path / "begun"
    places = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    program = subprocess.Popen(
        [sys.executable, "-c", HANGING, str(begun)],
        env=places,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    until(begun.exists)
    process = int(begun.read_text())
    os.kill(program.pid, getattr(signal, number))
    program.wait(30)
    until(lambda: not runs(process))


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C cannot be sent to one process there")
def test_ctrl_c_is_left_to_the_program(functions, tmp_path):
    begun = tmp_path / "begun"

    def survived():
        if not begun.exists():
            return False
        process = int(begun.read_text())
        os.kill(process, signal.SIGINT)
        time.sleep(0.3)
        return runs(process)

    assert run_separately(functions.hang, str(begun), enough=survived) is None


def until(happened):
    limit = time.monotonic() + 30
    while not happened():
        assert time.monotonic() < limit
        time.sleep(0.02)


def runs(process):
    """Return whether a process is there and no zombie."""
    try:
        os.kill(process, 0)
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except ProcessLookupError:
        return False
    except FileNotFoundError:  # without /proc
        return True
