"""A recording in one call, and what comes of it as people in a notebook look at it."""

import sys

import numpy as np
import pytest

import mossar_adapters.files
import mossar_stream
from mossar_adapters.files import FileError, read
from mossar_stream import Settings, SettingsError, segment_recording


@pytest.fixture
def path(tmp_path):
    swing = np.clip(np.sin(np.arange(240) / 8), 0, None)
    positions = np.zeros((240, 3, 3), np.float32)
    positions[:, 1, 0], positions[:, 2, 1] = swing, 0.5 * swing
    file = tmp_path / "swing.npz"
    names, parents = np.array(["hip", "<hand>", "foot"]), [-1, 0, 0]
    np.savez(file, positions=positions, fps=30, joint_names=names, parents=parents)
    return file


def test_a_recording_is_read_and_segmented_in_one_call(path):
    take = read(path, joints=("hip", "<hand>"))
    assert take.positions.shape == (240, 2, 3)
    assert repr(take) == f"{path}: 240 frames at 30 Hz, 2 joints, performer p1"
    result = take.segment(level="posture")
    settings = Settings(level="posture", range="file")
    same = segment_recording(take.positions, take.fps, take.skeleton, settings, times=take.times)
    assert result.key_frames == same.key_frames
    assert len(result.curves) == 240


@pytest.mark.parametrize("wrong", [{"performer": "zzz"}, {"joints": ("elbow",)}])
def test_what_is_not_in_it_is_refused(path, wrong):
    with pytest.raises(FileError, match=r"swing\.npz: no "):
        read(path, **wrong)


def test_an_unknown_setting_is_refused(path):
    with pytest.raises(SettingsError, match="no setting called 'foo'"):
        read(path).segment(foo=1)


def test_results_print_as_a_summary_and_as_html(path):
    result = read(path).segment(level="posture")
    count = len(result.key_frames)
    assert repr(result) == f"Result: {count} key frames, {count} of them at level posture"
    shown = result._repr_html_()
    assert repr(result) in shown
    assert "&lt;hand&gt;" in shown
    assert "<hand>" not in shown
    assert shown.count("<tr>") == min(12, count + 1) + 1
    assert result.at(count=1)._repr_html_().count("<tr>") == 3
    lines = repr(result.at(count=1)).splitlines()
    assert lines[0] == "Segmentation: 1 key frame, 2 segments"
    assert len(lines) == 3


def test_results_become_dataframes(path):
    pytest.importorskip("pandas")
    result = read(path).segment(level="posture")
    keys, parts = result.to_dataframe(), result.at(count=2).to_dataframe()
    assert list(keys.columns) == ["frame", "time", "kind", "velocity", "strength"]
    assert keys.frame.tolist() == [key.frame for key in result.key_frames]
    assert len(parts) == 3
    assert set(parts.state) <= {"moving", "resting"}
    empty = read(path).segment(level="posture", sig_threshold=1.0).to_dataframe()
    assert list(empty.columns) == list(keys.columns)


def test_repetitions_and_moves_become_dataframes(path):
    pytest.importorskip("pandas")
    result = read(path).segment(repetitions=True)
    counted = result.repetitions.to_dataframe()
    assert counted["count"].tolist() == [event.count for event in result.repetitions] != []
    assert result.moves.to_dataframe().empty
    assert "limb" in result.moves.to_dataframe().columns
    assert result.repetitions == list(result.repetitions)


@pytest.mark.parametrize(("library", "extra"), [("pandas", "notebook"), ("matplotlib.pyplot", "plot")])
def test_a_library_that_is_missing_is_named_with_its_extra(path, monkeypatch, library, extra):
    monkeypatch.setitem(sys.modules, library, None)
    result = read(path).segment(level="posture")
    with pytest.raises(ImportError, match=rf"pip install 'mossar-stream\[{extra}\]'"):
        result.to_dataframe() if extra == "notebook" else result.plot()


def test_settings_without_names_are_answered_with_how_they_are_given(path):
    with pytest.raises(TypeError, match=r"by name.*level=.*segment_recording"):
        read(path).segment(Settings(level="cluster"))


def test_results_are_drawn(path):
    figures = pytest.importorskip("matplotlib.figure")
    axes = figures.Figure().add_subplot()
    result = read(path).segment(level="posture")
    assert result.plot(axes=axes) is axes
    assert len(axes.patches) == len(result.key_frames) + 1
    assert len(axes.lines) == len(result.key_frames) + 2
    assert result.plot(0.5, axes=figures.Figure().add_subplot()).get_xlabel() == "s"


def test_dir_shows_the_public_face_only():
    assert set(dir(mossar_stream)) == {*mossar_stream.__all__, "__version__"}
    assert set(dir(mossar_adapters.files)) == set(mossar_adapters.files.__all__) >= {"read", "open_recording"}


@pytest.mark.parametrize("form", ["csv", "npz"])
def test_frames_with_all_joints_at_the_origin_show_nobody(tmp_path, form):
    names = ("hips", "neck", "left_hand")
    positions = np.tile(np.float32([[0, 1, 0], [0, 1.5, 0], [0.4, 1, 0]]), (60, 1, 1))
    positions[:, 2, 1] += np.sin(np.arange(60) / 5).astype(np.float32) / 3
    positions[:, 0] = 0  # relative to the hips
    positions[20:40] = 0
    path = tmp_path / f"take.{form}"
    if form == "npz":
        np.savez(path, positions=positions, fps=30.0, joint_names=np.array(names))
    else:
        rows = [["time", *(f"{name}.{axis}" for name in names for axis in "xyz")]]
        rows += [[k / 30, *pose.ravel().tolist()] for k, pose in enumerate(positions)]
        path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
    seen = np.isfinite(read(path, unit="m").positions)
    assert not seen[20:40].any()
    assert seen[:20].all()
    assert seen[40:].all()
