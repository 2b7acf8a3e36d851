import itertools
import logging
import threading
import time

import msgspec
import numpy as np
import pytest

from mossar_adapters.live import Counters, OutputClosedError
from mossar_adapters.pipeline import Pipeline, Upkeep
from mossar_adapters.pipeline.newcomers import LARGE_AT_ONCE, ORDINARY, Allowance
from mossar_adapters.source import Departure, Meta
from mossar_stream import (
    Frames,
    KeyFrameEvent,
    MossarError,
    Performers,
    SegmentEvent,
    Settings,
    SettingsError,
    Skeleton,
    StatsEvent,
    StreamEvent,
)


def test_the_events_are_those_of_the_core(stage):
    sink = stage.Collected()
    outcome = Pipeline([stage.demo()], [sink]).run()
    pool = Performers()
    expected = []
    for item in stage.demo().items():
        if isinstance(item, Meta):
            expected += pool.announce(item.performer, item.skeleton, item.fps)
        elif isinstance(item, Frames):
            expected += pool.push(item)
    expected += pool.end_takes("end of stream")
    of_the_core = [
        msgspec.structs.replace(event, run=None) if isinstance(event, StreamEvent) else event
        for event in sink.events
    ]
    assert of_the_core == expected
    assert [m.performer for m in sink.metas] == ["p1"]
    assert sink.closed
    assert outcome.complete
    assert outcome.frames == 360


def test_several_sinks_get_the_same_and_a_filter_changes_no_rev(stage):
    everything, filtered, view = stage.Collected(), stage.Collected(), stage.Collected()
    Pipeline([stage.demo()], [everything]).run()
    Pipeline([stage.demo()], [filtered], views=[view], emit=("key_frame.final",)).run()
    assert view.events == everything.events
    finals = [e for e in everything.events if isinstance(e, KeyFrameEvent) and e.status == "final"]
    assert filtered.events == finals != []


def test_performers_of_two_sources_with_the_same_name_stay_apart(stage):
    sink = stage.Collected()
    Pipeline([stage.demo(seed=1), stage.demo(seed=2)], [sink]).run()
    alone = stage.Collected()
    Pipeline([stage.demo(seed=2, performer="p2")], [alone]).run()
    assert [event for event in sink.events if event.performer == "p2"] == alone.events


def test_a_stall_is_reported_and_the_take_ends_after_the_pause(stage):
    sink = stage.Collected()
    source = stage.Script([stage.meta(), stage.wave(0, 30), 0.75, stage.wave(30, 30)], live=True)
    Pipeline([source], [sink], Settings(max_pause=0.6)).run()
    assert stage.changes(sink) == [
        ("p1", "started", ""),
        ("p1", "stalled", "no frames for 0.3 s"),
        ("p1", "ended", "frames stopped"),
        ("p1", "started", ""),
        ("p1", "resumed", ""),
        ("p1", "ended", "end of stream"),
    ]


def test_a_pause_of_a_recording_is_no_stall(stage):
    sink = stage.Collected()
    Pipeline([stage.Script([stage.meta(), stage.wave(0, 30), 0.4, stage.wave(30, 30)])], [sink]).run()
    assert [event for _, event, _ in stage.changes(sink)] == ["started", "ended"]


def test_a_source_that_fails_ends_its_takes_and_the_others_go_on(stage, caplog):
    sink = stage.Collected()
    failing = stage.Script(
        [stage.meta(), stage.wave(0, 30), MossarError("the camera is gone")], name="camera"
    )
    other = stage.Script([stage.meta("ann"), stage.wave(0, 60, "ann")])
    with caplog.at_level(logging.ERROR, "mossar"):
        outcome = Pipeline([failing, other], [sink]).run()
    assert ("p1", "ended", "source failed") in stage.changes(sink)
    assert ("ann", "ended", "end of stream") in stage.changes(sink)
    assert [str(error) for error in outcome.errors] == ["the camera is gone"]
    assert caplog.messages == ["camera: the camera is gone"]


def test_frames_that_do_not_fit_are_counted_and_the_stream_goes_on(stage, caplog):
    sink = stage.Collected()
    odd = Frames(np.zeros((3, 5, 3), np.float32), np.arange(3.0))
    unknown = stage.wave(0, 5, "nobody")
    outcome = Pipeline(
        [stage.Script([stage.meta(), odd, stage.wave(0, 60), odd, unknown])], [sink], upkeep=Upkeep(stats=100)
    ).run()
    assert outcome.frames == 60
    assert sink.of(StatsEvent)[-1].malformed == 6
    assert sum("cannot be used" in message for message in caplog.messages) == 2


