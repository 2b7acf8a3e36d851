import itertools
import logging
import threading
import time
from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from mossar_adapters.batch import MAX_PERFORMERS
from mossar_adapters.demo import DemoSource
from mossar_adapters.live import OutputClosedError
from mossar_adapters.pipeline import Ears, Pipeline, Upkeep, read_snapshot
from mossar_adapters.recording_source import RecordingSource
from mossar_adapters.source import Meta, Recording
from mossar_stream.errors import MossarError, SettingsError, SnapshotError
from mossar_stream.events import Event, KeyFrameEvent, SegmentEvent, StatsEvent, StreamEvent
from mossar_stream.frames import Frames
from mossar_stream.performers import Performers
from mossar_stream.settings import Settings
from mossar_stream.skeleton import Skeleton

SKELETON = Skeleton(("hip", "hand"), (-1, 0))


class Script:
    """A source that delivers what it is told to, and waits where it is told to."""

    def __init__(self, items: Sequence[object], *, live: bool = False, name: str = "script") -> None:
        self.name = name
        self.live = live
        self._items = items
        self._closed = threading.Event()

    def items(self) -> Iterator[Meta | Frames | None]:
        for item in self._items:
            if isinstance(item, float):
                until = time.monotonic() + item
                while (left := until - time.monotonic()) > 0:
                    if self._closed.wait(min(left, 0.1)):
                        return
                    yield None
            elif isinstance(item, Exception):
                raise item
            else:
                yield item

    def close(self) -> None:
        self._closed.set()


class Collected:
    """A sink that keeps what it gets."""

    def __init__(self, name: str = "collected") -> None:
        self.name = name
        self.dropped = 0
        self.metas: list[Meta] = []
        self.events: list[Event] = []
        self.closed = False

    def announce(self, meta: Meta) -> None:
        self.metas.append(meta)

    def send(self, events: Sequence[Event]) -> None:
        self.events += events

    def close(self) -> None:
        self.closed = True

    def of(self, kind: type) -> list[Event]:
        return [event for event in self.events if isinstance(event, kind)]


def wave(first: int = 0, count: int = 60, performer: str = "p1", fps: float = 30.0) -> Frames:
    """Frames of a hand that swings, numbered from `first`."""
    times = np.arange(first, first + count) / fps
    positions = np.zeros((count, 2, 3), np.float32)
    positions[:, 1, 0] = np.sin(2 * np.pi * times) * (np.sin(times) > 0)
    return Frames(positions, times, performer=performer)


def meta(performer: str = "p1") -> Meta:
    return Meta(performer, SKELETON, 30.0)


def demo(seconds=6.0, **options):
    return DemoSource(seconds=seconds, speed="max", **options)


def changes(sink):
    return [(event.performer, event.event, event.reason) for event in sink.of(StreamEvent)]


def recording(name="take.msk", chunk=30, count=240):
    frames = wave(0, count)

    def chunks():
        for i in range(0, count, chunk):
            yield Frames(frames.positions[i : i + chunk], frames.times[i : i + chunk])

    return Recording(name, SKELETON, 30.0, chunks, (), count)


def test_the_events_are_those_of_the_core():
    sink = Collected()
    outcome = Pipeline([demo()], [sink]).run()
    pool = Performers()
    expected = []
    for item in demo().items():
        if isinstance(item, Meta):
            expected += pool.announce(item.performer, item.skeleton, item.fps)
        elif isinstance(item, Frames):
            expected += pool.push(item)
    expected += pool.end_takes("end of stream")
    assert sink.events == expected
    assert [m.performer for m in sink.metas] == ["p1"]
    assert sink.closed
    assert outcome.complete
    assert outcome.frames == 360


def test_several_sinks_get_the_same_and_a_filter_changes_no_rev():
    everything, filtered, view = Collected(), Collected(), Collected()
    Pipeline([demo()], [everything]).run()
    Pipeline([demo()], [filtered], views=[view], emit=("key_frame.final",)).run()
    assert view.events == everything.events
    finals = [e for e in everything.events if isinstance(e, KeyFrameEvent) and e.status == "final"]
    assert filtered.events == finals != []


def test_performers_of_two_sources_with_the_same_name_stay_apart():
    sink = Collected()
    Pipeline([demo(seed=1), demo(seed=2)], [sink]).run()
    alone = Collected()
    Pipeline([demo(seed=2, performer="p2")], [alone]).run()
    assert [event for event in sink.events if event.performer == "p2"] == alone.events


def test_ten_performers_in_one_stream_give_the_events_of_ten_runs():
    together = Collected()
    Pipeline([demo(3.0, performers=10)], [together]).run()
    for k in range(10):
        alone = Collected()
        Pipeline([demo(3.0, seed=1 + k, performer=f"p{k + 1}")], [alone]).run()
        keys = [e for e in together.of(KeyFrameEvent) if e.performer == f"p{k + 1}"]
        times = [(e.frame, e.status, e.rev) for e in keys]
        assert times == [(e.frame, e.status, e.rev) for e in alone.of(KeyFrameEvent)]


