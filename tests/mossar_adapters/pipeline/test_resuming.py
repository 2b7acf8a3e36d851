import json

import pytest

from mossar_adapters.demo import performance
from mossar_adapters.pipeline import Pipeline, Upkeep, read_snapshot
from mossar_adapters.replay.recording_source import RecordingSource
from mossar_adapters.source import Recording
from mossar_adapters.zeromq.decoder import ZmqDecoder, ZmqMessage
from mossar_stream import Frames, MoveEvent, Moves, Settings, SnapshotError


def run(stage, path, *, stop_after=None):
    """Run over the recording, or only over its first chunks, and return the events."""
    sink = stage.Collected()
    source = RecordingSource(stage.recording())
    found = read_snapshot(path)
    resume = found if found is not None and not found.complete else None
    pipeline = Pipeline([source], [sink], upkeep=Upkeep(snapshot=path), resume=resume)
    if stop_after is not None:
        seen = iter(range(stop_after))
        push = pipeline.pool.push
        pipeline.pool.push = lambda frames: (next(seen, None) is None and pipeline.stop()) or push(frames)
    pipeline.run()
    return sink.events


@pytest.mark.parametrize("taught_meanwhile", [False, True])
def test_a_run_that_goes_on_recognises_the_moves_of_now_and_logs_that_they_changed(
    stage, tmp_path, caplog, taught_meanwhile
):
    take = performance(2, fps=30.0, seconds=20.0, moves=["rest:1", "punch_left", "rest:1", "kick_right"] * 4)
    positions, times = take.frames.positions, take.frames.times
    moves = Moves(take.skeleton)
    shown = performance(7, fps=30.0, seconds=4.0, moves=["rest:1", "punch_left", "rest:1"])
    moves.add("punch", shown.frames.positions, fps=30)

    def part(stop_after=None):
        def chunks():
            for i in range(0, len(times), 30):
                yield Frames(positions[i : i + 30], times[i : i + 30])

        sink = stage.Collected()
        recording = Recording("take.msk", take.skeleton, 30.0, chunks, (), len(times))
        pipeline = Pipeline(
            [RecordingSource(recording)],
            [sink],
            moves=Moves.from_json(moves.to_json()),
            upkeep=Upkeep(snapshot=tmp_path / "state"),
            resume=read_snapshot(tmp_path / "state"),
        )
        if stop_after is not None:
            seen = iter(range(stop_after))
            push = pipeline.pool.push
            pipeline.pool.push = lambda frames: (next(seen, None) is None and pipeline.stop()) or push(frames)
        pipeline.run()
        return [event.name for event in sink.of(MoveEvent) if event.status == "confirmed"]

    assert "kick" not in part(stop_after=6)
    if taught_meanwhile:
        shown = performance(8, fps=30.0, seconds=4.0, moves=["rest:1", "kick_right", "rest:1"])
        moves.add("kick", shown.frames.positions, fps=30)
    caplog.clear()
    names = part()
    assert "punch" in names
    assert ("kick" in names) == taught_meanwhile
    assert ("moves are not those of the snapshot" in caplog.text) == taught_meanwhile


@pytest.mark.parametrize("stop_after", [0, 1, 3])
def test_a_run_that_was_cut_short_and_one_that_went_on_are_one_run(stage, tmp_path, stop_after):
    whole = stage.Collected()
    Pipeline([RecordingSource(stage.recording())], [whole]).run()
    first = run(stage, tmp_path / "state", stop_after=stop_after)
    second = run(stage, tmp_path / "state")
    assert first + second == whole.events
    assert len(first) < len(whole.events)


def test_a_run_that_ended_is_complete_and_the_next_starts_anew(stage, tmp_path):
    first = run(stage, tmp_path / "state")
    assert read_snapshot(tmp_path / "state").complete
    assert run(stage, tmp_path / "state") == first


def test_settings_that_control_changed_hold_after_a_restart_too(stage, tmp_path):
    def changed(path, *, stop_after=None):
        found = read_snapshot(path)
        pipeline = Pipeline(
            [RecordingSource(stage.recording())],
            [stage.Collected()],
            upkeep=Upkeep(snapshot=path),
            resume=found,
        )
        if stop_after is not None:
            pipeline.set({"sig_threshold": 0.07, "level": 0.4})
            seen = iter(range(stop_after))
            push = pipeline.pool.push
            pipeline.pool.push = lambda frames: (next(seen, None) is None and pipeline.stop()) or push(frames)
        pipeline.run()
        return pipeline.pool

    changed(tmp_path / "state", stop_after=2)
    pool = changed(tmp_path / "state")
    assert (pool.settings.sig_threshold, pool.settings.level) == (0.07, 0.4)
    pool.announce("new", stage.meta().skeleton)
    assert pool["new"].settings == pool.settings
    assert pool["p1"].settings.sig_threshold == 0.07