def test_the_last_stats_know_the_delays_of_a_slow_sink_too(stage):
    class Slow(stage.Collected):
        def send(self, events):
            time.sleep(0.02)
            super().send(events)

    sink = Slow()
    Pipeline([stage.demo(3.0)], [sink], upkeep=Upkeep(stats=100)).run()
    assert sink.of(StatsEvent)[-1].latency_p99_ms > 20


def test_stats_tell_frames_rate_and_delays(stage):
    sink = stage.Collected()
    Pipeline([stage.demo()], [sink], upkeep=Upkeep(stats=100)).run()
    stats = sink.of(StatsEvent)[-1]
    assert (stats.frames, stats.fps) == (360, 60.0)
    assert 0 < stats.latency_p50_ms <= stats.latency_p99_ms


def test_the_rate_is_right_after_a_clock_was_set_back(stage):
    sink = stage.Collected()
    before, after = stage.wave(30_000, 60), stage.wave(0, 60)
    Pipeline([stage.Script([stage.meta(), before, after])], [sink], upkeep=Upkeep(stats=9.0)).run()
    (stats,) = sink.of(StatsEvent)
    assert stats.frames == 120
    assert stats.fps == pytest.approx(30.0, rel=0.02)


def test_a_run_of_some_seconds_ends_though_a_clock_is_set_back(stage):
    items = [stage.meta(), stage.wave(30_000, 60), *(stage.wave(30 * k, 30) for k in range(10))]
    outcome = Pipeline([stage.Script(items)], [stage.Collected()], seconds=4.0).run()
    assert outcome.frames == pytest.approx(4 * 30, abs=2)


def test_frames_after_the_end_of_a_run_do_not_count_in_its_rate(stage):
    sink = stage.Collected()
    items = [stage.meta(), stage.wave(0, 300)]
    Pipeline([stage.Script(items)], [sink], seconds=2.0, upkeep=Upkeep(stats=9.0)).run()
    (stats,) = sink.of(StatsEvent)
    assert (stats.frames, stats.fps) == (60, pytest.approx(30.0, rel=0.02))


def test_stats_right_after_others_have_a_rate(stage):
    sink, upkeep = stage.Collected(), Upkeep(stats=9.0)
    pipeline = Pipeline([stage.Script([stage.meta(), stage.wave(0, 300)])], [sink], upkeep=upkeep)
    pipeline.run()
    assert [upkeep.stats_of(pipeline, "p1").fps for _ in range(3)] == [pytest.approx(30.0)] * 3


def test_a_frame_out_of_order_lets_no_time_pass(stage):
    sink = stage.Collected()
    frames = stage.wave(0, 90)
    times = frames.times.copy()
    times[40:50] -= 0.5
    items = [stage.meta(), Frames(frames.positions, times)]
    Pipeline([stage.Script(items)], [sink], upkeep=Upkeep(stats=9.0)).run()
    (stats,) = sink.of(StatsEvent)
    assert stats.fps <= 30.0


def test_a_clock_of_nonsense_has_no_infinite_rate(stage):
    sink = stage.Collected()
    pose = np.zeros((2, 2, 3), np.float32)
    frames = Frames(pose, np.array([0.0, 5e-324]))
    Pipeline([stage.Script([stage.meta(), frames])], [sink], upkeep=Upkeep(stats=9.0)).run()
    assert [event.fps for event in sink.of(StatsEvent)] == [0.0]


def test_a_sink_that_fails_does_not_stop_the_others(stage, caplog):
    class Broken(stage.Collected):
        def send(self, events):
            raise OSError("no space left" if events else "")

    sink = stage.Collected()
    outcome = Pipeline([stage.demo()], [Broken("disk"), sink]).run()
    assert outcome.dead_sinks == ["disk"]
    assert stage.changes(sink)[-1][1] == "ended"
    assert "disk failed and gets no more events: no space left" in caplog.messages


