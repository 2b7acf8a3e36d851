"""What the numbers rest on: the motion, the clocks, and kernels that do what they are said to do."""

import numpy as np
import pytest

from mossar_adapters.files.loaded import LoadedRecording
from mossar_tools.bench.crowd import Crowd
from mossar_tools.bench.measurement import Measurement, Target, Timing, duration, rate
from mossar_tools.bench.motion import joined, performer, to_and_fro, with_joints
from mossar_tools.bench.push import waits
from mossar_tools.bench.work import prepare


@pytest.fixture(scope="module")
def motion():
    return performer(4.0)


def test_motion_goes_on_without_a_jump_and_without_end(motion):
    chunks = motion.chunks(2500, 700)
    positions = np.concatenate([own for own, _ in chunks])
    times = np.concatenate([own for _, own in chunks])
    assert len(positions) == len(times) == 2500
    assert np.diff(times) == pytest.approx(1 / motion.fps)
    assert np.linalg.norm(np.diff(positions, axis=0), axis=2).max() * motion.fps < 12.0


def test_recordings_that_are_joined_are_takes_apart(motion):
    both = joined("two", [motion, motion])
    assert len(both.times) == 2 * len(motion.times)
    assert np.diff(both.times).max() > 5.0


@pytest.mark.parametrize("count", [2, 10, 31, 50, 100])
def test_a_body_gets_any_number_of_joints(motion, count):
    skeleton, positions = with_joints(motion.skeleton, motion.positions[:5], count)
    assert len(skeleton) == positions.shape[1] == count
    assert len(np.unique(positions[0], axis=0)) == count


def test_slowed_motion_keeps_its_duration(motion):
    slow = motion.slowed(30.0)
    assert slow.fps == 30.0
    assert slow.times[-1] == pytest.approx(motion.times[-1], abs=0.05)


def test_the_wall_clock_counts_where_the_processor_was_ours():
    ours = [Timing(1.0, 0.99)] * 3
    shared = [Timing(2.0, 1.0), Timing(4.0, 1.0), Timing(1.0, 1.0)]
    assert rate("x", "x", 100, ours).value == pytest.approx(100.0)
    assert (rate("x", "x", 100, shared).clock, rate("x", "x", 100, shared).value) == ("cpu", 100.0)
    assert duration("x", "x", "ms", ours, each=10).value == pytest.approx(100.0)


def test_targets_are_eased_for_busy_machines_only():
    speed, size = Target(10.0, at_least=True), Target(1.0, halved=False)
    assert [speed.verdict(12.0, busy=False), speed.verdict(6.0, busy=False)] == ["met", "missed"]
    assert [speed.verdict(6.0, busy=True), speed.verdict(4.0, busy=True)] == ["half (busy)", "missed"]
    assert size.verdict(1.5, busy=True) == "missed"


def test_a_value_without_a_clock_is_shown_as_it_is():
    assert Measurement("memory", "growth", "MB", (0.5,)).value == 0.5


def test_every_push_is_timed(motion):
    took, undisturbed = waits(motion, 300)
    assert took.shape == undisturbed.shape == (300,)
    assert 0 < np.median(took) < 0.01


def test_a_crowd_moves_through_all_its_ways(motion):
    crowd = Crowd(motion.slowed(30.0), 5)
    before = crowd.pool["p4"].stats["frames"]
    crowd.push_many(crowd.batch(10))
    crowd.push_each(crowd.batch(3))
    assert crowd.pool["p4"].stats["frames"] == before + 13
    assert {crowd.pool[name].stats["out_of_order"] for name in crowd.names} == {0}


def test_recordings_nearest_to_31_joints_are_measured(motion):
    skeleton, positions = with_joints(motion.skeleton, motion.positions[:50], 20)
    few = LoadedRecording("few", skeleton, 30.0, positions, np.arange(50) / 30)
    right = LoadedRecording("right", motion.skeleton, 120.0, motion.positions[:60], motion.times[:60])
    work = prepare([few, right, few], quick=True, on_progress=str)
    assert [whole.name for whole in work.recordings] == ["right"]
    assert len(work.motions) == 2
    assert to_and_fro("a", skeleton, 30.0, positions).positions.shape == (98, 20, 3)
