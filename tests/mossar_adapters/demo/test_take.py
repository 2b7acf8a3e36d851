"""Whole performances: truth, determinism, and whether the moves can be told apart."""

import itertools
import subprocess
import sys

import numpy as np
import pytest

from mossar_adapters.demo import SKELETON, performance, take
from mossar_stream import SettingsError

SEEDS = range(1, 21)


def velocity(shown, window=0.25):
    """Equation 1: path lengths relative to the hips over the trailing window, summed over the joints, m."""
    local = shown.frames.positions.astype(float)
    local -= local[:, :1]
    path = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(local, axis=0), axis=2).sum(axis=1))])
    frames = round(window * shown.fps)
    return path - np.concatenate([np.zeros(frames), path[:-frames]])


@pytest.mark.parametrize("seed", SEEDS)
def test_bone_lengths_are_constant_to_the_micrometre(seed):
    positions = performance(seed).frames.positions.astype(float)
    parents, children = np.array(SKELETON.bones()).T
    lengths = np.linalg.norm(positions[:, children] - positions[:, parents], axis=2)
    assert np.ptp(lengths, axis=0).max() < 5e-6


@pytest.mark.parametrize("seed", SEEDS)
def test_heights_and_speeds_are_those_of_a_person(seed):
    positions = performance(seed).frames.positions
    head = positions[:, SKELETON.index("Head"), 1]
    assert np.median(head) == pytest.approx(1.55, abs=0.05)
    assert 0.9 < head.min() < head.max() < 2.1
    speed = np.linalg.norm(np.diff(positions, axis=0), axis=2) * 60
    assert 5 < speed.max() < 10


@pytest.mark.parametrize("seed", SEEDS)
def test_cuts_lie_inside_increase_and_chain_the_moves(seed):
    shown = performance(seed)
    times = [cut.time for cut in shown.cuts]
    assert len(times) == 16
    assert times[0] > 0
    assert times[-1] < shown.frames.times[-1]
    assert np.diff(times).min() > 0.5
    assert all(a.after == b.before for a, b in itertools.pairwise(shown.cuts))
    for cut in shown.cuts:
        assert shown.frames.times[cut.frame - 1] < cut.time <= shown.frames.times[cut.frame]


@pytest.mark.parametrize("seed", SEEDS)
def test_velocity_dips_at_every_true_cut(seed):
    shown = performance(seed)
    curve, times = velocity(shown), shown.frames.times
    bounds = [0.0, *(cut.time for cut in shown.cuts), times[-1]]
    for before, cut, after in zip(bounds, shown.cuts, bounds[2:], strict=False):
        dip = curve[np.abs(times - cut.time - 0.05) < 0.25].min()
        peaks = [curve[(times > a) & (times < b)].max() for a, b in ((before, cut.time), (cut.time, after))]
        peak = max(peaks) if cut.kind == "rest" else min(peaks)
        assert peak - dip > 0.8, (seed, cut)


def test_velocity_is_as_large_as_that_of_recorded_people():
    curve = np.concatenate([velocity(performance(seed)) for seed in SEEDS]) / 20
    assert 0.05 < np.median(curve) < 0.2
    assert 0.2 < curve.max() < 0.6


def test_the_default_take_is_a_round_of_three_quarters_of_a_minute_at_the_rate_asked_for():
    shown = performance(1, fps=30)
    assert 38 < shown.frames.times[-1] < 48
    np.testing.assert_allclose(np.diff(shown.frames.times), 1 / 30)
    assert shown.frames.first_frame == 0


def test_the_same_arguments_give_the_same_bytes():
    arguments = {"seconds": 10, "noise": 0.01, "noise_kind": "kinect", "jitter": 0.002, "drop": 0.1}
    first, second = performance(9, **arguments), performance(9, **arguments)
    assert first.frames.positions.tobytes() == second.frames.positions.tobytes()
    assert first.frames.times.tobytes() == second.frames.times.tobytes()
    assert first.cuts == second.cuts


