"""Held poses: reported once when they are held, from any side and of bodies of any size, however frames are cut."""

import importlib.util
from pathlib import Path

import msgspec
import numpy as np
import pytest

from mossar_stream import (
    Frames,
    Moves,
    MovesError,
    Performers,
    PoseEvent,
    Segmenter,
    Settings,
    Skeleton,
    SnapshotError,
    segment_recording,
    to_json,
)

_PLACE = Path(__file__).parents[1] / "moves" / "conftest.py"
_spec = importlib.util.spec_from_file_location("people_who_move", _PLACE)
people = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(people)
PERSON, STANDING, FPS = people.PERSON, people.STANDING, people.FPS
PLACE = {name: joint for joint, name in enumerate(PERSON.names)}


def raised(*arms, up=0.0):
    """Return a person with arms raised sideways, or (up=1) above the head."""
    pose = STANDING.copy()
    for side in arms:
        shoulder = pose[PLACE[f"{side}_shoulder"]]
        way = np.array([np.sign(shoulder[0]) * (1 - up), up, 0])
        pose[PLACE[f"{side}_elbow"]] = shoulder + 0.28 * way
        pose[PLACE[f"{side}_wrist"]] = shoulder + 0.53 * way
    return pose


T_POSE, HAND_UP = raised("left", "right"), raised("right", up=1.0)
# Lying on hands and toes: y and z of the standing person change places.
PLANK = (STANDING - [0, 1, 0])[:, [0, 2, 1]] * [1, -1, 1] + [0, 0.5, 0]
POSES = {"t": T_POSE, "plank": PLANK, "hand_up": HAND_UP}


def session(*poses, held=2.5, seed=0, noise=0.005):
    """Return positions and times of a person who stands, takes each pose, holds it and stands again."""
    still = np.repeat(STANDING[None], 45, axis=0)
    share = (0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 24)))[:, None, None]
    parts = [still]
    for pose in poses:
        way = STANDING + share * (pose - STANDING)
        parts += [way, np.repeat(pose[None], round(held * FPS), axis=0), way[::-1], still]
    frames = np.concatenate(parts)
    frames = frames + np.random.default_rng(seed).normal(0, noise, frames.shape)
    return frames.astype(np.float32), np.arange(len(frames)) / FPS


@pytest.fixture(scope="module")
def moves():
    found = Moves(PERSON)
    for name, pose in POSES.items():
        found.add_pose(name, pose)
    return found


def events_of(segmenter, frames, times, size=64):
    events = []
    for at in range(0, len(times), size):
        events += segmenter.push(frames[at : at + size], times[at : at + size])
    return events + segmenter.end_take()


def told(events):
    return [event for event in events if isinstance(event, PoseEvent)]


def story(events):
    return [(event.name, event.status) for event in told(events)]


def once(*names):
    return [(name, status) for name in names for status in ("entered", "held", "left")]


def test_each_pose_is_entered_held_and_left_once(moves):
    frames, times = session(T_POSE, PLANK, HAND_UP)
    events = told(events_of(Segmenter(PERSON, moves=moves), frames, times))
    assert story(events) == once("t", "plank", "hand_up")
    assert [event.id for event in events] == [f"p1/pose/0/{n}" for n in (1, 2, 3) for _ in range(3)]
    assert [event.rev for event in events] == [1, 2, 3] * 3
    for entered, held, left in zip(events[::3], events[1::3], events[2::3], strict=True):
        assert entered.start == held.start == left.start < entered.decided_time
        assert 1.0 <= held.seconds < 1.4
        assert 2.5 < left.seconds < 3.4
        assert held.deviation < 6
        assert set(held.limbs) == {"trunk", "left_arm", "right_arm", "left_leg", "right_leg"}


def test_turned_performers_of_other_sizes_hold_the_same_poses(moves):
    frames, times = session(T_POSE, PLANK, HAND_UP)
    for degrees, scale in ((90, 1.0), (-150, 0.7), (180, 1.3)):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        other = (scale * frames @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]).T + [3, 0, 5]).astype(
            np.float32
        )
        assert story(events_of(Segmenter(PERSON, moves=moves), other, times)) == once("t", "plank", "hand_up")
    seen_from_the_side = moves.copy()
    seen_from_the_side.facing = "as_shown"
    turned = frames[:, :, [2, 1, 0]] * np.float32([1, 1, -1])
    assert story(events_of(Segmenter(PERSON, moves=seen_from_the_side), turned, times)) == []


def mirrored_pose():
    found = Moves(PERSON)
    found.add_pose("hand_right", HAND_UP)
    found.set_rule("hand_right", mirrored=True)
    return found


