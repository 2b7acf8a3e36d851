import struct

import numpy as np
import pytest

from mossar_adapters.live import Counters
from mossar_adapters.receiving.batch import Batch
from mossar_adapters.receiving.pose import Pose
from mossar_adapters.receiving.sender_clocks import SenderClock, Verdict
from mossar_stream import Frames

SECONDS = 8.0


def float32(value):
    return struct.unpack("f", struct.pack("f", value))[0]


# Seconds of a clock that runs: what the sender says.
BROKEN = {
    "unix_float32": lambda t: float32(1655161200 + t),
    "still": lambda _: 7.0,
    "whole_seconds": lambda t: float(int(t + 0.37)),
    "quarter_seconds": lambda t: int((t + 0.1) * 4) / 4,
    "unix_ms_float32": lambda t: float32(1.7e12 + t * 1000),
    "minutes": lambda t: t / 60,
    "hours": lambda t: t / 3600,
    "stops": lambda t: min(t, 3.0),
}
OTHER_UNITS = {
    "ms": lambda t: 5000 + t * 1e3,
    "us": lambda t: t * 1e6,
    "ns": lambda t: t * 1e9,
    "unix_ms": lambda t: 1.7e12 + t * 1e3,
    "unix_ns": lambda t: 1.7e18 + t * 1e9,
    "ticks": lambda t: t * 1e7,
    "ticks_of_dates": lambda t: 6.385e17 + t * 1e7,
}
RUNNING = {
    "seconds": lambda t: t,
    "unix": lambda t: 1.7e9 + t,
    "set_back": lambda t: t - (5.0 if t > 4 else 0.0),
    "set_ahead": lambda t: t + (900.0 if t > 4 else 0.0),
    "set_ahead_often": lambda t: t + 900.0 * int(t / 0.4),
    "double_speed": lambda t: 2 * t,
    "half_speed": lambda t: t / 2,
}


def played(clock, fps, *, late=0.003, **options):
    """Return the times of frames, their arrivals, what was noted and counted."""
    counters, notes = Counters(), []
    batch = Batch(options.pop("fps_option", None), counters, notes.append, **options)
    rng = np.random.default_rng(7)
    arrivals = 2.0 + np.arange(int(SECONDS * fps)) / fps + rng.exponential(late, int(SECONDS * fps))
    for k, arrival in enumerate(arrivals):
        batch.put(Pose("p1", rng.normal(size=(2, 3)), float(arrival), float(clock(k / fps))))
    items = batch.take(float("inf"))
    times = np.concatenate([item.times for item in items if isinstance(item, Frames)])
    assert len(times) == len(arrivals), "no frame is lost"
    return times, arrivals, notes, counters.retimed


@pytest.mark.parametrize("fps", [8, 15, 30, 60, 120])
@pytest.mark.parametrize("name", BROKEN)
def test_frames_of_a_clock_that_does_not_run_are_timed_by_arrival(name, fps):
    times, _, notes, retimed = played(BROKEN[name], fps)
    steps = np.diff(times)
    assert steps.min() > 0
    assert np.abs(steps - 1 / fps).max() < max(1.2 / fps, 0.026), (
        "evenly, where the clock was used first as well"
    )
    assert times[-1] - times[0] == pytest.approx(SECONDS - 1 / fps, abs=0.3)
    assert len(notes) == 1
    assert "frames get the times of their arrival" in notes[0]
    assert retimed >= len(times) * (0.6 if name == "stops" else 0.9)


@pytest.mark.parametrize("fps", [8, 30, 120])
@pytest.mark.parametrize("name", OTHER_UNITS)
def test_times_in_another_unit_are_read_in_it(name, fps):
    times, _, notes, retimed = played(OTHER_UNITS[name], fps)
    assert np.diff(times) == pytest.approx(1 / fps, abs=1e-4)
    assert len(notes) == 1
    assert "not seconds; they are read so" in notes[0]
    assert retimed >= len(times) - 1


@pytest.mark.parametrize("fps", [8, 30, 120])
@pytest.mark.parametrize("name", RUNNING)
def test_a_clock_that_runs_is_used_also_where_it_is_set(name, fps):
    times, _, notes, retimed = played(RUNNING[name], fps)
    assert times.tolist() == [RUNNING[name](k / fps) for k in range(len(times))]
    assert retimed == 0
    assert len(notes) == ("speed" in name)
    assert all("its times are used" in note for note in notes)


def test_frame_numbers_instead_of_times_are_not_used():
    times, _, notes, _ = played(lambda t: round(t * 30), 30)
    assert np.diff(times) == pytest.approx(1 / 30, abs=0.01)
    assert "runs at another rate" in notes[0]


