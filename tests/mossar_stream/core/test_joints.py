"""Joints that are missing, come back, or are too fast to be true; the One-Euro filter."""

import numpy as np
import pytest

from mossar_stream import Segmenter, Settings, Skeleton

FPS = 50.0
ROOM = Settings(level="posture", window=0.02, range="fixed", range_max=1.0)
BODY = Skeleton(("hip", "left", "right", "head"), (-1, 0, 0, 0))


def velocities(positions, settings=ROOM, skeleton=BODY, fps=FPS):
    """Return the curve of open takes, m per frame as the window holds one displacement, and the counters."""
    segmenter = Segmenter(skeleton, settings, fps=fps)
    curve = []
    for frame in np.asarray(positions, np.float32):
        segmenter.push(frame)
        if segmenter.state is not None:  # no take is open while no joint is there
            curve.append(segmenter.state.value)
    return np.array(curve), segmenter.stats


def walkers(frames=40):
    """Return people whose three joints each move 10 mm per frame relative to the hip, which moves, too."""
    positions = np.zeros((frames, 4, 3))
    along = np.arange(frames)
    positions[:, :, 1] = 0.02 * along[:, None]
    positions[:, 1, 0], positions[:, 2, 0], positions[:, 3, 2] = 0.01 * along, -0.01 * along, 0.01 * along
    return positions


def test_where_the_performer_stands_does_not_matter():
    curve, _ = velocities(walkers())
    np.testing.assert_allclose(curve[1:], 0.03, rtol=1e-5)
    assert curve[0] == 0


def test_the_centroid_may_be_the_centre():
    positions = walkers()
    local = positions - positions.mean(axis=1, keepdims=True)
    expected = np.linalg.norm(np.diff(local, axis=0), axis=2).sum(axis=1)
    curve, _ = velocities(positions, ROOM.replace(center="centroid"))
    np.testing.assert_allclose(curve[1:], expected, rtol=1e-5)
    rootless, _ = velocities(positions, skeleton=Skeleton(BODY.names, root=-1))
    np.testing.assert_array_equal(curve, rootless)


def test_a_missing_joint_is_held_for_max_gap_and_makes_up_for_it_when_it_is_back():
    positions = walkers()
    positions[:, :, 1] = 0  # the hip rests
    positions[10:15, 1] = np.nan
    curve, stats = velocities(positions)
    np.testing.assert_allclose(curve[10:15], 0.02, rtol=1e-5)
    np.testing.assert_allclose(curve[15], 0.02 + 0.06, rtol=1e-5)
    np.testing.assert_allclose(curve[16:], 0.03, rtol=1e-5)
    assert stats["held"] == 5


def test_a_joint_that_stays_away_is_left_out_and_the_sum_scaled_up():
    positions = walkers()
    positions[:, :, 1] = 0
    positions[10:30, 1] = np.nan
    curve, stats = velocities(positions)
    held = int(0.25 * FPS)
    np.testing.assert_allclose(curve[10 : 10 + held - 1], 0.02, rtol=1e-5)
    np.testing.assert_allclose(curve[10 + held : 29], 0.02 * 3 / 2, rtol=1e-5)
    np.testing.assert_allclose(curve[31:], 0.03, rtol=1e-5)
    assert stats["held"] == held
    assert stats["outliers"] == 0


def test_there_is_no_displacement_across_a_gap_of_a_joint():
    positions = walkers()
    positions[:, :, 1] = 0
    positions[10:30, 1] = np.nan
    positions[30:, 1, 0] += 5.0
    curve, stats = velocities(positions)
    assert curve[30] <= 0.03 + 1e-6
    np.testing.assert_allclose(curve[31:], 0.03, rtol=1e-5)
    assert stats["outliers"] == 0


def test_a_missing_centre_beyond_max_gap_stops_the_curve():
    positions = walkers()
    positions[10:30, 0] = np.nan
    curve, _ = velocities(positions)
    held = int(0.25 * FPS)
    np.testing.assert_array_equal(curve[10 + held : 30], 0)
    np.testing.assert_allclose(curve[31:], 0.03, rtol=1e-5)


def test_a_joint_never_seen_does_not_count():
    positions = walkers()
    positions[:, 3] = np.nan
    curve, _ = velocities(positions)
    np.testing.assert_allclose(curve[1:], 0.03, rtol=1e-5)


def test_a_joint_first_seen_late_joins_in_without_a_jump():
    positions = walkers()
    positions[:20, 3] = np.nan
    positions[:, 3, 0] += 3.0
    curve, _ = velocities(positions)
    np.testing.assert_allclose(curve[1:], 0.03, rtol=1e-5)


def test_a_joint_faster_than_max_speed_is_an_outlier_and_held():
    positions = walkers()
    positions[:, :, 1] = 0
    positions[20, 2] += [0, 1.0, 0]  # 50 m/s there and back
    curve, stats = velocities(positions)
    np.testing.assert_allclose(curve[20:22], [0.02, 0.04], rtol=1e-5)
    assert stats["outliers"] == 1
    assert velocities(positions, ROOM.replace(max_speed=100.0))[1]["outliers"] == 0


def test_somebody_who_really_is_elsewhere_is_believed_after_max_gap():
    positions = walkers()
    positions[20:, 2] += [0, 9.0, 0]
    curve, stats = velocities(positions)
    assert curve[22:].max() < 0.05
    np.testing.assert_allclose(curve[-4:], 0.03, rtol=1e-5)
    assert 0 < stats["outliers"] <= 0.25 * FPS


