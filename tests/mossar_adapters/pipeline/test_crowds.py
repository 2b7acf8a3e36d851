"""Many performers: who makes room, who is refused, and who never ends the run of the others."""

import logging
import time

import pytest

from mossar_adapters.pipeline import Pipeline
from mossar_adapters.source import Departure, Meta
from mossar_stream import (
    FrameError,
    Settings,
    SettingsError,
    Skeleton,
    StreamEvent,
)


def test_who_had_to_make_room_and_comes_back_is_followed_again(stage, monkeypatch):
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline.MAX_PERFORMERS", 2)
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline._IDLE", 0.1)
    sink = stage.Collected()
    names = ("ann", "bob", "eve")
    items = [item for name in names for item in (0.15, stage.meta(name), stage.wave(0, 30, name))]
    again = [0.5, stage.wave(30, 60, "ann")]  # longer than a stall
    outcome = Pipeline([stage.Script([*items, *again], live=True)], [sink]).run()
    assert outcome.frames == 150
    changes = [
        (e.event, e.take, e.reason)
        for e in sink.of(StreamEvent)
        if e.performer == "ann" and e.event in {"started", "ended"}
    ]
    assert changes[:2] == [("started", 0, ""), ("ended", 0, "too many performers")]
    assert changes[2:] == [("started", 1, ""), ("ended", 1, "end of stream")]


def test_a_flood_of_performers_neither_takes_memory_nor_ends_the_run(stage, monkeypatch):
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline._NAMES", 40)
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline.MAX_PERFORMERS", 8)
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline._IDLE", -1.0)
    monkeypatch.setattr("mossar_adapters.pipeline.watch.STALL", 0.05)
    sink = stage.Collected()
    people = [f"someone{k}" for k in range(100)]
    items = [item for name in people for item in (stage.meta(name), stage.wave(0, 2, name))]
    pipeline = Pipeline([stage.Script([*items, 0.2, stage.meta(), stage.wave(0, 60)], live=True)], [sink])
    outcome = pipeline.run()
    assert outcome.frames == 260
    assert len(pipeline.performers) <= 41
    assert sum(e.event == "ended" for e in sink.of(StreamEvent)) == 101


def test_newcomers_are_refused_and_counted_while_all_others_move(stage, monkeypatch, caplog):
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline.MAX_PERFORMERS", 2)
    sink = stage.Collected()
    names = ("ann", "bob", "eve", "joe")
    items = [item for name in names for item in (stage.meta(name), stage.wave(0, 30, name))]
    again = [stage.wave(30, 30, name) for name in names]
    pipeline = Pipeline([stage.Script([*items, *again], live=True)], [sink])
    with caplog.at_level(logging.WARNING, "mossar"):
        outcome = pipeline.run()
    assert outcome.frames == 120
    unusable = {name: performer.unusable for name, performer in pipeline.performers.items()}
    assert unusable == {"ann": 0, "bob": 0, "eve": 60, "joe": 60}
    assert {event.performer for event in sink.events} == {"ann", "bob"}
    assert len([message for message in caplog.messages if "newcomers are refused" in message]) == 1


def test_a_performer_is_there_again_after_a_flood_of_names(stage, monkeypatch):
    """Metas of the flood fill every table, while the frames between them are dropped."""
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline._NAMES", 40)
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline.MAX_PERFORMERS", 8)
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline._IDLE", 0.05)
    sink = stage.Collected()
    before = [stage.meta("ann"), stage.wave(0, 30, "ann"), 0.3]
    flood = [item for k in range(200) for item in (stage.meta(f"x{k}"), stage.wave(0, 2, f"x{k}"))]
    after = [0.3, *(stage.wave(30 + k, 1, "ann") for k in range(60))]  # its meta does not come again
    pipeline = Pipeline([stage.Script([*before, *flood, *after], live=True)], [sink])
    pipeline.run()
    ours = [(e.event, e.take) for e in sink.of(StreamEvent) if e.performer == "ann"]
    assert ours[-2:] == [("started", 1), ("ended", 1)]
    assert pipeline.performers["ann"].unusable == 0


