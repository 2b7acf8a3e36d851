"""Time: what is in order, what is dropped, and where a take ends."""

import numpy as np
import pytest

from mossar_stream import Segmenter, Settings

STILL = np.zeros((2, 3), np.float32)


def pushed(core, times, **settings):
    segmenter = Segmenter(core.PAIR, Settings(**settings))
    events = segmenter.push(np.zeros((len(times), 2, 3), np.float32), np.asarray(times, float))
    return segmenter, [(e.event, e.take, e.reason) for e in events if e.__struct_config__.tag == "stream"]


def test_repeated_and_late_frames_are_dropped_and_counted(core):
    segmenter, changes = pushed(core, [0, 0.1, 0.1, 0.05, 0.2, -0.7, 0.3])
    assert changes == [("started", 0, "")]
    assert segmenter.stats == {
        "frames": 7,
        "out_of_order": 3,
        "outliers": 0,
        "held": 0,
        "gaps": 0,
        "unseen": 0,
    }
    assert (segmenter.state.frame, segmenter.state.time) == (6, 0.3)


def test_dropped_frames_leave_the_events_of_the_others_alone(core):
    positions, times = core.moving_people(8, losses=False)
    rng = np.random.default_rng(8)
    again = np.sort(np.concatenate([np.arange(len(times)), rng.integers(0, len(times), 40)]), kind="stable")
    late = times[again].copy()
    twice = np.flatnonzero(np.diff(again, prepend=-1) == 0)
    late[twice] -= rng.uniform(0, 0.5, len(twice))
    noisy = positions[again].copy()
    noisy[twice] += 7.0
    plain = Segmenter(core.skeleton(4)).push(positions, times)
    doubled = Segmenter(core.skeleton(4))
    events = doubled.push(noisy, late)
    assert [e.time for e in core.key_frames(events, "confirmed")] == [
        e.time for e in core.key_frames(plain, "confirmed")
    ]
    assert doubled.stats["out_of_order"] == 40


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_frames_without_a_time_are_dropped_and_counted(core, bad):
    segmenter, changes = pushed(core, [bad, bad, 0, 0.1, bad, 0.2])
    assert changes == [("started", 0, "")]
    assert segmenter.stats["out_of_order"] == 3
    assert segmenter.stats["frames"] == 6
    assert segmenter.state.time == 0.2


def test_a_pause_longer_than_max_pause_ends_the_take_and_one_as_long_does_not(core):
    assert pushed(core, [0, 1.0, 2.0])[1] == [("started", 0, "")]
    assert pushed(core, [0, 1.5, 2.0])[1] == [("started", 0, ""), ("ended", 0, "gap"), ("started", 1, "")]
    assert pushed(core, [0, 1.5, 2.0], max_pause=2.0)[1] == [("started", 0, "")]


@pytest.mark.parametrize("clock", [0.3, 7.1, 36000.1, 1.7e9])
def test_where_the_clock_began_does_not_decide_how_long_a_pause_is(core, clock):
    times = clock + np.array([0.0, 0.1, 1.4, 2.7])  # the pauses are as long as the longest, but for rounding
    assert pushed(core, times, max_pause=1.3)[1] == [("started", 0, "")]


def test_a_clock_set_back_ends_the_take(core):
    segmenter, changes = pushed(core, [10, 10.1, 3, 3.1])
    assert changes == [("started", 0, ""), ("ended", 0, "clock stepped back"), ("started", 1, "")]
    assert segmenter.state.frame == 1
    assert segmenter.stats["out_of_order"] == 0


def test_a_gap_that_ends_no_take_is_counted(core):
    segmenter, _ = pushed(core, [0, 0.1, 0.6, 0.7])
    assert segmenter.stats["gaps"] == 1


@pytest.mark.parametrize("seed", range(4))
def test_a_gap_gives_the_same_events_as_ending_the_take_by_hand(core, seed):
    positions, times = core.moving_people(seed, losses=False)
    times[100:] += 3.0
    by_gap, by_hand = Segmenter(core.skeleton(4)), Segmenter(core.skeleton(4))
    events = by_gap.push(positions, times) + by_gap.end_take()
    other = by_hand.push(positions[:100], times[:100]) + by_hand.end_take("gap")
    other += by_hand.push(positions[100:], times[100:]) + by_hand.end_take()
    assert core.lines(events) == core.lines(other)
    assert by_gap.stats == by_hand.stats


@pytest.mark.parametrize("seed", range(4))
def test_a_take_does_not_depend_on_the_takes_before(core, seed):
    positions, times = core.moving_people(seed, losses=False)
    first, second = Segmenter(core.skeleton(4)), Segmenter(core.skeleton(4))
    second.push(*core.moving_people(seed + 50, losses=False))
    second.reset()
    # The running range and the noise are forgotten with the reset; everything else with the take.
    found = [
        [(e.frame, e.kind, e.status, e.velocity, e.strength) for e in s.push(positions, times) + s.end_take()
         if e.__struct_config__.tag == "key_frame"]
        for s in (first, second)
    ]  # fmt: skip
    assert found[0] == found[1]
    assert found[0]


def test_a_take_starts_where_its_clock_does(core):
    positions, times = core.moving_people(9, losses=False)
    early = Segmenter(core.skeleton(4)).push(positions, np.arange(len(times)) / 64.0)
    late = Segmenter(core.skeleton(4)).push(positions, 2.0**30 + np.arange(len(times)) / 64.0)
    assert [(e.frame, e.strength) for e in core.key_frames(early, "final")] == [
        (e.frame, e.strength) for e in core.key_frames(late, "final")
    ]


def test_negative_times_are_times(core):
    segmenter, changes = pushed(core, [-5.0, -4.9, -4.8])
    assert changes == [("started", 0, "")]
    assert segmenter.stats["out_of_order"] == 0
    assert segmenter.state.time == -4.8


def test_events_come_in_the_order_of_their_cause(core):
    positions, times = core.moving_people(10, frames=600, losses=False)
    events = Segmenter(core.skeleton(4)).push(positions, times)
    causes = [e.decided_frame for e in events if e.__struct_config__.tag == "key_frame"]
    assert causes == sorted(causes)
    assert all(e.decided_frame >= e.frame for e in core.key_frames(events, "confirmed"))
