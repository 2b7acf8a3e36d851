import numpy as np

from mossar_adapters.pipeline.take_starts import TakeStart, take_starts
from mossar_stream.events import StreamEvent
from mossar_stream.frames import Frames


def started(take):
    return StreamEvent(performer="p1", event="started", take=take)


def frames(*times):
    return Frames(np.zeros((len(times), 2, 3), np.float32), np.array(times))


def test_the_first_take_begins_with_the_first_frame():
    assert take_starts([started(0)], frames(5.0, 5.1), None, 1.0) == [TakeStart("p1", 0, 5.0)]


def test_a_gap_inside_a_chunk_begins_a_take_behind_it():
    found = take_starts([started(0), started(1)], frames(5.0, 5.1, 9.0), None, 1.0)
    assert found == [TakeStart("p1", 0, 5.0), TakeStart("p1", 1, 9.0)]


def test_a_take_may_begin_without_a_gap_after_the_one_before_was_ended():
    assert take_starts([started(3)], frames(5.2, 5.3), 5.1, 1.0) == [TakeStart("p1", 3, 5.2)]


def test_going_on_begins_nothing():
    assert take_starts([], frames(5.2, 5.3), 5.1, 1.0) == []
