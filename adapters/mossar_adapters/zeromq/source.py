"""The ZeroMQ source: SUB, connecting or binding.

A socket around `ZmqDecoder`, which defines the accepted messages.
"""

import math
import time
from collections.abc import Iterator

import zmq

from mossar_adapters.address import Address
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Skipped
from mossar_adapters.source import Departure, Meta
from mossar_adapters.zeromq.decoder import ZmqDecoder, ZmqMessage
from mossar_adapters.zeromq.endpoint import CURVE_OPTIONS, binds, bound_at, can_read, open_socket
from mossar_adapters.zeromq.guarded import GuardedContext
from mossar_stream import Frames

OPTIONS = {
    "fps": "rate in Hz for frames without a time of their own",
    "unit": "m, cm, mm or inch",
    "performer": "name of the performer",
    "topic": "subscribe to topics that begin with this; default all",
    **CURVE_OPTIONS,
}
POLL_MS = 100
DRAIN = 512  # messages read before their frames are handed on
_SKIPPING = 2.0  # s at most to discard waiting messages; a sender may be as quick as this
QUEUE = 4096  # messages kept by ZeroMQ while the program is busy; half a gigabyte at worst


class ZmqSource:
    """Receives frame and meta maps over ZeroMQ; implements `Source`.

    Args:
        address: `zmq://HOST:PORT`, `zmq+bind://HOST:PORT` or an `ipc:` form.
        options: The user's fps and unit.

    Raises:
        MossarError: If the socket cannot be had or an option is wrong.
    """

    live = True

    def __init__(self, address: Address, options: ReadOptions | None = None) -> None:
        address.check(OPTIONS)
        self.name = address.url
        self.decoder = ZmqDecoder(options, address.options.get("performer"))
        self.counters = self.decoder.counters
        self._context = GuardedContext()
        try:
            topic = address.options.get("topic", "").encode()
            wanted: dict[int, int | bytes] = {
                zmq.RCVHWM: QUEUE,
                zmq.RCVTIMEO: POLL_MS,
                zmq.SUBSCRIBE: topic,
            }
            self._socket = open_socket(self._context, zmq.SUB, address, wanted)
        except BaseException:
            self._context.term()
            raise
        self._binds = binds(address)
        self.endpoint = bound_at(self._socket)
        self._opened = time.monotonic()
        self._running = self._closed = False
        self._skipped = Skipped(self.counters)

    def skip_waiting(self) -> None:
        """Discard all messages before now; their number is logged."""
        end = self._now + _SKIPPING
        while self._now < end and (messages := list(self._waiting())):
            self._skipped.add(self.decoder.receive(*messages))
        self._skipped.log(self.name)

    def items(self) -> Iterator[Meta | Frames | Departure | None]:
        """Yield metas and chunks of frames as they come; None when nothing came for a tenth of a second."""
        self._running = True
        try:
            yield from self._skipped.kept
            while not self._closed:
                try:
                    parts = self._socket.recv_multipart()
                except zmq.Again:
                    yield from self.decoder.idle(self._now)
                    yield None
                    continue
                yield from self.decoder.receive(ZmqMessage(parts, self._now), *self._waiting())
            yield from self.decoder.idle(math.inf)
        finally:
            self._release()

    def explain(self) -> str:
        """Return one line: the bound or connected address, and the arrivals."""
        counters = self.counters
        text = f"{self.name}: {'bound at' if self._binds else 'connecting to'} {self.endpoint}"
        if counters.received == 0:
            hint = "" if self._binds else " (is the sender running, and does it bind?)"
            return f"{text}; no message came yet{hint}"
        text += f"; {counters.received} messages came, topics: {', '.join(counters.seen) or 'none'}"
        if counters.malformed:
            text += f"; {counters.malformed} malformed, the last: {counters.last_error}"
        return text if self.decoder.frames else f"{text}; none was a frame map (type: frame)"

    def close(self) -> None:
        """End `items` soon. May be called twice, and from any thread."""
        self._closed = True
        if not self._running:
            self._release()

    def _release(self) -> None:
        self._closed = True
        self._socket.close(0)
        self._context.term()

    @property
    def _now(self) -> float:
        """Seconds since the socket was opened."""
        return time.monotonic() - self._opened

    def _waiting(self) -> Iterator[ZmqMessage]:
        """Yield the waiting messages, at most `DRAIN`."""
        for _ in range(DRAIN):
            if not can_read(self._socket):
                return
            yield ZmqMessage(self._socket.recv_multipart(), self._now)