def test_the_run_ends_when_nobody_reads_the_output_any_more(stage):
    class Departure(stage.Collected):
        def send(self, events):
            raise OutputClosedError(f"closed before {len(events)} events")

    outcome = Pipeline([stage.demo(None)], [Departure()]).run()
    assert outcome.abandoned
    assert not outcome.complete


def test_a_sink_that_never_returns_stalls_neither_stream_nor_end(stage, monkeypatch):
    monkeypatch.setattr("mossar_adapters.pipeline.outlet.PATIENCE", 0.2)
    monkeypatch.setattr("mossar_adapters.pipeline.outlet._CLOSING", 0.1)

    class Dead(stage.Collected):
        def send(self, events):
            threading.Event().wait(60 + len(events))

    sink = stage.Collected()
    source = stage.Script([stage.meta(), *[stage.wave(i, 1) for i in range(60)]], live=True)
    start = time.monotonic()
    Pipeline([source], [sink, Dead("dead")]).run()
    assert stage.changes(sink)[-1][1] == "ended"
    assert time.monotonic() - start < 2


def test_sinks_are_called_now_and_then_without_events(stage):
    class Patient(stage.Collected):
        def send(self, events):
            self.calls = [*getattr(self, "calls", []), len(events)]

    sink = Patient()
    Pipeline([stage.Script([0.5])], [sink]).run()
    assert sink.calls[:2] == [0, 0]


def test_another_skeleton_begins_the_next_take_and_ids_stay_unique(stage):
    sink = stage.Collected()
    other = Meta("p1", Skeleton(("hip", "hand", "head"), (-1, 0, 0)), 30.0)
    wider = stage.wave(60, 60)
    wider = Frames(np.repeat(wider.positions, [1, 2], axis=1), wider.times)
    Pipeline(
        [stage.Script([stage.meta(), stage.wave(0, 60), other, wider])], [sink], upkeep=Upkeep(stats=100)
    ).run()
    assert [(e.event, e.take) for e in sink.of(StreamEvent)] == [
        ("started", 0),
        ("ended", 0),
        ("started", 1),
        ("ended", 1),
    ]
    revs = [(e.id, e.rev) for e in sink.of(KeyFrameEvent)]
    assert len(set(revs)) == len(revs)
    assert sink.of(StatsEvent)[-1].frames == 120


def test_stopping_flushes_the_take(stage):
    sink = stage.Collected()
    pipeline = Pipeline([stage.Script([stage.meta(), stage.wave(0, 60), 60.0])], [sink])
    threading.Timer(0.2, pipeline.stop).start()
    outcome = pipeline.run()
    assert stage.changes(sink)[-1] == ("p1", "ended", "stopped")
    assert sink.events[-2].status == "final"
    assert not outcome.complete


def test_seconds_end_the_run_at_the_frame(stage):
    sink = stage.Collected()
    outcome = Pipeline([stage.demo(None)], [sink], seconds=2.0).run()
    assert outcome.frames == 120
    assert outcome.complete


def test_silence_is_explained(stage, caplog, monkeypatch):
    monkeypatch.setattr("mossar_adapters.pipeline.upkeep.SILENCE", 0.1)
    source = stage.Script([0.4], live=True, name="osc://127.0.0.1:9")
    source.explain = lambda: "osc://127.0.0.1:9: listening; no datagram came yet"
    with caplog.at_level(logging.WARNING, "mossar"):
        Pipeline([source], [stage.Collected()]).run()
    assert caplog.messages == ["osc://127.0.0.1:9: listening; no datagram came yet"]


@pytest.mark.parametrize("nowhere", [np.nan, 3e5])
def test_frames_in_which_nobody_is_are_counted_and_told_of_once(stage, caplog, nowhere):
    nobody = np.full((30, 2, 3), nowhere, np.float32)
    items = [stage.meta(), *(Frames(nobody, (30 * k + np.arange(30)) / 60) for k in range(5))]
    sink = stage.Collected()
    Pipeline([stage.Script(items)], [sink], upkeep=Upkeep(stats=9.0)).run()
    stats = [event for event in sink.events if isinstance(event, StatsEvent)]
    assert stats[-1].unseen == stats[-1].frames == 150
    assert caplog.text.count("p1: frames come without a tracked joint") == 1


