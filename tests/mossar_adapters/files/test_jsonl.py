import io
import json

import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.files import FileError, open_recording
from mossar_adapters.jsonlines import JsonLinesSource
from mossar_adapters.people import PeopleSource
from mossar_adapters.source import Departure, Meta
from mossar_adapters.urls import open_source
from mossar_stream import Frames

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


@pytest.mark.parametrize("people", [None, 2])
def test_a_performer_without_a_meta_is_read_from_a_file_as_from_a_pipe(tmp_path, people):
    meta = {"type": "meta", "performer": "7", "names": ["hip", "head"], "parents": [-1, 0]}
    frames = [
        FRAME | {"performer": name, "t": i / 10, "xyz": [[x, 1, 2], [x, 2.7 - x / 10, 2]]}
        for i in range(20)
        for x, name in ((0, "7"), (2, "9" if i < 10 else "12"))
    ]
    path = written(tmp_path, meta, *frames)
    assert not [note for note in open_recording(path).notes if "left out" in note]
    pipe = JsonLinesSource(parse_url("-"), stream=io.BytesIO(path.read_bytes()))
    found = []
    for source in (open_source(str(path)), pipe):
        items = (source if people is None else PeopleSource(source, people)).items()
        poses: dict[str, list] = {}
        for item in items:
            if isinstance(item, Frames):
                poses.setdefault(item.performer, []).extend(item.positions.tolist())
            elif isinstance(item, Meta):
                assert item.skeleton.names == ("hip", "head")
                assert item.skeleton.parents == (-1, 0)
            assert not isinstance(item, Departure)
        found.append(poses)
    assert found[0] == found[1]
    assert set(found[0]) == ({"7", "9", "12"} if people is None else {"p1", "p2"})


def test_a_described_performer_may_have_no_frames(tmp_path):
    meta = {"type": "meta", "performer": "p1", "names": ["hips", "neck", "head"], "parents": [-1, 0, 1]}
    other = meta | {"performer": "p2", "names": ["a", "b"], "parents": [-1, 0]}
    frames = [FRAME | {"performer": "p2", "t": t / 10} for t in range(4)]
    recording = open_recording(written(tmp_path, meta, other, *frames))
    assert recording.performers == ("p2",)
    assert (recording.skeleton.names, recording.fps) == (("a", "b"), pytest.approx(10))
    assert sum(len(chunk) for chunk in recording.chunks()) == 4


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
