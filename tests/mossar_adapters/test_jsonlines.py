import io
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.jsonlines import JsonLinesFrameSink, JsonLinesSink, JsonLinesSource
from mossar_adapters.live import OutputClosedError
from mossar_adapters.segment_csv import SegmentCsvSink
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_source
from mossar_stream import Frames, SegmentEvent, Skeleton, StreamEvent

STARTED = StreamEvent(performer="p1", event="started", take=0)


def test_frames_are_read_line_by_line_until_the_input_ends():
    lines = [
        {
            "v": 1,
            "type": "meta",
            "performer": "ada",
            "names": ["hips", "head"],
            "parents": [-1, 0],
            "fps": 50,
        },
        *({"type": "frame", "performer": "ada", "t": i / 50, "xyz": [[0, 1, i], None]} for i in range(5)),
        {"type": "stats"},
    ]
    text = "\n".join(map(json.dumps, lines)) + "\n\nno json\n" + '{"type":"frame","xyz":[[1,2]]}'
    source = JsonLinesSource(parse_url("-"), stream=io.BytesIO(text.encode()))
    items = [item for item in source.items() if item is not None]
    assert items[0].skeleton.names == ("hips", "head")
    positions = np.concatenate([item.positions for item in items[1:]])
    assert positions[:, 0, 2].tolist() == [0, 1, 2, 3, 4]
    assert np.isnan(positions[:, 1]).all()
    assert (source.counters.malformed, source.counters.ignored) == (2, 1)


def test_frames_without_time_are_spaced_by_the_rate():
    text = b'{"type":"frame","xyz":[[0,1,2]]}\n' * 4
    source = JsonLinesSource(parse_url("-"), ReadOptions(fps=25.0), io.BytesIO(text))
    frames = [item for item in source.items() if isinstance(item, Frames)]
    assert np.concatenate([item.times for item in frames]).tolist() == [0, 0.04, 0.08, 0.12]


def test_recorded_frames_read_the_same(tmp_path):
    path = tmp_path / "take.jsonl"
    sink = JsonLinesFrameSink(parse_url(str(path)))
    items = list(open_source("demo:?seconds=0.5&noise=0.01").items())
    for item in items:
        if isinstance(item, Meta):
            sink.announce(item)
        else:
            sink.send_frames(item)
    sink.close()
    read = [item for item in open_source(str(path)).items() if isinstance(item, Frames)]
    sent = np.concatenate([item.positions for item in items[1:]])
    assert np.array_equal(np.concatenate([item.positions for item in read]), sent)


def test_events_are_lines_of_json(tmp_path):
    path = tmp_path / "events.jsonl"
    sink = JsonLinesSink(parse_url(str(path)))
    sink.send([STARTED, STARTED])
    sink.send([])
    sink.close()
    sink.close()
    lines = path.read_text().splitlines()
    assert [json.loads(line)["event"] for line in lines] == ["started", "started"]


def test_a_reader_that_goes_away_ends_the_output_quietly():
    program = (
        "import sys\n"
        "from mossar_adapters.urls import open_sink\n"
        "from mossar_adapters.live import OutputClosedError\n"
        "from mossar_stream.events import StreamEvent\n"
        "sink = open_sink('-')\n"
        "event = StreamEvent(performer='p1', event='started', take=0)\n"
        "try:\n"
        "    while True: sink.send([event])\n"
        "except OutputClosedError:\n"
        "    sink.close()\n"
        "    sys.exit(0)\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    running = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment
    )
    assert running.stdout.readline().startswith(b'{"type":"stream"')
    running.stdout.close()
    assert running.stderr.read() == b""
    assert running.wait(10) == 0
    running.stderr.close()


def test_writing_into_a_closed_stream_is_the_quiet_end():
    stream = io.BytesIO()
    sink = JsonLinesSink(parse_url("-"), stream)
    stream.close()
    with pytest.raises(OutputClosedError):
        sink.send([STARTED])


def test_final_segments_become_rows(tmp_path, made):
    path = tmp_path / "segments.csv"
    sink = SegmentCsvSink(parse_url(str(path)))
    span = {"start_time": 0.5, "end_time": 1.5, "end_frame": 60}
    segment = [
        made(SegmentEvent, status=status, active_joints=("head",), **span) for status in ("closed", "final")
    ]
    sink.announce(Meta("p1", Skeleton(("hip", "head")), recording="walk.bvh"))
    sink.send([STARTED, *segment])
    sink.close()
    times = "start,end,duration,start_frame,end_frame"
    counted = "count,total,period,tempo,amplitude"
    followed = "relative_tempo,deviation," + ",".join(
        f"{field}_{limb}"
        for field in ("deviation", "range")
        for limb in ("trunk", "left_arm", "right_arm", "left_leg", "right_leg")
    )
    own = "similarity,active_joints,channel,limb"
    header, row = path.read_text().splitlines()
    assert (
        header
        == f"recording,performer,take,{times},state,kind,strength,{own},{counted},name,score,{followed}"
    )
    assert row == "walk.bvh,p1,0,0.5000,1.5000,1.0000,0,60,moving,,,,head,body" + "," * 20
