import numpy as np
import pytest

from mossar_adapters.files import FileError, ReadOptions, open_motion, open_recording
from mossar_adapters.files.kinematics import joint_positions, quaternions


def positions_of(recording):
    return np.concatenate([frames.positions for frames in recording.chunks()])


def rewritten(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    return path


def test_joints_are_the_ends_of_the_bones_in_metres(sample):
    recording = open_recording(sample("amc"))
    assert recording.skeleton.names == ("root", "leg", "spine")
    assert recording.skeleton.parents == (-1, 0, 0)
    unit = 0.0254 / 0.45
    np.testing.assert_allclose(
        positions_of(recording)[0], np.array([[0, 16, 0], [0, 0.1, 0], [0, 30.2, 0]]) * unit, atol=1e-6
    )


def test_bones_turn_about_their_own_axes(sample):
    turned = positions_of(open_recording(sample("amc")))[10]
    c = np.radians(20)
    axes = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    x, z, y = np.radians([10.0, -10.0, 10.0])
    about_x = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    about_z = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
    about_y = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    leg = about_y @ axes @ (about_z @ about_x) @ axes.T @ [0, -15.9, 0]
    np.testing.assert_allclose(turned[1] - turned[0], leg * 0.0254 / 0.45, atol=1e-6)


def test_the_rate_is_that_of_cmu_and_said_so(sample):
    recording = open_recording(sample("amc"))
    assert recording.fps == 120
    assert recording.notes == ("rate taken as 120 Hz (an AMC does not state it); set --fps to change",)
    assert open_recording(sample("amc"), ReadOptions(fps=60)).notes == ()


def test_a_unit_that_makes_giants_is_guessed_anew(sample):
    path = sample("amc")
    rewritten(path.parent / "a.asf", "length 0.45", "length 0.01")
    assert "unit taken as" in open_recording(path).notes[0]


def test_radians_are_read(sample):
    path = sample("amc")
    rewritten(path.parent / "a.asf", "axis 0 0 20 XYZ", "axis 0 0 0 XYZ")
    expected = positions_of(open_recording(path))
    rewritten(path.parent / "a.asf", "angle deg", "angle rad")
    rows = [
        f"{i + 1}\nroot 0 16 {i * 0.1} 0 {np.radians(i)} 0\nleg {np.radians(i)} {-np.radians(i)}\n"
        for i in range(30)
    ]
    path.write_text("".join(rows))
    np.testing.assert_allclose(positions_of(open_recording(path)), expected, atol=1e-6)


def test_the_motion_may_be_in_radians_though_the_skeleton_is_in_degrees(sample):
    path = sample("amc")
    expected = positions_of(open_recording(path))
    rows = [
        f"{i + 1}\nroot 0 16 {i * 0.1} 0 {np.radians(i)} 0\nleg {np.radians(i)} {-np.radians(i)}\n"
        for i in range(30)
    ]
    path.write_text(":RADIANS\n" + "".join(rows))
    np.testing.assert_allclose(positions_of(open_recording(path)), expected, atol=1e-6)


def test_the_skeleton_is_found_by_name_by_prefix_or_alone(sample):
    path = sample("amc")
    folder, asf = path.parent, path.parent / "a.asf"
    moved = path.rename(folder / "86_01.amc")
    assert open_recording(moved).frame_count == 30  # the only one
    (folder / "b.asf").write_bytes(asf.read_bytes())
    with pytest.raises(FileError, match=r"which \.asf belongs to it\? .* \(candidates: a\.asf, b\.asf\)"):
        open_recording(moved)
    assert open_recording(moved, ReadOptions(skeleton=str(asf))).frame_count == 30
    asf.rename(folder / "86.asf")
    assert open_recording(moved).frame_count == 30
    (folder / "86.asf").unlink()
    (folder / "b.asf").unlink()
    with pytest.raises(FileError, match="there is none in its folder"):
        open_recording(moved)
    with pytest.raises(FileError, match=r"no\.asf: there is no such skeleton file"):
        open_recording(moved, ReadOptions(skeleton="no.asf"))


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("leg 7 -7", "arm 7 -7", "line 25: the frame has other bones"),
        ("leg 7 -7", "leg 7", "line 25: the frame has other bones"),
        ("leg 7 -7", "leg 7 x", "line 25: 'x' is not a number"),
        ("leg 0 0", "arm 0 0", "line 4: 'arm' is no bone of the skeleton"),
    ],
)
def test_what_is_wrong_with_the_motion_is_said_with_its_line(sample, old, new, problem):
    path = rewritten(sample("amc"), old, new)
    with pytest.raises(FileError, match=problem):
        list(open_recording(path).chunks())


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        (":hierarchy", ":tree", "the section :hierarchy is missing"),
        ("root leg spine", "root leg tail", "line 33: there is no bone called 'tail'"),
        ("root leg spine", "root leg", "the bone 'spine' is not in the hierarchy"),
        ("root leg spine", "root leg spine leg", "line 33: 'leg' hangs on a bone"),
        ("length 15.9", "length long", "line 18: 1 numbers are missing"),
        ("length 0.45", "length 0", "line 6: a unit of length of 0 is impossible"),
        ("dof rx rz", "dof rx qq", "line 20: 'rx qq' are no degrees of freedom"),
        ("axis 0 0 20 XYZ", "axis 0 0 20 ABC", "line 19: 'ABC' is no order of axes"),
    ],
)
def test_what_is_wrong_with_the_skeleton_is_said_with_its_line(sample, old, new, problem):
    path = sample("amc")
    rewritten(path.parent / "a.asf", old, new)
    with pytest.raises(FileError, match=rf"a\.asf.*{problem}"):
        open_recording(path)


def test_the_motion_gives_the_positions_of_the_beginnings_of_the_bones(sample):
    motion = open_motion(sample("amc"))
    assert motion.names == ("root", "leg", "spine", "leg_End", "spine_End")
    chunk = next(motion.chunks())
    ends = joint_positions(chunk, motion.parents)[:, [0, 3, 4]]
    np.testing.assert_allclose(ends, positions_of(open_recording(sample("amc"))), atol=1e-6)
    assert quaternions(chunk.rotations).shape == (30, 5, 4)


def test_the_labelled_recordings_read_with_constant_bones(shared):
    counts = {"86_01": 4579, "13_29": 4592, "13_31": 3017, "14_14": 4653}
    for name, count in counts.items():
        options = ReadOptions(skeleton=str(shared / "labelled" / "86.asf"))
        recording = open_recording(shared / "labelled" / f"{name}.amc", options)
        positions = positions_of(recording)
        assert (recording.fps, recording.frame_count, positions.shape) == (120, count, (count, 31, 3))
        bones = np.array(recording.skeleton.bones())
        lengths = np.linalg.norm(positions[:, bones[:, 1]] - positions[:, bones[:, 0]], axis=2)
        assert np.ptp(lengths, axis=0).max() < 1e-5
        assert 1.4 < np.median(np.ptp(positions[:, :, 1], axis=1)) < 1.8