def test_a_place_that_the_next_frames_contradict_was_wrong():
    positions = walkers()
    positions[::7, 2, 1] += 50.0  # in the first frame, too, and never for max_gap at once
    curve, stats = velocities(positions)
    assert stats["outliers"] == 6
    curve[7::7] -= 0.01  # the joint is held for a frame,
    curve[8::7] -= np.hypot(0.02, 0.02) - 0.01  # and makes up for it, against the hip that has gone on
    np.testing.assert_allclose(curve[1:], 0.03, rtol=1e-4)


@pytest.mark.parametrize("root", [-1, 0])
def test_a_stray_marker_in_the_first_frame_moves_nobody(root):
    names = tuple(f"m{j}" for j in range(8))
    skeleton = Skeleton(names, root=root)
    rng = np.random.default_rng(3)
    pose = rng.normal(0, 0.3, (8, 3))
    positions = pose + 0.3 * np.sin(np.arange(100) / 10)[:, None, None] * rng.normal(0, 1, (8, 3))
    expected, _ = velocities(positions, skeleton=skeleton)
    for stray in (0, 5):
        odd = positions.copy()
        odd[0, stray] = 50.0
        segmenter = Segmenter(skeleton, ROOM, fps=FPS)
        segmenter.push(odd.astype(np.float32))
        assert segmenter.stats["outliers"] == 1
        assert np.abs(segmenter.state.pose).max() < 2.0
        curve, _ = velocities(odd, skeleton=skeleton)
        np.testing.assert_allclose(curve[3:], expected[3:], atol=1e-4)


def test_a_body_far_from_the_root_of_its_skeleton_counts():
    pose = np.random.default_rng(3).normal(0, 0.3, (8, 3))
    positions = np.tile(pose, (40, 1, 1))
    positions[:, 1:] += [5.0, 0.0, 0.0]  # a root that stays at the origin of the room
    skeleton = Skeleton(tuple("abcdefgh"), (-1, *[0] * 7))
    assert velocities(positions, skeleton=skeleton)[1]["outliers"] == 0


def test_of_a_place_that_was_borne_out_for_long_a_few_outliers_take_nothing():
    positions = walkers(400)
    positions[300:310, 2, 1] += 50.0
    positions[312:320, 2, 1] += 50.0
    curve, stats = velocities(positions)
    assert stats["outliers"] == 18
    assert stats["gaps"] == 0
    np.testing.assert_allclose(curve[321:], 0.03, rtol=1e-4)


def test_no_coordinate_is_a_million_metres():
    positions = walkers()
    positions[5:9, 1, 0] = 1e6
    curve, stats = velocities(positions)
    assert curve.max() < 0.2
    assert (stats["held"], stats["outliers"]) == (4, 4)


@pytest.mark.filterwarnings("ignore:performer p1 is")
@pytest.mark.parametrize("nowhere", [np.nan, 2e5, np.inf])
def test_frames_without_anybody_are_counted(nowhere):
    positions = walkers()
    positions[10:] = nowhere
    _, stats = velocities(positions)
    assert stats["unseen"] == len(positions) - 10
    curve, stats = velocities(np.full_like(positions, nowhere))
    assert stats["unseen"] == len(positions)
    assert len(curve) == 0
    assert (stats["outliers"] > 0) == (not np.isnan(nowhere))
    some = walkers()
    some[:, 1] = nowhere
    assert velocities(some)[1]["unseen"] == 0


def test_no_displacement_counts_across_a_gap_in_time():
    segmenter = Segmenter(BODY, ROOM)
    positions = walkers().astype(np.float32)
    segmenter.push(positions[:5], np.arange(5) / FPS)
    segmenter.push(positions[30], 0.7)
    assert segmenter.state.value == 0
    assert segmenter.stats == {
        "frames": 6,
        "out_of_order": 0,
        "outliers": 0,
        "held": 0,
        "gaps": 1,
        "unseen": 0,
    }
    segmenter.push(positions[31], 0.72)
    assert segmenter.state.value == pytest.approx(0.03, rel=1e-5)


def one_euro(x, fps, cutoff, beta):
    """Return the filtered positions (n, 3), as Casiez, Roussel and Vogel write the filter."""

    def weight(frequency):
        return 1 / (1 + fps / (2 * np.pi * frequency))

    filtered, slope = x[0].copy(), np.zeros(3)
    out = [filtered.copy()]
    for now in x[1:]:
        slope += weight(1.0) * ((now - filtered) * fps - slope)
        filtered += weight(cutoff + beta * np.linalg.norm(slope)) * (now - filtered)
        out.append(filtered.copy())
    return np.array(out)


def test_the_one_euro_filter_is_the_published_one():
    rng = np.random.default_rng(1)
    positions = (np.cumsum(rng.normal(0, 0.01, (80, 4, 3)), axis=0)).astype(np.float32)
    settings = ROOM.replace(smoothing="one_euro", one_euro_cutoff=2.0, one_euro_beta=0.5)
    curve, _ = velocities(positions, settings)
    smooth = np.stack([one_euro(positions[:, j].astype(float), FPS, 2.0, 0.5) for j in range(4)], axis=1)
    local = smooth - smooth[:, :1]
    expected = np.linalg.norm(np.diff(local, axis=0), axis=2).sum(axis=1)
    np.testing.assert_allclose(curve[1:], expected, rtol=1e-6)


def test_the_one_euro_filter_quietens_noise_at_rest():
    noise = np.random.default_rng(2).normal(0, 0.002, (400, 4, 3))
    raw, _ = velocities(noise)
    smooth, _ = velocities(noise, ROOM.replace(smoothing="one_euro"))
    assert smooth[100:].mean() < 0.4 * raw[100:].mean()
