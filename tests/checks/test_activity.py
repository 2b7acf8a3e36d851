"""The check of the activity: what it counts as a bout, a flicker and a delay, on the built-in performer."""

import pytest

from checks.activity import Bout, Reported, activity_of, bouts_of_performer, delays_of, is_exact, streamed
from mossar_stream import ActivityEvent, Settings


def change(state, start):
    return ActivityEvent(
        performer="p1",
        id=f"p1/activity/0/{start}",
        take=0,
        state=state,
        start=start,
        previous=None,
        limb=None,
        decided_time=start + 0.03,
    )


def test_a_bout_is_exact_only_with_one_moving_and_one_resting():
    bout = Bout(1.0, 2.0)
    right = [change("moving", 1.1), change("resting", 2.1)]
    assert is_exact(bout, Reported(right, 5.0))
    assert not is_exact(bout, Reported(right[:1], 5.0))
    assert not is_exact(bout, Reported([*right, change("moving", 2.3)], 5.0))
    assert is_exact(bout, Reported([*right, change("moving", 4.0)], 5.0))


def test_a_bout_that_is_too_short_is_a_flicker():
    events = [change("moving", 1.0), change("resting", 1.1), change("moving", 2.0), change("resting", 3.0)]
    assert Reported(events, 5.0).bouts == [Bout(1.0, 1.1), Bout(2.0, 3.0)]
    assert Reported(events, 5.0).flickers == 1


def test_the_performers_bouts_are_reported_exactly_and_delays_are_those_of_the_events():
    skeleton, frames, bouts = bouts_of_performer(3, 45.0)
    events = streamed(skeleton, frames, Settings(), 30.0)
    reported = activity_of(events, float(frames.times[-1]))
    assert bouts
    assert all(is_exact(bout, reported) for bout in bouts)
    finals = [delay for message, delay in delays_of(events) if message == "key_frame final"]
    assert max(finals) == pytest.approx(1.5, abs=0.2)
