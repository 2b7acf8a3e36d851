"""Outlet: one thread that feeds one sink, so that a slow or dead sink never stalls the stream.

A sink with `prompt = True` never blocks. The thread that brings the events feeds it at once, since waking
another thread takes longer than sending. Its own thread serves it in quiet times.
"""

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import cast

import msgspec

from mossar_adapters.abilities import Prompt, TakesEvents, TakesFrames, TakesStarts, offered
from mossar_adapters.pipeline.emission import Emission
from mossar_adapters.pipeline.take_starts import TakeStart
from mossar_adapters.sink import FrameSink, Sink
from mossar_adapters.source import Meta
from mossar_stream import Event, Frames

CAPACITY = 20_000  # events, or frames of a sink that takes frames
PATIENCE = 2.0  # s given to a sink at the end, to take the waiting parcels
_CLOSING = 1.0  # s given to it to close
_NAP = 0.1  # s, after which a wait looks whether the program is to end
_QUIET = 0.2  # s without events after which a sink may look after receivers that have joined

_log = logging.getLogger("mossar.pipeline")


class Parcel(msgspec.Struct, frozen=True):
    """Content of one call of a sink.

    Args:
        item: A meta, events, frames, or the beginning of a take for sinks that have `begin_take`.
        arrived_at: When the frame arrived that caused it, monotonic s; None if no frame did.
    """

    item: Meta | list[Event] | Frames | TakeStart
    arrived_at: float | None = None

    def size(self) -> int:
        """Return its size in the queue."""
        return 1 if isinstance(self.item, Meta | TakeStart) else len(self.item)


_NOTHING = Parcel([])


class Outlet:
    """Hands parcels to a sink, in a thread of its own unless the sink is prompt.

    Args:
        sink: Receives them; one that has `send_frames` gets frames as well.
        waits: Whether to wait for room instead of dropping the oldest parcels.
        delivered: Called with each parcel that was handed over, by the thread that did it.
        gives_up: Asked while waiting for room; True means that the program is to end.
        emission: The events that the sink gets; None for all.
        capacity: Size of the queue.
    """

    def __init__(
        self,
        sink: Sink | FrameSink,
        *,
        waits: bool,
        delivered: Callable[[Parcel], None] = lambda _: None,
        gives_up: Callable[[], bool] = lambda: False,
        emission: Emission | None = None,
        capacity: int = CAPACITY,
    ) -> None:
        self.sink = sink
        self.dropped = 0  # events and frames that found no room
        self.error: Exception | None = None  # error that ended the sink
        self._waits = waits
        self._delivered = delivered
        self._gives_up = gives_up
        self._emission = emission or Emission()
        self._capacity = capacity
        self._queue: deque[Parcel] = deque()
        self._size = 0
        self._busy = False
        self._given_up = False  # whether the sink was waited for in vain
        self._ending = False
        self._lock = threading.Lock()
        self._changed = threading.Condition(self._lock)
        self._thread = threading.Thread(target=self._deliver, name=f"write {sink.name}", daemon=True)
        prompt = offered(sink, Prompt)
        self.prompt = prompt is not None and prompt.prompt
        self._takes_frames = offered(sink, TakesFrames) is not None
        self.takes_events = offered(sink, TakesEvents) is not None
        self._takes_starts = offered(sink, TakesStarts) is not None

    def start(self) -> None:
        """Begin to deliver."""
        self._thread.start()

    def put(self, parcel: Parcel) -> None:
        """Hand a parcel over, or queue it."""
        if self.error is not None or not self._wants(parcel):
            return
        if isinstance(parcel.item, list):
            wanted = self._emission.of(parcel.item)
            if not wanted:
                return
            parcel = Parcel(wanted, parcel.arrived_at)
        with self._lock:
            if self.prompt and not self._queue and not self._busy:
                self._hand_over_now(parcel)
                return
            while self._waits and self._size >= self._capacity and not self._ended():
                self._changed.wait(_NAP)
            while self._size >= self._capacity and self._drop_oldest():
                pass
            self._queue.append(parcel)
            self._size += parcel.size()
            self._changed.notify_all()

    def settle(self) -> bool:
        """Wait until everything is handed over; return whether it was.

        A sink that is waited for gets all the time it takes, until the program is to end; then, and any other,
        `PATIENCE` seconds, once.
        """
        while self._waits and not self._ended():
            if self.drain(_NAP):
                return True
        done = self.drain(0 if self._given_up else PATIENCE)
        self._given_up = not done
        return done

    def drain(self, timeout: float) -> bool:
        """Wait until everything is handed over; return whether it was."""
        give_up = time.monotonic() + timeout
        with self._changed:
            while self.error is None and (self._busy or self._queue):
                left = give_up - time.monotonic()
                if left <= 0:
                    return False
                self._changed.wait(left)
        return self.error is None

    def end(self) -> None:
        """Have the sink closed as soon as it has got everything, without waiting for that; see `close`."""
        with self._changed:
            self._ending = True
            self._changed.notify_all()

    def close(self) -> None:
        """Deliver the waiting parcels, as far as the sink takes them in time, and close the sink."""
        self.end()
        self.settle()
        self._thread.join(_CLOSING)
        if self._thread.is_alive():
            _log.warning("%s does not take its events; %d are lost", self.sink.name, self._size)

    def _ended(self) -> bool:
        return self.error is not None or self._gives_up()

    def _wants(self, parcel: Parcel) -> bool:
        if isinstance(parcel.item, Meta):
            return True
        if isinstance(parcel.item, TakeStart):
            return self._takes_starts
        return self._takes_frames if isinstance(parcel.item, Frames) else self.takes_events

    def _drop_oldest(self) -> bool:
        for place, parcel in enumerate(self._queue):
            if not isinstance(parcel.item, Meta):
                del self._queue[place]
                self._size -= parcel.size()
                if not self.dropped:
                    _log.warning("%s is too slow: its oldest events are dropped", self.sink.name)
                self.dropped += parcel.size()
                return True
        return False

    def _deliver(self) -> None:
        try:
            while (parcel := self._next()) is not None:
                self._hand_over(parcel)
                with self._lock:
                    self._busy = False
                    self._changed.notify_all()
            self.sink.close()
        except Exception as error:  # noqa: BLE001 - a sink of any kind must not end the stream
            with self._lock:
                self._fail(error)

    def _hand_over_now(self, parcel: Parcel) -> None:
        try:
            self._hand_over(parcel)
        except Exception as error:  # noqa: BLE001 - as above
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        self.error = error
        self._queue.clear()
        self._changed.notify_all()

    def _next(self) -> Parcel | None:
        with self._changed:
            quiet = False
            while not self._queue:
                if self._ending or self.error is not None:
                    return None
                if quiet and self.takes_events:
                    self._busy = True
                    return _NOTHING
                quiet = not self._changed.wait(_QUIET)
            self._busy = True
            parcel = self._queue.popleft()
            self._size -= parcel.size()
            self._changed.notify_all()
            return parcel

    def _hand_over(self, parcel: Parcel) -> None:
        item = parcel.item
        if isinstance(item, Meta):
            self.sink.announce(item)
        elif isinstance(item, TakeStart):
            cast("TakesStarts", self.sink).begin_take(item.performer, item.take, item.time)
        elif isinstance(item, Frames):
            cast("FrameSink", self.sink).send_frames(item)
        else:
            cast("Sink", self.sink).send(item)
        if parcel is not _NOTHING:
            self._delivered(parcel)
