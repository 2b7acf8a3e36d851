"""Clips: one after the other they are the recording, and readers of others open them."""

import csv

import numpy as np
import pytest

from mossar_adapters.files import FileError, ReadOptions, open_motion, open_recording, read
from mossar_adapters.files.bvh_text import zyx_angles
from mossar_adapters.files.clips import TABLE, check_clips, clips_of_segments, write_clips
from mossar_adapters.files.kinematics import euler_rotations, joint_positions
from mossar_stream import Segment

CM = {"unit": "cm"}


def segment(start, end):
    return Segment(start, end, start / 30, end / 30, "moving", (), None)


def cut(path, folder, spans, **options):
    """Write the clips of spans of frames and return their paths."""
    rows = [{"start_frame": start} for start, _ in spans]
    clips = clips_of_segments([segment(*span) for span in spans])
    assert write_clips(folder, read(path, **options), clips, rows, ReadOptions(**options)) == len(spans)
    with (folder / TABLE).open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [int(row["start_frame"]) for row in table] == [start for start, _ in spans]
    return [folder / row["clip"] for row in table]


def test_clips_of_a_bvh_are_the_file_as_it_was_written(sample, tmp_path):
    path = sample("bvh")
    clips = cut(path, tmp_path / "clips", [(0, 9), (9, 20), (20, 29)], **CM)
    lines = path.read_text().splitlines()
    begin = next(i for i, line in enumerate(lines) if line.strip().startswith("Frame Time")) + 1
    found = []
    for clip in clips:
        own = clip.read_text().splitlines()
        motion = own.index("MOTION")
        assert own[: motion + 1] == lines[: lines.index("MOTION") + 1]
        assert own[motion + 1] == f"Frames: {len(own) - motion - 3}"
        found += own[motion + 3 :]
    assert found == [" ".join(line.split()) for line in lines[begin : begin + 30]]


ABOVE = """HIERARCHY
ROOT World
{
\tOFFSET 0 0 0
\tCHANNELS 3 Zrotation Xrotation Yrotation
\tJOINT Armature
\t{
\t\tOFFSET 0 0 5
\t\tCHANNELS 6 Xposition Yposition Zposition Yrotation Xrotation Zrotation
"""
# Of each joint: its parent, and where it hangs, cm.
BODY = {
    "Hips": ("", "0 90 0"),
    "Spine": ("Hips", "0 30 0"),
    "Head": ("Spine", "0 40 0"),
    "LeftArm": ("Spine", "20 20 0"),
    "RightArm": ("Spine", "-20 20 0"),
    "LeftLeg": ("Hips", "10 -45 0"),
    "LeftFoot": ("LeftLeg", "0 -45 0"),
    "RightLeg": ("Hips", "-10 -45 0"),
    "RightFoot": ("RightLeg", "0 -45 0"),
}


def below(joint):
    _, offset = BODY[joint]
    places = "6 Xposition Yposition Zposition Xrotation" if joint == "Hips" else "3 Xrotation"
    own = [f"JOINT {joint}", "{", f"OFFSET {offset}", f"CHANNELS {places} Yrotation Zrotation"]
    parts = [name for name, (parent, _) in BODY.items() if parent == joint]
    inner = [line for part in parts for line in below(part)] or ["End Site", "{", "OFFSET 0 9 0", "}"]
    return [*own, *inner, "}"]


def a_body_below_others(path):
    """Write a BVH of somebody who walks, with two joints above the hips at the origin, of which the lower one is turned."""
    turns = np.random.default_rng(1).uniform(-40, 40, (30, 3 * len(BODY)))
    rows = [
        " ".join(map(str, [0, 0, 90, 0, 0, 0, 10, 0, 0, 300 + 5 * k, 90, 20, *turns[k]])) for k in range(30)
    ]
    motion = ["MOTION", "Frames: 30", "Frame Time: 0.0333333", *rows, ""]
    path.write_text(ABOVE + "\n".join([*below("Hips"), "}", "}", *motion]))
    return path