def test_a_stall_is_reported_and_the_take_ends_after_the_pause():
    sink = Collected()
    source = Script([meta(), wave(0, 30), 0.75, wave(30, 30)], live=True)
    Pipeline([source], [sink], Settings(max_pause=0.6)).run()
    assert changes(sink) == [
        ("p1", "started", ""),
        ("p1", "stalled", "no frames for 0.3 s"),
        ("p1", "ended", "gap"),
        ("p1", "resumed", ""),
        ("p1", "started", ""),
        ("p1", "ended", "end of stream"),
    ]


def test_a_pause_of_a_recording_is_no_stall():
    sink = Collected()
    Pipeline([Script([meta(), wave(0, 30), 0.4, wave(30, 30)])], [sink]).run()
    assert [event for _, event, _ in changes(sink)] == ["started", "ended"]


def test_a_source_that_fails_ends_its_takes_and_the_others_go_on(caplog):
    sink = Collected()
    failing = Script([meta(), wave(0, 30), MossarError("the camera is gone")], name="camera")
    other = Script([meta("ann"), wave(0, 60, "ann")])
    with caplog.at_level(logging.ERROR, "mossar"):
        outcome = Pipeline([failing, other], [sink]).run()
    assert ("p1", "ended", "source failed") in changes(sink)
    assert ("ann", "ended", "end of stream") in changes(sink)
    assert [str(error) for error in outcome.errors] == ["the camera is gone"]
    assert caplog.messages == ["camera: the camera is gone"]


def test_frames_that_do_not_fit_are_counted_and_the_stream_goes_on(caplog):
    sink = Collected()
    odd = Frames(np.zeros((3, 5, 3), np.float32), np.arange(3.0))
    unknown = wave(0, 5, "nobody")
    outcome = Pipeline(
        [Script([meta(), odd, wave(0, 60), odd, unknown])], [sink], upkeep=Upkeep(stats=100)
    ).run()
    assert outcome.frames == 60
    assert sink.of(StatsEvent)[-1].malformed == 6
    assert sum("cannot be used" in message for message in caplog.messages) == 2


def test_stats_tell_frames_rate_and_delays():
    sink = Collected()
    Pipeline([demo()], [sink], upkeep=Upkeep(stats=100)).run()
    stats = sink.of(StatsEvent)[-1]
    assert (stats.frames, stats.fps) == (360, 60.0)
    assert 0 < stats.latency_p50_ms <= stats.latency_p99_ms


def test_a_sink_that_fails_does_not_stop_the_others(caplog):
    class Broken(Collected):
        def send(self, events):
            raise OSError("no space left" if events else "")

    sink = Collected()
    outcome = Pipeline([demo()], [Broken("disk"), sink]).run()
    assert outcome.dead_sinks == ["disk"]
    assert changes(sink)[-1][1] == "ended"
    assert "disk failed and gets no more events: no space left" in caplog.messages


def test_the_run_ends_when_nobody_reads_the_output_any_more():
    class Left(Collected):
        def send(self, events):
            raise OutputClosedError(f"closed before {len(events)} events")

    outcome = Pipeline([demo(None)], [Left()]).run()
    assert outcome.abandoned
    assert not outcome.complete


def test_a_sink_that_never_returns_stalls_neither_stream_nor_end():
    class Dead(Collected):
        def send(self, events):
            threading.Event().wait(60 + len(events))

    sink = Collected()
    source = Script([meta(), *[wave(i, 1) for i in range(60)]], live=True)
    start = time.monotonic()
    Pipeline([source], [sink, Dead("dead")]).run()
    assert changes(sink)[-1][1] == "ended"
    assert time.monotonic() - start < 8


def test_stopping_flushes_the_take():
    sink = Collected()
    pipeline = Pipeline([Script([meta(), wave(0, 60), 60.0])], [sink])
    threading.Timer(0.2, pipeline.stop).start()
    outcome = pipeline.run()
    assert changes(sink)[-1] == ("p1", "ended", "stopped")
    assert sink.events[-2].status == "final"
    assert not outcome.complete


def test_seconds_end_the_run_at_the_frame():
    sink = Collected()
    outcome = Pipeline([demo(None)], [sink], seconds=2.0).run()
    assert outcome.frames == 120
    assert outcome.complete


def test_silence_is_explained(caplog, monkeypatch):
    monkeypatch.setattr("mossar_adapters.pipeline.upkeep.SILENCE", 0.1)
    source = Script([0.4], live=True, name="osc://127.0.0.1:9")
    source.explain = lambda: "osc://127.0.0.1:9: listening; no datagram came yet"
    with caplog.at_level(logging.WARNING, "mossar"):
        Pipeline([source], [Collected()]).run()
    assert caplog.messages == ["osc://127.0.0.1:9: listening; no datagram came yet"]


