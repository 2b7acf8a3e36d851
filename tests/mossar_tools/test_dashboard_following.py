"""The dashboard shows a move that is followed: a ring, the count, the example over the body, what strays in colour."""

import re

import numpy as np
import pytest

from mossar_adapters.demo import DemoSource, performance
from mossar_adapters.pipeline import Pipeline
from mossar_stream import Frames, Moves, Segmenter, Settings, Skeleton
from mossar_stream.moves.mirroring import mirrored_joints
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.placement import Placement
from mossar_tools.dashboard.rings import rings
from mossar_tools.dashboard.scene import straying
from mossar_tools.dashboard.shadow import Shadow
from mossar_tools.dashboard.tables import state_card
from mossar_tools.dashboard.track import Track

FPS = 60.0


@pytest.fixture(scope="module")
def take():
    return performance(2, fps=FPS, moves=["rest:2", "squat", "squat", "squat", "rest:2"])


@pytest.fixture(scope="module")
def moves(take):
    found = Moves(take.skeleton)
    found.add("squat", take.frames.positions[round(3.4 * FPS) : round(4.6 * FPS)], FPS)
    return found


def glimpses_of(take, moves, positions):
    """Yield what the dashboard would show after each tenth of a second."""
    segmenter, track = (
        Segmenter(take.skeleton, Settings(), moves=moves, follow=True),
        Track("p1", take.skeleton),
    )
    for i, time in enumerate(take.frames.times.tolist()):
        for event in segmenter.push(positions[i], time):
            track.add_event(event)
        track.add_frames(Frames(positions[i : i + 1], np.array([time]), performer="p1"))
        track.add_sample(segmenter.state)
        track.set_following(segmenter.following, moves, segmenter.settings.up)
        if i % 6 == 5:
            yield track.glimpse(1.0, [])


def test_a_ring_goes_round_with_each_squat_and_the_count_goes_up(take, moves):
    seen = list(glimpses_of(take, moves, take.frames.positions))
    counts = [glimpse.followed_moves[0].count for glimpse in seen]
    assert counts == sorted(counts)
    assert counts[-1] >= 4
    going = [rings([glimpse]) for glimpse in seen if glimpse.followed_moves[0].progress is not None]
    shares = {round(float(re.search(r'data-progress="([\d.]+)"', ring)[1]), 1) for ring in going}
    assert len(shares) >= 4
    card = state_card([seen[-1]], frozen=False, recording="", frames=0)
    assert f"<td>squat</td><td><b>{counts[-1]}</b></td>" in card
    assert rings([]) == ""


def test_the_example_lies_over_the_body_while_the_move_is_made_and_not_else(take, moves):
    seen = list(glimpses_of(take, moves, take.frames.positions))
    assert all((glimpse.overlay is None) == (glimpse.followed_moves[0].progress is None) for glimpse in seen)
    over = [glimpse for glimpse in seen if glimpse.overlay is not None]
    assert len(over) > 20
    apart = [np.linalg.norm(one.overlay.joints - one.body.joints, axis=1).max() for one in over]
    assert np.median(apart) < 0.1  # m: the same person makes the same move
    assert np.median([np.nanmax(one.overlay.strays) for one in over]) < 15


def test_the_mirror_image_lies_over_a_body_seen_in_a_mirror():
    kicks = performance(2, fps=FPS, moves=["rest:2", "kick_right", "rest:1", "kick_right", "rest:2"])
    mine = Moves(kicks.skeleton)
    mine.add("kick_right", kicks.frames.positions[round(1.6 * FPS) : round(3.4 * FPS)], FPS)
    mine.set_rule("kick_right", mirrored=True)
    seen = kicks.frames.positions
    inside = seen[:, mirrored_joints(kicks.skeleton)] * np.array([-1, 1, 1], np.float32)

    def apart(positions, name):
        found = [one for one in glimpses_of(kicks, mine, positions) if one.overlay is not None]
        over = [one for one in found if one.followed_moves[0].name == name]
        return len(over), np.median(
            [np.linalg.norm(one.overlay.joints - one.body.joints, axis=1).max() for one in over]
        )

    count, distance = apart(seen, "kick_right")
    assert count > 5
    assert apart(inside, "kick_left") == (count, pytest.approx(distance, abs=0.02))


