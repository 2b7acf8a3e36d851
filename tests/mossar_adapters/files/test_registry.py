import gzip
import os

import numpy as np
import pytest

from mossar_adapters.files import FORMATS, FileError, Format, ReadOptions, open_recording
from mossar_adapters.files.registry import format_of
from mossar_adapters.files.units import height

# Rate, frames, joints, height in metres of the recordings that conftest writes.
EXPECTED = {
    "bvh": (30, 30, 5, 1.7),
    "amc": (120, 30, 3, 1.65),
    "npz": (60, 30, 4, 1.7),
    "csv": (60, 30, 4, 1.7),
    "jsonl": (60, 30, 4, 1.7),
    "msk": (60, 30, 4, 1.7),
    "trc": (60, 30, 4, 1.7),
    "motive": (60, 30, 4, 1.7),
    "qtm": (60, 30, 4, 1.7),
    "msrc12": (30.303, 31, 20, 1.7),
    "ntu": (30, 30, 25, 1.7),
    "mediapipe": (25, 30, 4, 1.7),
    "openpose": (30, 1, 4, 1.7),
    "c3d": (60, 30, 4, 1.7),
    "xdf": (60, 30, 4, 1.7),
    "osc": (60, 30, 4, 1.7),
}


def frames_of(recording):
    return list(recording.chunks())


def positions_of(recording):
    return np.concatenate([frames.positions for frames in frames_of(recording)])


def test_every_format_reads_with_its_rate_count_joints_and_height(sample, kind):
    fps, count, joints, tall = EXPECTED[kind]
    recording = open_recording(sample(kind))
    positions = positions_of(recording)
    assert recording.fps == pytest.approx(fps, rel=1e-3)
    assert recording.frame_count == len(positions) == count
    assert len(recording.skeleton) == positions.shape[1] == joints
    assert height(positions) == pytest.approx(tall, abs=0.05)
    assert positions.dtype == np.float32


def test_a_second_pass_yields_the_same_frames(sample, kind):
    recording = open_recording(sample(kind))
    for first, second in zip(frames_of(recording), frames_of(recording), strict=True):
        np.testing.assert_array_equal(first.positions, second.positions)
        np.testing.assert_array_equal(first.times, second.times)


def test_times_are_finite_and_increase(sample, kind):
    times = np.concatenate([frames.times for frames in frames_of(open_recording(sample(kind)))])
    assert np.isfinite(times).all()
    assert (np.diff(times) > 0).all()


def test_the_rate_of_the_user_replaces_that_of_the_file(sample, kind):
    recording = open_recording(sample(kind), ReadOptions(fps=50))
    times = np.concatenate([frames.times for frames in frames_of(recording)])
    assert recording.fps == 50
    np.testing.assert_allclose(np.diff(times), 0.02)


def test_the_unit_of_the_user_is_taken(sample, kind):
    as_metres = positions_of(open_recording(sample(kind), ReadOptions(unit="m")))
    as_centimetres = positions_of(open_recording(sample(kind), ReadOptions(unit="cm")))
    np.testing.assert_allclose(as_centimetres, as_metres * 0.01, rtol=1e-5)


def test_joints_and_root_can_be_chosen(sample):
    recording = open_recording(sample("csv"), ReadOptions(joints=("head", "hip"), root="head"))
    assert recording.skeleton.names == ("head", "hip")
    assert recording.skeleton.root == 0
    whole = positions_of(open_recording(sample("csv")))
    np.testing.assert_array_equal(positions_of(recording), whole[:, [3, 0]])


@pytest.mark.parametrize("options", [{"root": "tail"}, {"joints": ("tail",)}, {"performer": "nobody"}])
def test_choosing_what_is_not_there_is_an_error(sample, options):
    with pytest.raises(FileError, match=r"a\.csv: no "):
        open_recording(sample("csv"), ReadOptions(**options))


