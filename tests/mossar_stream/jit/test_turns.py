"""On the plain path, processes that share a folder of kernels compile one after the other."""

import os
import subprocess
import sys
import threading
import time

import numba
import pytest
from numba.core import event

from mossar_stream.jit.turns import _Turn, system_locks, take_turns

locks = system_locks()
pytestmark = pytest.mark.skipif(locks is None, reason="this system's files cannot be locked so")

# Two processes compile one kernel for different types: the first one has written its index, but not its code yet, when the
# second one, which looked before, writes both. Each waits for that a second at most: it may be kept from looking.
RACE = """
import sys, time
from pathlib import Path
from numba import njit
from numba.core.caching import IndexDataCacheFile
from numba.core.types import float64, int64
from mossar_stream.jit.turns import system_locks, take_turns

folder, own, turns = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
if turns == "turns":
    take_turns(folder, system_locks())
look, write, write_index = (
    IndexDataCacheFile._load_index, IndexDataCacheFile._save_data, IndexDataCacheFile._save_index
)
looks = []

def await_moment(moment):
    give_up = time.monotonic() + 1.0
    while not (folder / moment).exists() and time.monotonic() < give_up:
        time.sleep(0.001)

def looking(file):
    found = look(file)
    looks.append(found)
    if len(looks) == 2:
        (folder / f"{own} looked").touch()
        await_moment("second looked" if own == "first" else "first wrote its index")
    return found

def writing_index(file, overloads):
    write_index(file, overloads)
    (folder / f"{own} wrote its index").touch()

def writing(file, name, data):
    if own == "first":
        await_moment("second wrote")
    write(file, name, data)
    (folder / f"{own} wrote").touch()

IndexDataCacheFile._load_index, IndexDataCacheFile._save_data, IndexDataCacheFile._save_index = (
    looking, writing, writing_index
)
njit(cache=True)(__import__("double").double).compile((int64 if own == "first" else float64,))
"""


def compiled_by_two(folder, turns):
    """Return what two processes run afterwards that were compiled at once."""
    (folder / "double.py").write_text("def double(x):\n    return x + x\n")
    program = folder / "program.py"
    program.write_text(RACE)
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(folder / "kernels"),
        "PYTHONPATH": os.pathsep.join([str(folder), *sys.path]),
    }
    both = [
        subprocess.Popen([sys.executable, program, folder, own, turns], env=environment)
        for own in ("first", "second")
    ]
    assert [one.wait(120) for one in both] == [0, 0]
    check = "import double, numba; d = numba.njit(cache=True)(double.double); print(d(3), d(2.5))"
    done = subprocess.run(
        [sys.executable, "-c", check], env=environment, capture_output=True, text=True, check=False
    )
    return done.stdout.strip() or done.returncode


def test_processes_that_compile_for_different_types_at_once_get_their_own_code(tmp_path):
    assert compiled_by_two(tmp_path, "turns") == "6 5.0"


def test_without_turns_they_would_get_each_other_s(tmp_path):
    """Should this fail one day, numba has mended the cause, and turns may go."""
    assert compiled_by_two(tmp_path, "no turns") != "6 5.0"


def test_a_process_that_was_stopped_is_not_waited_for_without_end(tmp_path):
    holder = (tmp_path / "turn").open("w")
    locks.flock(holder, locks.LOCK_EX)
    turn = _Turn(tmp_path / "turn", locks, longest=0.2)
    began = time.monotonic()
    for _ in range(10):
        turn.on_start(None)
        turn.on_end(None)
    assert 0.2 <= time.monotonic() - began < 2.0
    holder.close()


def test_threads_of_a_process_share_its_turn(tmp_path):
    turn = _Turn(tmp_path / "turn", locks, longest=5.0)
    turn.on_start(None)
    other = threading.Thread(target=turn.on_start, args=(None,))
    other.start()
    other.join(2)
    assert not other.is_alive()
    turn.on_end(None)
    with (tmp_path / "turn").open("w") as stranger, pytest.raises(BlockingIOError):
        locks.flock(stranger, locks.LOCK_EX | locks.LOCK_NB)
    turn.on_end(None)
    with (tmp_path / "turn").open("w") as stranger:
        locks.flock(stranger, locks.LOCK_EX | locks.LOCK_NB)


def test_a_folder_that_is_gone_keeps_nobody_from_compiling(tmp_path):
    take_turns(tmp_path / "gone", locks)
    listener = event._registered["numba:compiler_lock"][-1]
    try:
        assert numba.njit(lambda x: x + 1)(2) == 3
    finally:
        event.unregister("numba:compiler_lock", listener)