def test_other_settings_or_sources_are_refused(stage, tmp_path):
    run(stage, tmp_path / "state", stop_after=1)
    snapshot = read_snapshot(tmp_path / "state")
    with pytest.raises(SnapshotError, match="other settings"):
        Pipeline([RecordingSource(stage.recording())], [], Settings(window=0.3), resume=snapshot)
    with pytest.raises(SnapshotError, match="other sources"):
        Pipeline([RecordingSource(stage.recording("other.msk"))], [], resume=snapshot)


def test_snapshots_are_written_while_running(stage, tmp_path):
    path = tmp_path / "state"
    source = stage.Script([stage.meta(), stage.wave(0, 60), 0.3, stage.wave(60, 60), 0.3])
    found = []
    pipeline = Pipeline(
        [source],
        [stage.Collected()],
        upkeep=Upkeep(snapshot=path, period=0.1),
        tick=lambda: found.append(read_snapshot(path)),
    )
    pipeline.run()
    frames = {s.sources[0].frames.get("p1") for s in found if s is not None and not s.complete}
    assert {60, 120} <= frames


def test_outputs_are_on_the_disk_before_the_snapshot_that_counts_on_them(stage, tmp_path, monkeypatch):
    done = []

    class Kept(stage.Collected):
        def position(self):
            return len(self.events)

        def sync(self):
            done.append(("sync", len(self.events)))

    def written(_, snapshot):
        done.append(("snapshot", snapshot.sinks["collected"]))

    monkeypatch.setattr("mossar_adapters.pipeline.upkeep.write_snapshot", written)
    source = RecordingSource(stage.recording())
    Pipeline([source], [Kept()], upkeep=Upkeep(snapshot=tmp_path / "state")).run()
    assert [kind for kind, _ in done] == ["sync", "snapshot"] * (len(done) // 2)
    assert all(done[i][1] == done[i + 1][1] for i in range(0, len(done), 2))
    assert done[0] == ("sync", 0), (
        "before the first frame: a run that is killed then can go on with its outputs"
    )


def test_a_snapshot_that_cannot_be_written_is_a_failure_and_said_once(stage, tmp_path, caplog):
    sink = stage.Collected()
    script = stage.Script([stage.meta(), stage.wave(0, 60), 0.5])
    path = tmp_path / "no" / "state"
    outcome = Pipeline([script], [sink], upkeep=Upkeep(snapshot=path, period=0.1)).run()
    assert outcome.dead_sinks == [str(path)]
    assert outcome.frames == 60
    assert len([message for message in caplog.messages if "cannot be written" in message]) == 1


def test_a_sender_that_describes_its_skeleton_once_is_known_after_a_restart(stage, tmp_path):
    meta, wave = stage.meta(), stage.wave(0, 240)

    def message(number):
        joints = wave.positions[number].tolist()
        return {"type": "frame", "performer": "p1", "t": float(wave.times[number]), "xyz": joints}

    def heard(first, last, *, described):
        """Return what a fresh decoder makes of messages, as after a restart."""
        decoder, found = ZmqDecoder(), []
        maps = [message(number) for number in range(first, last)]
        if described:
            names = {"names": meta.skeleton.names, "parents": meta.skeleton.parents}
            maps.insert(0, {"type": "meta", "performer": "p1", **names, "root": meta.skeleton.root})
        for number, one in enumerate(maps):
            found += decoder.receive(ZmqMessage((json.dumps(one).encode(),), (first + number) / 30))
        return found

    def go_on(items, *, cut):
        sink, resume = stage.Collected(), read_snapshot(tmp_path / "state")
        source = stage.Script(items, live=False)
        pipeline = Pipeline(
            [source],
            [sink],
            Settings(limbs=True),
            upkeep=Upkeep(snapshot=tmp_path / "state"),
            resume=resume,
        )
        if cut:
            push, left = pipeline.pool.push, iter(range(119))
            pipeline.pool.push = lambda frames: (next(left, None) is None and pipeline.stop()) or push(frames)
        pipeline.run()
        return sink

    whole = stage.Collected()
    Pipeline([stage.Script(heard(0, 240, described=True))], [whole], Settings(limbs=True)).run()
    first = go_on(heard(0, 240, described=True), cut=True)
    second = go_on(heard(120, 240, described=False), cut=False)
    assert first.events + second.events == whole.events
    assert [own.skeleton for own in second.metas] == [meta.skeleton]
    assert not [event for event in second.events if getattr(event, "reason", "") == "another skeleton"]