def test_seconds_are_not_waited_for_with_who_has_left_or_stopped(stage):
    sink = stage.Collected()
    ann, bob, eve = ([stage.meta(name), stage.wave(0, 30, name)] for name in ("ann", "bob", "eve"))
    script = [*ann, *bob, *eve, Departure("bob", "lost user"), stage.wave(30, 60, "ann"), 30.0]
    began = time.monotonic()
    outcome = Pipeline([stage.Script(script, live=True)], [sink], seconds=2.0).run()
    assert time.monotonic() - began < 10, "eve's frames have stopped"
    assert outcome.complete
    assert outcome.frames == 30 + 30 + 60
    ends = {e.performer: e.reason for e in sink.of(StreamEvent) if e.event == "ended"}
    assert ends == {"bob": "lost user", "eve": "frames stopped", "ann": "frames stopped"}


def test_an_error_of_one_performer_does_not_end_the_run(stage, monkeypatch, caplog):
    sink = stage.Collected()
    items = [item for name in ("ann", "bob") for item in (stage.meta(name), stage.wave(0, 60, name))]
    pipeline = Pipeline([stage.Script(items)], [sink])
    announce = pipeline.pool.announce

    def refused(performer, *rest):
        if performer == "ann":
            raise SettingsError("location=free is impossible here")
        return announce(performer, *rest)

    monkeypatch.setattr(pipeline.pool, "announce", refused)
    with caplog.at_level(logging.WARNING, "mossar"):
        outcome = pipeline.run()
    assert outcome.frames == 60
    assert not outcome.errors
    assert stage.changes(sink) == [("bob", "started", ""), ("bob", "ended", "end of stream")]
    assert caplog.messages[0] == "script: ann cannot be followed: location=free is impossible here"


def test_of_many_who_cannot_be_followed_the_first_are_told_of_each_once(stage, monkeypatch, caplog):
    def refuse(*_):
        raise FrameError("no")

    items = [stage.meta(f"p{k}") for k in range(50)] * 2
    pipeline = Pipeline([stage.Script(items)], [stage.Collected()])
    monkeypatch.setattr(pipeline.pool, "announce", refuse)
    pipeline.run()
    said = [message for message in caplog.messages if "cannot be followed" in message]
    assert said[0] == "script: p0 cannot be followed: no"
    assert said[-1] == "script: p19 cannot be followed: no; others are not logged any more"
    assert len(said) == 20


@pytest.mark.parametrize(
    "named", [{"limbs": "hands=hnd"}, {"steps": True, "feet": "left=hip right=hnd"}], ids=["limbs", "feet"]
)
def test_a_source_whose_first_performer_lacks_a_joint_that_the_user_names_is_refused(stage, named):
    items = [stage.meta(), stage.wave(0, 60), 60.0]
    source = stage.Script(items, live=True)
    began = time.monotonic()
    outcome = Pipeline([source], [stage.Collected()], Settings(**named)).run()
    assert time.monotonic() - began < 30, "the sender goes on for a minute"
    assert outcome.frames == 0
    (error,) = outcome.errors
    assert isinstance(error, FrameError)
    assert "no joint called 'hnd'; there are hip, hand - did you mean hand?" in str(error)


def test_a_later_performer_that_lacks_a_joint_does_not_end_a_source(stage, caplog):
    other = Meta("bob", Skeleton(("hip", "foot"), (-1, 0)), 30.0)
    items = [
        stage.meta("ann"),
        stage.wave(0, 60, "ann"),
        other,
        stage.wave(0, 60, "bob"),
        stage.wave(60, 60, "ann"),
    ]
    with caplog.at_level(logging.WARNING, "mossar"):
        outcome = Pipeline([stage.Script(items)], [stage.Collected()], Settings(limbs="hands=hand")).run()
    assert (outcome.frames, outcome.errors) == (120, [])
    assert "bob cannot be followed: limb hands: no joint called 'hand'" in caplog.messages[0]
