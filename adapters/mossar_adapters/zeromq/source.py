"""The ZeroMQ source: SUB, connecting or binding.

Accepted are two parts, topic and a msgpack or JSON map, or a single JSON part. Events and stats that pass by
are left alone.
"""

import time
from collections.abc import Iterator, Sequence

import zmq

from mossar_adapters.address import Address
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Counters
from mossar_adapters.maps.codec import from_json, from_msgpack
from mossar_adapters.maps.decoder import MapIntake
from mossar_adapters.receiving.batch import Batch
from mossar_adapters.source import Left, Meta
from mossar_adapters.zeromq.endpoint import CURVE_OPTIONS, binds, bound_at, can_read, open_socket
from mossar_adapters.zeromq.guarded import GuardedContext
from mossar_stream.errors import FrameError
from mossar_stream.frames import Frames

OPTIONS = {
    "fps": "rate in Hz for frames without a time of their own",
    "unit": "m, cm, mm or inch",
    "performer": "name of the performer",
    "topic": "subscribe to topics that begin with this; default all",
    **CURVE_OPTIONS,
}
POLL_MS = 100
DRAIN = 512  # messages read before their frames are handed on
QUEUE = 4096  # messages kept by ZeroMQ while the program is busy; half a gigabyte at worst


class ZmqSource:
    """Receives frame and meta maps over ZeroMQ; implements `LiveSource`.

    Args:
        address: `zmq://HOST:PORT`, `zmq+bind://HOST:PORT` or an `ipc:` form.
        options: The user's fps and unit.

    Raises:
        MossarError: If the socket cannot be had or an option is wrong.
    """

    live = True

    def __init__(self, address: Address, options: ReadOptions | None = None) -> None:
        address.check(OPTIONS)
        options = options or ReadOptions()
        self.name = address.url
        self.counters = Counters()
        self._batch = Batch(options.fps)
        self._intake = MapIntake(self._batch, self.counters, options, address.options.get("performer"))
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
        self._running = False
        self._closed = False

    def items(self) -> Iterator[Meta | Frames | Left | None]:
        """Yield metas and chunks of frames as they come; None when nothing came for a tenth of a second."""
        self._running = True
        try:
            while not self._closed:
                try:
                    parts = self._socket.recv_multipart()
                except zmq.Again:
                    yield None
                    continue
                self.take(parts)
                self._drain()
                yield from self.collected()
        finally:
            self._release()

    def take(self, parts: Sequence[bytes]) -> None:
        """Use a message of one or more parts; `items` does so with those of the socket."""
        self.counters.received += 1
        try:
            self._use(parts)
        except FrameError as error:
            self.counters.reject(str(error))

    def collected(self) -> list[Meta | Frames | Left]:
        """Return what has come together since the last call."""
        return self._batch.take()

    def explain(self) -> str:
        """Return one line that says what is bound or connected and what came."""
        counters = self.counters
        text = f"{self.name}: {'bound at' if self._binds else 'connecting to'} {self.endpoint}"
        if counters.received == 0:
            hint = "" if self._binds else " (is the sender running, and does it bind?)"
            return f"{text}; no message came yet{hint}"
        text += f"; {counters.received} messages came, topics: {', '.join(counters.seen) or 'none'}"
        if counters.malformed:
            text += f"; {counters.malformed} malformed, the last: {counters.last_error}"
        return f"{text}; none was a frame map (type: frame)"

    def close(self) -> None:
        """End `items` soon. May be called twice, and from any thread."""
        self._closed = True
        if not self._running:
            self._release()

    def _release(self) -> None:
        self._closed = True
        self._socket.close(0)
        self._context.term()

    def _drain(self) -> None:
        for _ in range(DRAIN):
            if not can_read(self._socket):
                return
            self.take(self._socket.recv_multipart())

    def _use(self, parts: Sequence[bytes]) -> None:
        if len(parts) > 2:
            raise FrameError(
                f"a message of {len(parts)} parts; two (topic, map) or one (JSON) are understood"
            )
        if len(parts) == 2:
            self.counters.see(parts[0][:80].decode("utf-8", "replace"))
        data = parts[-1]
        found = from_json(data) if len(parts) == 1 or data.lstrip()[:1] == b"{" else from_msgpack(data)
        if found is None:
            self.counters.ignored += 1
        else:
            self._intake.take(found, time.monotonic() - self._opened)
