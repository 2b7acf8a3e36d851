"""Outputs that fail: full disks, folders that cannot be written, recordings that must not be lost."""

import contextlib
import errno
import json
import os
import signal
import threading
import time

import numpy as np
import pytest

from mossar_adapters.files import FileError, open_recording
from mossar_adapters.files.output import OutputFile
from mossar_adapters.files.replacing import Draft
from mossar_adapters.pipeline.snapshot import Snapshot, read_snapshot, write_snapshot
from mossar_stream import SnapshotError
from mossar_tools.console import console
from mossar_tools.outputs import Outputs


def without_run(path):
    """Return the events of a file without what differs from run to run."""
    events = [json.loads(line) for line in path.read_text().splitlines()]
    assert {len(event.pop("run")) for event in events if "run" in event} == {12}
    return events


def test_a_full_disk_ends_the_recording_and_not_the_stream(mossar, disk_of_128k, tmp_path):
    events, take = tmp_path / "e.jsonl", disk_of_128k / "take.msk"
    run = ("run", "demo:", "--speed", "max", "--seconds", "60")
    status, _, err = mossar(*run, "--to", events, "--to", take)
    assert status == 1
    assert f"{take}: cannot be written: No space left on device" in err
    assert "Traceback" not in err
    mossar(*run, "--to", tmp_path / "quiet.jsonl")
    assert without_run(events) == without_run(tmp_path / "quiet.jsonl")
    assert open_recording(take).frame_count > 100


@pytest.mark.parametrize("name", ["events.jsonl", "segments.csv"])
def test_a_full_disk_ends_a_file_of_events_with_one_line(mossar, disk_of_128k, tmp_path, name):
    (disk_of_128k / "filling").write_bytes(bytes(120 << 10))
    run = ("run", "demo:", "--speed", "max", "--seconds", "600")
    status, _, err = mossar(*run, "--to", disk_of_128k / name, "--to", tmp_path / "e.jsonl")
    assert status == 1
    assert len([line for line in err.splitlines() if "error" in line]) == 1
    assert "No space left on device" in err
    assert json.loads((tmp_path / "e.jsonl").read_text().splitlines()[-1])["event"] == "ended"


def test_recording_on_a_full_disk_fails_with_one_line(mossar, disk_of_128k):
    take = disk_of_128k / "take.msk"
    status, _, err = mossar("record", "demo:", take, "--speed", "max", "--seconds", "60")
    assert status == 1
    assert "cannot be written: No space left on device" in err
    assert open_recording(take).frame_count > 100


def test_a_read_only_folder_is_an_error_while_the_stream_goes_on(mossar, read_only_disk, tmp_path):
    events = tmp_path / "e.jsonl"
    run = ("run", "demo:", "--speed", "max", "--seconds", "5")
    status, _, err = mossar(*run, "--to", read_only_disk / "take.msk", "--to", events)
    assert status == 1
    assert "cannot be written: permission denied; the stream continues without it" in err
    assert json.loads(events.read_text().splitlines()[-1])["event"] == "ended"


def test_a_read_only_folder_is_wrong_usage_where_nothing_else_is_written(mossar, read_only_disk):
    status, _, err = mossar("run", "demo:", "--to", read_only_disk / "e.jsonl")
    assert status == 2
    assert "Read-only file system" in err


def test_a_full_disk_keeps_the_snapshot_that_was_and_nothing_beside_it(disk_of_128k):
    path = disk_of_128k / "state"
    small = Snapshot(b"{}", complete=False, performers={"p1": bytes(1000)})
    write_snapshot(path, small)
    (disk_of_128k / "filling").write_bytes(bytes(80 << 10))
    with pytest.raises(SnapshotError, match="cannot be written: No space left on device"):
        write_snapshot(path, Snapshot(b"{}", complete=False, performers={"p1": os.urandom(60 << 10)}))
    assert sorted(found.name for found in disk_of_128k.iterdir()) == ["filling", "state"]
    assert read_snapshot(path) == small


@pytest.mark.parametrize("name", ["events.jsonl", "segments.csv", "take.msk", "notes.txt"])
def test_two_runs_do_not_write_one_file(process, mossar, tmp_path, name):
    path, other = tmp_path / name, tmp_path / "other.jsonl"
    running = process("run", "demo:", "--to", path, "--to", other)
    wait_for(lambda: other.exists() and other.stat().st_size)
    status, out, err = mossar("run", "demo:?seconds=1", "--to", path, "--force")
    assert (status, out) == (2, "")
    assert f"{path}: another run is writing it; end that run, or name another file" in err
    running.send_signal(signal.SIGTERM)
    assert running.wait(20) == 143
    assert mossar("run", "demo:?seconds=1", "--to", path, "--force", "--speed", "max")[0] == 0
    assert sorted(found.name for found in tmp_path.iterdir()) == sorted([name, "other.jsonl"])


