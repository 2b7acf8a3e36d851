"""Which performers a run misses: the watch of each, over sources that are read at their own speed."""

import pytest

from mossar_adapters.pipeline import Pipeline, Upkeep
from mossar_adapters.pipeline.inbox import Arrival
from mossar_stream import StreamEvent


@pytest.fixture
def watched(stage):
    """Return how to let frames of a performer be heard, and what a look at a time finds."""
    sources = [stage.Script([], live=True, name=name) for name in ("left", "right")]
    sink = stage.Collected()
    pipeline = Pipeline(sources, [sink], upkeep=Upkeep())
    (outlet,) = pipeline.outlets
    found = []
    outlet.put = lambda parcel: found.extend(parcel.item if isinstance(parcel.item, list) else ())

    class Watched:
        run = pipeline

        @staticmethod
        def heard(name, source, at):
            performer = pipeline.naming.performer(source, name)
            if name not in pipeline.pool:
                pipeline.pool.announce(name, stage.meta(name).skeleton)
            pipeline.pool.push(stage.wave(round(at * 30), 1, name))
            pipeline.feeds[source].looked_at = at
            pipeline.upkeep.heard(pipeline, Arrival(source, None, at), performer)

        @staticmethod
        def look(now, heard_out=None):
            for source, feed in enumerate(pipeline.feeds):
                feed.looked_at = (heard_out or {}).get(source, now)
            found.clear()
            pipeline.upkeep._look_for_stalls(pipeline, now)
            changes = (event for event in found if isinstance(event, StreamEvent))
            return [(e.performer, e.event) for e in changes if e.event in {"stalled", "ended"}]

    return Watched


def test_time_stands_still_for_frames_that_wait_in_a_queue(watched):
    watched.heard("p1", 0, 0.0)
    watched.heard("p2", 1, 0.0)
    assert watched.look(0.5, {0: 0.2}) == [("p2", "stalled")]
    assert watched.look(0.6, {0: 0.4}) == [("p1", "stalled")]


def test_a_performer_that_left_is_missed_although_others_keep_the_queue_full(watched):
    watched.heard("p1", 0, 0.0)
    found = []
    for k in range(1, 21):
        watched.heard("p2", 0, k / 10)
        found += watched.look(k / 10 + 0.05, {0: k / 10 + 0.01})
    assert found == [("p1", "stalled"), ("p1", "ended")]
    assert watched.run.performers["p1"].time.is_absent


def test_performers_of_a_source_that_ended_are_not_missed(watched):
    watched.heard("p1", 0, 0.0)
    watched.heard("p2", 1, 0.0)
    watched.run._end_source(0, None)
    assert {name for name, _ in watched.look(5.0)} == {"p2"}


def test_a_performer_that_made_room_is_not_missed(watched):
    watched.heard("p1", 0, 0.0)
    watched.heard("p2", 0, 0.0)
    watched.run.pool.remove("p1")
    assert {name for name, _ in watched.look(5.0)} == {"p2"}
