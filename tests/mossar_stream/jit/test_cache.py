"""The folder of compiled kernels is shared fairly, belongs to its user, and may be damaged."""

import errno
import os
import shutil
import subprocess
import sys
import time

import pytest

from mossar_stream.jit.cache import (
    LONGEST_UNUSED,
    MOST_FOLDERS,
    make_folder,
    open_cache,
    own_temporary,
)
from mossar_stream.jit.decorators import entry_point
from mossar_stream.jit.sources import PACKAGE

root_only = pytest.mark.skipif(
    not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give files to another user"
)


def age(folder, seconds):
    folder.mkdir(parents=True, exist_ok=True)
    os.utime(folder, (time.time() - seconds, time.time() - seconds))


def test_environments_that_share_a_cache_keep_each_other_s_kernels(tmp_path):
    one, _ = make_folder([tmp_path], "kernels-one")
    other, _ = make_folder([tmp_path], "kernels-other")
    (one / "kernel").touch()
    make_folder([tmp_path], "kernels-other")
    assert (one / "kernel").exists()
    assert other.is_dir()


def test_kernels_unused_for_a_month_are_removed_and_nothing_else(tmp_path):
    age(tmp_path / "kernels-old", LONGEST_UNUSED + 60)
    age(tmp_path / "kernels-new", LONGEST_UNUSED - 60)
    age(tmp_path / "notes", LONGEST_UNUSED + 60)
    make_folder([tmp_path], "kernels-own")
    assert {folder.name for folder in tmp_path.iterdir()} == {"kernels-new", "kernels-own", "notes"}


def test_using_a_cache_keeps_it(tmp_path):
    age(tmp_path / "kernels-own", LONGEST_UNUSED + 60)
    make_folder([tmp_path], "kernels-own")
    make_folder([tmp_path], "kernels-other")
    assert (tmp_path / "kernels-own").is_dir()


def test_the_folders_used_last_are_kept_where_there_are_many(tmp_path):
    for number in range(MOST_FOLDERS + 3):
        age(tmp_path / f"kernels-{number}", 3600 + number)
    make_folder([tmp_path], "kernels-own")
    kept = {f"kernels-{number}" for number in range(MOST_FOLDERS)}
    assert {folder.name for folder in tmp_path.iterdir()} == kept | {"kernels-own"}


def test_the_next_folder_serves_where_the_first_cannot_be_made(tmp_path):
    (tmp_path / "file").touch()
    folder, lasts = make_folder([tmp_path / "file", tmp_path / "home"], "kernels-own")
    assert (folder, lasts) == (tmp_path / "home" / "kernels-own", True)


def test_a_folder_of_its_own_serves_a_process_that_may_write_nowhere(read_only_disk):
    folder, lasts = make_folder([read_only_disk], "kernels-own")
    assert folder.is_dir()
    assert not lasts
    folder.rmdir()


def test_a_user_without_a_home_that_the_system_does_not_know_can_import_the_package():
    program = (
        "import os, pathlib\ndef home(): raise RuntimeError\npathlib.Path.home = home\nimport mossar_stream"
    )
    environment = {name: value for name, value in os.environ.items() if name != "XDG_CACHE_HOME"}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_folders_are_the_user_s_alone(tmp_path):
    parent = own_temporary(tmp_path)
    folder, _ = make_folder([parent], "kernels-own")
    assert parent == own_temporary(tmp_path)
    assert folder.parent == parent
    for made in (parent, folder):
        assert made.stat().st_mode & 0o077 == 0


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="the system has no user numbers")
def test_a_temporary_folder_that_others_can_redirect_is_refused(tmp_path):
    (tmp_path / "theirs").mkdir()
    (tmp_path / f"mossar-stream-{os.getuid()}").symlink_to(tmp_path / "theirs")
    with pytest.raises(PermissionError):
        own_temporary(tmp_path)


@root_only
@pytest.mark.parametrize("theirs", ["kernels-own", "kernels-own/deep/kernel.nbc", "kernels-own/deep", "."])
def test_root_loads_nothing_that_another_user_could_have_written(tmp_path, theirs):
    (tmp_path / "cache" / "kernels-own" / "deep").mkdir(parents=True, mode=0o700)
    (tmp_path / "cache" / "kernels-own").chmod(0o700)
    (tmp_path / "cache" / "kernels-own" / "deep" / "kernel.nbc").touch()
    parents = [tmp_path / "cache", tmp_path / "next"]
    assert make_folder(parents, "kernels-own").folder == parents[0] / "kernels-own"
    os.chown(tmp_path / "cache" / theirs, 4321, 4321)
    assert make_folder(parents, "kernels-own").folder == parents[1] / "kernels-own"


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="the system has no user numbers")
def test_a_folder_that_others_can_write_to_is_not_taken(tmp_path):
    folder, _ = make_folder([tmp_path / "first"], "kernels-own")
    folder.chmod(0o777)
    assert make_folder([tmp_path / "first", tmp_path / "next"], "kernels-own").folder.parent.name == "next"


def test_importing_everything_makes_no_folder(tmp_path):
    copy = tmp_path / "lib" / "mossar_stream"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    program = "import mossar_stream\nfor name in mossar_stream.__all__: getattr(mossar_stream, name)"
    places = {"PYTHONPATH": str(tmp_path / "lib"), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    environment = {**os.environ, **places, "TMPDIR": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"}
    subprocess.run([sys.executable, "-c", program], env=environment, check=True)
    assert [path.name for path in tmp_path.iterdir()] == ["lib"]
    assert not list(tmp_path.rglob("kernels-*"))


@entry_point
def tripled(x):
    return 3 * x


@entry_point
def tripled_again(x):
    return 3 * x


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("left", [0, 20])
def test_kernels_that_a_power_cut_left_damaged_are_compiled_anew(ending, left):
    open_cache()

    def files():
        return list(open_cache().folder.rglob(f"test_cache.tripled-*.{ending}"))

    def fresh():
        return entry_point(tripled.py_func)

    assert fresh()(2) == 6
    for file in files():
        file.write_bytes(file.read_bytes()[:left])
    assert fresh()(2) == 6
    assert files()
    assert min(file.stat().st_size for file in files()) > left
    again = fresh()
    assert again(2) == 6
    assert again.stats.cache_hits


def test_a_full_disk_costs_the_cache_and_nothing_else(monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    assert tripled_again(2.5) == 7.5


TWO_AT_ONCE = """
import sys
from numba import njit
from numba.core import types
from mossar_stream.jit.sturdy_cache import SturdyCache

def double(x):
    return x + x

def started():
    kernel = njit(double)
    kernel._cache = SturdyCache(double)
    return kernel, kernel._cache._cache_file

numbers = (types.int64,), (types.float64,)
one, file = started()
one.compile(numbers[0])
said = file._load_index()
other, its_file = started()
its_file._load_index = lambda: {}  # it looked before the first one wrote
other.compile(numbers[1])
file._save_index(said)  # and wrote its index earlier, but its code later
again, _ = started()
assert repr([again(3), again(2.5)]) == "[6, 5.0]", [again(3), again(2.5)]
print("right")
"""


def test_two_processes_that_compile_for_different_types_at_once_never_run_each_other_s_code(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(TWO_AT_ONCE)
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(tmp_path / "kernels"),
        "PYTHONPATH": os.pathsep.join(sys.path),
    }
    done = subprocess.run(
        [sys.executable, program, tmp_path], env=environment, capture_output=True, text=True, check=False
    )
    assert done.stdout == "right\n", done.stderr
