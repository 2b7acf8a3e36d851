"""Files that outlast their run: what is never replaced, and what is left after a machine lost its power."""

import csv
import json
import logging
import random
from pathlib import Path

import numpy as np
import pytest

from mossar_adapters.files import FileError, open_recording
from mossar_adapters.files.msk import MskWriter
from mossar_adapters.files.output import OutputFile
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_frame_sink, open_sink
from mossar_stream import Frames, SegmentEvent, Skeleton, StreamEvent

STARTED = StreamEvent(performer="p1", event="started", take=0)
META = Meta("p1", Skeleton(("hip", "hand"), (-1, 0)))


def frames(count, first=0):
    return Frames(np.ones((count, 2, 3), np.float32), (first + np.arange(count)) / 30)


@pytest.mark.parametrize("name", ["events.jsonl", "segments.csv", "take.msk"])
def test_a_file_with_something_in_it_is_replaced_only_by_force(tmp_path, name):
    path = tmp_path / name
    opened = open_frame_sink if name.endswith("msk") else open_sink
    path.write_bytes(b"dear to somebody\n")
    with pytest.raises(FileError, match="there is a file already; --force replaces it"):
        opened(str(path))
    assert path.read_bytes() == b"dear to somebody\n"
    opened(str(path), force=True).close()
    path.write_bytes(b"")
    opened(str(path)).close()


def test_a_file_that_is_shorter_than_was_written_is_cut_behind_its_last_line_and_that_is_said(
    tmp_path, caplog
):
    path = tmp_path / "events.jsonl"
    sink = open_sink(str(path))
    sink.send([STARTED] * 10)
    position = sink.position()
    sink.close()
    whole = path.read_bytes()
    path.write_bytes(whole[:-100])
    with caplog.at_level(logging.WARNING, "mossar"):
        again = open_sink(str(path), position=position)
    again.send([STARTED])
    again.close()
    lines = path.read_bytes().splitlines()
    assert len(lines) == 9
    assert all(json.loads(line)["event"] == "started" for line in lines)
    assert f"{position - 8 * len(whole) // 10} bytes of the last run are lost" in caplog.text


def test_a_table_has_one_heading_however_short_it_became(tmp_path, made):
    path = tmp_path / "segments.csv"
    sink = open_sink(str(path))
    sink.send([made(SegmentEvent)] * 3)
    position = sink.position()
    sink.close()
    for size in (0, 5, path.stat().st_size - 3):
        path.write_bytes(path.read_bytes()[:size])
        again = open_sink(str(path), position=position)
        again.send([made(SegmentEvent)])
        again.close()
        lines = path.read_text().splitlines()
        assert lines[0].startswith("recording,performer,take")
        assert sum(line.startswith("recording,") for line in lines) == 1


def test_a_file_that_is_gone_begins_anew(tmp_path, caplog):
    with caplog.at_level(logging.WARNING, "mossar"):
        open_sink(str(tmp_path / "events.jsonl"), position=1000).close()
    assert "the file that the last run wrote is gone" in caplog.text
    assert (tmp_path / "events.jsonl").read_bytes() == b""


@pytest.mark.parametrize("seed", range(20))
def test_a_recording_cut_anywhere_goes_on_behind_its_last_whole_record(tmp_path, seed):
    path = tmp_path / "take.msk"
    with MskWriter(path) as writer:
        writer.write(META)
        writer.write(frames(20))
        position = writer.position()
    data = path.read_bytes()
    size = random.Random(seed).randrange(len(data) + 1)
    path.write_bytes(data[:size])
    with MskWriter(path, position=position) as writer:
        assert writer.position() <= max(size, 4)
        kept = writer.position() * 20 // len(data)
        writer.write(META)
        writer.write(frames(5, 100))
    recording = open_recording(path)
    assert recording.notes == ()
    found = np.concatenate([chunk.times for chunk in recording.chunks()])
    assert found[-5:].tolist() == frames(5, 100).times.tolist()
    assert len(found) >= kept + 4


@pytest.mark.parametrize("zeros", [1, 4, 5, 300, 100_000])
@pytest.mark.parametrize("inside", [0, 30])
def test_a_recording_with_a_tail_of_zeros_reads_up_to_its_last_whole_record(tmp_path, zeros, inside):
    path = tmp_path / "take.msk"
    with MskWriter(path) as writer:
        writer.write(META)
        writer.write(frames(20))
    data = path.read_bytes()
    path.write_bytes(data[: len(data) - inside] + bytes(zeros))
    recording = open_recording(path)
    assert recording.frame_count in {20, 20 - (inside > 0)}
    assert (
        recording.notes == ("the file is cut off in its last record; everything before it is read",) or inside
    )


def test_zeros_in_the_middle_of_a_recording_are_damage(tmp_path):
    path = tmp_path / "take.msk"
    with MskWriter(path) as writer:
        writer.write(META)
        position = writer.position()
        writer.write(frames(20))
    data = path.read_bytes()
    path.write_bytes(data[:position] + bytes(64) + data[position:])
    with pytest.raises(FileError, match="record 2 is damaged"):
        open_recording(path)


def test_devices_that_cannot_be_synchronised_are_written_all_the_same():
    file = OutputFile(Path("/dev/null"), replace=True)
    file.write(b"x")
    file.sync()
    file.close()


def test_names_in_a_table_are_no_formulas(tmp_path, made):
    path = tmp_path / "segments.csv"
    sink = open_sink(str(path))
    sink.announce(Meta("=1+1", META.skeleton, recording="@take.bvh"))
    sink.send([made(SegmentEvent, performer="=1+1", active_joints=("-hand", "foot"))])
    sink.send([made(SegmentEvent, channel="@arm", limb="+arm", start_time=-2.5)])
    sink.close()
    with path.open(newline="") as file:
        row, of_limb = csv.DictReader(file)
    assert (row["recording"], row["performer"], row["active_joints"]) == (
        "'@take.bvh",
        "'=1+1",
        "'-hand foot",
    )
    assert (of_limb["channel"], of_limb["limb"], of_limb["start"]) == ("'@arm", "'+arm", "-2.5000")
