import numpy as np

from mossar_adapters.pipeline.take_starts import TakeStart, parts, take_starts
from mossar_stream import Frames, StreamEvent


def started(take):
    return StreamEvent(performer="p1", event="started", take=take)


def frames(*times, **fields):
    return Frames(np.zeros((len(times), 2, 3), np.float32), np.array(times), **fields)


def test_a_take_begins_with_the_first_frame_of_a_part():
    assert take_starts([started(3)], frames(5.0, 5.1)) == [TakeStart("p1", 3, 5.0)]
    assert take_starts([], frames(5.2, 5.3)) == []


def test_a_chunk_is_cut_where_time_leaps_forward_or_back():
    confidence = np.arange(10, dtype=np.float32).reshape(5, 2)
    chunk = frames(5.0, 5.1, 9.0, 2.0, 2.1, confidence=confidence, first_frame=7)
    found = parts(chunk, 1.0)
    assert [part.times.tolist() for part in found] == [[5.0, 5.1], [9.0], [2.0, 2.1]]
    assert [part.first_frame for part in found] == [7, 9, 10]
    assert np.array_equal(np.concatenate([part.confidence for part in found]), confidence)


def test_a_chunk_without_leaps_stays_whole():
    for chunk in (frames(1.0), frames(1.0, 1.5, 2.4, 1.9)):
        assert parts(chunk, 1.0) == [chunk]
