"""Joints that are no part of the body, and sizes that no body has, in every format."""

import json

import numpy as np
import pytest

from checks.walking_body import BODY, NAMES, PARENTS, walking, with_joints_above
from mossar_adapters.files import open_recording, read
from mossar_adapters.files.body import BODY as LIMITS
from mossar_adapters.files.body import THINGS, fitting_factor, limits_of, reference_joints, size_in_words
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.options import ReadOptions
from mossar_stream import Skeleton

ORIGIN = (0.0, 0.0, 0.0)


def follows(body):
    """Return what lies on the floor below the hips, and goes along."""
    return body[:, :1] * [1, 0, 1]


@pytest.mark.parametrize(
    ("names", "places", "way"),
    [
        (("joint_Root",), ORIGIN, 6.0),
        (("joint_Root",), ORIGIN, 0.0),
        (("Armature",), (-40.0, 2.0, 9.0), 0.0),
        (("World", "Armature", "Root"), ORIGIN, 6.0),
        (("World", "Armature", "Root"), [(0, 0, 0), (5, 0, 5), (1, 0, 0)], 6.0),
    ],
)
@pytest.mark.parametrize("named", [True, False])
def test_joints_above_the_body_are_found_by_what_they_do(names, places, way, named):
    skeleton, positions = with_joints_above(names, places)
    if not named:
        skeleton = Skeleton(tuple(f"n{joint}" for joint in range(len(skeleton))), skeleton.parents)
    found = reference_joints(skeleton, positions(walking(way=way)))
    assert found == skeleton.names[: len(names)]


@pytest.mark.parametrize("named", [True, False])
def test_a_joint_that_goes_along_on_the_floor_is_found(named):
    body = walking()
    skeleton, positions = with_joints_above(("Motion",), follows(body))
    if not named:
        skeleton = Skeleton(tuple(f"n{joint}" for joint in range(len(skeleton))), skeleton.parents)
    assert reference_joints(skeleton, positions(body)) == skeleton.names[:1]


def test_what_hangs_on_the_world_beside_the_body_is_left_out_too():
    skeleton, positions = with_joints_above(("root",), ORIGIN)
    beside = Skeleton((*skeleton.names, "ik_foot_root", "camera"), (*skeleton.parents, 0, 0))
    frames = positions(walking())
    frames = np.concatenate([frames, np.zeros((len(frames), 2, 3))], axis=1)
    assert reference_joints(beside, frames) == ("root", "ik_foot_root", "camera")


def test_a_joint_without_a_parent_is_left_out_if_the_body_walks_away_from_it():
    skeleton = Skeleton((*NAMES, "joint_Root"), (*PARENTS, -1))
    frames = np.concatenate([walking(), np.zeros((240, 1, 3))], axis=1)
    assert reference_joints(skeleton, frames) == ("joint_Root",)
    in_hand = np.concatenate([walking(), walking()[:, -1:] + 0.1], axis=1)
    assert reference_joints(skeleton, in_hand) == ()


def test_the_hips_of_a_body_are_part_of_it():
    assert reference_joints(BODY, walking()) == ()
    assert reference_joints(BODY, walking(way=0.0)) == ()
    still = np.repeat(walking(1), 50, axis=0)
    assert reference_joints(BODY, still) == ()


def test_a_forearm_that_a_hand_hangs_on_is_part_of_it():
    names = ["forearm", "wrist", *(f"finger{f}_{k}" for f in range(5) for k in range(3))]
    parents = [-1, 0, *(1 if k == 0 else 1 + 3 * f + k for f in range(5) for k in range(3))]
    turned = np.sin(np.arange(100) / 10)[:, None] * 0.1
    places = np.zeros((100, len(names), 3))
    places[:, 1, 1] = 0.25
    for f in range(5):
        for k in range(3):
            places[:, 2 + 3 * f + k] = [0.02 * f, 0.33 + 0.03 * k, 0]
            places[:, 2 + 3 * f + k, 2] += turned[:, 0]
    assert reference_joints(Skeleton(tuple(names), tuple(parents)), places) == ()
    noisy = places + np.random.default_rng(1).normal(0, 0.003, places.shape)
    assert reference_joints(Skeleton(tuple(names), tuple(parents)), noisy) == ()


