import json

import numpy as np
import pytest

from mossar_adapters.files import FileError, ReadOptions, open_recording
from mossar_adapters.files.units import height
from mossar_adapters.joint_sets import COCO_17


def positions_of(recording):
    return np.concatenate([frames.positions for frames in recording.chunks()])


def written(tmp_path, content, name="a.json"):
    path = tmp_path / name
    path.write_text(json.dumps(content))
    return path


def points(count=17, z=0.3):
    return [{"x": 0.1, "y": 0.05 * i, "z": z} for i in range(count)]


LISTED = [[p["x"], p["y"], p["z"]] for p in points()]


@pytest.mark.parametrize(
    "content",
    [
        [points(), points()],
        {"frames": [points(), points()]},
        {"fps": 30, "frames": [{"landmarks": points()}, {"landmarks": points()}]},
        [{"pose_landmarks": [points()]}, {"pose_landmarks": [points()]}],
        [{"poseLandmarks": points()}, {"poseLandmarks": points()}],
        [{"keypoints": points(), "keypoints3D": points()}] * 2,
        [[{"keypoints": points()}], [{"keypoints": points()}]],
        [LISTED, LISTED],
        {"data": [{"pose": LISTED}, {"pose": LISTED}]},
        {"0": {"landmarks": points()}, "1": {"landmarks": points()}},
        [{"pose_landmarks": {"landmark": points()}}] * 2,
        {"frame_10": LISTED, "frame_9": LISTED},
        {"landmarks": [LISTED, LISTED], "video": "a.mp4"},
        {"positions": [LISTED, LISTED]},
        {"frames": [{"bodies": [{"body_id": 1, "joint_positions": LISTED}], "timestamp_usec": 9}] * 2},
        [[v for point in LISTED for v in point]] * 2,
        [{"landmarks": [v for point in LISTED for v in [*point, 0.9]]}] * 2,
        [{"frame": 1, **dict(zip(COCO_17.names, points(), strict=True))}] * 2,
        [{"landmarks": dict(zip(COCO_17.names, LISTED, strict=True))}] * 2,
    ],
)
def test_many_shapes_are_understood(tmp_path, content):
    recording = open_recording(written(tmp_path, content))
    positions = positions_of(recording)
    assert positions.shape == (2, 17, 3)
    assert recording.skeleton.names[0] == "nose"
    assert recording.skeleton.root == -1
    assert positions[0, 0, 1] > positions[0, 16, 1]  # y points up


def test_world_landmarks_are_metres_and_image_landmarks_are_scaled(tmp_path):
    world = open_recording(
        written(tmp_path, [{"pose_world_landmarks": points(), "pose_landmarks": points()}])
    )
    assert height(positions_of(world)) == pytest.approx(0.8)
    image = open_recording(written(tmp_path, [{"pose_landmarks": points()}]))
    assert height(positions_of(image)) == pytest.approx(1.7)
    assert "scaled so that the skeleton is 1.7 m tall" in "".join(image.notes)


def test_two_dimensions_are_an_error_unless_allowed(tmp_path):
    flat = [{"x": p["x"], "y": p["y"]} for p in points()]
    for content in (
        [flat],
        {"people": [{"pose_keypoints_2d": [1, 2, 0.5, 3, 4, 0.5]}]},
        {"people": [{"pose_keypoints": [1, 2, 0.5] * 18}]},
        {"bodies": [{"joints": [1, 2, 0.5] * 18}]},
    ):
        path = written(tmp_path, content)
        with pytest.raises(FileError, match=r"frame 0: its poses are 2-D, .*--allow-2d takes them anyway"):
            open_recording(path)
        assert (positions_of(open_recording(path, ReadOptions(allow_2d=True)))[:, :, 2] == 0).all()


def test_openpose_points_without_confidence_are_missing(tmp_path):
    person = {"pose_keypoints_3d": [0, 0, 0, 0, 1, 2, 3, 0.5] + [1, 1, 1, 0.9] * 23}
    recording = open_recording(written(tmp_path, {"people": [person]}))
    (frames,) = recording.chunks()
    assert np.isnan(frames.positions[0, 0]).all()
    assert np.isfinite(frames.positions[0, 1]).all()
    assert frames.confidence[0, 1] == 0.5
    assert len(recording.skeleton) == 25
    assert recording.skeleton.names[recording.skeleton.root] == "MidHip"


