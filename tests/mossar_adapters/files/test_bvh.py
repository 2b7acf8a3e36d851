import re

import numpy as np
import pytest

from mossar_adapters.files import FileError, ReadOptions, open_motion, open_recording
from mossar_adapters.files.kinematics import joint_positions


def positions_of(recording):
    return np.concatenate([frames.positions for frames in recording.chunks()])


def rewritten(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    return path


def bone_lengths(recording):
    positions = positions_of(recording)
    bones = np.array(recording.skeleton.bones())
    return np.linalg.norm(positions[:, bones[:, 1]] - positions[:, bones[:, 0]], axis=2)


def test_joints_end_sites_and_parents_are_read(sample):
    skeleton = open_recording(sample("bvh")).skeleton
    assert skeleton.names == ("Hips", "Leg", "Leg_End", "Neck", "Neck_End")
    assert skeleton.parents == (-1, 0, 1, 0, 3)


def test_each_joint_has_its_own_order_of_rotations(sample):
    recording = open_recording(sample("bvh"), ReadOptions(unit="cm"))
    last = positions_of(recording)[29]
    y, z = np.radians([29.0, 5.0])  # hips: Ry(29); leg: Rz(5) Rx(29)
    x = np.radians(29.0)
    leg = np.array([np.sin(z) * np.cos(x), -np.cos(z) * np.cos(x), -np.sin(x)]) * 0.9
    hip_turn = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    leg[0] += 0.1
    expected = np.array([0, 0.9, 0.29]) + hip_turn @ leg
    np.testing.assert_allclose(last[2], expected, atol=1e-6)


def test_the_unit_is_guessed_from_the_height_and_said(sample):
    recording = open_recording(sample("bvh"))
    assert recording.notes == ("unit taken as cm (skeleton is 1.70 m tall); set --unit to change",)


def test_people_who_begin_curled_up_do_not_mislead_the_guess(sample):
    path = rewritten(sample("bvh"), " 0 0 0 5 0 0 0 0 0\n", " 0 0 0 150 0 0 0 0 150\n")
    assert "unit taken as cm" in open_recording(path).notes[0]


@pytest.mark.parametrize(
    ("step", "fps"),
    [
        ("0.008333", 120),
        (".0083333", 120),
        ("0.0417083750417", 23.976),
        ("0.04", 25),
        ("0.033", 30),
        ("1e-2", 100),
    ],
)
def test_the_rate_is_the_one_meant_by_the_printed_frame_time(sample, step, fps):
    recording = open_recording(rewritten(sample("bvh"), "0.0333333", step))
    assert recording.fps == pytest.approx(fps, rel=1e-6)


def test_position_channels_replace_the_offset_of_any_joint(sample):
    path = rewritten(
        sample("bvh"),
        "CHANNELS 3 Xrotation Yrotation Zrotation",
        "CHANNELS 4 Xrotation Yrotation Zrotation Yposition",
    )
    text = path.read_text()
    head, _, motion = text.partition("Frame Time: 0.0333333\n")
    path.write_text(head + "Frame Time: 0.0333333\n" + motion.replace("\n", " 70\n"))
    first = positions_of(open_recording(path, ReadOptions(unit="cm")))[0]
    np.testing.assert_allclose(first[3] - first[0], [0, 0.7, 0], atol=1e-6)


def test_names_with_spaces_and_braces_on_the_same_line_are_read(sample):
    path = rewritten(sample("bvh"), "JOINT Leg\n  {", "JOINT Left Leg {")
    assert open_recording(path).skeleton.names[1] == "Left Leg"


def test_joints_of_the_same_name_are_told_apart(sample):
    path = rewritten(sample("bvh"), "JOINT Neck", "JOINT Leg")
    assert open_recording(path).skeleton.names[3:] == ("Leg_2", "Leg_End_2")


def test_rows_beyond_the_announced_frames_are_left_out_and_missing_ones_noted(sample):
    assert open_recording(rewritten(sample("bvh"), "Frames: 30", "Frames: 20")).frame_count == 20
    recording = open_recording(rewritten(sample("bvh"), "Frames: 30", "Frames: 99999999"))
    assert recording.frame_count == 30
    assert recording.notes[0] == "the file is cut off: 30 of 99999999 frames are there"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Frames: 30\nFrame Time: 0.0333333\n", "Frame Time: 0.0333333\nFrames: 30\n"),
        ("Frames: 30\nFrame Time: 0.0333333\n", "\nFrames :\t30 \n\nFrame  Time :\t.0333333 \n"),
        ("HIERARCHY\n", "# made by somebody\nHIERARCHY\n# the body\n"),
    ],
)
def test_headings_may_be_turned_around_spaced_oddly_and_commented(sample, old, new):
    usual = open_recording(sample("bvh"))
    expected = positions_of(usual)
    found = open_recording(rewritten(sample("bvh"), old, new))
    assert (found.fps, found.skeleton) == (usual.fps, usual.skeleton)
    np.testing.assert_array_equal(positions_of(found), expected)


