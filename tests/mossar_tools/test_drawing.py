import itertools

import numpy as np
import pytest

from mossar_adapters.demo import SKELETON, performance
from mossar_stream import KeyFrame, Skeleton, segment_recording
from mossar_tools.bars import bar
from mossar_tools.dendrogram import merges
from mossar_tools.poses import spread
from mossar_tools.stick_figures import head_of, project, sides, view_of


def test_spread_places_keep_their_order_and_distance():
    rng = np.random.default_rng(3)
    for count in (1, 2, 7, 15):
        times = np.sort(rng.uniform(0, 30, count)).tolist()
        places = spread(times, 0.0, 30.0, 30 / 16)
        assert all(b - a >= 30 / 16 - 1e-6 for a, b in itertools.pairwise(places))
        assert places[0] >= 0
        assert places[-1] <= 30


def test_places_with_room_stay_where_they_are():
    assert spread([3.0, 9.0], 0.0, 30.0, 1.0) == [3.0, 9.0]


def test_merges_join_neighbours_up_to_the_whole():
    take = performance(seed=2, seconds=12).frames
    result = segment_recording(take.positions, 60, SKELETON)
    found = merges(result.hierarchy, 0.0, 12.0)
    assert len(found) == len(result.key_frames)
    assert (found[-1].start, found[-1].end) == (0.0, 12.0)
    heights = [merge.height for merge in found]
    assert heights == sorted(heights)
    for merge in found:
        assert merge.start <= merge.left <= merge.right <= merge.end
        assert max(merge.left_height, merge.right_height) <= merge.height


def test_no_key_frame_is_no_merge():
    assert merges([], 0.0, 1.0) == []
    key = KeyFrame(30, 1.0, "minimum", 0.1, 0.5)
    assert merges([key], 0.0, 2.0)[0].height == 0.5


def test_key_frames_at_the_same_time_as_the_ends_are_no_trouble():
    times = [0.0, 1.0, 1.0, 2.0]
    keys = [KeyFrame(i, time, "minimum", 0.1, 0.1 * i) for i, time in enumerate(times)]
    found = merges([keys[2], keys[0], keys[3], keys[1]], 0.0, 2.0)
    assert (found[-1].start, found[-1].end) == (0.0, 2.0)
    assert len(found) == 4


def test_figures_stand_upright_and_face_the_reader_whatever_their_axes():
    take = performance(seed=2, seconds=4).frames.positions.astype(float)
    head, foot = SKELETON.index("Head"), SKELETON.index("LeftFoot")
    left, right = SKELETON.index("LeftUpperArm"), SKELETON.index("RightUpperArm")
    toes = SKELETON.index("LeftToes")
    zxy = take[:, :, [2, 0, 1]]  # z is up now
    shifted = take @ np.array([[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]]) + [5, 0, 3]
    for poses in (take, zxy, shifted):
        view = view_of(SKELETON, poses)
        flat = project(poses[0], view)
        assert flat[head, 1] - flat[foot, 1] > 1.2
        assert flat[left, 0] > flat[right, 0]
        assert flat[toes, 0] > flat[foot, 0]


def test_figures_without_feet_stand_upright_where_y_points_down():
    take = performance(seed=2, seconds=4).frames.positions.astype(float)
    names = ("Head", "Spine", "LeftHand", "RightHand")
    poses = take[:, [SKELETON.index(name) for name in names]] * [1, -1, 1]
    flat = project(poses[0], view_of(Skeleton(names), poses))
    assert flat[0, 1] - flat[1, 1] > 0.2


@pytest.mark.parametrize(
    "names", [("lhand", "rhand", "lfoot", "rfoot"), ("L_Hand", "R_Hand", "L_Foot", "R_Foot")]
)
def test_sides_are_told_by_names(names):
    assert sides(Skeleton(names)).tolist() == [1, -1, 1, -1]


def test_unnamed_joints_have_no_side_and_no_head():
    skeleton = Skeleton(("joint0", "joint1", "joint2"))
    assert not sides(skeleton).any()
    assert head_of(skeleton) == -1
    pose = np.array([[0, 0, 0], [1, 0, 0], [0, 3, 0]], float)
    assert np.isfinite(project(pose, view_of(skeleton, pose[None]))).all()


@pytest.mark.parametrize(("share", "fine"), [(-1, True), (0, True), (0.123, True), (1, False), (7, False)])
def test_bars_have_their_width(share, fine):
    assert len(bar(share, 10, fine=fine)) == 12
