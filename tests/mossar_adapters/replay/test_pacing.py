"""Pacing: order and lower bounds only; how late a wake-up is depends on the machine."""

import threading
import time

import pytest

from mossar_adapters.replay.pacing import Pacer


def test_first_wait_returns_at_once_whatever_the_source_time():
    assert Pacer(1.0).wait_until(1e6, timeout=0.0)


def test_waits_at_least_until_the_source_time_is_due():
    pacer = Pacer(1.0)
    pacer.wait_until(5.0)
    start = time.monotonic()
    assert pacer.wait_until(5.1)
    assert time.monotonic() - start >= 0.09


def test_double_speed_halves_the_wait():
    pacer = Pacer(2.0)
    pacer.wait_until(0.0)
    assert not pacer.wait_until(0.2, timeout=0.0)
    start = time.monotonic()
    assert pacer.wait_until(0.2)
    assert time.monotonic() - start >= 0.09


def test_deadlines_are_absolute_so_that_late_frames_do_not_wait():
    pacer = Pacer(1.0)
    pacer.wait_until(0.0)
    time.sleep(0.06)
    assert pacer.wait_until(0.02, timeout=0.0)
    assert pacer.wait_until(0.05, timeout=0.0)


def test_max_speed_never_waits():
    pacer = Pacer("max")
    assert all(pacer.wait_until(t, timeout=0.0) for t in (0.0, 1e9, 5.0))


def test_timeout_gives_up_and_a_later_wait_succeeds():
    pacer = Pacer(1.0)
    pacer.wait_until(0.0)
    assert not pacer.wait_until(0.1, timeout=0.01)
    assert pacer.wait_until(0.1)


def test_interrupt_ends_a_long_wait_in_another_thread():
    pacer = Pacer(1.0)
    pacer.wait_until(0.0)
    results = []
    waiter = threading.Thread(target=lambda: results.append(pacer.wait_until(3600.0)))
    waiter.start()
    pacer.interrupt()
    waiter.join(timeout=10)
    assert results == [False]
    assert not pacer.wait_until(0.0)


@pytest.mark.parametrize("speed", [1.0, "max"])
def test_nothing_is_due_while_paused(speed):
    pacer = Pacer(speed)
    pacer.wait_until(0.0)
    pacer.pause()
    assert not pacer.wait_until(0.0, timeout=0.02)
    pacer.resume()
    assert pacer.wait_until(0.0, timeout=0.0)


def test_a_pause_moves_later_deadlines():
    pacer = Pacer(1.0)
    pacer.wait_until(0.0)
    start = time.monotonic()
    pacer.pause()
    pacer.pause()
    time.sleep(0.05)
    pacer.resume()
    pacer.resume()
    assert pacer.wait_until(0.05)
    assert time.monotonic() - start >= 0.09


@pytest.mark.parametrize("speed", [0, -1.0, float("nan"), float("inf")])
def test_impossible_speed_is_refused(speed):
    with pytest.raises(ValueError, match="speed must be a positive number or 'max'"):
        Pacer(speed)
