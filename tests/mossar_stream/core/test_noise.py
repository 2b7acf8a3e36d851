"""People who stand still before a noisy sensor, and what they do before and after."""

import numpy as np
import pytest

from checks.reference.counted import counted_by
from checks.reference.motion import Motion
from checks.reference.motion_velocity import velocity
from mossar_stream import Segmenter, Settings, Skeleton, segment_recording

demo = pytest.importorskip("mossar_adapters.demo")
ORDERS = {"before": ("stand:20", "punch", "kick"), "after": ("punch", "kick", "stand:20")}


def confirmed(core, take, **settings):
    segmenter = Segmenter(take.skeleton, Settings(**settings), fps=take.fps)
    return [e.time for e in core.key_frames(segmenter.push(take.frames) + segmenter.end_take(), "confirmed")]


def while_standing(take, times):
    """Return how many of the times lie in the period of standing."""
    stands_first = take.cuts[0].before == "stand"
    begin, end = (0.0, take.cuts[0].time) if stands_first else (take.cuts[-1].time, np.inf)
    return sum(begin <= time < end for time in times)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("noise", [0.001, 0.005])
@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_twenty_seconds_of_standing_are_few_key_frames(core, fps, noise, order):
    most = 2
    for seed in range(3):
        take = demo.performance(seed, fps=fps, noise=noise, moves=ORDERS[order])
        for level in ("motion", "cluster"):
            assert while_standing(take, confirmed(core, take, level=level)) <= most
        whole = segment_recording(take.frames.positions, fps, take.skeleton, Settings(range="file"))
        assert while_standing(take, [k.time for k in whole.at("motion").key_frames]) <= most + (noise > 0.001)


def test_without_the_margin_they_flood(core):
    take = demo.performance(1, fps=60.0, noise=0.005, moves=ORDERS["before"])
    assert while_standing(take, confirmed(core, take, noise_margin=0.0)) > 20


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
@pytest.mark.parametrize(("noise", "recall"), [(0.002, 0.95), (0.005, 0.8)])
def test_the_cuts_of_a_noisy_performance_are_still_found(core, fps, noise, recall):
    hits = total = 0
    for seed in range(5):
        take = demo.performance(seed, fps=fps, noise=noise)
        times = np.array(confirmed(core, take))
        hits += sum(np.abs(times - cut.time).min() <= 0.25 for cut in take.cuts)
        total += len(take.cuts)
        assert len(times) <= 8.25 * len(take.cuts)
    assert hits >= recall * total


def test_a_clean_recording_goes_through_unchanged_but_for_its_first_moment(core, walk_86_01):
    positions, skeleton = walk_86_01
    found = []
    for margin in (0.0, 1.5):
        segmenter = Segmenter(skeleton, Settings(noise_margin=margin), fps=120.0)
        events = core.key_frames(segmenter.push(positions) + segmenter.end_take(), "confirmed")
        found.append(core.lines(e for e in events if e.frame > 24))
    assert found[0] == found[1]
    assert len(found[0]) > 30


def test_the_fixed_range_and_the_papers_preset_know_no_noise(core):
    for settings in (
        Settings(range="fixed", range_max=5.0),
        Settings.build("paper", {"similarity": "likelihood"}),
    ):
        segmenter = Segmenter(core.skeleton(4), settings, fps=60.0)
        segmenter.push(np.random.default_rng(0).normal(0, 0.05, (120, 4, 3)))
        assert segmenter.row.state["noise"]["estimate"] == 0
        assert segmenter.row.state["noise"]["floor"] == 0


def test_white_noise_is_told_from_motion(core):
    rng = np.random.default_rng(3)
    still = rng.normal(0, 0.01, (120, 4, 3))
    moving = np.cumsum(np.full((120, 4, 3), 0.01) * rng.uniform(0.5, 1, (1, 4, 3)), axis=0)
    found = []
    for positions in (still, moving):
        segmenter = Segmenter(core.skeleton(4), Settings(rate_limit=0.0), fps=60.0)
        segmenter.push(positions)
        found.append(segmenter.row.state["noise"]["estimate"].item())
    path = np.linalg.norm(np.diff(still[:, 1:] - still[:, :1], axis=0), axis=2).sum(axis=1).mean() * 60
    assert found[0] == pytest.approx(path, rel=0.3)
    assert found[1] == 0


def test_a_reset_forgets_the_noise(core):
    segmenter = Segmenter(core.skeleton(4), Settings(), fps=60.0)
    segmenter.push(np.random.default_rng(0).normal(0, 0.05, (120, 4, 3)))
    assert segmenter.row.state["noise"]["estimate"] > 0
    segmenter.reset()
    assert segmenter.row.state["noise"]["estimate"] == 0


@pytest.mark.parametrize("loss", [0.3, 0.5])
def test_where_frames_are_lost_noise_is_still_told_from_motion(core, loss):
    rng = np.random.default_rng(4)
    times = np.arange(3600) / 60.0
    moving = np.zeros((3600, 4, 3))
    moving[:, 1:, 0] = (0.3 * np.sin(2 * np.pi * 2.0 * times))[:, None]  # to and fro, twice a second
    kept = rng.random(3600) >= loss
    for positions, is_noise in ((moving, False), (rng.normal(0, 0.03, moving.shape), True)):
        segmenter = Segmenter(core.skeleton(4), Settings())
        segmenter.push(positions[kept], times[kept])
        assert (segmenter.row.state["noise"]["estimate"] > 0) == is_noise


def test_a_joint_that_jumps_is_not_noise_of_all():
    rng = np.random.default_rng(6)
    times = np.arange(900) / 30.0
    moving = np.zeros((900, 6, 3))
    moving[:, 1:, 0] = (0.2 * np.sin(2 * np.pi * 0.5 * times))[:, None]
    moving[300:600] = moving[300]  # a rest
    levels = []
    for jumps in (False, True):
        noisy = moving + rng.normal(0, 0.001, moving.shape)
        if jumps:
            noisy[700:720:2, 5, 1] += 0.3
        poses = noisy - noisy[:, :1]
        heard = velocity(poses, times, 5, np.zeros(900))
        levels.append(heard.noise[-1])
    assert levels[1] == pytest.approx(levels[0], rel=0.25)


@pytest.mark.parametrize("noise", [0.003, 0.005])
def test_rests_between_reaches_are_found_in_noise_too(noise):
    rng = np.random.default_rng(7)
    targets = np.cumsum(rng.choice([-1, 1], (40, 7, 3)) * rng.uniform(0.1, 0.3, (40, 7, 3)), axis=0)
    at = np.arange(39 * 42) / 42.0  # reaches of 0.8 s, rests of 0.6 s
    number = at.astype(int)
    share = 0.5 - 0.5 * np.cos(np.pi * np.clip((at - number) / 0.57, 0.0, 1.0))[:, None, None]
    poses = np.zeros((len(at), 8, 3))
    poses[:, 1:] = targets[number] + share * (targets[number + 1] - targets[number])
    skeleton = Skeleton(tuple("abcdefgh"), (-1, *[0] * 7))
    rests = np.arange(1, 39) * 1.4 - 0.3
    for seen in (poses, poses + rng.normal(0, noise, poses.shape)):
        motion = Motion(seen, 30.0, skeleton, counted_by(seen, 30.0, skeleton))
        found = np.array(motion.final()) / 30.0
        assert np.mean([np.abs(found - rest).min() <= 0.45 for rest in rests]) >= 0.9
        assert len(found) <= 2.2 * len(rests)
