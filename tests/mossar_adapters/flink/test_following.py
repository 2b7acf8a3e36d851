"""Following: the events are those of direct runs, wherever the live segmenters are lost."""

import numpy as np
import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.flink.following import Following
from mossar_adapters.flink.records import records_of
from mossar_adapters.source import Meta
from mossar_stream import (
    FollowEvent,
    FrameError,
    Frames,
    Moves,
    PoseEvent,
    Segmenter,
    Settings,
    Skeleton,
    SnapshotError,
    to_json,
)


class Engine:
    """What an engine does with a following: keeps snapshots, and loses the following now and then."""

    def __init__(self, most=4096, settings=None, moves=None, follow=()):
        self.most, self.settings, self.moves, self.follow = most, settings or Settings(), moves, follow
        self.kept = {}
        self.now = 0.0
        self.fail()

    def fail(self):
        self.following = Following(self.settings, self.most, self.moves, self.follow)

    def take(self, performer, record):
        line, events = self.following.take(performer, record, self.now, lambda: self.kept.get(performer))
        self.kept[performer] = line.snapshot()
        return [to_json(event) for event in events]

    def end(self, performer):
        line = self.following.line(performer, self.now, lambda: self.kept.get(performer))
        return [to_json(event) for event in line.segmenter.end_take("end of stream")]


@pytest.fixture(scope="module")
def people(flink):
    return flink.generated(3, 6)


@pytest.mark.parametrize("lost_every", [1, 7, 10**6])
@pytest.mark.parametrize("most", [1, 4096])
def test_events_are_those_of_direct_runs(flink, people, lost_every, most):
    engine, found = Engine(most), {meta.performer: [] for meta, _ in people}
    lines = [[*records_of(meta), *records_of(frames)] for meta, frames in people]
    for count, turn in enumerate(zip(*lines, strict=True)):
        if count % lost_every == lost_every - 1:
            engine.fail()
        for performer, record in zip(found, turn, strict=True):
            found[performer] += engine.take(performer, record)
    for performer, events in found.items():
        events += engine.end(performer)
    assert found == flink.direct(people)


@pytest.mark.parametrize("lost_every", [3, 10**6])
def test_followed_moves_and_held_poses_are_those_of_direct_runs(lost_every):
    source = DemoSource.from_url("demo:?seconds=8&moves=rest:2,squat,rest:2,squat", speed="max")
    meta, *chunks = source.items()
    positions = np.concatenate([chunk.positions for chunk in chunks])
    moves = Moves(meta.skeleton)
    moves.add("squat", positions[60:300], 60.0)
    moves.add_pose("standing", positions[60])
    engine, found = Engine(moves=moves, follow=("squat",)), []
    for count, record in enumerate(
        [*records_of(meta), *(one for part in chunks for one in records_of(part))]
    ):
        if count % lost_every == lost_every - 1:
            engine.fail()
        found += engine.take(meta.performer, record)
    found += engine.end(meta.performer)
    segmenter = Segmenter(meta.skeleton, Settings(), meta.performer, meta.fps, moves, ("squat",))
    wanted = [event for part in chunks for event in segmenter.push(part)] + segmenter.end_take(
        "end of stream"
    )
    assert found == [to_json(event) for event in wanted]
    said = {(type(event), event.status) for event in wanted if isinstance(event, FollowEvent | PoseEvent)}
    assert {(FollowEvent, "done"), (PoseEvent, "held"), (PoseEvent, "left")} <= said