@pytest.mark.parametrize(
    ("old", "new", "line", "problem"),
    [
        ("0 90 7 ", "0 ninety 7 ", 35, "'ninety' is not a number"),
        ("0 90 7 ", "90 7 ", 35, "the row has 11 values instead of 12"),
        ("0 90 7 ", "0 0 90 7 ", 35, "the row has 13 values instead of 12"),
        ("Frame Time: 0.0333333", "Frame Time: 0", 27, "a frame time of 0 s is impossible; set --fps"),
        ("Frames: 30", "Frames: many", 26, "MOTION is not followed by"),
        ("Frames: 30", "Frames: 0", 27, "the motion has 0 frames"),
        ("OFFSET 10 0 0", "OFFSET 10 0 up", 8, "OFFSET is not followed by three numbers"),
        ("CHANNELS 6 X", "CHANNELS 7 X", 5, "a number and as many names"),
        ("Yrotation\n    End", "Yrotation Yrotation\n    End", 9, "has no place here"),
        ("CHANNELS 3 Zrotation X", "CHANNELS 3 Xrotation X", 9, "a channel is named twice"),
        ("JOINT Neck", "JOIN Neck", 15, "'JOIN' has no place here"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(sample, old, new, line, problem):
    path = rewritten(sample("bvh"), old, new)
    with pytest.raises(FileError) as found:
        list(open_recording(path).chunks())
    assert f"{path}, line {line}: " in str(found.value)
    assert problem in str(found.value)


def test_a_number_that_is_not_finite_makes_what_hangs_on_it_missing(sample):
    positions = positions_of(open_recording(rewritten(sample("bvh"), "0 90 7 0 0 7 5", "0 90 7 0 0 7 nan")))
    assert np.isnan(positions[7, 2]).all()
    assert np.isfinite(positions[7, [0, 1, 3, 4]]).all()


def test_bone_lengths_are_constant(sample):
    lengths = bone_lengths(open_recording(sample("bvh")))
    np.testing.assert_allclose(lengths, np.broadcast_to(lengths[0], lengths.shape), atol=1e-5)


def test_the_motion_gives_the_positions(sample):
    motion = open_motion(sample("bvh"))
    chunk = next(motion.chunks())
    assert chunk.rotations.shape == (30, 5, 3, 3)
    np.testing.assert_allclose(motion.offsets[4], [0, 0.2, 0])
    expected = positions_of(open_recording(sample("bvh")))
    np.testing.assert_allclose(joint_positions(chunk, motion.parents), expected, atol=1e-6)


def test_a_recording_longer_than_a_chunk_is_continuous(sample):
    recording = open_recording(sample("bvh", frames=600))
    chunks = list(recording.chunks())
    assert [len(frames) for frames in chunks] == [256, 256, 88]
    np.testing.assert_allclose(np.concatenate([f.times for f in chunks]), np.arange(600) / 30)


def test_positions_without_rotations_have_no_motion(sample):
    with pytest.raises(FileError, match="CSV has joint positions but no rotations"):
        open_motion(sample("csv"))


def test_walk01_agrees_with_its_reference_positions_to_their_printed_precision(shared):
    folder = shared / "formats" / "bvh"
    motion = open_motion(folder / "walk01.bvh", ReadOptions(unit="m"))
    ours = np.concatenate([joint_positions(chunk, motion.parents) for chunk in motion.chunks()])
    printed = np.loadtxt(folder / "walk01_pos.csv", delimiter=",", skiprows=1)[:, 1:].reshape(101, -1, 3)
    names = open_recording(folder / "walk01_pos.csv").skeleton.names
    order = [motion.names.index(name) for name in names]
    assert np.abs(ours[:, order] - printed).max() < 1.1e-5  # 5 decimals of a cm


def test_every_real_bvh_has_constant_bones_and_a_plausible_height(shared):
    for path in sorted((shared / "formats" / "bvh").glob("*.bvh")):
        recording = open_recording(path)
        lengths = bone_lengths(recording)
        np.testing.assert_allclose(lengths, np.broadcast_to(lengths[0], lengths.shape), atol=2e-4)
        announced = int(path.read_text().lower().split("frames:")[1].split()[0])
        assert recording.frame_count == announced == len(positions_of(recording))


def test_a_minus_sign_may_stand_in_for_the_blank_before_it(sample):
    wanted = positions_of(open_recording(sample("bvh")))
    path = sample("bvh")
    head, rows = path.read_text().split("MOTION")
    glued = "\n".join(re.sub(r"(?<=\d) -", "-", line) for line in rows.split("\n"))
    path.write_text(head.replace("0 -", "0-") + "MOTION" + glued)
    found = positions_of(open_recording(path))
    np.testing.assert_array_equal(found, wanted)
    first = next(line for line in rows.split("\n") if line.startswith("0"))
    some = "1.5-2.5e-3-7" + first[len(first.split()[0]) :].split(" ", 3)[3].join(["  ", ""])
    path.write_text(head + "MOTION\nFrames: 1\nFrame Time: 0.1\n" + some + "\n")
    np.testing.assert_allclose(
        positions_of(open_recording(path, ReadOptions(unit="m")))[0, 0], [1.5, -2.5e-3, -7]
    )


MISSING = "Frames: 30\n"


@pytest.mark.parametrize(
    ("line", "fps"),
    [
        ("Frame Time: 0,0166667", 60),
        ("Frame Time 0.0166667 s", 60),
        ("FrameTime = 0.0166667 sec", 60),
        ("Frame Time: 16.6667 ms", 60),
        ("Frame Time: 1.66667e-2", 60),
        ("Frame Time: 60 fps", 60),
        ("Frame Time: 1/60", 60),
        ("Frame Time: 0.0166667 # s", 60),
        ("Frame Rate: 60", 60),
        ("FPS: 29.97", 29.97),
        ("Frame Time: 29.97 Hz", 29.97),
        ("Frame Time: 60", 60),
        ("Frame Time: 120.0", 120),
    ],
)
def test_the_frame_time_may_be_written_in_other_ways(sample, line, fps):
    path = rewritten(sample("bvh"), "Frame Time: 0.0333333", line)
    recording = open_recording(path)
    assert recording.fps == pytest.approx(fps)
    doubted = [note for note in recording.notes if "set --fps" in note]
    assert bool(doubted) == (line in {"Frame Time: 60", "Frame Time: 120.0"})
    assert open_recording(path, ReadOptions(fps=50)).fps == 50


@pytest.mark.parametrize(
    "line", ["", "Frame Time: nan", "Frame Time: 0", "Frame Time: -0.02", "Frame Time: soon", "Frame Time:"]
)
def test_a_rate_that_the_file_does_not_say_is_asked_for(sample, line):
    path = rewritten(sample("bvh"), "Frame Time: 0.0333333\n", line and line + "\n")
    with pytest.raises(FileError, match="set --fps"):
        open_recording(path)
    recording = open_recording(path, ReadOptions(fps=60))
    assert (recording.fps, recording.frame_count) == (60, 30)
    assert len(positions_of(recording)) == 30


def test_less_than_one_frame_a_second_is_doubted(sample):
    recording = open_recording(rewritten(sample("bvh"), "Frame Time: 0.0333333", "Frame Time: 2"))
    assert recording.fps == 0.5
    assert any("0.5 Hz" in note and "set --fps" in note for note in recording.notes)


def body(name, shape=6, indent=""):
    """Return a chain of joints as a BVH hierarchy."""
    word = "ROOT" if not indent else "JOINT"
    channels = (
        "6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"
        if not indent
        else "3 Zrotation Xrotation Yrotation"
    )
    lines = [
        f"{indent}{word} {name}",
        indent + "{",
        f"{indent} OFFSET 0 30 0",
        f"{indent} CHANNELS {channels}",
    ]
    lines += body(f"{name}x", shape - 1, indent + " ") if shape > 1 else []
    return [*lines, indent + "}"]


def two_bodies(path, *bodies):
    """Write a BVH of several trees; tree n stands n m along x and turns by n degrees a frame."""
    rows = []
    for frame in range(30):
        for n, (_, shape) in enumerate(bodies):
            rows += [f"{100 * n} 0 0 {n * frame} 0 0" + " 0 0 0" * (shape - 1)]
    rows = [" ".join(rows[k : k + len(bodies)]) for k in range(0, len(rows), len(bodies))]
    lines = [line for name, shape in bodies for line in body(name, shape)]
    path.write_text("\n".join(["HIERARCHY", *lines, "MOTION", "Frames: 30", "Frame Time: 0.02", *rows, ""]))
    return path


def test_two_roots_are_two_performers(tmp_path):
    path = two_bodies(tmp_path / "two.bvh", ("Hips", 6), ("B_Hips", 6))
    recording = open_recording(path)
    assert recording.performers == ("p1", "p2")
    assert recording.skeleton.names[:2] == ("Hips", "Hipsx")
    assert recording.frame_count == 60
    assert "1.50 m tall" in recording.notes[0]  # not what both take up
    chunks = list(recording.chunks())
    assert [frames.performer for frames in chunks] == ["p1", "p2"]
    assert [frames.positions[0, 0, 0] for frames in chunks] == [0, 1]
    second = open_recording(path, ReadOptions(performer="p2"))
    assert second.skeleton.names[0] == "B_Hips"
    assert positions_of(second)[0, 0, 0] == 1
    assert open_motion(path, ReadOptions(performer="p2")).names[0] == "B_Hips"
    assert open_motion(path).parents == (-1, 0, 1, 2, 3, 4)


def test_a_prop_is_no_performer(tmp_path):
    recording = open_recording(two_bodies(tmp_path / "prop.bvh", ("Hips", 6), ("Sword", 2)))
    assert (recording.performers, len(recording.skeleton)) == (("p1",), 8)
    recording = open_recording(
        two_bodies(tmp_path / "more.bvh", ("Hips", 6), ("B_Hips", 6), ("Sword", 2), ("Dog", 7))
    )
    assert (recording.performers, len(recording.skeleton)) == (("p1", "p2"), 6)
    assert any("Dog (p3), Sword left out" in note for note in recording.notes)
    assert len(open_recording(tmp_path / "more.bvh", ReadOptions(performer="p3")).skeleton) == 7
