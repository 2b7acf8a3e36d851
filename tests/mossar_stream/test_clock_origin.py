"""Where the clock began decides nothing: at these rates frames are exactly as far apart as what times are compared with."""

import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_stream import Moves, Segmenter, Settings

SQUATS = ["squat"] * 12
EXERCISES = [None, ["wave_left", "squat", "rest:0.5"] * 8, SQUATS]
ORIGINS = (0.0, 36000.0, 1e6, 9.6e8, 1.7e9)  # s; the last two are times since 1970, of 2000 and of today
ROUNDED = 5e-6  # s, more than times since 1970 are rounded by
OF_TIMES = ("time", "start", "end", "start_time", "end_time", "active_start", "active_end", "decided_time")


def outline(events, origin):
    """Return what events say, and their times without the clock's origin."""
    found, moments = [], []
    for event in events:
        facts = [getattr(event, name, None) for name in ("id", "status", "state", "kind", "name", "count")]
        found.append((type(event).__name__, *facts))
        times = [getattr(event, name, None) for name in OF_TIMES]
        moments.append([np.nan if time is None else time - origin for time in times])
    return found, np.array(moments)


def outlines(take, settings, **how):
    """Return what a take's events say, after seeing that it is the same wherever its clock began."""
    positions, times = np.array(take.frames.positions), np.array(take.frames.times)
    found = []
    for origin in ORIGINS:
        segmenter = Segmenter(take.skeleton, settings, fps=take.fps, **how)
        found.append(outline(segmenter.push(positions, times + origin) + segmenter.end_take(), origin))
    for events, moments in found[1:]:
        assert events == found[0][0]
        np.testing.assert_allclose(moments, found[0][1], rtol=0, atol=ROUNDED)
    return found[0][0]


def kinds(events):
    return {event[0] for event in events}


@pytest.mark.parametrize(("seed", "fps"), [(2, 100.0), (6, 100.0), (10, 100.0), (0, 15.0), (6, 15.0)])
def test_segments_key_frames_and_repetitions(seed, fps):
    take = performance(seed, fps=fps, seconds=20.0, moves=EXERCISES[min(seed, 2)])
    found = outlines(take, Settings(level="motion", repetitions=True))
    assert kinds(found) >= {"KeyFrameEvent", "SegmentEvent", "RepetitionEvent"}


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
    assert kinds(found) >= {"MoveEvent", "PoseEvent", "FollowEvent"}


@pytest.mark.parametrize("fps", [100.0, 200.0, 400.0])
def test_steps(fps):
    take = performance(4, fps=fps, seconds=8.0, moves=["walk", "walk", "walk"])
    found = outlines(take, Settings(steps=True))
    assert "StepEvent" in kinds(found)
