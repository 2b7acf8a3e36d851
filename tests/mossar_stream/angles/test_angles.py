"""Angles: exact on a skeleton whose angles are known, and what geometry gives on squats."""

from pathlib import Path

import numpy as np
import pytest

from mossar_stream import RepetitionEvent, Skeleton, joint_angles, ranges_of_motion

NAMES = (
    *("hips", "chest", "head"),
    *(
        f"{side}_{part}"
        for side in ("left", "right")
        for part in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle", "foot_index")
    ),
)
SKELETON = Skeleton(NAMES, (-1, *([0] * (len(NAMES) - 1))), 0)


def turned(vector, degrees):
    """Turn about the axis to the left, forwards being z and up y."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([vector[0], c * vector[1] + s * vector[2], -s * vector[1] + c * vector[2]])


def pose(hip, knee, ankle, shoulder, elbow, lean):
    """Return (J, 3): a performer bent by so many degrees in the plane of walking."""
    trunk = turned([0, 0.5, 0], lean)
    places = {"hips": np.array([0.0, 1, 0])}
    places["chest"] = places["hips"] + trunk
    places["head"] = places["chest"] + trunk / 2
    for side, sign in (("left", 1), ("right", -1)):
        at = places["hips"] + [0.1 * sign, 0, 0]
        places[f"{side}_hip"] = at
        down = -trunk / np.linalg.norm(trunk)
        thigh = turned(down, -hip) * 0.4
        shank = turned(thigh, knee)
        foot = turned(shank / 2, -90 - ankle)
        for part, bone in (("knee", thigh), ("ankle", shank), ("foot_index", foot)):
            at = at + bone
            places[f"{side}_{part}"] = at
        at = places["chest"] + [0.2 * sign, 0, 0]
        places[f"{side}_shoulder"] = at
        arm = turned(down, -shoulder) * 0.3
        places[f"{side}_elbow"] = at + arm
        places[f"{side}_wrist"] = at + arm + turned(arm, -elbow)
    return np.array([places[name] for name in NAMES])


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("axes", [(0, 1, 2), (2, 0, 1)])
def test_angles_are_exact_to_a_tenth_of_a_degree(seed, axes):
    random = np.random.default_rng(seed)
    hip, knee, shoulder, elbow = random.uniform(0, 150, 4)
    ankle, lean = random.uniform(-40, 30), random.uniform(0, 30)
    one = pose(hip, knee, ankle, shoulder, elbow, lean)[None, :, axes]
    found = joint_angles(one, SKELETON, up="xyz"[axes.index(1)])
    expected = {
        "hip_flexion": hip,
        "knee_flexion": knee,
        "ankle_dorsiflexion": ankle,
        "shoulder_elevation": shoulder,
        "elbow_flexion": elbow,
    }
    for name, value in expected.items():
        for side in ("left", "right"):
            assert found[f"{side}_{name}"][0] == pytest.approx(value, abs=0.1), name
    assert found["trunk_inclination"][0] == pytest.approx(lean, abs=0.1)


def test_upwards_is_found_where_nobody_says_it():
    upright = np.array([pose(0, 0, 0, 0, 0, lean) for lean in np.linspace(0, 40, 30)])
    for axes in ((0, 1, 2), (1, 2, 0)):
        found = joint_angles(upright[:, :, axes], SKELETON)
        assert found["trunk_inclination"] == pytest.approx(np.linspace(0, 40, 30), abs=0.1)


def test_a_missing_joint_leaves_the_others():
    one = pose(10, 20, 0, 30, 40, 0)[None].copy()
    one[0, NAMES.index("left_ankle")] = np.nan
    found = joint_angles(one, SKELETON)
    assert np.isnan(found["left_knee_flexion"][0])
    assert found["right_knee_flexion"][0] == pytest.approx(20, abs=0.1)


@pytest.fixture
def repetition(made):
    return lambda count, start, end: made(RepetitionEvent, count=count, start=start, end=end)


def test_ranges_say_how_far_and_how_long(repetition):
    times = np.arange(401) / 100
    shape = np.interp(times, [0, 1, 2, 2.5, 4], [0, 100, 100, 0, 0])  # up in 1 s, held for 1 s, down in 0.5 s
    angles = {
        "left_knee_flexion": shape,
        "right_knee_flexion": 0.9 * shape,
        "trunk_inclination": 20 - 0.2 * shape,
    }
    left, right, trunk = ranges_of_motion(angles, times, [repetition(1, 0.0, 4.0)])
    assert (left.minimum, left.maximum, left.range) == (0, 100, 100)
    assert (left.up, left.hold, left.down) == pytest.approx((0.8, 1.0 + 0.1 + 0.05, 0.4), abs=0.011)
    assert left.asymmetry == right.asymmetry == pytest.approx(100 * 10 / 95)
    assert (trunk.range, trunk.asymmetry) == (pytest.approx(20), None)
    assert trunk.up == pytest.approx(0.8, abs=0.011)


def test_what_does_not_move_or_is_not_seen_has_no_phases(repetition):
    times = np.arange(100) / 50
    still = {"left_knee_flexion": np.full(100, 3.0), "right_knee_flexion": np.full(100, np.nan)}
    (only,) = ranges_of_motion(still, times, [repetition(1, 0.0, 1.9)])
    assert (only.angle, only.range, only.up, only.asymmetry) == ("left_knee_flexion", 0.0, None, None)


def test_positions_that_do_not_fit_the_skeleton_are_refused():
    with pytest.raises(ValueError, match="the skeleton calls for"):
        joint_angles(np.zeros((3, 4, 3)), SKELETON)


def test_knees_in_squats_bend_as_legs_of_these_lengths_must():
    folder = Path(__file__).parents[4] / "shared" / "data" / "labelled" / "ui_prmd"
    if not folder.is_dir():
        pytest.skip(f"the recordings are not here ({folder})")
    from mossar_adapters.files import read

    take = read(next(iter(sorted(folder.glob("m01_s*.npz")))))
    angles = joint_angles(take.positions, take.skeleton)
    joints = {name: take.skeleton.names.index(name) for name in take.skeleton.names}
    hip, knee, ankle = (
        next(j for n, j in joints.items() if word in n.lower() and "left" in n.lower())
        for word in ("hip", "knee", "ankle")
    )
    a, b, c = (
        np.linalg.norm(take.positions[:, i].astype(float) - take.positions[:, j], axis=1)
        for i, j in ((hip, knee), (knee, ankle), (hip, ankle))
    )
    law = 180 - np.degrees(np.arccos(np.clip((a**2 + b**2 - c**2) / (2 * a * b), -1, 1)))  # of cosines
    assert angles["left_knee_flexion"] == pytest.approx(law, abs=0.1)
    assert 60 < np.nanmax(law) < 160
    assert np.nanmin(law) < 30
