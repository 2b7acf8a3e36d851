import threading
import time

import numpy as np

from mossar_adapters.pipeline.inbox import Arrival, Inbox
from mossar_adapters.source import Meta
from mossar_stream import Frames, Skeleton

META = Meta("p1", Skeleton(("hip",)))


def frames(count, first=0):
    return Frames(np.zeros((count, 2, 3), np.float32), np.arange(first, first + count) / 10)


def arrival(source, item):
    return Arrival(source, item, 0.0)


def test_a_full_queue_of_a_live_source_drops_its_oldest_frames_and_counts_them():
    inbox = Inbox([True], capacity=10)
    for first in range(0, 30, 5):
        inbox.put(arrival(0, frames(5, first)))
    assert inbox.dropped == [20]
    assert [inbox.get(0).item.times[0] for _ in range(2)] == [2.0, 2.5]


def test_metas_are_never_dropped():
    inbox = Inbox([True], capacity=4)
    inbox.put(arrival(0, None))
    for _ in range(5):
        inbox.put(arrival(0, frames(4)))
    assert inbox.get(0).item is None
    assert len(inbox.get(0).item) == 4


def test_metas_without_end_make_even_a_live_reader_wait(monkeypatch):
    monkeypatch.setattr("mossar_adapters.pipeline.inbox.MOST", 10)
    inbox = Inbox([True])
    for _ in range(10):
        inbox.put(arrival(0, META))
    done = threading.Event()
    writer = threading.Thread(target=lambda: (inbox.put(arrival(0, META)), done.set()))
    writer.start()
    assert not done.wait(0.05)
    inbox.get(0)
    assert done.wait(2)
    writer.join()


def test_a_full_queue_of_a_recording_makes_its_reader_wait():
    inbox = Inbox([False], capacity=4)
    inbox.put(arrival(0, frames(4)))
    done = threading.Event()
    writer = threading.Thread(target=lambda: (inbox.put(arrival(0, frames(4))), done.set()))
    writer.start()
    assert not done.wait(0.05)
    inbox.get(0)
    assert done.wait(2)
    writer.join()
    assert inbox.dropped == [0]


def test_a_chunk_larger_than_the_queue_fits_into_an_empty_one():
    inbox = Inbox([False, True], capacity=4)
    assert inbox.put(arrival(0, frames(100)))
    assert inbox.put(arrival(1, frames(100)))


def test_sources_take_turns():
    inbox = Inbox([False, False])
    for source in (0, 0, 0, 1, 1):
        inbox.put(arrival(source, frames(1)))
    assert [inbox.get(0).source for _ in range(5)] == [0, 1, 0, 1, 0]


def test_requests_go_before_frames():
    inbox = Inbox([False])
    inbox.put(arrival(0, frames(1)))
    inbox.ask(lambda: None)
    assert callable(inbox.get(0).item)


def test_get_returns_none_after_the_timeout():
    start = time.monotonic()
    assert Inbox([False]).get(0.03) is None
    assert time.monotonic() - start < 1


def test_closing_lets_a_waiting_reader_go():
    inbox = Inbox([False], capacity=1)
    inbox.put(arrival(0, frames(1)))
    results = []
    reader = threading.Thread(target=lambda: results.append(inbox.put(arrival(0, frames(1)))))
    reader.start()
    inbox.close()
    reader.join(2)
    assert results == [False]