def test_missing_joints_are_no_reason():
    skeleton, positions = with_joints_above(("joint_Root",), ORIGIN)
    frames = positions(walking())
    frames[:100, 5:] = np.nan
    frames[::3, 0] = np.nan
    assert reference_joints(skeleton, frames) == ("joint_Root",)
    assert reference_joints(skeleton, np.full_like(frames, np.nan)) == ()
    assert reference_joints(skeleton, frames[:0]) == ()


def test_the_root_that_the_user_names_belongs_to_the_body():
    skeleton, positions = with_joints_above(("World", "Armature"), [(-9, 0, 0), ORIGIN])
    frames = positions(walking())
    assert reference_joints(skeleton, frames, "Armature") == ("World",)
    assert reference_joints(skeleton, frames, "World") == ()
    assert reference_joints(skeleton, frames, "Spine") == ("World", "Armature")


def bvh(path, skeleton, frames):
    """Write positions as a BVH whose joints all have positions."""
    children = {
        joint: [c for c, p in enumerate(skeleton.parents) if p == joint] for joint in range(len(skeleton))
    }
    order = []

    def lines(joint):
        order.append(joint)
        own = " ".join("0" for _ in range(3))
        word = "ROOT" if skeleton.parents[joint] < 0 else "JOINT"
        head = [
            f"{word} {skeleton.names[joint]}",
            "{",
            f"OFFSET {own}",
            "CHANNELS 3 Xposition Yposition Zposition",
        ]
        return [*head, *(line for child in children[joint] for line in lines(child)), "}"]

    tops = [joint for joint, parent in enumerate(skeleton.parents) if parent < 0]
    text = [
        "HIERARCHY",
        *(line for top in tops for line in lines(top)),
        "MOTION",
        f"Frames: {len(frames)}",
        "Frame Time: 0.0166667",
    ]
    local = frames.copy()
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            local[:, joint] -= frames[:, parent]
    rows = [" ".join(f"{value:.4f}" for value in row[order].ravel()) for row in local]
    path.write_text("\n".join([*text, *rows, ""]))


def npz(path, skeleton, frames):
    np.savez(
        path,
        positions=frames,
        fps=60.0,
        joint_names=np.array(skeleton.names),
        parents=np.array(skeleton.parents),
    )


def jsonl(path, skeleton, frames):
    meta = {
        "v": 1,
        "type": "meta",
        "performer": "p1",
        "names": skeleton.names,
        "parents": skeleton.parents,
        "root": 0,
    }
    rows = [
        {"v": 1, "type": "frame", "performer": "p1", "seq": n, "t": n / 60, "xyz": xyz.tolist()}
        for n, xyz in enumerate(frames)
    ]
    path.write_text("\n".join(json.dumps(row) for row in [meta, *rows]))


def csv(path, skeleton, frames):
    head = ["time", *(f"{name}.{axis}" for name in skeleton.names for axis in "xyz")]
    rows = [[n / 60, *xyz.ravel()] for n, xyz in enumerate(frames)]
    path.write_text("\n".join(",".join(map(str, row)) for row in [head, *rows]))


@pytest.mark.parametrize(
    ("suffix", "write", "scale"),
    [(".bvh", bvh, 100), (".npz", npz, 1), (".jsonl", jsonl, 1), (".csv", csv, 100)],
)
def test_every_format_with_parents_leaves_it_out_of_the_body(tmp_path, suffix, write, scale):
    skeleton, positions = with_joints_above(("joint_Root",), ORIGIN)
    plain, above = tmp_path / f"plain{suffix}", tmp_path / f"above{suffix}"
    write(plain, BODY, scale * walking())
    write(above, skeleton, scale * positions(walking()))
    wanted, found = read(plain), read(above)
    assert found.skeleton.names == wanted.skeleton.names
    assert found.skeleton.root == wanted.skeleton.root == 0
    assert np.allclose(found.positions, wanted.positions, atol=1e-3)
    whole = open_recording(above)
    assert whole.reference == ("joint_Root",)
    assert "joint_Root" in whole.skeleton.names  # exports of frames keep it
    assert any("joint_Root is no part of the body" in note for note in whole.notes)
    assert whole.skeleton.names[whole.skeleton.root] == "Hips"