def test_a_folder_is_one_recording_in_the_order_of_its_numbers(tmp_path):
    for i in (10, 9, 1, 2):
        body = (
            {"people": [{"pose_keypoints_3d": [float(i), 1, 1, 1, 0, 2, 1, 1]}]} if i != 2 else {"people": []}
        )
        written(tmp_path, body, f"take_{i}_keypoints.json")
    recording = open_recording(tmp_path, ReadOptions(unit="m", fps=10))
    (frames,) = recording.chunks()
    np.testing.assert_array_equal(frames.positions[:, 0, 0], [1, 9, 10])
    np.testing.assert_allclose(frames.times, [0, 0.2, 0.3])  # nobody in the second frame


def test_people_are_performers(tmp_path):
    recording = open_recording(
        written(tmp_path, [[points(), points(z=0.5)], [points()]]), ReadOptions(unit="m")
    )
    assert recording.performers == ("p1", "p2")
    assert [(frames.performer, len(frames)) for frames in recording.chunks()] == [("p1", 2), ("p2", 1)]


def test_people_of_an_image_are_one_frame(tmp_path):
    person = {"keypoints": [1.0, 2.0, 0.9] * 17, "score": 2.9}
    path = written(tmp_path, [{"image_id": name, **person} for name in ("0.jpg", "0.jpg", "1.jpg")])
    with pytest.raises(FileError, match="2-D"):
        open_recording(path)
    recording = open_recording(path, ReadOptions(allow_2d=True))
    assert [(f.performer, len(f)) for f in recording.chunks()] == [("p1", 2), ("p2", 1)]


def test_a_frame_per_line_is_understood(tmp_path):
    for name in ("a.json", "a.jsonl", "a.ndjson"):
        path = tmp_path / name
        path.write_text("".join(json.dumps({"time": i / 20, "landmarks": LISTED}) + "\n" for i in range(5)))
        assert (open_recording(path).fps, open_recording(path).frame_count) == (20, 5)
        path.write_bytes(path.read_bytes()[:-40])
        assert open_recording(path).frame_count == 4
        assert any("cut off; 4 frames are whole" in note for note in open_recording(path).notes)