def test_clips_of_a_bvh_begin_with_the_body(tmp_path):
    path = a_body_below_others(tmp_path / "take.bvh")
    whole = read(path, **CM)
    assert whole.reference == ("World", "Armature")
    clips = cut(path, tmp_path / "clips", [(0, 9), (9, 29)], **CM)
    found = [read(clip, **CM) for clip in clips]
    assert all(clip.skeleton == whole.skeleton and not clip.reference for clip in found)
    np.testing.assert_allclose(np.concatenate([clip.positions for clip in found]), whole.positions, atol=1e-5)
    assert all("World" not in clip.read_text() for clip in clips)
    assert all(clip.read_text().count("ROOT Hips") == 1 for clip in clips)


def test_clips_keep_what_root_asks_for(tmp_path):
    path = a_body_below_others(tmp_path / "take.bvh")
    clips = cut(path, tmp_path / "clips", [(0, 29)], root="World", **CM)
    assert clips[0].read_text().startswith(ABOVE)


def test_clips_of_a_bvh_are_opened_by_another_library(sample, tmp_path):
    bvhio = pytest.importorskip("bvhio")
    path = sample("bvh")
    whole = read(path, **CM)
    clips = cut(path, tmp_path / "clips", [(0, 9), (9, 29)], **CM)
    root = bvhio.readAsHierarchy(str(clips[1]))
    named = {joint.Name: joint for joint, _, _ in root.layout()}
    for frame in (0, 7, 20):
        root.loadPose(frame)
        for name in ("Hips", "Leg", "Neck"):
            place = np.array(named[name].PositionWorld) / 100
            expected = whole.positions[9 + frame, whole.skeleton.names.index(name)]
            np.testing.assert_allclose(place, expected, atol=1e-5)


def test_rotations_of_an_acclaim_recording_become_bvh(sample, tmp_path):
    bvhio = pytest.importorskip("bvhio")
    path = sample("amc")
    motion = open_motion(path)
    chunks = list(motion.chunks())
    places = np.concatenate([joint_positions(chunk, motion.parents) for chunk in chunks])
    clips = cut(path, tmp_path / "clips", [(0, 4), (4, len(places) - 1)])
    parts = [read(clip, **CM) for clip in clips]
    order = [motion.names.index(name) for name in parts[0].skeleton.names]
    assert sorted(order) == list(range(len(motion.names)))
    again = np.concatenate([part.positions for part in parts])
    np.testing.assert_allclose(again, places[:, order], atol=1e-5)
    assert open_recording(clips[0]).fps == pytest.approx(motion.fps)
    root = bvhio.readAsHierarchy(str(clips[1]))
    root.loadPose(2)
    for joint, _, _ in root.layout():
        expected = places[6, motion.names.index(joint.Name)]
        np.testing.assert_allclose(np.array(joint.PositionWorld) / 100, expected, atol=1e-5)


def test_positions_become_archives(sample, tmp_path):
    path = sample("npz")
    whole = read(path)
    last = len(whole.times) - 1
    clips = cut(path, tmp_path / "clips", [(0, 5), (5, last)])
    parts = [read(clip) for clip in clips]
    assert [part.skeleton for part in parts] == [whole.skeleton] * 2
    np.testing.assert_array_equal(np.concatenate([part.positions for part in parts]), whole.positions)
    np.testing.assert_array_equal(np.concatenate([part.times for part in parts]), whole.times)


@pytest.mark.parametrize("y", [0.3, np.pi / 2, -np.pi / 2])
def test_angles_make_up_the_rotation_again(y):
    rotations = euler_rotations(np.array([[0.4, y, -1.2], [3.0, y, 2.0]]), "zyx")
    np.testing.assert_allclose(euler_rotations(zyx_angles(rotations), "zyx"), rotations, atol=1e-7)


def test_a_folder_with_files_in_it_is_left_alone_unless_that_is_wished(tmp_path):
    check_clips(tmp_path / "new", replace=False)
    (tmp_path / "a.txt").write_text("mine")
    with pytest.raises(FileError, match="--force"):
        check_clips(tmp_path, replace=False)
    check_clips(tmp_path, replace=True)
    with pytest.raises(FileError, match="file"):
        check_clips(tmp_path / "a.txt", replace=True)
    with pytest.raises(FileError, match="no folder"):
        check_clips(tmp_path / "b" / "c", replace=False)
