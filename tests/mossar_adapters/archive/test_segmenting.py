"""Segmenting one recording of an archive; no engine is needed."""

import numpy as np
import pytest

from mossar_adapters.archive import segmenting
from mossar_adapters.archive.segmenting import problem, segment_file
from mossar_adapters.demo import DemoSource
from mossar_adapters.files import FileError, MskWriter, ReadOptions
from mossar_adapters.source import Meta
from mossar_stream import Frames, Moves, Settings, Skeleton, segment_recording

WHOLE = Settings(range="file")


@pytest.fixture
def performance(tmp_path):
    path = tmp_path / "two.msk"
    with MskWriter(path) as writer:
        for item in DemoSource.from_url("demo:?performers=2&seconds=5", speed="max").items():
            writer.write(item)
    return path


def test_each_performer_is_segmented_as_a_recording_of_its_own(performance):
    found = segment_file(performance, WHOLE, ReadOptions())
    assert [(one.performer, one.frames, one.fps) for one in found] == [("p1", 300, 60.0), ("p2", 300, 60.0)]
    meta, *chunks = DemoSource.from_url("demo:?seconds=5", speed="max").items()
    positions = np.concatenate([chunk.positions for chunk in chunks])
    times = np.concatenate([chunk.times for chunk in chunks])
    direct = segment_recording(positions, 60.0, meta.skeleton, WHOLE, times=times)
    assert found[0].key_frames == direct.key_frames
    assert found[0].segments == direct.segments
    assert found[0].seconds == pytest.approx(299 / 60)


def test_one_performer_is_read_where_that_is_asked_for(performance):
    (found,) = segment_file(performance, WHOLE, ReadOptions(performer="p2"))
    assert found.performer == "p2"


def test_joints_without_confidence_are_missing(tmp_path):
    positions = np.zeros((60, 2, 3), np.float32)
    positions[30:, 1, 0] = np.linspace(0, 1, 30)
    sure = np.ones((60, 2), np.float32)
    sure[:, 1] = 0
    with MskWriter(tmp_path / "a.msk") as writer:
        writer.write(Meta("p1", Skeleton(("hip", "hand"), (-1, 0)), 30.0))
        writer.write(Frames(positions, np.arange(60) / 30, sure))
    (found,) = segment_file(tmp_path / "a.msk", WHOLE, ReadOptions())
    assert found.key_frames == []


def test_what_is_too_long_for_the_memory_is_refused_before_it_is_read(performance, monkeypatch):
    monkeypatch.setattr(segmenting, "MAX_BYTES", 1000)
    with pytest.raises(FileError, match="too long to be held in memory"):
        segment_file(performance, WHOLE, ReadOptions())


def test_problems_are_one_line():
    assert problem(FileError("a.bvh", "bad")) == "a.bvh: bad"
    assert problem(KeyError("x\ny")) == r"internal error: KeyError: 'x\ny'"
    assert "\n" not in problem(ValueError("two\nlines"))


def test_limbs_moves_and_repetitions_are_those_of_segment_recording(performance):
    meta, *chunks = DemoSource.from_url("demo:?seconds=5", speed="max").items()
    positions = np.concatenate([chunk.positions for chunk in chunks])
    times = np.concatenate([chunk.times for chunk in chunks])
    moves = Moves(meta.skeleton)
    moves.add("some", positions[200:260], 60.0)
    settings = WHOLE.replace(limbs=True, repetitions=True)
    found, _ = segment_file(performance, settings, ReadOptions(), moves)
    direct = segment_recording(positions, 60.0, meta.skeleton, settings, times=times, moves=moves)
    assert found.moves == direct.moves
    assert {event.name for event in found.moves} == {"some"}
    assert found.limbs == {name: (own.key_frames, own.segments) for name, own in direct.limbs.items()}
    assert any(keys for keys, _ in found.limbs.values())
    counted = [*direct.repetitions, *(one for own in direct.limbs.values() for one in own.repetitions)]
    assert found.repetitions == counted


