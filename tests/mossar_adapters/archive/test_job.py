"""The job on a real engine: killed and resumed. Needs the extra `archive`; see `.ci/run`."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from mossar_adapters.archive.segmenting import segment_file
from mossar_adapters.demo import DemoSource
from mossar_adapters.files import MskWriter, ReadOptions
from mossar_stream import Moves, Settings

pytest.importorskip("ray", reason="the extra archive is not installed (its own environment, see .ci/run)")

ROOT = Path(__file__).parents[3]
LABELLED = ROOT.parent / "shared" / "data" / "labelled"
RECORDINGS = 500
BROKEN = {
    "empty.bvh": b"",
    "words.amc": b"this is no motion\n",
    "cut.npz": b"PK\x03\x04 and no more",
    "joints.csv": b"time,a.x\n0,1\n",
    "zeros.c3d": bytes(2048),
    "half.json": b'{"type":"frame","xyz":[[0,',
}


def write_performance(path, seed, seconds=4):
    with MskWriter(path) as writer:
        for item in DemoSource.from_url(f"demo:?seed={seed}&seconds={seconds}", speed="max").items():
            writer.write(item)


def write_archive(folder, count=RECORDINGS):
    """Write labelled, generated and broken recordings; return the names of the good ones."""
    good = []
    if LABELLED.is_dir():
        for path in [*LABELLED.glob("*.a[ms]?"), *LABELLED.glob("precog/*.npz")]:
            name = path.relative_to(LABELLED).as_posix()
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, folder / name)
            good += [name] if path.suffix != ".asf" else []
    for name, content in BROKEN.items():
        (folder / name).write_bytes(content)
    (folder / "made").mkdir()
    for seed in range(count - len(good) - len(BROKEN)):
        good.append(f"made/{seed}.msk")
        write_performance(folder / good[-1], seed)
    (folder / "notes.md").write_text("passed over\n")
    return good


class Archive:
    """A folder of recordings and the job on it, as a process group of its own."""

    def __init__(self, folder):
        self.source, self.target = folder / "in", folder / "out"
        self.source.mkdir()
        self.started = []

    def start(self, *options, source=None, path=()):
        places = [str(ROOT / part) for part in ("", "adapters", "tools")]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([*map(str, path), *places])}
        given = [str(source or self.source), str(self.target), *options]
        self.started.append(
            subprocess.Popen(
                [sys.executable, "-m", "mossar_tools", "archive", *given],
                stderr=subprocess.PIPE,
                env=environment,
                start_new_session=True,
            )
        )
        return self.started[-1]

    def run(self, *options, **more):
        process = self.start(*options, **more)
        _, messages = process.communicate(timeout=600)
        assert process.returncode == 0, messages.decode()
        return messages.decode()

    def kill(self, process):
        """Kill the program and the engine it started: all are of its session."""
        for entry in Path("/proc").glob("[0-9]*/stat"):
            fields = entry.read_text().rpartition(")")[2].split()
            if int(fields[3]) == process.pid:
                os.kill(int(entry.parent.name), signal.SIGKILL)
        process.wait()
        process.stderr.close()

    def parts(self, table="recordings"):
        return sorted(self.target.glob(f"{table}/part-*.parquet"))

    def table(self, name):
        import pyarrow.parquet as pq

        return [row for part in self.parts(name) for row in pq.read_table(part).to_pylist()]

    def paths(self, name):
        return sorted(row["path"] for row in self.table(name))


@pytest.fixture
def archive(tmp_path):
    made = Archive(tmp_path)
    yield made
    for process in made.started:
        if process.poll() is None:
            made.kill(process)


def test_killed_and_resumed_every_file_stands_in_the_tables_exactly_once(archive):
    good = write_archive(archive.source)
    process = archive.start()
    until = time.monotonic() + 300
    while len(archive.parts()) < 10:
        assert process.poll() is None, process.stderr.read().decode()
        assert time.monotonic() < until, "the job makes no progress"
        time.sleep(0.05)
    archive.kill(process)
    finished = {part: part.stat().st_mtime_ns for part in archive.parts()}
    # What a job leaves that dies between two tables of a part.
    shutil.copy(archive.parts("segments")[0], archive.target / "segments" / "part-0123456789abcdef.parquet")
    (archive.target / "errors").mkdir(exist_ok=True)
    (archive.target / "errors" / ".part-0123456789abcdef.parquet.tmp").touch()

    messages = archive.run("--resume")

    assert f"{len(good)} of {RECORDINGS} recordings segmented, {len(BROKEN)} broken" in messages
    assert finished.items() <= {part: part.stat().st_mtime_ns for part in archive.parts()}.items()
    assert archive.paths("recordings") == sorted(good)
    assert archive.paths("errors") == sorted(BROKEN)
    assert not [*archive.target.glob("*/.*"), *archive.target.glob("*/part-0123456789abcdef*")]
    for name in (*good[:2], *good[-2:]):
        (direct,) = segment_file(archive.source / name, Settings(range="file"), ReadOptions())
        keys = [row for row in archive.table("key_frames") if row["path"] == name]
        parts = [row for row in archive.table("segments") if row["path"] == name]
        assert [(row["frame"], row["strength"]) for row in keys] == [
            (key.frame, key.strength) for key in direct.key_frames
        ]
        assert [(row["start_frame"], row["end_frame"], tuple(row["active_joints"])) for row in parts] == [
            (part.start_frame, part.end_frame, part.active_joints) for part in direct.segments
        ]


def test_a_file_that_kills_its_worker_is_an_error_and_the_others_are_not(archive, tmp_path):
    write_performance(archive.source / "a.msk", 1)
    write_performance(archive.source / "killer.msk", 2)
    write_performance(archive.source / "z.msk", 3)
    (tmp_path / "sitecustomize.py").write_text(
        "import os, mossar_adapters.archive.segmenting as segmenting\n"
        "whole = segmenting.open_recording\n"
        "segmenting.open_recording = lambda path, *rest: os._exit(9) if path.stem == 'killer' else whole(path, *rest)\n"
    )
    archive.run(path=[tmp_path])
    assert archive.paths("recordings") == ["a.msk", "z.msk"]
    assert archive.paths("errors") == ["killer.msk"]


def test_what_is_read_by_url_comes_with_its_skeletons_and_is_named_as_in_the_bucket(archive):
    if not LABELLED.is_dir():
        pytest.skip(f"the labelled recordings are not here ({LABELLED})")
    shutil.copy(LABELLED / "86_01.amc", archive.source)
    shutil.copy(LABELLED / "86.asf", archive.source)
    (archive.source / "bad.bvh").write_text("bad")
    archive.run(source=archive.source.as_uri())
    assert archive.paths("recordings") == ["86_01.amc"]
    assert archive.table("errors") == [{"path": "bad.bvh", "error": "bad.bvh: this does not look like BVH"}]
    assert archive.table("recordings")[0]["frames"] == 4579


def test_added_recordings_are_segmented_and_settings_are_not_mixed(archive):
    write_performance(archive.source / "a.msk", 1)
    archive.run()
    write_performance(archive.source / "b.msk", 2)
    archive.run("--resume")
    assert archive.paths("recordings") == ["a.msk", "b.msk"]
    for options, message in [((), "--resume continues"), (("--resume", "--level", "cluster"), "not mixed")]:
        process = archive.start(*options)
        _, messages = process.communicate(timeout=60)
        assert process.returncode == 2
        assert message in messages.decode()
        assert len(messages.splitlines()) == 1


def test_the_frames_of_each_performer_are_segmented_by_themselves(archive):
    with MskWriter(archive.source / "two.msk") as writer:
        for item in DemoSource.from_url("demo:?performers=2&seconds=4", speed="max").items():
            writer.write(item)
    archive.run()
    rows = archive.table("recordings")
    assert [(row["performer"], row["frames"]) for row in rows] == [("p1", 240), ("p2", 240)]
    assert {row["performer"] for row in archive.table("segments")} == {"p1", "p2"}


def test_steps_have_rows(archive):
    with MskWriter(archive.source / "walk.msk") as writer:
        for item in DemoSource.from_url("demo:?seconds=8&moves=walk", speed="max").items():
            writer.write(item)
    archive.run("--steps")
    rows = archive.table("steps")
    (found,) = segment_file(archive.source / "walk.msk", Settings(range="file", steps=True), ReadOptions())
    assert [(row["side"], row["status"], row["time"]) for row in rows if row["path"] == "walk.msk"] == [
        (step.side, step.status, step.time) for step in found.steps
    ]
    assert all(row["confidence"] > 0 and row["y"] is not None for row in rows)


def test_limbs_moves_and_repetitions_have_rows(archive, tmp_path):
    write_performance(archive.source / "a.msk", 1, seconds=12)
    (archive.source / "plain.csv").write_text(
        "time,a.x,a.y,a.z,b.x,b.y,b.z\n" + "".join(f"{k / 30},0,1,0,0,{k % 20 / 20},1\n" for k in range(120))
    )
    (file,) = segment_file(archive.source / "a.msk", Settings(range="file"), ReadOptions())
    meta, *chunks = DemoSource.from_url("demo:?seed=1&seconds=12", speed="max").items()
    positions = np.concatenate([chunk.positions for chunk in chunks])
    moves = Moves(meta.skeleton)
    moves.add("some", positions[200:260], 60.0)
    moves.save(tmp_path / "moves.json")
    given = ("--moves", str(tmp_path / "moves.json"), "--limbs", "--repetitions")
    archive.run(*given)
    keys = [row for row in archive.table("key_frames") if row["path"] == "a.msk"]
    assert {"body", "left_arm", "right_leg"} <= {row["channel"] for row in keys}
    assert [row["frame"] for row in keys if row["channel"] == "body"] == [
        key.frame for key in file.key_frames
    ]
    moved = archive.table("moves")
    assert moved
    assert {(row["path"], row["performer"], row["name"]) for row in moved} == {("a.msk", "p1", "some")}
    assert all(row["start_time"] < row["end_time"] for row in moved)
    assert archive.table("repetitions")
    notes = {row["path"]: row["notes"] for row in archive.table("recordings")}
    assert "the moves need joints" in notes["plain.csv"][-1]
    process = archive.start("--resume", "--limbs", "--repetitions")  # without the moves: another job
    _, messages = process.communicate(timeout=60)
    assert process.returncode == 2
    assert "not mixed" in messages.decode()