def test_the_mirror_image_of_a_pose_has_the_name_of_the_other_side():
    found = Moves.from_json(mirrored_pose().to_json())
    frames, times = session(HAND_UP, raised("left", up=1.0))
    seen = told(events_of(Segmenter(PERSON, moves=found), frames, times))
    assert story(seen) == once("hand_right", "hand_left")
    assert {event.name: event.deviation < 4 for event in seen} == {"hand_right": True, "hand_left": True}
    turned = np.roll(frames, 1, axis=2)
    lying = Moves(PERSON)
    lying.add_pose("hand_right", np.roll(HAND_UP, 1, axis=1))
    lying.set_rule("hand_right", mirrored=True)
    upright = Segmenter(PERSON, Settings(up="z"), moves=lying)
    assert story(events_of(upright, turned, times)) == once("hand_right", "hand_left")


def test_a_pose_has_no_other_rule_and_loses_it_with_the_pose():
    found = mirrored_pose()
    for fields in ({"strict": 0.8}, {"again": 1}):
        with pytest.raises(MovesError, match="is a pose"):
            found.set_rule("hand_right", **fields)
    text = found.to_json().replace(b'{"mirrored":true}', b'{"strict":0.8}')
    with pytest.raises(MovesError, match="can only be mirrored"):
        Moves.from_json(text)
    found.remove("hand_right")
    found.add_pose("hand_right", HAND_UP)
    assert not found.rule("hand_right").mirrored


def test_z_may_point_upwards():
    upright = Moves(PERSON)
    upright.add_pose("plank", PLANK[:, [2, 0, 1]])
    frames, times = session(PLANK)
    segmenter = Segmenter(PERSON, Settings(up="z"), moves=upright)
    assert story(events_of(segmenter, frames[:, :, [2, 0, 1]], times)) == once("plank")


def test_who_pauses_in_a_pose_does_not_hold_it(moves):
    frames, times = session(T_POSE, held=0.1)
    assert story(events_of(Segmenter(PERSON, moves=moves), frames, times)) == [
        ("t", "entered"),
        ("t", "left"),
    ]


def test_one_who_wavers_in_a_pose_holds_it_once(moves):
    frames, times = session(T_POSE, held=12.0, noise=0.003)
    sway = 0.07 * np.sin(2 * np.pi * 0.6 * times)[:, None].astype(np.float32)
    for joint in ("left_wrist", "right_wrist"):
        frames[:, PLACE[joint], 1] += sway[:, 0]
    assert story(events_of(Segmenter(PERSON, moves=moves), frames, times)) == once("t")


def test_the_limb_and_the_joint_that_stray_are_named(moves):
    bent = T_POSE.copy()
    bent[PLACE["left_wrist"]] += [0, -0.12, 0]
    frames, times = session(bent, noise=0.001)
    held = next(
        e for e in told(events_of(Segmenter(PERSON, moves=moves), frames, times)) if e.status == "held"
    )
    assert held.joint == "left_wrist"
    assert held.limb == "left_arm"
    assert held.limbs["right_arm"] < 3 < held.limbs["left_arm"]


def test_hold_is_per_pose_and_what_was_shown_last_counts():
    shown = Moves(PERSON)
    frames, times = session(T_POSE, held=2.5)
    shown.add_pose("t", frames[: 45 + 24 + 70], FPS, hold=2.0)
    assert abs(shown.poses[0].metres(15) - T_POSE).max() < 0.01
    held = next(
        e for e in told(events_of(Segmenter(PERSON, moves=shown), frames, times)) if e.status == "held"
    )
    assert 2.0 <= held.seconds < 2.2


def test_chunks_and_snapshots_make_no_difference(moves):
    frames, times = session(T_POSE, HAND_UP)
    wanted = [to_json(e) for e in events_of(Segmenter(PERSON, moves=moves), frames, times, len(times))]
    for size in (1, 7):
        assert [to_json(e) for e in events_of(Segmenter(PERSON, moves=moves), frames, times, size)] == wanted
    segmenter, events = Segmenter(PERSON, moves=moves), []
    for at in range(0, len(times), 5):
        segmenter = Segmenter.restore(segmenter.snapshot())
        events += segmenter.push(frames[at : at + 5], times[at : at + 5])
    assert [to_json(e) for e in events + segmenter.end_take()] == wanted


def test_other_events_stay_as_they_are(moves):
    frames, times = session(T_POSE, PLANK)
    events = events_of(Segmenter(PERSON, moves=moves), frames, times)
    without = events_of(Segmenter(PERSON), frames, times)
    assert [to_json(e) for e in events if not isinstance(e, PoseEvent)] == [to_json(e) for e in without]


def test_several_performers_and_moves_that_change(moves):
    frames, times = session(T_POSE)
    pool, events = Performers(moves=moves), []
    for name in ("a", "b"):
        pool.announce(name, PERSON)
    middle = 45 + 24 + 50
    for name in ("a", "b"):
        events += pool.push(Frames(frames[:middle], times[:middle], performer=name))
    pool.moves = None
    for name in ("a", "b"):
        events += pool.push(Frames(frames[middle:], times[middle:], performer=name))
    for name in ("a", "b"):
        own = [event for event in told(events) if event.performer == name]
        assert story(own) == once("t")
        assert own[-1].seconds < 2.2


