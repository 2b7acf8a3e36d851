"""Ranges: what a velocity is a share of."""

import numpy as np
import pytest

from mossar_stream import Segmenter, Settings, segment_recording

BASE = {"window": 1 / 32, "max_speed": 1e4, "noise_margin": 0.0, "range_floor": 0.0, "sig_threshold": 0.25}


def states(core, curve, **settings):
    segmenter = Segmenter(core.PAIR, Settings(**{**BASE, **settings}), fps=core.FPS)
    found = []
    for frame in core.hand_steps(np.asarray(curve) / 16):
        segmenter.push(frame)
        found.append(segmenter.state)
    return found


def test_running_is_the_largest_velocity_so_far(core):
    curve = [0, 1, 2, 8, 4, 2, 16, 1]
    found = states(core, curve)
    scales = np.maximum.accumulate(curve) / 16
    np.testing.assert_array_equal([s.scale for s in found], scales)
    np.testing.assert_allclose([s.value for s in found][1:], np.array(curve[1:]) / 16 / scales[1:])


def test_the_floor_counts_per_joint_and_keeps_small_movements_at_rest(core):
    found = states(core, [0, 1, 2, 1, 2, 16], range_floor=0.5)
    assert [s.scale for s in found] == [0.5] * 5 + [1.0]
    assert [s.moving for s in found] == [False] * 5 + [True]


def test_fixed_bounds_are_those_given(core):
    found = states(core, [0, 4, 8, 12], range="fixed", range_min=0.25, range_max=0.75)
    assert [s.value for s in found] == [-0.5, 0.0, 0.5, 1.0]
    assert [s.scale for s in found] == [1.0] * 4
    assert [s.threshold for s in found] == [0.25] * 4


def test_decay_halves_the_largest_velocity_in_a_half_life(core):
    found = states(core, [0, 16] + [0] * 64, range="decay", range_half_life=1.0)
    assert found[1].scale == 1.0
    assert found[1 + 32].scale == pytest.approx(0.5)
    assert found[1 + 64].scale == pytest.approx(0.25)
    assert (
        states(core, [0, 16] + [0] * 64, range="decay", range_half_life=1.0, range_floor=0.4)[-1].scale == 0.4
    )


def test_the_running_range_survives_a_take(core):
    segmenter = Segmenter(core.PAIR, Settings(**BASE), fps=core.FPS)
    segmenter.push(core.hand_steps(np.array([0, 16, 16]) / 16))
    segmenter.end_take()
    events = segmenter.push(core.hand_steps(np.array([0, 2, 2]) / 16))
    assert segmenter.state.scale == 1.0
    assert core.key_frames(events, "confirmed") == []


def test_file_is_the_range_of_the_whole_recording(core):
    curve = np.array([0, 4, 8, 4, 2, 4, 16, 3, 5, 0, 0]) / 16
    frames = core.hand_steps(curve)
    whole = segment_recording(frames, core.FPS, core.PAIR, Settings(**BASE, range="file", level="posture"))
    fixed = segment_recording(
        frames, core.FPS, core.PAIR, Settings(**BASE, range="fixed", range_max=1.0, level="posture")
    )
    assert whole.key_frames == fixed.key_frames
    assert [k.frame for k in whole.key_frames]


def test_nothing_is_emitted_while_nobody_has_moved(core):
    events = Segmenter(core.PAIR, Settings(range_floor=0.0), fps=30.0).push(np.zeros((90, 2, 3), np.float32))
    assert [e.__struct_config__.tag for e in events] == ["stream"]
