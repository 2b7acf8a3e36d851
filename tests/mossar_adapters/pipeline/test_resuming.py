import pytest

from mossar_adapters.pipeline import Pipeline, Upkeep, read_snapshot
from mossar_adapters.replay.recording_source import RecordingSource
from mossar_stream.errors import SnapshotError
from mossar_stream.settings import Settings


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