def test_another_process_gives_the_same_bytes():
    code = (
        "import zlib; from mossar_adapters.demo import performance; "
        "print(zlib.crc32(performance(9, noise=0.01).frames.positions.tobytes()))"
    )
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, check=True) for _ in range(2)]
    assert runs[0].stdout == runs[1].stdout


def test_other_seeds_give_other_performances():
    assert performance(1).cuts != performance(2).cuts


def test_a_shorter_performance_is_the_beginning_of_a_longer_one():
    short, long = (performance(3, seconds=seconds, noise=0.01) for seconds in (7.3, 12.0))
    count = len(short.frames)
    assert count == 438
    np.testing.assert_array_equal(short.frames.positions, long.frames.positions[:count])
    assert short.cuts == long.cuts[: len(short.cuts)]
    assert all(cut.time < 7.3 for cut in short.cuts)


def test_without_seconds_or_moves_it_is_the_beginning_of_the_endless_one():
    shown = performance(3)
    longer = performance(3, seconds=60)
    np.testing.assert_array_equal(shown.frames.positions, longer.frames.positions[: len(shown.frames)])


def test_the_rate_changes_neither_motion_nor_cuts():
    coarse, fine = performance(5, fps=30), performance(5, fps=120)
    np.testing.assert_array_equal(coarse.frames.positions, fine.frames.positions[::4][: len(coarse.frames)])
    assert [cut.time for cut in coarse.cuts] == [cut.time for cut in fine.cuts]


def test_moves_are_done_in_the_order_asked_for():
    shown = performance(1, moves=["stand:20", "punch_left", "walk", "stand:20"])
    assert [cut.after for cut in shown.cuts] == ["punch_left", "walk", "stand"]
    assert shown.cuts[0].time == pytest.approx(20.0 + 0.14, abs=0.02)
    assert shown.frames.times[-1] == pytest.approx(shown.cuts[-1].time + 0.14 + 20.0, abs=0.04)


def test_standing_still_moves_by_no_more_than_breathing_and_noise():
    still = performance(1, moves=["stand:20"])
    assert np.ptp(still.frames.positions, axis=0).max() < 0.0025
    noisy = performance(1, moves=["stand:20"], noise=0.005).frames.positions
    np.testing.assert_allclose(noisy.std(axis=0), 0.005, rtol=0.15)


def test_dropped_frames_leave_cut_times_and_renumber_cut_frames():
    whole, thinned = performance(4), performance(4, drop=0.3)
    assert [cut.time for cut in whole.cuts] == [cut.time for cut in thinned.cuts]
    for cut in thinned.cuts:
        assert thinned.frames.times[cut.frame - 1] < cut.time <= thinned.frames.times[cut.frame]


def test_performers_stay_near_their_place():
    hips = performance(6, seconds=600, fps=10, place=(4.0, -1.0)).frames.positions[:, 0]
    assert np.hypot(hips[:, 0] - 4.0, hips[:, 2] + 1.0).max() < 6.0


def test_names_are_made_fit_for_performers():
    assert performance(1, seconds=0.5, performer="anna b.").frames.performer == "anna_b_"


def test_too_short_to_hold_a_frame_is_empty():
    assert len(performance(1, moves=["rest"], seconds=1e-9, drop=0.9).frames) in {0, 1}


def test_too_long_a_performance_is_refused(monkeypatch):
    monkeypatch.setattr(take, "MAX_FRAMES", 1000)
    with pytest.raises(SettingsError, match="at most 1000 frames"):
        performance(1, moves=["stand:86400"], fps=1000)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"seed": -1}, "seed must be 0 or more, not -1"),
        ({"seconds": 0}, "seconds must be a positive number, not 0"),
        ({"seconds": float("nan")}, "seconds must be a positive number, not nan"),
        ({"moves": []}, "moves must name at least one move"),
        ({"moves": ["fly"]}, "no move is called 'fly'"),
    ],
)
def test_impossible_arguments_are_refused(arguments, message):
    with pytest.raises(SettingsError, match=message):
        performance(**arguments)