def test_a_full_queue_is_said_and_counted(caplog):
    sink = Collected()
    chunks = [wave(i * 500, 500) for i in range(12)]
    pipeline = Pipeline([Script([meta(), *chunks], live=True)], [sink], upkeep=Upkeep(stats=100))
    pipeline.feeds[0].start()
    pipeline.feeds[0].join(2)
    pipeline.feeds[0].start = lambda: None
    pipeline.run()
    assert sink.of(StatsEvent)[-1].queue_dropped == 4000
    assert any("4000 frames were dropped" in message for message in caplog.messages)


def test_who_leaves_ends_a_take():
    sink, ears = Collected(), Ears()
    source = Script([meta(), wave(0, 60), 0.25])
    pipeline = Pipeline([source], [sink])
    ears.tie(pipeline, 0)
    threading.Timer(0.05, lambda: ears.lost("p1", "user lost")).start()
    pipeline.run()
    assert changes(sink)[-1] == ("p1", "ended", "user lost")


def test_range_file_is_refused_for_streams():
    with pytest.raises(SettingsError, match="mossar segment"):
        Pipeline([demo()], [], Settings(range="file"))


def test_a_take_tells_sinks_when_it_began():
    class Clocked(Collected):
        def begin_take(self, performer, take, time):
            self.events.append((performer, take, round(time, 3)))

    sink = Clocked()
    Pipeline([Script([meta(), wave(30, 30), wave(300, 30)])], [sink]).run()
    begins = [event for event in sink.events if isinstance(event, tuple)]
    assert begins == [("p1", 0, 1.0), ("p1", 1, 10.0)]


class TestSnapshots:
    def run(self, path, *, stop_after=None):
        """Run over the recording, or only over its first chunks, and return the events."""
        sink = Collected()
        source = RecordingSource(recording())
        found = read_snapshot(path)
        resume = found if found is not None and not found.complete else None
        pipeline = Pipeline([source], [sink], upkeep=Upkeep(snapshot=path), resume=resume)
        if stop_after is not None:
            seen = iter(range(stop_after))
            push = pipeline.pool.push
            pipeline.pool.push = lambda frames: (next(seen, None) is None and pipeline.stop()) or push(frames)
        pipeline.run()
        return sink.events

    @pytest.mark.parametrize("stop_after", [0, 1, 3])
    def test_a_run_that_was_cut_short_and_one_that_went_on_are_one_run(self, tmp_path, stop_after):
        whole = Collected()
        Pipeline([RecordingSource(recording())], [whole]).run()
        first = self.run(tmp_path / "state", stop_after=stop_after)
        second = self.run(tmp_path / "state")
        assert first + second == whole.events
        assert len(first) < len(whole.events)

    def test_a_run_that_ended_is_complete_and_the_next_starts_anew(self, tmp_path):
        first = self.run(tmp_path / "state")
        assert read_snapshot(tmp_path / "state").complete
        assert self.run(tmp_path / "state") == first

    def test_other_settings_or_sources_are_refused(self, tmp_path):
        self.run(tmp_path / "state", stop_after=1)
        snapshot = read_snapshot(tmp_path / "state")
        with pytest.raises(SnapshotError, match="other settings"):
            Pipeline([RecordingSource(recording())], [], Settings(window=0.3), resume=snapshot)
        with pytest.raises(SnapshotError, match="other sources"):
            Pipeline([RecordingSource(recording("other.msk"))], [], resume=snapshot)

    def test_snapshots_are_written_while_running(self, tmp_path):
        path = tmp_path / "state"
        source = Script([meta(), wave(0, 60), 0.3, wave(60, 60), 0.3])
        found = []
        pipeline = Pipeline(
            [source],
            [Collected()],
            upkeep=Upkeep(snapshot=path, period=0.1),
            tick=lambda: found.append(read_snapshot(path)),
        )
        pipeline.run()
        frames = {s.sources[0].frames.get("p1") for s in found if s is not None and not s.complete}
        assert {60, 120} <= frames


def test_segments_follow_each_other_without_gaps():
    sink = Collected()
    Pipeline([demo()], [sink]).run()
    finals = [e for e in sink.of(SegmentEvent) if e.status == "final"]
    assert all(a.end_frame == b.start_frame for a, b in itertools.pairwise(finals))


def test_a_sender_that_invents_performers_takes_no_more_memory_than_the_most_of_them():
    names = [f"p{k}" for k in range(3 * MAX_PERFORMERS)]
    items = [item for name in names for item in (meta(name), wave(0, 3, name))]
    pipeline = Pipeline([Script(items)], [Collected()])
    pipeline.run()
    assert pipeline.outcome.frames == 3 * len(names)
    facts = (pipeline.pool.names, pipeline.latency, pipeline.times, pipeline.naming.of_source(0))
    assert [len(fact) for fact in facts] == [MAX_PERFORMERS] * 4
    assert pipeline.pool.names[-1] == names[-1]
