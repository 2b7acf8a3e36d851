import numpy as np
import pytest

from mossar_adapters.files import FileError, open_recording


def positions_of(recording):
    return np.concatenate([frames.positions for frames in recording.chunks()])


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, np.int16])
def test_positions_of_any_kind_of_number_are_read_in_chunks(tmp_path, order, dtype):
    positions = np.asarray(np.random.default_rng(1).integers(-3, 3, (600, 5, 3)), dtype, order=order)
    np.savez(tmp_path / "a.npz", positions=positions, fps=60)
    recording = open_recording(tmp_path / "a.npz")
    assert [len(frames) for frames in recording.chunks()] == [256, 256, 88]
    np.testing.assert_array_equal(positions_of(recording), positions)


def test_times_are_taken_before_a_rate(tmp_path):
    times = [0.0, 0.5, 0.9]
    np.savez(tmp_path / "a.npz", positions=np.ones((3, 2, 3)), times=times, fps=99)
    (frames,) = open_recording(tmp_path / "a.npz").chunks()
    np.testing.assert_array_equal(frames.times, times)


@pytest.mark.parametrize("name", ["times", "timestamps", "time"])
def test_times_and_names_have_several_names(tmp_path, name):
    np.savez(tmp_path / "a.npz", positions=np.ones((3, 2, 3)), names=["a", "b"], **{name: np.arange(3) / 20})
    recording = open_recording(tmp_path / "a.npz")
    assert (recording.fps, recording.skeleton.names, recording.notes) == (20, ("a", "b"), ())


def test_things_that_only_share_a_name_with_times_are_passed_over(tmp_path):
    np.savez(tmp_path / "a.npz", positions=np.ones((3, 2, 3)), time="noon", names=["a"], fps=60)
    assert open_recording(tmp_path / "a.npz").fps == 60


def test_positions_of_giants_are_not_taken_as_metres(tmp_path):
    person = np.tile([[0.0, 0, 0], [0, 1700, 0]], (4, 1, 1))
    np.savez(tmp_path / "a.npz", positions=person, fps=60)
    recording = open_recording(tmp_path / "a.npz")
    assert np.nanmax(positions_of(recording)) == pytest.approx(1.7)
    assert recording.notes == ("unit taken as mm (skeleton is 1.70 m tall); set --unit to change",)


def test_a_single_fitting_array_is_taken_with_a_note(tmp_path):
    person = np.tile([[0.0, 0, 0], [0, 1700, 0]], (4, 1, 1))
    np.savez(tmp_path / "a.npz", joints3d=person, other=np.ones(3))
    recording = open_recording(tmp_path / "a.npz")
    assert recording.notes[0] == "'joints3d' is taken for the joint positions"
    assert np.nanmax(positions_of(recording)) == pytest.approx(1.7)


def test_amass_is_explained(tmp_path):
    np.savez(
        tmp_path / "a.npz",
        poses=np.ones((9, 156)),
        trans=np.ones((9, 3)),
        betas=np.ones(16),
        mocap_framerate=120.0,
    )
    with pytest.raises(
        FileError, match="SMPL/AMASS body parameters, not joint positions; these need the licensed"
    ):
        open_recording(tmp_path / "a.npz")


def test_objects_are_not_unpickled(tmp_path):
    np.savez(
        tmp_path / "a.npz", positions=np.ones((2, 2, 3)), joint_names=np.array([{"a": 1}, None], dtype=object)
    )
    with pytest.raises(FileError, match="holds Python objects"):
        open_recording(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("arrays", "problem"),
    [
        (
            {"positions": np.ones((2, 3))},
            r"no array positions of shape \(n, J, 3\); there are: positions \(2, 3\)",
        ),
        ({"positions": np.ones((0, 2, 3))}, "has 0 frames"),
        ({"positions": np.ones((2, 2, 3)), "fps": -1}, "'fps' is no possible rate; set --fps"),
        ({"positions": np.ones((2, 2, 3)), "fps": "fast"}, "'fps' is no possible rate"),
        ({"positions": np.ones((2, 2, 3)), "times": [1.0]}, "'times' is not one number for each of 2 frames"),
        (
            {"positions": np.ones((2, 2, 3)), "times": [1.0, np.nan]},
            "'times' holds values that are not finite",
        ),
        (
            {"positions": np.ones((2, 2, 3)), "joint_names": ["a"]},
            "'joint_names' is not one text for each of 2 joints",
        ),
        ({"positions": np.ones((2, 2, 3)), "parents": [1, 0]}, "form a cycle"),
        ({"positions": np.ones((2, 2, 3)), "parents": [-1]}, "'parents' is not one index"),
        ({"positions": np.ones((2, 2000, 3))}, "2000 joints; 1 to 1024"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, arrays, problem):
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(FileError, match=problem):
        open_recording(tmp_path / "a.npz")


def test_a_shape_that_lies_takes_no_memory(sample):
    path = sample("npz")
    np.savez(path, positions=np.ones((3, 2, 3)))
    data = path.read_bytes()
    path.write_bytes(
        data.replace(b"(3, 2, 3)", b"(9**9,2,3)".ljust(9)[:9]).replace(b"(3, 2, 3)", b"(9, 2, 3)")
    )
    with pytest.raises(FileError):
        open_recording(path)


def test_every_precog_recording_reads(shared):
    paths = sorted((shared / "labelled" / "precog").glob("*.npz"))
    assert len(paths) == 36
    for path in paths:
        recording = open_recording(path)
        with np.load(path) as truth:
            np.testing.assert_array_equal(positions_of(recording), truth["positions"])
            assert recording.skeleton.names == tuple(truth["joint_names"])
        assert (recording.fps, recording.skeleton.root, recording.notes) == (30, 0, ())