@pytest.mark.skipif(os.name != "posix", reason="kill -9 is of POSIX systems")
def test_two_runs_do_not_share_a_snapshot_and_a_killed_one_holds_nothing(process, mossar, tmp_path):
    state = tmp_path / "state"
    running = process("run", "demo:?seconds=60", "--to", tmp_path / "a.jsonl", "--snapshot", state)
    wait_for(state.exists)
    again = ("run", "demo:?seconds=60", "--to", tmp_path / "b.jsonl", "--snapshot", state, "--speed", "max")
    status, _, err = mossar(*again)
    assert status == 2
    assert f"{state}: another run is writing it" in err
    assert not (tmp_path / "b.jsonl").exists()
    running.kill()
    running.wait(20)
    assert mossar(*again)[0] == 0
    assert not list(tmp_path.glob(".state.lock"))


def test_a_claim_is_released_by_whichever_thread_closes_the_file(tmp_path):
    file = OutputFile(tmp_path / "a.jsonl", replace=False)
    with pytest.raises(FileError, match="another run is writing it"):
        OutputFile(tmp_path / "a.jsonl", replace=True)
    thread = threading.Thread(target=file.close)
    thread.start()
    thread.join()
    OutputFile(tmp_path / "a.jsonl", replace=True).close()
    assert [found.name for found in tmp_path.iterdir()] == ["a.jsonl"]


def test_a_link_to_a_file_that_is_written_is_the_same_file(tmp_path):
    with contextlib.closing(OutputFile(tmp_path / "a.jsonl", replace=False)):
        (tmp_path / "b.jsonl").symlink_to(tmp_path / "a.jsonl")
        with pytest.raises(FileError, match="another run is writing it"):
            OutputFile(tmp_path / "b.jsonl", replace=True)


def test_devices_are_written_by_as_many_as_like():
    with contextlib.closing(OutputFile(os.devnull, replace=True)):
        OutputFile(os.devnull, replace=True).close()


def wait_for(condition):
    until = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.02)


def test_a_recording_that_is_there_is_never_replaced_without_force(mossar, tmp_path):
    take = tmp_path / "take.msk"
    take.write_bytes(b"precious")
    for command in (("run", "demo:", "--to", take, "--to", "-"), ("record", "demo:", take)):
        status, _, err = mossar(*command, "--speed", "max", "--seconds", "1")
        assert status == 2
        assert "--force replaces it" in err
        assert take.read_bytes() == b"precious"


@pytest.mark.skipif(os.name != "posix", reason="kill -9 is of POSIX systems")
def test_a_recording_survives_kill_9_and_goes_on_from_the_snapshot(process, mossar, swing, tmp_path):
    take, state = tmp_path / "take.msk", tmp_path / "state"
    arguments = ("run", swing, "--to", take, "--snapshot", state, "--snapshot-every", "0.1")
    running = process(*arguments, "--speed", "4")
    until = time.monotonic() + 20
    while not (take.exists() and take.stat().st_size > 5000):
        assert time.monotonic() < until
        time.sleep(0.02)
    running.send_signal(signal.SIGKILL)
    running.wait(10)
    assert 0 < open_recording(take).frame_count < 240
    assert mossar(*arguments)[0] == 0
    first, second = (list(open_recording(path).chunks()) for path in (swing, take))
    assert np.array_equal(*(np.concatenate([c.positions for c in chunks]) for chunks in (first, second)))


@pytest.mark.parametrize("option", ["--json", "--csv"])
def test_an_error_while_a_table_is_written_leaves_the_old_one(tmp_path, mossar, monkeypatch, option):
    old = tmp_path / "old.txt"
    old.write_text("old", encoding="utf-8")

    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Draft, "put", full)
    status, _, err = mossar("settings", option, old, "--force")
    assert (status, "No space left" in err) == (1, True)
    assert old.read_text(encoding="utf-8") == "old"


def test_a_batch_that_is_interrupted_keeps_the_rows_of_a_new_table_only(tmp_path):
    new, old = tmp_path / "new.csv", tmp_path / "old.csv"
    old.write_text("old", encoding="utf-8")
    for path in (new, old):
        outputs = Outputs(None, str(path), None)
        with contextlib.suppress(KeyboardInterrupt), outputs.csv_rows(("a",), console()) as write:
            write([{"a": 1}])
            raise KeyboardInterrupt
    assert new.read_text(encoding="utf-8").split() == ["a", "1"]
    assert old.read_text(encoding="utf-8") == "old"