def test_a_frame_per_line_is_understood_in_files_of_any_length(tmp_path, monkeypatch):
    monkeypatch.setattr("mossar_adapters.files.pose_json.MAX_SIZE", 100)
    path = tmp_path / "a.jsonl"
    lines = [json.dumps({"image_id": i // 2, "landmarks": LISTED}) for i in range(6)]
    path.write_text("\n\n".join(lines).replace("0.1,", "NaN,", 1))
    recording = open_recording(path)
    assert (recording.performers, recording.frame_count) == (("p1", "p2"), 6)
    assert np.isnan(positions_of(recording)).any(axis=(1, 2)).sum() == 1
    path.write_text("\n".join([*lines[:3], "{", *lines[3:]]))
    with pytest.raises(FileError, match="line 4: this is no JSON"):
        open_recording(path)


def test_what_stands_below_json_is_cut_off(tmp_path):
    path = written(tmp_path, {"fps": 20, "frames": [LISTED, LISTED]})
    path.write_text(path.read_text() + "\nwritten by me\n")
    assert open_recording(path).frame_count == 2


def test_nan_as_python_writes_it_is_missing(tmp_path):
    path = written(tmp_path, [LISTED, [[float("nan")] * 3, *LISTED[1:]], [[float("nan")] * 3] * 17])
    missing = np.isnan(positions_of(open_recording(path))).all(axis=2)
    assert missing.sum(axis=1).tolist() == [0, 1, 17]


def test_joints_are_named_once_or_by_their_keys_and_may_be_absent_now_and_then(tmp_path):
    three = {"hip": [0, 0, 0], "neck": [0, 1, 0], "head": [0, 1.5, 0]}
    path = written(
        tmp_path, [{"a": [1, 2, 3], "neck": [0, 1, 0], "hip": [0, 0, 0]}, three | {"toe": [0, -1, 0]}, three]
    )
    recording = open_recording(path, ReadOptions(unit="m"))
    assert recording.skeleton.names == ("hip", "neck", "head", "toe")
    assert recording.notes[-1] == "1 poses with other joints are left out"
    np.testing.assert_array_equal(np.isnan(positions_of(recording)[:, 3, 0]), [False, True])
    named = open_recording(written(tmp_path, {"joint_names": ["a", "b"], "frames": [LISTED[:2]] * 2}))
    assert named.skeleton.names == ("a", "b")


def test_what_other_programs_leave_in_a_folder_is_passed_over(tmp_path):
    written(tmp_path, {"people": [{"pose_keypoints_3d": [1.0, 1, 1, 1, 0, 2, 1, 1]}]}, "a_0_keypoints.json")
    (tmp_path / "._a_0_keypoints.json").write_bytes(b"\0\5\x16\7Mac OS X")
    (tmp_path / "notes.txt").write_text("x")
    (tmp_path / "folder.json").mkdir()
    (tmp_path / "a_1_keypoints.json").symlink_to(tmp_path / "nowhere.json")
    assert open_recording(tmp_path).frame_count == 1


def test_labels_are_not_taken_for_poses(tmp_path):
    labels = written(tmp_path, {"recording": "86_01.amc", "cuts": [100, 200]}, "86_01.json")
    with pytest.raises(
        FileError, match=r"86_01\.json: this holds no poses; it is about the recording 86_01\.amc"
    ):
        open_recording(labels)
    with pytest.raises(FileError, match=r"no pose in it; 86_01\.json is about .* or try mossar evaluate"):
        open_recording(tmp_path)
    written(tmp_path, [points()], "frame_0.json")
    assert open_recording(tmp_path).frame_count == 1


def test_the_older_joints_of_openpose_have_names(tmp_path):
    path = written(tmp_path, {"people": [{"pose_keypoints_3d": [0.5, 1, 1, 1] * 18}]})
    skeleton = open_recording(path).skeleton
    assert skeleton.names[:2] == ("Nose", "Neck")
    assert skeleton.parents[8] == 1


@pytest.mark.parametrize("key", ["joints", "keypoints"])
def test_a_flat_list_whose_thirds_are_no_scores_is_in_space(tmp_path, key):
    flat = [v for i in range(18 if key == "joints" else 17) for v in (0.1, 0.05 * i, -0.3)]
    positions = positions_of(open_recording(written(tmp_path, [{key: flat}] * 2), ReadOptions(unit="m")))
    np.testing.assert_allclose(positions[0, :, 2], 0.3, rtol=1e-6)


def test_a_flat_list_of_24_joints_is_not_taken_for_18_with_confidences(tmp_path):
    flat = [v for i in range(24) for v in (-0.1, 0.05 * i, -0.3)]
    with pytest.raises(FileError, match="no pose is found"):
        open_recording(written(tmp_path, [flat] * 2))


@pytest.mark.parametrize(("key", "unit"), [("time", 1), ("t", 1e3), ("timestamp", 1e6), ("timestamp", 1e9)])
def test_times_without_a_unit_are_in_that_in_which_frames_come_usually(tmp_path, key, unit):
    frames = [{key: t * unit, "landmarks": points()} for t in (0.1, 0.14, 0.18)]
    recording = open_recording(written(tmp_path, frames))
    np.testing.assert_allclose(next(recording.chunks()).times, [0.1, 0.14, 0.18])
    assert any("times taken as" in note for note in recording.notes) == (unit > 1)


def test_times_in_the_frames_are_taken(tmp_path):
    frames = [{"timestamp_ms": t, "landmarks": points()} for t in (100, 140, 180)]
    recording = open_recording(written(tmp_path, frames))
    assert recording.fps == 25
    np.testing.assert_allclose(next(recording.chunks()).times, [0.1, 0.14, 0.18])


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ({"hello": "world"}, r"no pose is found in it \(keys: hello\)"),
        ([1, 2, 3], "no pose is found in it"),
        ([], "there is no pose in it"),
        ({"people": []}, "there is no pose in it"),
        ([[*points()[:3], {"x": "left", "y": 1, "z": 2}]], "a coordinate is not a number"),
        ([[[1, 2, 3]] * 2000], "a pose has 2000 points"),
        ({"people": [{"pose_keypoints_3d": [1, 2, 3]}]}, "3 numbers, which are not 4 for each joint"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, content, problem):
    with pytest.raises(FileError, match=problem):
        open_recording(written(tmp_path, content))


def test_brackets_without_end_are_no_traceback(tmp_path):
    for text in ("[" * 100_000, '{"a":' * 100_000, "[[[[[[[[[[[[1]]]]]]]]]]]]"):
        path = tmp_path / "a.json"
        path.write_text(text)
        with pytest.raises(FileError):
            open_recording(path)


def test_real_files_of_pose_estimators(shared):
    folder = shared / "formats" / "json"
    dance = open_recording(folder / "mediapipe_dance1.json")
    assert (dance.fps, dance.frame_count, len(dance.skeleton)) == (10, 25, 33)
    flat = open_recording(folder / "041.json", ReadOptions(allow_2d=True))
    assert flat.performers == ("p1", "p2", "p3")
    with pytest.raises(FileError, match="2-D"):
        open_recording(folder / "040.json")