@pytest.mark.parametrize("lost_every", [1, 7])
def test_limbs_and_moves_are_those_of_direct_runs_and_the_examples_are_kept_once(people, lost_every):
    (meta, frames), *_ = people
    moves = Moves(meta.skeleton)
    moves.add("some", frames.positions[150:210], 60.0)
    moves.add("other", frames.positions[240:300], 60.0)
    settings = Settings(limbs=True)
    engine, found = Engine(settings=settings, moves=moves), []
    for count, record in enumerate([*records_of(meta), *records_of(frames)]):
        if count % lost_every == lost_every - 1:
            engine.fail()
        found += engine.take(meta.performer, record)
    found += engine.end(meta.performer)
    segmenter = Segmenter(meta.skeleton, settings, meta.performer, meta.fps, moves)
    wanted = [to_json(e) for e in [*segmenter.push(frames), *segmenter.end_take("end of stream")]]
    assert found == wanted
    assert any(b'"type":"move"' in line for line in found)
    assert any(b'"channel":"left_arm"' in line for line in found)
    assert moves.to_json() not in engine.kept[meta.performer]
    other = Skeleton(("hip", "hand"), (-1, 0))
    with pytest.raises(FrameError, match="the moves need joints"):
        engine.take("bob", *records_of(Meta("bob", other, 60.0)))


def test_records_read_again_after_a_failure_give_the_same_events(people):
    (meta, frames), *_ = people
    records = [*records_of(meta), *records_of(frames)]
    engine = Engine()
    for record in records[:12]:
        engine.take("g0", record)
    kept = dict(engine.kept)
    once = [engine.take("g0", record) for record in records[12:]]
    engine.kept = kept
    engine.fail()
    assert [engine.take("g0", record) for record in records[12:]] == once


def test_a_performer_who_was_never_described_gets_a_skeleton_by_the_number_of_joints():
    engine = Engine()
    positions = np.zeros((2, 33, 3), np.float32)
    for record in records_of(Frames(positions, np.arange(2) / 30, None, "ann")):
        engine.take("ann", record)
    line = engine.following.line("ann", 0.0, lambda: None)
    assert "nose" in line.segmenter.skeleton.names
    (record,) = records_of(Frames(positions[:, :5], np.arange(2) / 30, None, "bob"))
    assert b'"started"' in engine.take("bob", record)[0]


def test_the_same_meta_again_changes_nothing_and_another_skeleton_ends_the_take(people):
    (meta, frames), *_ = people
    engine = Engine()
    for record in [*records_of(meta), *records_of(frames)]:
        engine.take("g0", record)
    (again,) = records_of(meta)
    assert engine.take("g0", again) == []
    (other,) = records_of(Meta("g0", Skeleton(("hip", "hand"), (-1, 0))))
    assert b'"another skeleton"' in engine.take("g0", other)[-1]


def test_frames_that_do_not_fit_change_nothing(people):
    (meta, frames), *_ = people
    engine = Engine()
    for record in [*records_of(meta), *records_of(frames)]:
        engine.take("g0", record)
    before = dict(engine.kept)
    (misfit,) = records_of(Frames(np.zeros((1, 2, 3), np.float32), np.array([99.0]), None, "g0"))
    with pytest.raises(FrameError, match="this skeleton needs"):
        engine.take("g0", misfit)
    assert engine.following.line("g0", 0.0, lambda: None).snapshot() == before["g0"]


def test_who_is_forgotten_begins_anew_and_a_stranger_is_nobody(people):
    (meta, _), *_ = people
    engine = Engine()
    (record,) = records_of(meta)
    engine.take("g0", record)
    engine.following.forget("g0")
    assert engine.following.line("g0", 0.0, lambda: None) is None
    line = engine.following.line("g0", 5.0, lambda: engine.kept["g0"])
    assert (line.heard, line.due) == (5.0, float("inf"))


def test_a_damaged_snapshot_is_said():
    with pytest.raises(SnapshotError):
        Following(Settings()).line("ann", 0.0, lambda: b"nothing")


@pytest.mark.parametrize("lost_every", [1, 10**6])
def test_steps_are_those_of_a_direct_run(lost_every):
    meta, *chunks = DemoSource.from_url("demo:?seconds=8&moves=walk", speed="max").items()
    settings = Settings(steps=True)
    direct = Segmenter(meta.skeleton, settings, fps=meta.fps)
    expected = [to_json(event) for chunk in chunks for event in direct.push(chunk)]
    engine, found = Engine(settings=settings), []
    for count, record in enumerate(record for item in (meta, *chunks) for record in records_of(item)):
        if count % lost_every == 0:
            engine.fail()
        found += engine.take("p1", record)
    assert found == expected
    assert any(b'"type":"step"' in line for line in found)