@pytest.mark.parametrize("fps", [8, 30, 120])
def test_a_clock_that_runs_backwards_is_not_used(fps):
    times, _, notes, retimed = played(lambda t: 100 - t, fps)
    assert times[0] == 100.0
    assert times[4] > 100.0, "no later than after four frames they go on"
    assert np.diff(times)[4:] == pytest.approx(1 / fps, abs=0.02)
    assert len(notes) == 1
    assert "runs backwards; frames get the times of their arrival" in notes[0]
    assert retimed == len(times) - 4


def test_frames_that_overtake_each_other_are_no_clock_that_runs_backwards():
    order = [k + (2, 0, -2)[k % 3] for k in range(240)]  # 2 1 0, 5 4 3 and so on
    _, _, notes, retimed = played(lambda t: order[round(t * 30)] / 30, 30)
    assert (notes, retimed) == ([], 0)


@pytest.mark.parametrize("fps", [30, 60])
def test_a_clock_ten_times_as_fast_is_not_used(fps):
    times, _, notes, _ = played(lambda t: t * 10, fps)
    assert np.diff(times)[2 * fps :] == pytest.approx(1 / fps, abs=0.01)
    assert len(notes) == 1


def test_a_recording_that_is_sent_at_once_keeps_its_times():
    batch, notes = Batch(note=print), []
    rng = np.random.default_rng(1)
    for k in range(200):
        batch.put(Pose("p1", rng.normal(size=(2, 3)), k * 1e-4, k / 30 + (5.0 if k > 100 else 0.0)))
    frames = batch.take(float("inf"))[1]
    assert frames.times == pytest.approx([k / 30 + (5.0 if k > 100 else 0.0) for k in range(200)], abs=1e-12)
    assert not notes


def test_the_same_frame_sent_twice_says_nothing_about_the_clock():
    batch, notes = Batch(note=print), []
    rng = np.random.default_rng(1)
    for k in range(100):
        pose = rng.normal(size=(2, 3))
        for again in range(2):
            batch.put(Pose("p1", pose, k / 30 + again * 0.01, k / 30))
    times = batch.take()[1].times
    assert times.tolist() == [k / 30 for k in range(100) for _ in range(2)]
    assert not notes


def test_halves_of_a_frame_are_the_same_frame():
    batch = Batch(note=pytest.fail)
    rng = np.random.default_rng(1)
    for k in range(50):
        for half in range(2):
            pose = rng.normal(size=(2, 3))
            pose[half] = np.nan
            batch.put(Pose("p1", pose, k / 30, k / 30))
    assert batch.take()[1].times.tolist() == [k / 30 for k in range(50) for _ in range(2)]


def test_one_frame_with_the_time_of_the_one_before_is_held_back_briefly_and_keeps_its_time():
    notes = []
    clock = SenderClock(Verdict(), lambda a, b: a != b, notes.append)
    sent = [k / 30 for k in range(20)]
    sent[5] = sent[4]
    found = [clock.put(k, time, k / 30) for k, time in enumerate(sent)]
    assert [time for batch in found for _, time in batch] == sent
    assert max(map(len, found)) <= 6
    assert not clock.holds
    assert not notes


def test_frames_held_back_go_on_when_nothing_more_comes():
    clock = SenderClock(Verdict(), lambda a, b: a != b, lambda _: None)
    for k in range(4):
        clock.put(k, 7.0, k / 30)
    assert clock.holds
    assert clock.settle(3 / 30 + 0.05) == []
    times = [time for _, time in clock.settle(3 / 30 + 0.2)]
    assert times == pytest.approx([7.0 + k / 30 for k in range(1, 4)], abs=0.005)
    assert not clock.holds


def test_performers_of_a_sender_whose_clock_stands_stay_side_by_side():
    batch = Batch(note=lambda _: None)
    rng = np.random.default_rng(1)
    for k in range(90):
        for name in ("ann", "bob") if k >= 45 else ("ann",):
            batch.put(Pose(name, rng.normal(size=(2, 3)), k / 30, 5.0))
    frames = {item.performer: item.times for item in batch.take() if isinstance(item, Frames)}
    assert frames["bob"] == pytest.approx(frames["ann"][45:], abs=0.01)


def test_a_rate_that_is_given_counts_frames_of_a_clock_that_stands():
    times, _, notes, _ = played(BROKEN["still"], 30, fps_option=25.0)
    assert np.diff(times) == pytest.approx(1 / 25)
    assert "times at 25 Hz" in notes[0]


def test_a_file_through_a_pipe_with_a_clock_that_stands_is_counted():
    batch = Batch(note=lambda _: None, piped=True)
    rng = np.random.default_rng(1)
    for _ in range(200):
        batch.put(Pose("p1", rng.normal(size=(2, 3)), 0.1, 5.0))
    assert np.diff(batch.take(float("inf"))[1].times) == pytest.approx(1 / 30)
