"""Functions in a process of their own."""

import sys
import time

import pytest

from mossar_adapters.aside import aside

PROGRAM = """
import os, sys, time
def say(*words):
    sys.stdout.write(" ".join(words))
def fail(word):
    sys.exit(word)
def abort():
    os.abort()
def hang(path):
    open(path, "w").close()
    time.sleep(60)
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
    done = aside(functions.say, "a b", "'c'", enough=never)
    assert (done.returncode, done.stdout) == (0, "a b 'c'")


def test_a_function_that_fails_says_why(functions):
    done = aside(functions.fail, "no luck", enough=never)
    assert (done.returncode, done.stderr.strip()) == (1, "no luck")


def test_a_function_that_aborts_ends_only_its_own_process(functions):
    assert aside(functions.abort, enough=never).returncode != 0


def test_a_function_that_hangs_is_given_up(functions, tmp_path):
    begun = tmp_path / "begun"
    start = time.monotonic()
    assert aside(functions.hang, str(begun), enough=begun.exists) is None
    assert time.monotonic() - start < 30
