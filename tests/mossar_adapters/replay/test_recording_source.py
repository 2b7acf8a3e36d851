import time

import numpy as np
import pytest

from mossar_adapters.replay.interleaving import in_order_of_time
from mossar_adapters.replay.recording_source import LOOP_PAUSE, RecordingSource
from mossar_adapters.source import Meta, Recording
from mossar_stream import Frames, Skeleton

SKELETON = Skeleton(("hip", "hand"), (-1, 0))


def recording(count=20, fps=100.0, performers=("p1",), chunk=8):
    def chunks():
        for i in range(0, count, chunk):
            n = min(chunk, count - i)
            for k, name in enumerate(performers):
                times = np.arange(i, i + n) / fps + 0.001 * k
                yield Frames(np.full((n, 2, 3), k, np.float32), times, np.ones((n, 2), np.float32), name)

    return Recording("take.msk", SKELETON, fps, chunks, ("a note",), count, performers)


def frames_of(source):
    return [item for item in source.items() if isinstance(item, Frames)]


def times_of(source):
    return np.concatenate([frames.times for frames in frames_of(source)])


def test_at_full_speed_the_chunks_of_the_reader_come_as_they_are():
    source = RecordingSource(recording())
    assert not source.live
    items = list(source.items())
    assert items[0] == Meta("p1", SKELETON, 100.0, recording=source.name)
    assert [len(item) for item in items[1:]] == [8, 8, 4]


def test_at_a_speed_frames_come_one_by_one_at_their_times():
    source = RecordingSource(recording(), 2.0)
    assert source.live
    start = time.monotonic()
    found = frames_of(source)
    assert [len(frames) for frames in found] == [1] * 20
    assert found[3].confidence.shape == (1, 2)
    assert 0.09 <= time.monotonic() - start < 1


def test_several_performers_come_in_order_of_time():
    found = frames_of(RecordingSource(recording(performers=("a", "b")), 100.0))
    assert [frames.performer for frames in found] == ["a", "b"] * 20
    assert (np.diff([frames.times[0] for frames in found]) > 0).all()


def test_a_performer_that_has_ended_does_not_hold_up_the_others():
    times = np.arange(200) / 10
    chunks = [Frames(np.zeros((1, 1, 3), np.float32), times[:1], None, "a")]
    chunks += [Frames(np.zeros((1, 1, 3), np.float32), times[i : i + 1], None, "b") for i in range(200)]
    taken = 0

    def arriving():
        nonlocal taken
        for chunk in chunks:
            taken += 1
            yield chunk

    ordered = in_order_of_time(arriving(), 2)
    assert len([next(ordered) for _ in range(100)]) == 100
    assert taken < 200
    assert sum(1 for _ in ordered) == 101


def test_resuming_skips_the_frames_of_each_performer():
    source = RecordingSource(recording(performers=("a", "b")))
    source.resume({"a": 10, "b": 3})
    counts = {
        name: sum(len(f) for f in frames_of_performer) for name, frames_of_performer in split(source).items()
    }
    assert counts == {"a": 10, "b": 17}


def split(source):
    found = {}
    for frames in frames_of(source):
        found.setdefault(frames.performer, []).append(frames)
    return found


def test_a_loop_goes_on_in_time_after_a_pause_that_begins_a_new_take():
    source = RecordingSource(recording(), loop=True)
    items = source.items()
    next(items)
    chunks = [next(items) for _ in range(6)]
    times = np.concatenate([chunk.times for chunk in chunks])
    steps = np.diff(times)
    assert (steps > 0).all()
    assert steps[19] == pytest.approx(LOOP_PAUSE)
    source.close()


def test_the_only_performer_can_be_renamed():
    items = list(RecordingSource(recording(), performer="ann").items())
    assert {item.performer for item in items} == {"ann"}


def test_closing_ends_a_wait():
    source = RecordingSource(recording(fps=0.1), 1.0)
    items = source.items()
    next(items)
    next(items)
    assert next(items) is None
    source.close()
    assert list(items) == []
