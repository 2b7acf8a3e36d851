"""A machine that loses its power: outputs are shorter than what was written, at random places."""

import json
import logging
import random

import numpy as np
import pytest

from mossar_adapters.files import open_recording
from mossar_adapters.pipeline import Pipeline, Upkeep, read_snapshot
from mossar_adapters.replay.recording_source import RecordingSource
from mossar_adapters.urls import open_frame_sink, open_sink

CHUNKS = 8  # of 30 frames


def run(stage, folder, *, stop_after=None):
    """Run over the recording, or its first chunks, with two files of events and one of frames."""
    state = folder / "state"
    found = read_snapshot(state)
    at = {} if found is None else found.sinks
    events, table, take = (str(folder / name) for name in ("e.jsonl", "e.csv", "take.msk"))
    sinks = [open_sink(path, position=at.get(path)) for path in (events, table)]
    sinks.append(open_frame_sink(take, position=at.get(take)))
    pipeline = Pipeline(
        [RecordingSource(stage.recording())], sinks, upkeep=Upkeep(snapshot=state), resume=found
    )
    if stop_after is not None:
        seen = iter(range(stop_after))
        push = pipeline.pool.push
        pipeline.pool.push = lambda frames: (next(seen, None) is None and pipeline.stop()) or push(frames)
    pipeline.run()


def lines(path):
    return path.read_bytes().decode().splitlines()


@pytest.mark.parametrize("seed", range(50))
def test_no_more_is_lost_than_the_disk_lost_and_that_is_said(stage, tmp_path, caplog, seed):
    rng = random.Random(seed)
    (tmp_path / "whole").mkdir()
    (tmp_path / "cut").mkdir()
    run(stage, tmp_path / "whole")
    run(stage, tmp_path / "cut", stop_after=rng.randrange(1, CHUNKS - 1))
    written, left = {}, {}
    for name in ("e.jsonl", "e.csv", "take.msk"):
        path = tmp_path / "cut" / name
        data = path.read_bytes()
        written[name], left[name] = len(data), rng.randrange(len(data) + 1)
        path.write_bytes(data[: left[name]])
    counted_on = {
        path.rpartition("/")[2]: size
        for path, size in read_snapshot(tmp_path / "cut" / "state").sinks.items()
    }
    with caplog.at_level(logging.WARNING, "mossar"):
        run(stage, tmp_path / "cut")
    shorter = {name for name in written if left[name] < counted_on[name]}
    assert sum("are lost" in message for message in caplog.messages) == len(shorter)

    for name in ("e.jsonl", "e.csv"):
        whole, found = lines(tmp_path / "whole" / name), lines(tmp_path / "cut" / name)
        kept = (tmp_path / "whole" / name).read_bytes()[: left[name]].count(b"\n")
        later = (tmp_path / "whole" / name).read_bytes()[written[name] :].count(b"\n")
        head = whole[:1] if name.endswith("csv") and kept == 0 else []
        assert found == [*head, *whole[:kept], *whole[len(whole) - later :]]
    assert all(json.loads(line) for line in lines(tmp_path / "cut" / "e.jsonl"))

    recording = open_recording(tmp_path / "cut" / "take.msk")
    assert recording.notes == ()
    times = np.concatenate([chunk.times for chunk in recording.chunks()])
    assert np.isin(times, np.arange(30 * CHUNKS) / 30).all()
    assert times[-1] == (30 * CHUNKS - 1) / 30