def test_a_gap_and_the_end_of_a_take_end_a_pose(moves):
    frames, times = session(T_POSE)
    middle = 45 + 24 + 50
    segmenter = Segmenter(PERSON, moves=moves)
    assert story(segmenter.push(frames[:middle], times[:middle]) + segmenter.end_take()) == once("t")
    late = times + np.where(np.arange(len(times)) >= middle, 0.6, 0.0)
    events = told(events_of(Segmenter(PERSON, moves=moves), frames, late))
    assert [event.status for event in events[:3]] == ["entered", "held", "left"]
    assert events[3].id == "p1/pose/0/2"


def test_a_file_keeps_poses_and_older_files_are_read(moves):
    again = Moves.from_json(moves.to_json())
    assert again.poses == moves.poses
    assert again.to_json() == moves.to_json()
    content = msgspec.json.decode(moves.to_json())
    assert content["version"] == 3
    del content["poses"]
    assert Moves.from_json(msgspec.json.encode({**content, "version": 2})).poses == ()
    assert msgspec.json.decode(Moves(PERSON).to_json())["version"] == 2
    again.remove("plank")
    assert [pose.name for pose in again.poses] == ["t", "hand_up"]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"positions": T_POSE[:5]}, "form"),
        ({"positions": np.full_like(T_POSE, np.nan)}, "lacks some"),
        ({"positions": np.zeros_like(T_POSE)}, "one place"),
        ({"positions": "plank"}, "numbers"),
        (
            {"positions": np.linspace(0, 1, 90)[:, None, None] * (PLANK - STANDING) + STANDING},
            "nothing is held",
        ),
        ({"positions": T_POSE, "hold": -1}, "hold"),
        ({"positions": T_POSE, "hold": True}, "hold"),
        ({"positions": T_POSE, "fps": 0}, "rate"),
        ({"positions": T_POSE, "name": ""}, "name"),
        ({"positions": T_POSE, "name": "kick"}, "a move already"),
    ],
)
def test_what_cannot_be_a_pose_is_refused(given, says):
    shown = Moves(PERSON)
    shown.add("kick", people.performed("kick_right"), FPS)
    with pytest.raises(MovesError, match=says):
        shown.add_pose(**{"name": "t", **given})
    assert shown.poses == ()


def test_bad_files_are_refused(moves):
    content = msgspec.json.decode(moves.to_json())
    for change in ({"positions": [1, 2]}, {"hold": -1}, {"name": " "}):
        bad = {**content, "poses": [{**content["poses"][0], **change}]}
        with pytest.raises(MovesError):
            Moves.from_json(msgspec.json.encode(bad))


def test_a_damaged_state_is_refused(moves):
    segmenter = Segmenter(PERSON, moves=moves)
    holding = segmenter._followers.holding
    sound = holding.to_bytes()
    for bad in (sound[:-8], b"", b"\xff" * len(sound)):
        with pytest.raises(SnapshotError):
            holding.go_on_from(bad)


def test_a_skeleton_of_one_joint_has_no_pose():
    with pytest.raises(MovesError):
        Moves(Skeleton(("a",))).add_pose("t", np.zeros((1, 3)))


def test_flat_skeletons_without_a_root_and_joints_in_one_place_have_poses():
    flat = Skeleton(("spine", "left_wrist", "right_wrist", "head", "mark"), (-1, 0, 0, 0, 0), root=-1)
    low = np.array([[0, 1.1, 0], [0.2, 0.8, 0], [-0.2, 0.8, 0], [0, 1.6, 0], [0, 1.1, 0]], float)
    high = low.copy()
    high[1] = [0.3, 1.9, 0]
    shown = Moves(flat)
    shown.add_pose("hand_up", high)
    share = (0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 24)))[:, None, None]
    still = np.repeat(low[None], 45, axis=0)
    way = low + share * (high - low)
    frames = np.concatenate([still, way, np.repeat(high[None], 75, axis=0), way[::-1], still])
    frames = (frames + np.random.default_rng(0).normal(0, 0.005, frames.shape)).astype(np.float32)
    events = events_of(Segmenter(flat, moves=shown), frames, np.arange(len(frames)) / FPS)
    assert story(events) == once("hand_up")


def test_a_recording_has_the_poses_that_were_held(moves):
    frames, times = session(T_POSE, PLANK)
    result = segment_recording(frames, skeleton=PERSON, times=times, moves=moves)
    assert [pose.name for pose in result.poses] == ["t", "plank"]
    assert [pose.seconds for pose in result.poses] == [
        e.seconds
        for e in told(events_of(Segmenter(PERSON, moves=moves), frames, times))
        if e.status == "left"
    ]
