import numpy as np
import pytest

from mossar_adapters.receiving.clocks import Clocks

STEP = 1 / 30  # s


@pytest.mark.parametrize("ahead", [-60.0, -1.0, 0.3, 1.0, 60.0])
def test_a_second_clock_is_shifted_once_and_its_steps_stay(ahead):
    clocks = Clocks()
    late = np.random.default_rng(7).exponential(0.008, 600)
    first, second = [], []
    for k in range(300):
        came = 5 + k * STEP
        first.append(clocks.time("", 100 + k * STEP, came + late[2 * k]))
        second.append(clocks.time("b", 100 + ahead + k * STEP, came + 0.01 + late[2 * k + 1]))
    assert first == [100 + k * STEP for k in range(300)]
    assert np.allclose(np.diff(second), STEP, atol=1e-9)
    assert np.allclose(np.subtract(second, first), 0.0, atol=0.08)


@pytest.mark.parametrize("jump", [-100.0, -1.0, 1.0, 100.0])
@pytest.mark.parametrize("who", ["", "b"])
def test_a_clock_that_is_set_goes_on_where_it_was(who, jump):
    clocks = Clocks()
    found = {"": [], "b": []}
    for k in range(120):
        for sender, times in found.items():
            sent = 50 + k * STEP + (jump if sender == who and k >= 60 else 0.0)
            times.append(clocks.time(sender, sent, k * STEP))
    for times in found.values():
        assert np.allclose(np.diff(times), STEP, atol=1e-9)


def test_a_sender_that_is_alone_keeps_every_time_that_it_sends():
    clocks = Clocks()
    sent = [100.0, 100.1, 0.0, 0.1, 5.0, 4.0, 1e9]
    assert [clocks.time("", time, 0.1 * k) for k, time in enumerate(sent)] == sent


def test_frames_that_the_network_kept_back_are_no_jump():
    clocks = Clocks()
    came = [0.1 * k for k in range(10)] + [3.0] * 20 + [3.0 + 0.1 * k for k in range(1, 20)]
    held = []
    for k, arrival in enumerate(came):
        clocks.time("", 7.0 + arrival, arrival)
        held.append(clocks.time("b", 40.0 + 0.1 * k, arrival))
    assert np.allclose(np.diff(held)[:9], 0.1)
    assert np.allclose(np.diff(held)[10:], 0.1), "a silence of two seconds, and no jump after it"


def test_a_clock_that_stood_still_while_its_sender_was_silent_is_shifted():
    clocks = Clocks()
    for k in range(10):
        clocks.time("", k * 0.1, k * 0.1)
        clocks.time("b", 20 + k * 0.1, k * 0.1)
    for k in range(10, 100):
        clocks.time("", k * 0.1, k * 0.1)
    assert clocks.time("b", 21.0, 10.0) == pytest.approx(10.0, abs=0.2)


def test_the_next_sender_after_all_are_gone_is_the_first_again():
    clocks = Clocks()
    clocks.time("1", 100.0, 0.0)
    clocks.forget("1")
    assert clocks.time("2", 3.0, 5.0) == 3.0