@pytest.mark.parametrize(
    "options", [{"fps": 0}, {"fps": float("nan")}, {"fps": -1}, {"fps": 1e-308}, {"unit": "furlong"}]
)
def test_impossible_options_are_refused(options):
    with pytest.raises(ValueError, match="must be"):
        ReadOptions(**options)


@pytest.mark.parametrize("name", [name for form in FORMATS for name in form.extensions])
def test_an_empty_file_is_one_clear_line(tmp_path, name):
    path = tmp_path / f"x{name}"
    path.touch()
    with pytest.raises(FileError, match="the file is empty"):
        open_recording(path)


@pytest.mark.parametrize("name", sorted({name for form in FORMATS for name in form.extensions}))
@pytest.mark.parametrize(
    "content", [bytes(range(256)) * 8, b"\0" * 3000, b"hello\n" * 300, b"\xff\xfe" + b"\xd8" * 99]
)
def test_rubbish_is_one_clear_line(tmp_path, name, content):
    path = tmp_path / f"x{name}"
    path.write_bytes(content)
    with pytest.raises(FileError) as found:
        list(open_recording(path).chunks())
    assert "\n" not in str(found.value)
    assert str(path) in str(found.value)


def test_missing_files_folders_and_unknown_extensions_are_named(tmp_path):
    with pytest.raises(FileError, match="No such file"):
        open_recording(tmp_path / "none.bvh")
    with pytest.raises(FileError, match="folder"):
        open_recording(tmp_path)
    (tmp_path / "a.mp3").write_bytes(b"x")
    with pytest.raises(FileError, match=r"'\.mp3' is not known; known are \.amc"):
        open_recording(tmp_path / "a.mp3")


@pytest.mark.parametrize("kind", ["bvh", "trc", "motive", "qtm", "msk", "xdf"])
@pytest.mark.parametrize("name", ["a.txt", "a.csv", "a.dat", "a"])
def test_a_file_that_says_what_it_is_needs_no_extension(sample, kind, name):
    path = sample(kind)
    expected = open_recording(path)
    moved = path.rename(path.with_name(name))
    found = open_recording(moved)
    assert (found.skeleton, found.fps) == (expected.skeleton, expected.fps)
    assert len(positions_of(found)) == expected.frame_count


@pytest.mark.parametrize("first", ["hierarchy", "Hierarchy_no", "MSK_id"])
def test_a_table_whose_first_heading_begins_like_another_format_is_a_table(tmp_path, first):
    path = tmp_path / "table.csv"
    path.write_text(f"{first},hip.x,hip.y,hip.z\n1,0,1,0\n2,0,1,0\n")
    assert format_of(path).name == "CSV"


@pytest.mark.parametrize(
    ("name", "content", "advice"),
    [
        ("a.bvh.gz", gzip.compress(b"HIERARCHY", mtime=0), "packed with gzip; unpack it first"),
        ("a.c3d", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n", "git lfs pull"),
        ("a.csv", b"PK\x03\x04" + bytes(99), "save the sheet as CSV"),
    ],
)
def test_files_to_be_unpacked_or_fetched_are_refused_with_advice(tmp_path, name, content, advice):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FileError, match=advice):
        open_recording(tmp_path / name)


@pytest.mark.parametrize("kind", ["bvh", "amc", "csv", "trc", "c3d", "msk", "jsonl", "npz"])
def test_a_file_that_goes_away_is_one_clear_line(sample, kind):
    path = sample(kind)
    recording = open_recording(path)
    path.unlink()
    with pytest.raises(FileError, match="No such file"):
        list(recording.chunks())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_pipe_is_refused_instead_of_waited_for(tmp_path):
    os.mkfifo(tmp_path / "a.bvh")
    with pytest.raises(FileError, match="a pipe or a device"):
        open_recording(tmp_path / "a.bvh")


def test_a_missing_extra_is_named(sample):
    row = Format(
        "XDF", (".xdf",), lambda _h, _p: True, "nowhere", "", extra="files", library="not_installed_here"
    )
    with pytest.raises(FileError, match=r"pip install 'mossar-stream\[files\]'"):
        open_recording(sample("xdf"), formats=(row,))