def test_performances_and_held_poses_are_those_of_segment_recording_and_have_rows(tmp_path):
    meta, *chunks = DemoSource.from_url(
        "demo:?seconds=9&moves=rest:2,squat,rest:2,squat", speed="max"
    ).items()
    with MskWriter(tmp_path / "squats.msk") as writer:
        for item in (meta, *chunks):
            writer.write(item)
    positions = np.concatenate([chunk.positions for chunk in chunks])
    times = np.concatenate([chunk.times for chunk in chunks])
    moves = Moves(meta.skeleton)
    moves.add("squat", positions[60:300], 60.0)
    moves.add_pose("standing", positions[60])
    (found,) = segment_file(tmp_path / "squats.msk", WHOLE, ReadOptions(), moves, ("squat",))
    direct = segment_recording(
        positions, 60.0, meta.skeleton, WHOLE, times=times, moves=moves, follow=("squat",)
    )
    assert found.followed == direct.followed
    assert found.poses == direct.poses
    assert [done.count for done in found.followed] == [1, 2]
    assert len(found.poses) >= 2
    tables = pytest.importorskip("mossar_adapters.archive.tables", reason="needs the extra archive")
    rows = tables.no_rows()
    tables.add_rows(rows, "squats.msk", [found])
    poses, squats = (
        tables.pa.Table.from_pylist(rows[name], tables.SCHEMAS[name]).to_pylist()
        for name in ("poses", "followed")
    )
    assert [row["path"] for row in poses] == ["squats.msk"] * len(found.poses)
    for row, event in zip(poses, found.poses, strict=True):
        assert row["end_time"] - row["start_time"] == pytest.approx(event.seconds)
        assert (row["name"], row["deviation"], dict(row["limbs"])) == (
            "standing",
            event.deviation,
            event.limbs,
        )
    assert [(row["count"], row["score"], dict(row["range"])) for row in squats] == [
        (event.count, event.score, event.range) for event in found.followed
    ]


def test_steps_are_those_of_segment_recording(tmp_path):
    meta, *chunks = DemoSource.from_url("demo:?seconds=8&moves=walk", speed="max").items()
    with MskWriter(tmp_path / "walk.msk") as writer:
        for item in (meta, *chunks):
            writer.write(item)
    positions = np.concatenate([chunk.positions for chunk in chunks])
    times = np.concatenate([chunk.times for chunk in chunks])
    (found,) = segment_file(tmp_path / "walk.msk", WHOLE.replace(steps=True), ReadOptions())
    direct = segment_recording(positions, meta.fps, meta.skeleton, WHOLE.replace(steps=True), times=times)
    assert found.steps == list(direct.steps)
    assert {step.status for step in found.steps} == {"strike", "off"}


def test_recordings_without_feet_have_no_steps_and_say_so(tmp_path):
    rows = "".join(f"{k / 30},0,1,0,0,{k % 20 / 20},1\n" for k in range(120))
    (tmp_path / "plain.csv").write_text("time,a.x,a.y,a.z,b.x,b.y,b.z\n" + rows)
    (found,) = segment_file(tmp_path / "plain.csv", WHOLE.replace(steps=True), ReadOptions())
    assert found.steps == []
    assert found.key_frames
    assert "steps need ankles or toes" in found.notes[-1]


def test_recordings_that_lack_joints_of_the_moves_are_segmented_and_say_so(performance):
    moves = Moves(Skeleton(("hip", "tail"), (-1, 0)))
    wag = np.zeros((30, 2, 3))
    wag[:, 1, 0] = np.sin(np.linspace(0, 6, 30))
    moves.add("wag", wag, 30.0)
    found, _ = segment_file(performance, WHOLE, ReadOptions(), moves)
    assert found.key_frames
    assert found.moves == []
    assert "tail" in found.notes[-1]
