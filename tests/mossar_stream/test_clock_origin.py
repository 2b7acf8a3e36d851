"""Where the clock began decides nothing: at these rates frames are exactly as far apart as what times are compared with."""

import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_stream import Moves, Segmenter, Settings

SQUATS = ["squat"] * 12
EXERCISES = [None, ["wave_left", "squat", "rest:0.5"] * 8, SQUATS]
ORIGINS = (0.0, 36000.0, 1e6)  # s
OF_TIMES = ("time", "start", "end", "start_time", "end_time", "active_start", "active_end", "decided_time")


def outline(events, origin):
    """Return what events say, times without the clock's origin, to a hundredth of a millisecond."""
    found = []
    for event in events:
        times = [getattr(event, name, None) for name in OF_TIMES]
        rounded = [None if time is None else round(time - origin, 5) + 0.0 for time in times]
        facts = [getattr(event, name, None) for name in ("id", "status", "state", "kind", "name", "count")]
        found.append((type(event).__name__, *facts, *rounded))
    return found


def outlines(take, settings, **how):
    """Return the outlines of a take's events by the origin of its clock; they have to be the same."""
    positions, times = np.array(take.frames.positions), np.array(take.frames.times)
    found = []
    for origin in ORIGINS:
        segmenter = Segmenter(take.skeleton, settings, fps=take.fps, **how)
        found.append(outline(segmenter.push(positions, times + origin) + segmenter.end_take(), origin))
    return found


def kinds(events):
    return {event[0] for event in events}


@pytest.mark.parametrize(("seed", "fps"), [(2, 100.0), (6, 100.0), (10, 100.0), (0, 15.0), (6, 15.0)])
def test_segments_key_frames_and_repetitions(seed, fps):
    take = performance(seed, fps=fps, seconds=20.0, moves=EXERCISES[min(seed, 2)])
    found = outlines(take, Settings(level="motion", repetitions=True))
    assert found[1] == found[0]
    assert found[2] == found[0]
    assert kinds(found[0]) >= {"KeyFrameEvent", "SegmentEvent", "RepetitionEvent"}


@pytest.mark.parametrize("fps", [40.0, 100.0, 120.0, 125.0])
def test_moves_poses_and_what_is_followed(fps):
    moves = Moves(performance(1, seconds=1.0).skeleton)
    for name, move in (("punch", "punch_left"), ("squat", "squat")):
        shown = performance(7, seconds=4.0, moves=["rest:1", move, "rest:1"])
        moves.add(name, shown.frames.positions, fps=60)
    moves.add_pose(
        "standing", performance(3, seconds=2.0, moves=["stand:2"]).frames.positions, fps=60, hold=0.5
    )
    take = performance(5, fps=fps, seconds=15.0, moves=["rest:1", "punch_left", "squat", "rest:1"] * 3)
    found = outlines(take, Settings(), moves=moves, follow=True)
    assert found[1] == found[0]
    assert found[2] == found[0]
    assert kinds(found[0]) >= {"MoveEvent", "PoseEvent", "FollowEvent"}


@pytest.mark.parametrize("fps", [100.0, 200.0, 400.0])
def test_steps(fps):
    take = performance(4, fps=fps, seconds=8.0, moves=["walk", "walk", "walk"])
    found = outlines(take, Settings(steps=True))
    assert found[1] == found[0]
    assert found[2] == found[0]
    assert "StepEvent" in kinds(found[0])
