"""Rows have room for few undecided key frames, and grow: the events are those of a row that was large from the beginning."""

import numpy as np
import pytest

from mossar_stream import Performers, Segmenter, Settings
from mossar_stream.core import plan
from mossar_stream.core.kernels import MORE_ROOM

SETTINGS = {
    "remerge_window": 20,
    "range_floor": 0.01,
    "window": 0.05,
    "remerge_seconds": 1e6,
    "repetitions": True,
}


@pytest.fixture
def take(core):
    """Positions and times of a take in which many key frames are undecided."""
    return core.moving_people(3, frames=900, losses=False)


def segmented(core, take, settings, chunk=64, *, restores=False):
    """Return the events of a take, and the room of its row at the end."""
    positions, times = take
    segmenter, events = Segmenter(core.skeleton(4), settings, fps=60.0), []
    for begin in range(0, len(times), chunk):
        events += segmenter.push(positions[begin : begin + chunk], times[begin : begin + chunk])
        if restores:
            segmenter = Segmenter.restore(segmenter.snapshot())
    events += segmenter.end_take()
    return core.lines(events), segmenter.row.plan.sizes[1]


@pytest.mark.parametrize("level", ["motion", "posture"])
@pytest.mark.parametrize("chunk", [1, 64, 900])
def test_events_do_not_depend_on_the_room_at_first(core, take, monkeypatch, level, chunk):
    settings = Settings(level=level, **SETTINGS)
    found, room = segmented(core, take, settings, chunk)
    assert room > plan.FIRST_ROOM
    assert segmented(core, take, settings, chunk, restores=True) == (found, room)
    monkeypatch.setattr(plan, "FIRST_ROOM", 1000)
    assert segmented(core, take, settings, chunk) == (found, settings.resolved().remerge_window)


def test_a_row_grows_no_further_than_its_window(core, take):
    for window in (3, plan.FIRST_ROOM, plan.FIRST_ROOM + MORE_ROOM + 1):
        _, room = segmented(core, take, Settings(**{**SETTINGS, "remerge_window": window}))
        assert room == window


def test_rows_of_many_grow_each_on_its_own(core, take):
    positions, times = take
    settings = Settings(**SETTINGS)
    still = np.repeat(positions[:1], len(times), axis=0)
    pool = Performers(settings)
    for name in ("p1", "p2"):
        pool.announce(name, core.skeleton(4), 60.0)
    events = pool.push_many(pool.names, np.stack([positions, still]), times) + pool.end_takes()
    rooms = [pool[name].row.plan.sizes[1] for name in pool.names]
    assert rooms[0] > rooms[1] == plan.FIRST_ROOM
    assert core.lines(e for e in events if e.performer == "p1") == segmented(core, take, settings)[0]


def test_settings_that_leave_the_row_as_it_is_leave_its_room(core, take):
    positions, times = take
    segmenter = Segmenter(core.skeleton(4), Settings(**SETTINGS), fps=60.0)
    segmenter.push(positions, times)
    room = segmenter.row.plan.sizes[1]
    events = segmenter.change(max_gap=0.3)
    assert (events, segmenter.row.plan.sizes[1]) == ([], room)
