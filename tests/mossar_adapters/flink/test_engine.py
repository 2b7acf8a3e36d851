"""The engine's options, and where a job goes on; nothing here starts an engine."""

import os
import shutil

import msgspec
import pytest

from mossar_adapters.flink.engine import check_java, latest_checkpoint, leave_nothing, options, runs_cut_short
from mossar_adapters.flink.job import Job, Source
from mossar_stream import MossarError


@pytest.fixture
def job(tmp_path):
    checkpoints = msgspec.structs.replace(Job(source=Source(files="x")).checkpoints, folder=tmp_path.as_uri())
    return Job(source=Source(files="x"), checkpoints=checkpoints)


def checkpoint(folder, name, age, whole=True):
    place = folder / name
    place.mkdir(parents=True)
    if whole:
        (place / "_metadata").touch()
        os.utime(place / "_metadata", (1e9 - age, 1e9 - age))
    return place


def test_a_job_goes_on_from_the_latest_whole_checkpoint(tmp_path, job):
    assert latest_checkpoint(tmp_path.as_uri()) is None
    assert "execution.state-recovery.path" not in options(job)
    checkpoint(tmp_path, "a/chk-9", age=30)
    latest = checkpoint(tmp_path, "b/chk-2", age=10)
    checkpoint(tmp_path, "b/chk-3", age=0, whole=False)
    assert latest_checkpoint(tmp_path.as_uri()) == latest
    assert options(job)["execution.state-recovery.path"] == latest.as_uri()


def test_no_run_goes_on_from_one_that_has_ended_whatever_is_left_of_it(tmp_path, job):
    killed = checkpoint(tmp_path, "killed/chk-3", age=99)
    checkpoint(tmp_path, "ended/chk-9", age=1)
    leave_nothing(tmp_path.as_uri(), "ended")
    assert not list(tmp_path.glob("ended/chk-*"))
    checkpoint(tmp_path, "ended/chk-9", age=0)  # which the engine writes after it said that the job has ended
    assert latest_checkpoint(tmp_path.as_uri()) == killed
    leave_nothing(tmp_path.as_uri(), "next", "killed")
    assert latest_checkpoint(tmp_path.as_uri()) is None
    assert "execution.state-recovery.path" not in options(job)


def test_no_run_goes_on_from_an_older_part_of_a_job_that_was_killed_twice(tmp_path):
    checkpoint(tmp_path, "over/chk-1", age=200)
    leave_nothing(tmp_path.as_uri(), "over")
    checkpoint(tmp_path, "first/chk-3", age=99)
    checkpoint(tmp_path, "second/chk-7", age=50)
    cut_short = runs_cut_short(tmp_path.as_uri())
    assert cut_short == ["first", "second"]
    leave_nothing(tmp_path.as_uri(), "third", *cut_short)
    assert latest_checkpoint(tmp_path.as_uri()) is None
    assert runs_cut_short("s3://bucket/checkpoints") == []


def test_a_run_without_checkpoints_ends_too(tmp_path):
    leave_nothing((tmp_path / "none yet").as_uri(), "a")
    leave_nothing("s3://bucket/checkpoints", "a")
    assert latest_checkpoint((tmp_path / "none yet").as_uri()) is None


def test_a_job_may_begin_anew(tmp_path, job):
    checkpoint(tmp_path, "a/chk-1", age=0)
    anew = msgspec.structs.replace(job.checkpoints, resume=False)
    assert "execution.state-recovery.path" not in options(msgspec.structs.replace(job, checkpoints=anew))


def test_checkpoints_in_a_bucket_are_named_by_the_user():
    assert latest_checkpoint("s3://bucket/checkpoints") is None


def test_options_of_the_job_win(job):
    given = {"execution.buffer-timeout.interval": "50 ms", "pipeline.object-reuse": True}
    found = options(msgspec.structs.replace(job, flink=given))
    assert found["execution.buffer-timeout.interval"] == "50 ms"
    assert found["pipeline.object-reuse"] == "true"


def test_the_interpreter_is_this_one_only_on_this_machine(job):
    assert "python.executable" in options(job)
    assert "python.executable" not in options(job, on_cluster=True)


@pytest.mark.parametrize(("version", "fine"), [("1.8.0_392", False), ("17.0.15", True), ("11.0.2", True)])
def test_java_must_be_there_and_new_enough(tmp_path, monkeypatch, version, fine):
    java = tmp_path / "bin" / "java"
    java.parent.mkdir()
    java.write_text(f"#!/bin/sh\necho 'openjdk version \"{version}\"' >&2\n")
    java.chmod(0o755)
    monkeypatch.setenv("JAVA_HOME", str(tmp_path))
    if fine:
        check_java()
        return
    with pytest.raises(MossarError, match="needs Java 11 or 17, not"):
        check_java()


def test_a_missing_java_is_said(tmp_path, monkeypatch):
    monkeypatch.setenv("JAVA_HOME", str(tmp_path))
    with pytest.raises(MossarError, match="install Java 17"):
        check_java()
    monkeypatch.delenv("JAVA_HOME")
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(MossarError, match="there is no java"):
        check_java()
