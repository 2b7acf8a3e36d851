"""The folder of compiled kernels is shared fairly, and kernels that only kernels call cannot be called."""

import errno
import os
import subprocess
import sys
import time

import pytest

from mossar_stream.jit.decorators import (
    CACHE_FOLDER,
    LONGEST_UNUSED,
    MOST_FOLDERS,
    cache_folder,
    compiled,
    entry_point,
    own_temporary,
)


def age(folder, seconds):
    folder.mkdir(parents=True, exist_ok=True)
    os.utime(folder, (time.time() - seconds, time.time() - seconds))


def test_environments_that_share_a_cache_keep_each_other_s_kernels(tmp_path):
    one, _ = cache_folder([tmp_path], "kernels-one")
    other, _ = cache_folder([tmp_path], "kernels-other")
    (one / "kernel").touch()
    cache_folder([tmp_path], "kernels-other")
    assert (one / "kernel").exists()
    assert other.is_dir()


def test_kernels_unused_for_a_month_are_removed_and_nothing_else(tmp_path):
    age(tmp_path / "kernels-old", LONGEST_UNUSED + 60)
    age(tmp_path / "kernels-new", LONGEST_UNUSED - 60)
    age(tmp_path / "notes", LONGEST_UNUSED + 60)
    cache_folder([tmp_path], "kernels-own")
    assert {folder.name for folder in tmp_path.iterdir()} == {"kernels-new", "kernels-own", "notes"}


def test_using_a_cache_keeps_it(tmp_path):
    age(tmp_path / "kernels-own", LONGEST_UNUSED + 60)
    cache_folder([tmp_path], "kernels-own")
    cache_folder([tmp_path], "kernels-other")
    assert (tmp_path / "kernels-own").is_dir()


def test_the_folders_used_last_are_kept_where_there_are_many(tmp_path):
    for number in range(MOST_FOLDERS + 3):
        age(tmp_path / f"kernels-{number}", 3600 + number)
    cache_folder([tmp_path], "kernels-own")
    kept = {f"kernels-{number}" for number in range(MOST_FOLDERS)}
    assert {folder.name for folder in tmp_path.iterdir()} == kept | {"kernels-own"}


def test_the_next_folder_serves_where_the_first_cannot_be_made(tmp_path):
    (tmp_path / "file").touch()
    folder, lasts = cache_folder([tmp_path / "file", tmp_path / "home"], "kernels-own")
    assert (folder, lasts) == (tmp_path / "home" / "kernels-own", True)


def test_a_folder_of_its_own_serves_a_process_that_may_write_nowhere(read_only_disk):
    folder, lasts = cache_folder([read_only_disk], "kernels-own")
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


def test_each_user_has_a_temporary_folder_of_its_own(tmp_path):
    folder = own_temporary(tmp_path)
    assert folder == own_temporary(tmp_path)
    assert folder.stat().st_mode & 0o077 == 0


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="the system has no user numbers")
def test_a_temporary_folder_that_others_can_redirect_is_refused(tmp_path):
    (tmp_path / "theirs").mkdir()
    (tmp_path / f"mossar-stream-{os.getuid()}").symlink_to(tmp_path / "theirs")
    with pytest.raises(PermissionError):
        own_temporary(tmp_path)


@compiled
def doubled(x, y):
    return 2 * x + y


@entry_point
def doubled_and_one(x):
    return doubled(x, 1)


def test_an_inner_kernel_works_in_others_and_refuses_calls_from_python():
    assert doubled_and_one(4) == 9
    with pytest.raises(TypeError):
        doubled(4, 1)


@entry_point
def tripled(x):
    return 3 * x


@entry_point
def tripled_again(x):
    return 3 * x


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("left", [0, 20])
def test_kernels_that_a_power_cut_left_damaged_are_compiled_anew(ending, left):
    def files():
        return list(CACHE_FOLDER.rglob(f"test_compiled.tripled-*.{ending}"))

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
