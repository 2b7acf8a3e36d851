"""Another process compiles while this one does, and nothing depends on it."""

import sys
import time

import numba
import pytest

from mossar_stream.jit import precompile as subject
from mossar_stream.jit.cache import open_cache
from mossar_stream.jit.precompile import other_processes


def compile_something():
    numba.njit(lambda x: x + 1)(1)


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Return what writes the module that the other process calls."""
    if not subject.is_possible(open_cache()):
        pytest.skip("there is one core only, or no cache that lasts")
    monkeypatch.syspath_prepend(tmp_path)

    def write(body):
        (tmp_path / "lent_hand.py").write_text(f"def compile_part(folder, part):\n    {body}\n")
        return "lent_hand"

    return write


@pytest.fixture
def noted(tmp_path, module):
    """Return the module of a process that notes what it was asked for, and where."""
    note = tmp_path / "note"
    return module(f"open({str(note)!r}, 'w').write(folder + ' ' + part)"), note


def test_the_other_process_starts_when_something_is_compiled_and_is_awaited(noted):
    name, note = noted
    with other_processes(name, ["likelihood"]):
        compile_something()
    assert note.read_text() == f"{open_cache().folder} likelihood"


def test_there_is_none_when_all_is_loaded(noted):
    name, note = noted
    with other_processes(name, ["likelihood"]):
        pass
    assert not note.exists()


def test_one_that_fails_is_no_error(module):
    with other_processes(module("raise SystemExit(3)"), ["likelihood"]):
        compile_something()


def test_one_that_hangs_is_given_up(module, monkeypatch):
    monkeypatch.setattr(subject, "LONGEST_WAIT", 0.1)
    began = time.perf_counter()
    with other_processes(module("import time; time.sleep(60)"), ["likelihood"]):
        compile_something()
    assert time.perf_counter() - began < 30


def test_it_ends_with_a_block_that_fails(module):
    began = time.perf_counter()
    hanging = other_processes(module("import time; time.sleep(60)"), ["likelihood"])
    with pytest.raises(KeyboardInterrupt), hanging:  # noqa: PT012
        compile_something()
        raise KeyboardInterrupt
    assert time.perf_counter() - began < 30


@pytest.mark.parametrize("executable", ["", "/opt/studio/studio", None])
def test_a_program_that_embeds_python_is_not_started_again(noted, monkeypatch, executable):
    monkeypatch.setattr(sys, "executable", executable)
    name, note = noted
    with other_processes(name, ["likelihood"]):
        compile_something()
    assert not note.exists()


def test_a_frozen_program_is_not_started_again(monkeypatch):
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    assert not subject.is_possible(open_cache())


def test_an_interpreter_that_cannot_be_started_is_no_error(noted, monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    name, note = noted
    with other_processes(name, ["likelihood"]):
        compile_something()
    assert not note.exists()