def turned(positions, degrees):
    angle = np.radians(degrees)
    cosine, sine = np.cos(angle), np.sin(angle)
    return (positions @ np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]]).T).astype(np.float32)


@pytest.mark.parametrize(("degrees", "size"), [(0, 1.0), (70, 1.0), (-120, 1.3), (0, 0.7)])
def test_the_example_faces_as_the_performer_does_and_has_its_size(take, moves, degrees, size):
    example = moves.examples[0]
    shown = example.followed(len(take.skeleton), take.skeleton.root)[0]
    poses = turned(shown * size, degrees) + np.float32(2.0)
    placement, shadow = Placement(take.skeleton), Shadow(moves.skeleton, take.skeleton)
    for pose in poses:
        placement.learn(pose)
    for k, pose in enumerate(poses):
        body = placement.place(pose)
        over = shadow.pose(example, k / (len(poses) - 1), body, placement)
        assert np.abs(over - body).max() < 0.03
        assert np.nanmax(shadow.strays(over, body)) < 3


def test_the_bone_that_strays_gets_colour_and_others_do_not(take, moves):
    example, names = moves.examples[0], list(take.skeleton.names)
    pose = example.followed(len(names), take.skeleton.root)[0][0].copy()
    placement, shadow = Placement(take.skeleton), Shadow(moves.skeleton, take.skeleton)
    placement.learn(pose)
    elbow, hand = names.index("LeftLowerArm"), names.index("LeftHand")
    pose[hand] = pose[elbow] + np.array([0.0, 0.25, 0.0], np.float32)  # straight up
    body = placement.place(pose)
    strays = shadow.strays(shadow.pose(example, 0.0, body, placement), body)
    shares = dict(zip(take.skeleton.bones(), straying(strays).tolist(), strict=True))
    assert shares.pop((elbow, hand)) == 1.0
    assert max(shares.values()) < 0.1


def test_joints_of_other_sets_are_matched_and_those_that_are_missing_do_no_harm(moves):
    names = (
        "pelvis",
        "left_hip",
        "right_hip",
        "left_knee",
        "right_knee",
        "left_shoulder",
        "right_shoulder",
        "nose",
    )
    streamed = Skeleton(names, (-1, 0, 0, 1, 2, 0, 0, 0))
    shadow, placement = Shadow(moves.skeleton, streamed), Placement(streamed)
    rng = np.random.default_rng(1)
    pose = rng.normal(0, 0.5, (8, 3)).astype(np.float32)
    placement.learn(pose)
    for missing in ([], [0], [1, 2], list(range(8))):
        body = placement.place(pose)
        body[missing] = np.nan
        over = shadow.pose(moves.examples[0], 0.5, body, placement)
        assert np.isfinite(over).all()
        assert shadow.strays(over, body).shape == (7,)


@pytest.mark.parametrize(("wanted", "found"), [(("squat",), ("squat",)), (("lunge",), ()), (("all",), True)])
def test_a_move_is_followed_once_it_is_taught(moves, wanted, found):
    show = LiveShow(Settings(), follow=wanted)
    pipeline = Pipeline([DemoSource.from_url("demo:?seconds=1", speed="max")], [], Settings())
    assert pipeline.pool.follow == ()
    show._recognise(moves)
    show.tick(pipeline)
    assert pipeline.pool.follow == found


def test_a_held_pose_is_shown_above_the_curve_until_it_is_left(take):
    frames, moves = take.frames.positions, Moves(take.skeleton)
    moves.add_pose("standing", frames[60])
    segmenter, track = Segmenter(take.skeleton, Settings(), moves=moves), Track("p1", take.skeleton)
    shown = []
    for k, time in enumerate(take.frames.times.tolist()):
        track.add_frames(Frames(frames[k : k + 1], np.array([time])))
        for event in segmenter.push(frames[k], time):
            track.add_event(event)
        track.add_sample(segmenter.state)
        if k % 6 == 5:
            stretches = [move for move in track.glimpse(5.0, []).moves if move.name == "standing"]
            shown.append((time, [(move.start, move.end) for move in stretches]))
    during = next(stretches for time, stretches in shown if 1.5 < time < 1.8)
    assert len(during) == 1
    assert during[0][1] >= 1.5  # it goes on
    later = next(stretches for time, stretches in shown if 3.4 < time < 3.8)
    assert len(later) == 1
    assert 1.5 < later[0][1] < 3.4