def test_the_root_decides(tmp_path):
    skeleton, positions = with_joints_above(("joint_Root",), ORIGIN)
    npz(tmp_path / "a.npz", skeleton, positions(walking()))
    kept = read(tmp_path / "a.npz", root="joint_Root")
    assert kept.skeleton.names[kept.skeleton.root] == "joint_Root"
    assert read(tmp_path / "a.npz", root="Spine").skeleton.names == NAMES
    assert read(tmp_path / "a.npz", joints=("joint_Root", "Head")).skeleton.names == ("joint_Root", "Head")
    with pytest.raises(FileError, match="no joint called"):
        read(tmp_path / "a.npz", root="nobody")


def trc(path, unit, frames):
    names = NAMES
    head = [
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"60\t60\t{len(frames)}\t{len(names)}\t{unit}\t60\t1\t{len(frames)}",
        "Frame#\tTime\t" + "\t\t\t".join(names),
        "\t\t" + "\t".join(f"{axis}{n}" for n in range(1, len(names) + 1) for axis in "XYZ"),
        "",
    ]
    rows = [
        "\t".join([str(n + 1), f"{n / 60:.5f}", *(f"{v:.6f}" for v in xyz.ravel())])
        for n, xyz in enumerate(frames)
    ]
    path.write_text("\n".join([*head, *rows, ""]))


@pytest.mark.parametrize(
    ("unit", "scale", "note"),
    [("mm", 1, "taken as m "), ("m", 1000, "taken as mm "), ("cm", 1000, "taken as mm ")],
)
def test_a_stated_unit_that_contradicts_the_numbers_is_not_taken(tmp_path, unit, scale, note):
    trc(tmp_path / "a.trc", unit, scale * walking())
    found = read(tmp_path / "a.trc")
    assert np.allclose(found.positions, walking(), atol=1e-3)
    assert note in " ".join(open_recording(tmp_path / "a.trc").notes)
    given = read(tmp_path / "a.trc", unit=unit)
    assert not np.allclose(given.positions, walking(), atol=1e-3)
    assert "check --unit" in " ".join(open_recording(tmp_path / "a.trc", ReadOptions(unit=unit)).notes)


def test_a_body_that_no_unit_fits_is_logged(tmp_path):
    bvh(tmp_path / "a.bvh", BODY, 0.0125 * walking())
    assert "the body is 2 cm tall; set --unit" in open_recording(tmp_path / "a.bvh").notes
    trc(tmp_path / "b.trc", "m", 0.0125 * walking())
    assert "the body is 2 cm tall; set --unit" in open_recording(tmp_path / "b.trc").notes


def test_a_hand_of_markers_is_as_large_as_a_hand():
    assert limits_of(NAMES) == LIMITS
    assert limits_of(["C7", "T10", "LASI", "RASI", "LKNE", "RKNE"]) == THINGS
    assert fitting_factor(1700.0, limits_of(["C7", "T10", "LASI"])) == 1.0  # a few points are no body
    assert [fitting_factor(tall, THINGS) for tall in (0.06, 0.18, 8.0)] == [1.0] * 3
    assert fitting_factor(0.0017, THINGS, 0.001) == 1000.0
    assert [fitting_factor(tall, THINGS) for tall in (0.04, 0.0017, 1700.0, 0.0)] == [
        None,
        None,
        0.001,
        1.0,
    ]
    assert [fitting_factor(tall, LIMITS, 0.01) for tall in (0.17, 17.0, 170.0)] == [None, 0.1, None]


def test_sizes_in_words():
    assert [size_in_words(tall) for tall in (0.0017, 0.02, 0.43, 1.72, 1720.2)] == [
        "1.7 mm",
        "2 cm",
        "43 cm",
        "1.7 m",
        "1720 m",
    ]