def test_most_frames_are_never_dropped_without_a_line(stage, caplog):
    positions = np.random.default_rng(1).normal(size=(30, 2, 3)).astype(np.float32)
    items = [stage.meta(), *(Frames(positions, np.full(30, 7.0)) for _ in range(3))]
    Pipeline([stage.Script(items)], [stage.Collected()]).run()
    assert [message for message in caplog.messages if "dropped" in message] == [
        "p1: 89 of 90 frames are dropped: their times are not later than those before"
    ]


@pytest.mark.parametrize(
    ("trickle", "said"),
    [
        (False, "live: the frames have stopped, and nothing else comes; is the sender still running?"),
        (True, "live: the frames have stopped; 3 messages came since, without a frame. it listens"),
    ],
)
def test_frames_that_have_stopped_are_told_from_those_that_never_came(
    stage, caplog, monkeypatch, trickle, said
):
    monkeypatch.setattr("mossar_adapters.pipeline.upkeep.SILENCE", 0.4)
    source = stage.Script([stage.meta(), stage.wave(0, 30), 0.8], live=True, name="live")
    source.counters = Counters(received=30)
    source.explain = lambda: "it listens"
    if trickle:
        later = threading.Timer(0.3, lambda: setattr(source.counters, "received", 33))
        later.start()
    with caplog.at_level(logging.WARNING, "mossar"):
        Pipeline([source], [stage.Collected()]).run()
    assert caplog.messages == [said]


def test_a_full_queue_is_said_and_counted(stage, caplog):
    sink = stage.Collected()
    chunks = [stage.wave(i * 500, 500) for i in range(12)]
    pipeline = Pipeline([stage.Script([stage.meta(), *chunks], live=True)], [sink], upkeep=Upkeep(stats=100))
    pipeline.feeds[0].start()
    pipeline.feeds[0].join(2)
    pipeline.feeds[0].start = lambda: None
    pipeline.run()
    assert sink.of(StatsEvent)[-1].queue_dropped == 4000
    assert any("4000 frames were dropped" in message for message in caplog.messages)


def test_who_leaves_ends_a_take(stage):
    sink = stage.Collected()
    items = [
        Departure("p1", "unknown"),
        stage.meta(),
        stage.wave(0, 60),
        Departure("p1", "lost user"),
        stage.wave(60, 60),
    ]
    Pipeline([stage.Script(items, live=True)], [sink]).run()
    assert stage.changes(sink) == [
        ("p1", "started", ""),
        ("p1", "ended", "lost user"),
        ("p1", "started", ""),
        ("p1", "ended", "end of stream"),
    ]
    last = max(event.end_frame for event in sink.of(SegmentEvent) if event.take == 0)
    assert last == 59, "who left is told behind the last frame, however long frames waited"


def test_range_file_is_refused_for_streams(stage):
    with pytest.raises(SettingsError, match="mossar segment"):
        Pipeline([stage.demo()], [], Settings(range="file"))


def test_a_take_tells_sinks_when_it_began(stage):
    class Clocked(stage.Collected):
        def begin_take(self, performer, take, time):
            self.events.append((performer, take, round(time, 3)))

    sink = Clocked()
    Pipeline([stage.Script([stage.meta(), stage.wave(30, 30), stage.wave(300, 30)])], [sink]).run()
    begins = [event for event in sink.events if isinstance(event, tuple)]
    assert begins == [("p1", 0, 1.0), ("p1", 1, 10.0)]


def test_a_take_that_begins_within_a_chunk_after_one_that_the_wall_clock_ended_tells_when(stage):
    """The first frame of the chunk begins a take, and a leap in the chunk another one."""

    class Clocked(stage.Collected):
        def begin_take(self, performer, take, time):
            self.events.append((performer, take, round(time, 3)))

    sink = Clocked()
    frames = stage.wave(60, 60)
    frames.times[30:] += 5
    script = [stage.meta(), stage.wave(0, 30), 1.5, stage.wave(30, 30), Departure("p1", "gone"), frames]
    Pipeline([stage.Script(script, live=True)], [sink]).run()
    begins = [event for event in sink.events if isinstance(event, tuple)]
    assert begins == [("p1", 0, 0.0), ("p1", 1, 1.0), ("p1", 2, 2.0), ("p1", 3, 8.0)]


