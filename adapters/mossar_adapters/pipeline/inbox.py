"""Inbox: bounded queues from the reader threads to the one thread that segments.

Bounds are in frames. A full queue of a live source drops its oldest frames, because late key frames are worth
less than missing ones; a recording waits instead, because nothing of it may be lost.
"""

import threading
from collections import deque
from collections.abc import Callable, Sequence

import msgspec

from mossar_adapters.source import Departure, Meta, Occupant
from mossar_stream import Frames

CAPACITY = 2048  # frames per source
# Arrivals per source; metas and leavings are never dropped, so too many of them make a reader wait.
MOST = 4096


class Arrival(msgspec.Struct, frozen=True):
    """Something that a source delivered.

    Args:
        source: Index of the source.
        item: A meta, frames, a performer that came or left, a request, an error that ended the source, or None when
            the source ended.
        at: Time of arrival, monotonic s.
        came: Time at which frames began to arrive at the source, monotonic s; they may have waited to be completed. None
            if unknown.
        meta: The source's last announcement of the performer, with frames: the reader need not have seen it
            itself.
    """

    source: int
    item: "Meta | Frames | Departure | Occupant | Callable[[], None] | Exception | None"
    at: float
    meta: Meta | None = None
    came: float | None = None


class Inbox:
    """Hands arrivals of several sources over, fairly. Every method may be called from any thread, `get` from one.

    Frames come some milliseconds apart and find the processor cold: a condition variable in Python then costs as much
    as a frame's own way through the source. A reader that waits for arrivals therefore waits for a lock.

    Args:
        drops: For each source, whether its oldest frames are dropped when its queue is full.
        capacity: Frames that a queue holds; one chunk always fits.
    """

    def __init__(self, drops: Sequence[bool], capacity: int = CAPACITY) -> None:
        self.dropped = [0] * len(drops)  # frames dropped of each source
        self._drops = list(drops)
        self._capacity = capacity
        self._queues: list[deque[Arrival]] = [deque() for _ in drops]
        self._frames = [0] * len(drops)  # in each queue
        self._urgent: deque[Arrival] = deque()
        self._next = 0  # source whose turn it is
        self._closed = False
        self._lock = threading.Lock()
        self._room_made = threading.Condition(self._lock)
        self._writers = 0  # that wait for room
        self._bell = threading.Lock()  # held, but for the moment after something has come
        self._bell.acquire()

    def put(self, arrival: Arrival) -> bool:
        """Add an arrival; wait for room if its source does not drop, or sends anything but frames without end.

        Returns:
            False if the inbox was closed: the source need not go on.
        """
        source, count = arrival.source, _frames_in(arrival)
        with self._lock:
            while not self._closed and self._must_wait(source, count):
                self._writers += 1
                self._room_made.wait()
                self._writers -= 1
            if self._closed:
                return False
            while self._drops[source] and self._is_full(source, count):
                self._drop_oldest(source)
            self._queues[source].append(arrival)
            self._frames[source] += count
            self._ring()
        return True

    def ask(self, request: Callable[[], None]) -> None:
        """Give a task to the thread that segments, to be done before the waiting arrivals."""
        with self._lock:
            self._urgent.append(Arrival(-1, request, 0.0))
            self._ring()

    def get(self, timeout: float) -> Arrival | None:
        """Return the next arrival, None after `timeout` seconds without one."""
        while (
            arrival := self._next_arrival()
        ) is None:  # the bell may have rung for an arrival that is taken already
            if not self._bell.acquire(timeout=timeout):
                return None
        return arrival

    def oldest(self) -> dict[int, float]:
        """Return for each source of which something waits when the oldest of that arrived, monotonic s."""
        with self._lock:
            return {source: queue[0].at for source, queue in enumerate(self._queues) if queue}

    def close(self) -> None:
        """Let no more in; writers that wait return."""
        with self._lock:
            self._closed = True
            self._room_made.notify_all()

    def _ring(self) -> None:
        if self._bell.locked():
            self._bell.release()

    def _next_arrival(self) -> Arrival | None:
        with self._lock:
            if self._urgent:
                return self._urgent.popleft()
            for _ in self._queues:
                source = self._next
                self._next = (source + 1) % len(self._queues)
                if self._queues[source]:
                    arrival = self._queues[source].popleft()
                    self._frames[source] -= _frames_in(arrival)
                    if self._writers:
                        self._room_made.notify_all()
                    return arrival
        return None

    def _is_full(self, source: int, count: int) -> bool:
        return self._frames[source] > 0 and self._frames[source] + count > self._capacity

    def _must_wait(self, source: int, count: int) -> bool:
        if len(self._queues[source]) >= MOST:
            return True
        return not self._drops[source] and self._is_full(source, count)

    def _drop_oldest(self, source: int) -> None:
        queue = self._queues[source]
        for place, arrival in enumerate(queue):
            count = _frames_in(arrival)
            if count:
                del queue[place]
                self._frames[source] -= count
                self.dropped[source] += count
                return


def _frames_in(arrival: Arrival) -> int:
    return len(arrival.item) if isinstance(arrival.item, Frames) else 0
