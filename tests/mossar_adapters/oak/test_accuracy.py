"""How near the joints and key frames seen by a camera come to the true ones."""

import functools

import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_adapters.oak.source import CONFIDENCE, DEFAULTS, SKELETON, OakSource
from mossar_stream import KeyFrameEvent, Segmenter, Settings

MOVES = (
    "rest:1",
    "punch_left",
    "rest:1",
    "squat",
    "rest:1",
    "wave_right",
    "rest:1",
    "kick_left",
    "rest:1",
    "jump",
)
NOISY = {"noise": 0.1, "holes": 0.05, "jitter": 0.7}
ROUGH = {"noise": 0.2, "holes": 0.1, "jitter": 1.0}


@functools.cache
def play(studio, seed=3, moves=MOVES, confidence=CONFIDENCE, **sensor):
    """Return (source, true positions, times, positions from the camera, cuts) of a take."""
    take = performance(seed=seed, fps=studio.FPS, moves=moves)
    body = studio.coco(take)
    times = take.frames.times + studio.START
    pictures = [(i, t, [joints]) for i, (t, joints) in enumerate(zip(times, body, strict=True))]
    stage = studio.Stage(**sensor)
    source = OakSource(connect=studio.opened(stage.camera), confidence=confidence)
    _, items = studio.shown(stage, pictures, source)
    frames = studio.frames_of(items)
    assert [f.times[0] for f in frames] == pytest.approx(times, abs=1e-6)
    return source, studio.with_pelvis(body), times, np.concatenate([f.positions for f in frames]), take.cuts


def key_frames(positions, times, settings, status="confirmed"):
    # The likelihood alone merges what the performer repeats, so that the true cuts are those between moves.
    segmenter = Segmenter(SKELETON, Settings.build(overrides={"level": "posture", **settings}), fps=24.0)
    segmenter.level = Settings(similarity="likelihood").strength("motion")
    events = segmenter.push(positions, times) + segmenter.end_take()
    return np.array(sorted(e.time for e in events if isinstance(e, KeyFrameEvent) and e.status == status))


def agreement(one, other, tolerance):
    """Return the F1 score of a one-to-one matching of times, nearest first."""
    free, hits = list(other), 0
    for moment in one:
        near = min(free, key=lambda x: abs(x - moment), default=np.inf)
        if abs(near - moment) <= tolerance:
            free.remove(near)
            hits += 1
    return 2 * hits / (len(one) + len(other))


def test_joints_come_back_within_the_depth_resolution_where_they_are_visible(studio):
    source, true, _, found, _ = play(studio)
    error = np.abs(found - true)
    visible = np.isfinite(error[:, :, 0])
    assert visible.mean() > 0.85
    assert source.counters.malformed == 0
    assert np.nanmedian(error) < 0.001
    assert np.nanpercentile(error[:, :, :2], 99.5) < 0.005
    assert np.nanpercentile(error[:, :, 2], 99.5) < studio.DEPTH_STEP


def test_depth_noise_and_holes_stay_within_a_few_steps_of_depth(studio):
    source, true, _, found, _ = play(studio, **NOISY)
    error = np.abs(found - true)
    assert source.counters.no_depth > 0
    assert np.nanpercentile(error[:, :, :2], 99) < 0.03
    assert np.nanmedian(error[:, :, 2]) < studio.DEPTH_STEP
    assert np.nanpercentile(error[:, :, 2], 95) < 2 * studio.DEPTH_STEP


@pytest.mark.parametrize("settings", [{}, dict(DEFAULTS)], ids=["plain", "defaults"])
def test_confirmed_key_frames_are_those_of_the_direct_run_within_a_frame(studio, settings):
    _, true, times, found, _ = play(studio)
    direct = key_frames(true.astype(np.float32), times, settings)
    seen = key_frames(found, times, settings)
    assert len(direct) > 10
    assert agreement(direct, seen, 1.5 / studio.FPS) >= 0.93  # reached: 0.96


@pytest.mark.parametrize("settings", [{}, dict(DEFAULTS)], ids=["plain", "defaults"])
def test_but_for_hidden_joints_they_would_be_all_the_same(studio, settings):
    _, true, times, found, _ = play(studio)
    without_hidden = np.where(np.isnan(found), np.nan, true).astype(np.float32)
    direct = key_frames(without_hidden, times, settings)
    seen = key_frames(found, times, settings)
    assert agreement(direct, seen, 1.5 / studio.FPS) == 1.0


def test_hidden_joints_would_move_most_key_frames_if_the_network_was_believed(studio):
    _, true, times, found, _ = play(studio)
    _, _, _, believed, _ = play(studio, confidence=0.0)
    direct = key_frames(true.astype(np.float32), times, {})
    assert agreement(direct, key_frames(believed, times, {}), 1.5 / studio.FPS) < 0.6
    assert agreement(direct, key_frames(found, times, {}), 1.5 / studio.FPS) > 0.9


def test_noisy_depth_moves_confirmed_key_frames_by_some_frames(studio):
    _, true, times, found, _ = play(studio, **NOISY)
    direct = key_frames(true.astype(np.float32), times, {})
    seen = key_frames(found, times, {})
    assert agreement(direct, seen, 6 / studio.FPS) > 0.65  # reached: 0.73; 0.42 within 1.5 frames


@pytest.mark.parametrize("sensor", [{}, NOISY, ROUGH], ids=["clean", "noisy", "rough"])
def test_final_key_frames_hit_the_ends_of_moves_and_the_defaults_do_no_harm(studio, sensor):
    plain, helped = [], []
    for seed in range(1, 7):
        _, _, times, found, cuts = play(studio, seed, **sensor)
        moments = times[[min(cut.frame, len(times) - 1) for cut in cuts]]
        plain.append(agreement(moments, key_frames(found, times, {}, "final"), 0.3))
        helped.append(agreement(moments, key_frames(found, times, dict(DEFAULTS), "final"), 0.3))
    assert np.mean(helped) >= np.mean(plain)  # 0.92 against 0.86 with rough depth
    assert np.mean(helped) > 0.9


def test_somebody_who_stands_still_gives_no_key_frames(studio):
    _, _, times, found, _ = play(studio, 5, ("rest:1", "squat", "rest:1", "punch_left", "rest:12"), **NOISY)
    still = times[-1] - 11
    assert (key_frames(found, times, dict(DEFAULTS)) > still).sum() <= 2
    assert not (key_frames(found, times, dict(DEFAULTS), "final") > still).any()