def test_max_pause_changed_while_running_is_that_of_the_wall_clock_too(stage):
    sink = stage.Collected()
    script = stage.Script([stage.meta(), stage.wave(0, 60), 0.9, stage.wave(60, 30), 0.2], live=True)
    pipeline = Pipeline([script], [sink])
    pipeline.ask(lambda: pipeline.set({"max_pause": 0.4}))
    pipeline.run()
    assert ("p1", "ended", "frames stopped") in stage.changes(sink)


def test_segments_follow_each_other_without_gaps(stage):
    sink = stage.Collected()
    Pipeline([stage.demo()], [sink]).run()
    finals = [e for e in sink.of(SegmentEvent) if e.status == "final"]
    assert all(a.end_frame == b.start_frame for a, b in itertools.pairwise(finals))


def test_sinks_that_take_long_to_close_are_closed_together(stage):
    class Lingering(stage.Collected):
        def close(self):
            time.sleep(0.4)
            super().close()

    sinks = [Lingering() for _ in range(5)]
    pipeline = Pipeline([stage.demo()], sinks)
    pipeline.stop()
    began = time.monotonic()
    pipeline.run()
    assert time.monotonic() - began < 1.0
    assert all(sink.closed for sink in sinks)


def test_limbs_wanted_of_skeletons_without_any_are_logged_once(stage, caplog):
    one = Skeleton(("hand",), (-1,))
    items = []
    for name in ("ann", "bob"):
        frames = stage.wave(performer=name)
        alone = Frames(frames.positions[:, -1:], frames.times, performer=name)
        items += [Meta(name, one, 30.0), alone]
    sink = stage.Collected()
    outcome = Pipeline([stage.Script(items)], [sink], Settings(limbs=True)).run()
    assert outcome.frames == 120
    assert not outcome.errors
    assert [record.getMessage() for record in caplog.records].count(
        "script: ann has no limbs, as no joint of its skeleton can move against another; it is segmented as without limbs"
    ) == 1
    assert "bob" not in caplog.text


def test_a_stranger_with_ever_new_skeletons_is_put_off_and_the_others_are_followed(stage, caplog):
    items, joints = [stage.meta()], 200
    for number in range(150):
        items.append(stage.wave(number, 1))
        names = tuple(f"{number}_{joint}" for joint in range(joints))
        items.append(Meta("z", Skeleton(names), 30.0))
        items.append(Frames(np.ones((1, joints, 3), np.float32), np.array([number / 30]), performer="z"))
    items += [stage.meta("late"), stage.wave(performer="late")]
    pipeline = Pipeline([stage.Script(items, live=True)], [sink := stage.Collected()])
    pipeline.run()
    assert pipeline.pool["p1"].stats["frames"] == 150
    assert pipeline.pool["late"].stats["frames"] == 60
    began = sum(e.event == "started" for e in sink.of(StreamEvent) if e.performer == "z")
    assert LARGE_AT_ONCE // (joints - ORDINARY) <= began < 150
    assert pipeline.performers["z"].unusable == 150 - began
    assert caplog.text.count("more new performers or skeletons come than one second allows") == 1


@pytest.mark.parametrize(
    ("joints", "at_once", "in_ten_seconds"),
    [(21, 256, 256), (32, 256, 256), (128, 102, 150), (300, 11, 35), (1024, 2, 6)],
)
def test_a_crowd_begins_at_once_and_large_skeletons_one_after_the_other(joints, at_once, in_ten_seconds):
    allowance = Allowance()
    began = sum(allowance.grants(joints, 0.0) for _ in range(256))
    assert began == at_once
    began += sum(allowance.grants(joints, at / 20) for at in range(1, 201) if began < 256)
    assert in_ten_seconds <= began


def test_whoever_brings_large_skeletons_keeps_no_ordinary_performer_out():
    allowance = Allowance()
    assert not all(allowance.grants(1024, at / 20) for at in range(100))
    assert all(allowance.grants(32, 5.0) for _ in range(100))


def test_a_recording_may_change_its_skeleton_as_often_as_it_likes(stage):
    items = []
    for number in range(100):
        names = tuple(f"{number}_{joint}" for joint in range(400))
        items.append(Meta("z", Skeleton(names), 30.0))
        items.append(Frames(np.ones((1, 400, 3), np.float32), np.array([number / 30]), performer="z"))
    pipeline = Pipeline([stage.Script(items)], [])
    pipeline.run()
    assert not pipeline.performers["z"].unusable
    assert pipeline.outcome.frames == 100
