"""A run has a name, by which receivers tell its events from those of another run with the same ids."""

import pytest

from mossar_adapters.pipeline import Pipeline, Upkeep, read_snapshot
from mossar_adapters.pipeline.pipeline import new_run_id
from mossar_adapters.replay.recording_source import RecordingSource
from mossar_stream import StreamEvent


def run_of(sink):
    """The one name that all beginnings of takes and all metas have."""
    names = {event.run for event in sink.of(StreamEvent) if event.event == "started"}
    return (names | {meta.run for meta in sink.metas}).pop()


def test_every_run_has_a_name_of_its_own_in_metas_and_beginnings_only(stage, monkeypatch):
    monkeypatch.setattr("mossar_adapters.pipeline.pipeline.new_run_id", new_run_id)
    sinks = [stage.Collected(), stage.Collected()]
    for sink in sinks:
        Pipeline([stage.demo(seconds=2.0)], [sink]).run()
        assert sink.metas
        assert {event.run is None for event in sink.of(StreamEvent) if event.event != "started"} == {True}
    first, second = map(run_of, sinks)
    assert first != second


def test_a_name_can_be_given(stage):
    sink = stage.Collected()
    Pipeline([stage.demo(seconds=2.0)], [sink], run_id="monday").run()
    assert run_of(sink) == "monday"


def test_a_run_that_goes_on_keeps_its_name(stage, tmp_path):
    path = tmp_path / "state"
    source = RecordingSource(stage.recording())
    first = Pipeline([source], [stage.Collected()], upkeep=Upkeep(snapshot=path), run_id="monday")
    first.stop()
    first.run()
    sink = stage.Collected()
    again = Pipeline(
        [RecordingSource(stage.recording())], [sink], resume=read_snapshot(path), run_id="tuesday"
    )
    again.run()
    assert run_of(sink) == "monday"


def test_frames_are_written_without_the_run(stage):
    class Frames(stage.Collected):
        def send_frames(self, frames):
            pass

    Frames.send = property()  # a sink of frames alone
    sink = Frames()
    Pipeline([stage.demo(seconds=1.0)], [sink]).run()
    assert [(meta.run, meta.settings) for meta in sink.metas] == [(None, None)]


@pytest.mark.parametrize(("change", "told"), [({"level": 0.3}, 0.3), ({"level": "cluster"}, "cluster")])
def test_settings_that_change_are_announced(stage, change, told):
    sink = stage.Collected()
    pipeline = Pipeline([stage.Script([stage.meta(), stage.wave(0, 30), 0.2, stage.wave(30, 30)])], [sink])
    pipeline.ask(lambda: pipeline.set(change))
    pipeline.run()
    assert sink.metas[-1].settings["level"] == told
