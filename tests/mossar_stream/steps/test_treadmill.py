"""On a treadmill the ground moves: strikes and offs are those on the belt."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from checks.gaits import FEET, GAITS, SKELETON, performed, wiggling
from checks.steps import EDGE, STEPS, _event, found_in
from mossar_adapters.annotations.reading import read_annotations
from mossar_adapters.files import read
from mossar_stream import Segmenter, Settings, StepEvent

STRIKE, OFF = 0.05, 0.07  # s
DATA = Path(__file__).parents[4] / "shared" / "data"


def on_belt(positions, times, velocity, axis=0):
    """Return positions carried by a belt, m/s along an axis, constant or a function of the time."""
    since = times - times[0]
    speeds = velocity(since) if callable(velocity) else np.full(len(since), float(velocity))
    way = np.concatenate([[0.0], np.cumsum(speeds[1:] * np.diff(since))])
    carried = positions.astype(np.float64)
    carried[..., axis] += way[:, None]
    return carried.astype(np.float32)


def f1(found, truth):
    """Return F1 within the tolerances."""
    hits = 0
    for side in ("left", "right"):
        for status, tolerance in (("strike", STRIKE), ("off", OFF)):
            times = [event.time for event in found if (event.side, event.status) == (side, status)]
            for moment in sorted(t for t, s, what in truth if (s, what) == (side, status)):
                near = [time for time in times if abs(time - moment) <= tolerance + 1e-9]
                if near:
                    times.remove(min(near, key=lambda time: abs(time - moment)))
                    hits += 1
    return 2 * hits / (len(found) + len(truth))


VELOCITIES = {
    "slow": -0.3,
    "fast": -1.8,
    "forwards": 0.7,
    "faster and faster": lambda since: -0.6 - 0.08 * since,
    "slower and slower": lambda since: 1.5 - 0.08 * since,
    "up and down": lambda since: -1.0 - 0.2 * np.sin(since),
}


@pytest.mark.parametrize("velocity", VELOCITIES.values(), ids=VELOCITIES.keys())
@pytest.mark.parametrize("gait", ["walking", "slow", "fast", "backwards", "stairs"])
def test_steps_on_a_belt_are_those_over_ground(gait, velocity):
    positions, times, truth = performed(GAITS[gait], 12.0, 100.0, 0.001)
    assert f1(found_in(positions, times, SKELETON, FEET), truth) >= 0.95
    assert f1(found_in(on_belt(positions, times, velocity), times, SKELETON, FEET), truth) >= 0.95


@pytest.mark.parametrize("gait", ["walking", "running"])
def test_the_belt_may_be_as_fast_as_the_walk_so_that_the_body_stays(gait):
    positions, times, truth = performed(GAITS[gait], 12.0, 100.0, 0.001)
    way = positions[-10:].mean((0, 1)) - positions[:10].mean((0, 1))
    axis = int(np.argmax(np.abs(way)))
    belt = -way[axis] / (times[-1] - times[0])
    found = found_in(on_belt(positions, times, belt, axis), times, SKELETON, FEET)
    assert f1(found, truth) >= 0.95


@pytest.mark.parametrize("share", [-0.5, 0.5, 1.0, 1.5])
def test_a_real_walk_on_a_belt_has_its_strikes_and_offs(share):
    path = DATA / "formats/c3d/gait_13_events.c3d"
    if not path.exists():
        pytest.skip(f"no {path}")
    walk = read(path)
    first, last = float(walk.times[0]), float(walk.times[-1])
    marks = [mark for tier in read_annotations(path) if tier.name == STEPS for mark in tier.marks]
    truth = [
        event for event in (_event(first, mark) for mark in marks) if first + EDGE < event[0] < last - EDGE
    ]
    carried = on_belt(walk.positions, walk.times, -1.03 * share)
    found = found_in(carried, walk.times, walk.skeleton)
    assert f1([event for event in found if first + EDGE < event.time < last - EDGE], truth) >= 0.9


@pytest.mark.parametrize("belt", [0.0, 0.8])
def test_who_stands_makes_no_steps_whether_the_ground_moves_or_not(belt):
    positions = wiggling(60.0, 100.0, 0.001)
    times = np.arange(len(positions)) / 100.0
    assert found_in(on_belt(positions, times, belt), times, SKELETON, FEET) == []


def test_a_belt_that_starts_and_stops_again():
    walk, _times, truth = performed(GAITS["walking"], 12.0, 100.0, 0.001)
    still = 300  # frames
    positions = np.concatenate([np.repeat(walk[:1], still, 0), walk, np.repeat(walk[-1:], still, 0)])
    whole = np.arange(len(positions)) / 100.0
    after = [(moment + 3.0, side, what) for moment, side, what in truth]

    def belt(since):
        return -0.9 * np.clip(np.minimum(since - 3.0, 15.0 - since) / 3.0, 0.0, 1.0)

    found = found_in(on_belt(positions, whole, belt), whole, SKELETON, FEET)
    assert f1(found, after) >= 0.8  # the first steps, while it gets faster from rest, are partly missed


def events(positions, times, sizes):
    segmenter = Segmenter(SKELETON, Settings(steps=True, feet=FEET, level="posture"))
    found, start = [], 0
    while start < len(positions):
        size = sizes[start % len(sizes)]
        found += segmenter.push(positions[start : start + size], times[start : start + size])
        start += size
    return [event for event in [*found, *segmenter.end_take()] if isinstance(event, StepEvent)]


def test_events_do_not_depend_on_chunks_and_are_in_order():
    walk, times, _ = performed(GAITS["walking"], 6.0, 100.0, 0.001)
    positions = on_belt(walk, times, -0.9)
    whole = events(positions, times, [len(positions)])
    assert len(whole) > 10
    assert whole == events(positions, times, [1]) == events(positions, times, [7, 64])
    for side in ("left", "right"):
        own = [event for event in whole if event.side == side]
        assert [event.time for event in own] == sorted({event.time for event in own})
        assert all(one.status != other.status for one, other in itertools.pairwise(own))
    assert all(event.decided_time >= event.time for event in whole)


@pytest.mark.parametrize("frame", [50, 100, 101, 110, 130, 300])
def test_a_snapshot_knows_the_belt(frame):
    walk, times, _ = performed(GAITS["walking"], 5.0, 100.0, 0.001)
    positions = on_belt(walk, times, -0.9)
    segmenter = Segmenter(SKELETON, Settings(steps=True, feet=FEET, level="posture"))
    found = segmenter.push(positions[:frame], times[:frame])
    again = Segmenter.restore(segmenter.snapshot())
    found += again.push(positions[frame:], times[frame:])
    found += again.end_take()
    steps = [event for event in found if isinstance(event, StepEvent)]
    assert steps == events(positions, times, [len(positions)])


def test_places_are_those_in_the_room():
    walk, times, _ = performed(GAITS["walking"], 8.0, 100.0, 0.001)
    positions = on_belt(walk, times, -0.9)
    for event in events(positions, times, [64]):
        feet = positions[np.searchsorted(times, event.time)]
        assert np.linalg.norm(feet - event.position, axis=1).min() < 0.25
