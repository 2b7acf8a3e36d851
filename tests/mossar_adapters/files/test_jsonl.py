import json

import numpy as np
import pytest

from mossar_adapters.files import FileError, open_recording

FRAME = {"type": "frame", "performer": "p1", "t": 0.0, "xyz": [[0, 1, 2], [0, 2.7, 2]]}


def written(tmp_path, *lines):
    path = tmp_path / "a.jsonl"
    path.write_text("".join((line if isinstance(line, str) else json.dumps(line)) + "\n" for line in lines))
    return path


def test_null_is_missing(tmp_path):
    path = written(tmp_path, FRAME, FRAME | {"t": 0.1, "xyz": [None, [None, 1, 2]]})
    (frames,) = open_recording(path).chunks()
    assert np.isnan(frames.positions[1]).any(axis=1).all()


def test_nan_as_python_writes_it_is_missing(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_text(
        '{"type": "meta", "names": ["NaN", "b"], "parents": [-1, 0]}\n'
        '{"type": "frame", "t": 0, "xyz": [[NaN, NaN, NaN], [-Infinity, 1, 2]]}\n'
        '{"type": "frame", "t": 1, "xyz": [[0, 1, 2], [0, 1, 2]]}\n'
    )
    recording = open_recording(path)
    assert recording.skeleton.names == ("NaN", "b")
    (frames,) = recording.chunks()
    assert np.isnan(frames.positions[0]).all()
    assert np.isfinite(frames.positions[1]).all()


def test_frames_without_a_meta_have_unnamed_joints_and_no_root(tmp_path):
    recording = open_recording(written(tmp_path, FRAME, FRAME | {"t": 0.5}))
    assert recording.skeleton.names == ("joint0", "joint1")
    assert recording.skeleton.root == -1
    assert recording.fps == 2


def test_events_and_other_types_are_passed_over(tmp_path):
    path = written(tmp_path, {"type": "stats", "frames": 1}, FRAME, {"type": "key_frame"}, "")
    assert open_recording(path).frame_count == 1


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ('{"type": "frame", "xyz": [[1, 2]]}', "xyz is not a list of"),
        ('{"type": "frame", "xyz": []}', "xyz has 0 joints"),
        ('{"type": "frame", "xyz": "abc"}', "xyz has 1 bytes|Invalid base64|xyz"),
        (
            '{"type": "frame", "xyz": [[1, 2, 3]], "shape": [2, 3]}',
            r"shape says \[2, 3\] but xyz has \[1, 3\]",
        ),
        (
            '{"type": "frame", "xyz": [[1, 2, 3]], "conf": [1, 2]}',
            "conf is not one number for each of 1 joints",
        ),
        ('{"type": "frame", "xyz": [[1, 2, 3]], "t": 1e300}', "is no time"),
        ('{"type": "frame", "xyz": [[1, 2, 3], [1, 2, 3]]}', "some frames have a time t and others do not"),
        ('{"type": "meta", "names": []}', "1 to 1024 joints"),
        ('{"type": "meta", "names": ["a", "a"]}', "two joints are called 'a'"),
        ('{"type": "meta", "names": ["a"], "unit": "cm"}', "frames are in metres"),
        ('{"type": "meta", "names": ["a"], "fps": -1}', "a rate of -1.0 Hz is impossible"),
        ("{nonsense", "malformed"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, line, problem):
    path = written(tmp_path, FRAME, line, FRAME | {"t": 1.0})
    with pytest.raises(FileError, match=problem) as found:
        open_recording(path)
    assert "2" in str(found.value)