def test_cut_off_anywhere_every_format_yields_what_is_whole_or_one_clear_line(sample, kind):
    path = sample(kind)
    whole = path.read_bytes()
    count = open_recording(path).frame_count
    for length in range(1, len(whole), max(1, len(whole) // 60)):
        path.write_bytes(whole[:length])
        found = whole_frames(path)
        assert found < count or kind == "mediapipe" or length > 0.95 * len(whole)


def whole_frames(path):
    """Return how many frames of a damaged file read, 0 if it is refused with one line."""
    try:
        recording = open_recording(path)
    except FileError as error:
        return 0 if "\n" not in str(error) else -1
    count = len(positions_of(recording))
    assert recording.frame_count == count >= 1
    return count


@pytest.mark.parametrize(
    "kind", ["bvh", "trc", "motive", "qtm", "ntu", "c3d", "xdf", "msk", "jsonl", "mediapipe", "amc", "osc"]
)
def test_that_a_file_is_cut_off_is_noted(sample, kind):
    path = sample(kind)
    path.write_bytes(path.read_bytes()[: len(path.read_bytes()) * 8 // 10 - 3])
    recording = open_recording(path)
    assert 10 <= len(positions_of(recording)) < EXPECTED[kind][1]
    assert any("cut off" in note for note in recording.notes)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"])
@pytest.mark.parametrize("ends", ["\r\n", "\r", "\n"])
def test_encodings_and_line_ends_do_not_matter(sample, encoding, ends):
    for kind in ("bvh", "csv", "trc", "amc", "qtm", "msrc12", "ntu", "motive", "osc"):
        path = sample(kind)
        expected = positions_of(open_recording(path))
        text = path.read_bytes().decode("utf-8-sig").replace("\n", ends)
        path.write_bytes(text.encode(encoding))
        np.testing.assert_array_equal(positions_of(open_recording(path)), expected)


@pytest.mark.parametrize("padding", [b"\0" * 100, b"\x1a"])
def test_what_a_crash_or_an_old_program_leaves_behind_the_text_is_no_frame(sample, padding):
    for kind in ("bvh", "csv", "trc", "amc", "qtm", "msrc12", "ntu", "motive", "osc"):
        path = sample(kind)
        expected = positions_of(open_recording(path))
        path.write_bytes(path.read_bytes() + padding)
        np.testing.assert_array_equal(positions_of(open_recording(path)), expected)


def test_a_skeleton_without_its_motion_is_refused_with_a_hint(tmp_path):
    (tmp_path / "86.asf").write_text(":version 1.10\n")
    with pytest.raises(FileError, match="a skeleton without motion"):
        open_recording(tmp_path / "86.asf")


def test_a_new_format_is_one_function_and_one_row(tmp_path, monkeypatch):
    (tmp_path / "dots_reader.py").write_text(
        """
import numpy as np
from mossar_adapters.source import Recording
from mossar_stream.frames import Frames, constant_times
from mossar_stream.skeleton import Skeleton


def read(path, options):
    values = np.loadtxt(path, dtype=np.float32)
    positions = values.reshape(len(values), -1, 3)
    fps = options.fps or 10.0

    def chunks():
        yield Frames(positions, constant_times(len(positions), fps))

    skeleton = Skeleton(tuple(f"dot{i}" for i in range(positions.shape[1])), root=-1)
    return Recording(str(path), skeleton, fps, chunks, frame_count=len(positions))
"""
    )
    monkeypatch.syspath_prepend(tmp_path)
    row = Format("dots", (".dots",), lambda head, _path: head[:1].isdigit(), "dots_reader", "dots in a row")
    (tmp_path / "a.dots").write_text("0 1 2 3 4 5\n0 1 2 3 4 6\n")
    recording = open_recording(tmp_path / "a.dots", ReadOptions(joints=("dot1",)), formats=(*FORMATS, row))
    np.testing.assert_array_equal(positions_of(recording)[:, 0], [[3, 4, 5], [3, 4, 6]])
