import subprocess
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest

import mossar_stream
from mossar_adapters.files import FileError, MskWriter, ReadOptions, open_recording
from mossar_adapters.files.output import OutputError
from mossar_adapters.source import Meta
from mossar_stream import Frames, Skeleton

PAIR = Skeleton(("a", "b"), (-1, 0))
TRIPLE = Skeleton(("a", "b", "c"))


def some_frames(count, joints=2, performer="p1", start=0.0, *, confidence=False):
    rng = np.random.default_rng(count)
    positions = rng.normal(size=(count, joints, 3)).astype(np.float32)
    positions[0, 0] = np.nan
    scores = rng.random((count, joints)).astype(np.float32) if confidence else None
    return Frames(positions, start + np.arange(count) / 100, scores, performer)


@pytest.mark.parametrize("confidence", [False, True])
def test_what_is_written_is_read(tmp_path, confidence):
    path = tmp_path / "a.msk"
    frames = some_frames(300, confidence=confidence)
    with MskWriter(path) as writer:
        writer.write(Meta("p1", PAIR, 100.0))
        writer.write(frames)
    recording = open_recording(path)
    assert (recording.skeleton, recording.fps, recording.frame_count, recording.notes) == (PAIR, 100, 300, ())
    chunks = list(recording.chunks())
    np.testing.assert_array_equal(np.concatenate([c.positions for c in chunks]), frames.positions)
    np.testing.assert_array_equal(np.concatenate([c.times for c in chunks]), frames.times)
    if confidence:
        np.testing.assert_array_equal(np.concatenate([c.confidence for c in chunks]), frames.confidence)


def test_the_records_are_the_maps_of_the_interface(tmp_path):
    path = tmp_path / "a.msk"
    with MskWriter(path) as writer:
        writer.write(Meta("p1", PAIR, 100.0))
        writer.write(some_frames(2))
    data = path.read_bytes()[4:]
    maps = []
    while data:
        length = int.from_bytes(data[:4], "little")
        maps.append(msgspec.msgpack.decode(data[4 : 4 + length]))
        data = data[4 + length :]
    meta, _, second = maps
    assert meta == {
        "v": 1, "type": "meta", "performer": "p1", "names": ["a", "b"], "parents": [-1, 0], "root": 0, "fps": 100.0,
        "unit": "m", "version": mossar_stream.__version__,
    }  # fmt: skip
    assert set(second) == {"v", "type", "performer", "seq", "t", "shape", "xyz"}
    assert (second["seq"], second["shape"], len(second["xyz"])) == (1, [2, 3], 24)


def test_a_file_that_is_there_is_kept_unless_forced(tmp_path):
    path = tmp_path / "a.msk"
    path.write_bytes(b"precious")
    with pytest.raises(FileError, match="there is a file already; --force replaces it"):
        MskWriter(path)
    assert path.read_bytes() == b"precious"
    MskWriter(path, force=True).close()
    assert path.read_bytes() == b"MSK1"
    with pytest.raises(FileError, match="cannot be written"):
        MskWriter(tmp_path / "none" / "a.msk")


def test_cut_anywhere_it_reads_up_to_the_last_whole_record(tmp_path):
    path = tmp_path / "a.msk"
    with MskWriter(path) as writer:
        writer.write(Meta("p1", PAIR, 100.0))
        writer.write(some_frames(3))
    whole = path.read_bytes()
    counts = []
    for length in range(len(whole) + 1):
        path.write_bytes(whole[:length])
        try:
            counts.append(open_recording(path).frame_count)
        except FileError:
            counts.append(0)
    assert counts == sorted(counts)
    assert set(counts) == {0, 1, 2, 3}


def test_a_writer_that_dies_leaves_everything_it_wrote(tmp_path):
    path = tmp_path / "a.msk"
    program = f"""
import os
import numpy as np
from mossar_adapters.files import msk
from mossar_adapters.source import Meta
from mossar_stream.frames import Frames
from mossar_stream.skeleton import Skeleton
writer = msk.MskWriter({str(path)!r})
writer.write(Meta("p1", Skeleton(("a",)), 100.0))
for i in range(3):
    writer.write(Frames(np.ones((1, 1, 3), np.float32), np.array([float(i)])))
os._exit(9)
"""
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 9
    assert open_recording(path).frame_count == 3


def test_it_goes_on_where_a_former_run_was_sure_of_its_frames(tmp_path):
    path = tmp_path / "a.msk"
    with MskWriter(path) as writer:
        writer.write(Meta("p1", PAIR, 100.0))
        writer.write(some_frames(3))
        sure = writer.position()
        writer.write(some_frames(5))
    with MskWriter(path, position=sure) as writer:
        writer.write(Meta("p1", PAIR, 100.0))
        writer.write(some_frames(4))
    assert open_recording(path).frame_count == 7


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_is_one_clear_line():
    with pytest.raises(OutputError, match="/dev/full: cannot be written: No space left on device"):
        MskWriter("/dev/full", force=True)


def test_what_fitted_on_a_full_disk_is_read(disk_of_128k):
    path = disk_of_128k / "a.msk"
    with MskWriter(path) as writer:
        writer.write(Meta("p1", PAIR, 100.0))
        frames = some_frames(10_000)
        writer.write(some_frames(200))
        with pytest.raises(OutputError, match="cannot be written"):
            writer.write(frames)
    recording = open_recording(path)
    assert recording.frame_count > 100
    assert recording.notes == ("the file is cut off in its last record; everything before it is read",)


def test_several_performers_share_the_skeleton_and_others_are_left_out(tmp_path):
    path = tmp_path / "a.msk"
    with MskWriter(path) as writer:
        for name, skeleton in (("anna", PAIR), ("bo", PAIR), ("cy", TRIPLE)):
            writer.write(Meta(name, skeleton, 100.0))
        for name, joints in (("anna", 2), ("cy", 3), ("bo", 2)):
            writer.write(some_frames(5, joints, name))
    recording = open_recording(path)
    assert recording.performers == ("anna", "bo")
    assert recording.frame_count == 10
    assert recording.notes == ("5 frames with another skeleton are left out",)
    only = open_recording(path, ReadOptions(performer="cy"))
    assert only.skeleton == TRIPLE
    assert [len(frames) for frames in only.chunks()] == [5]


def test_frames_after_a_change_of_skeleton_are_left_out(tmp_path):
    path = tmp_path / "a.msk"
    other = Skeleton(("x", "y"))
    with MskWriter(path) as writer:
        for skeleton in (PAIR, other, PAIR):
            writer.write(Meta("p1", skeleton, 100.0))
            writer.write(some_frames(4))
    recording = open_recording(path)
    assert recording.frame_count == sum(len(frames) for frames in recording.chunks()) == 8
    assert recording.notes == ("4 frames with another skeleton are left out",)


def test_damage_is_one_clear_line(tmp_path):
    path = tmp_path / "a.msk"
    for data, problem in (
        (b"MSK1\xff\xff\xff\xff1234", "record 1 is damaged: it has a length of 4294967295 bytes"),
        (b"MSK1\x02\x00\x00\x00\xc1\xc1", "record 1 is damaged"),
        (b"MSK2\x02\x00\x00\x00\xc1\xc1", "no .msk recording of version 1"),
        (b"MSK1", "no whole frame"),
    ):
        path.write_bytes(data)
        with pytest.raises(FileError, match=problem):
            open_recording(path)
