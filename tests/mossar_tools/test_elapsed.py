"""Times as people read them."""

import pytest

from mossar_tools.elapsed import Elapsed, clock


def test_times_count_from_the_first_frame():
    elapsed = Elapsed()
    elapsed.see("p1", 2190.0, 2190.5)
    assert elapsed.since("p1", 2190.5) == 0.5
    assert elapsed.since("nobody", 3.0) == 3.0


def test_a_performer_who_comes_later_is_on_the_same_clock():
    elapsed = Elapsed()
    elapsed.see("p1", 100.0, 140.0)
    elapsed.see("p2", 140.1, 141.0)
    assert elapsed.since("p2", 141.0) == 41.0


def test_another_clock_goes_on_where_the_stream_is():
    elapsed = Elapsed()
    elapsed.see("p1", 100.0, 140.0)
    elapsed.see("p2", 1.7e9, 1.7e9 + 1)
    assert elapsed.since("p2", 1.7e9 + 1) == 41.0


def test_a_clock_that_jumps_goes_on_and_events_of_the_take_before_keep_their_time():
    elapsed = Elapsed()
    elapsed.see("p1", 100.0, 140.0)
    elapsed.see("p1", 0.0, 3.0)
    assert elapsed.since("p1", 3.0) == 43.0
    assert elapsed.since("p1", 139.0) == 39.0


def test_names_without_end_take_no_memory():
    elapsed = Elapsed()
    for number in range(5000):
        elapsed.see(f"p{number}", 0.0, 1.0)
    assert len(elapsed._spans) <= 4096


@pytest.mark.parametrize(
    ("seconds", "digits", "shown"),
    [
        (40.0, 0, "0:40"),
        (59.96, 1, "1:00.0"),
        (3600, 1, "1:00:00.0"),
        (-0.01, 1, "0:00.0"),
        (-1.5, 1, "-0:01.5"),
    ],
)
def test_a_clock_shows_minutes(seconds, digits, shown):
    assert clock(seconds, digits) == shown
