"""Frames over a WebSocket that listens: pages and programs connect and send JSON, `ws+bind://127.0.0.1:8766`.

A message is a frame or meta map, as over ZeroMQ (`maps.frame_maps`). A performer's name belongs to the connection that
sends it (`receiving.owners`). The performers of a page leave with it.
"""

import math
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, NamedTuple

from mossar_adapters.address import Address
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Counters, Skipped
from mossar_adapters.maps.codec import from_json
from mossar_adapters.maps.intake import MapIntake
from mossar_adapters.receiving.fair_queue import FairQueue
from mossar_adapters.source import Departure, Meta
from mossar_adapters.websocket_server import OPTIONS as SERVER_OPTIONS
from mossar_adapters.websocket_server import WebSocketServer
from mossar_stream import FrameError, Frames

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

OPTIONS: Final = {
    "fps": "rate in Hz for frames without a time of their own",
    "unit": "m, cm, mm or inch",
    "performer": "name of the performer",
    **SERVER_OPTIONS,
}
MAX_MESSAGE: Final = 128 << 10  # bytes, as over ZeroMQ
QUEUE: Final = 4096  # messages that wait to be read; then the oldest of the client with most go
DRAIN: Final = 512  # messages read before their frames are handed on
_IDLE: Final = 0.1  # s without a message after which the reader gets None
GONE: Final = "disconnected"  # reason of takes that end because the sender went away


class Message(NamedTuple):
    """A message of a client: its number, the text, None when it went away, and the time, s."""

    client: int
    text: bytes | None
    arrival: float


class WebSocketCounters(Counters):
    """The received messages; see `Counters`.

    Args:
        late: Messages dropped because they were not read in time.
    """

    late: int = 0


class WebSocketSource:
    """Receives frame and meta maps over WebSockets; implements `Source`.

    Args:
        address: `ws+bind://HOST:PORT`; port 0 takes a free one.
        options: The user's fps and unit.

    Raises:
        MossarError: If the port cannot be had, an option is wrong or the extra `web` is not installed.
    """

    live = True

    def __init__(self, address: Address, options: ReadOptions | None = None) -> None:
        address.check(OPTIONS)
        self.name = address.url
        self.counters = WebSocketCounters()
        self._intake = MapIntake(self.counters, options, address.options.get("performer"))
        self._inbox: FairQueue[Message] = FairQueue(QUEUE)
        self._connected = 0
        self._opened = time.monotonic()
        self._closed = False
        self._skipped = Skipped(self.counters)
        self._server = WebSocketServer(address, self._serve, max_in=MAX_MESSAGE)
        self.port = self._server.port

    def skip_waiting(self) -> None:
        """Begin `items` with the next message; the number of discarded ones is logged."""
        for _ in range(QUEUE):
            message = self._inbox.get(0)
            if message is None:
                break
            self._receive(message)
        self._skipped.add(self._intake.batch.take())
        self._skipped.log(self.name)

    def items(self) -> Iterator[Meta | Frames | Departure | None]:
        """Yield metas, chunks of frames and departures; None when nothing came for a tenth of a second."""
        yield from self._skipped.kept
        while not self._closed:
            message = self._inbox.get(_IDLE)
            if message is None:
                yield from self._intake.batch.take(time.monotonic() - self._opened)
                yield None
                continue
            self._receive(message)
            for _ in range(DRAIN):
                message = self._inbox.get(0)
                if message is None:
                    break
                self._receive(message)
            yield from self._intake.batch.take()
        yield from self._intake.batch.take(math.inf)

    def explain(self) -> str:
        """Return one line: the bound address, and the arrivals."""
        counters = self.counters
        text = f"{self.name}: listening at port {self.port}; {self._server.clients} connected"
        if not self._connected:
            return f"{text}; no client has connected yet"
        text += f", {counters.received} messages came"
        if counters.malformed:
            return f"{text}; {counters.malformed} malformed, the last: {counters.last_error}"
        return (
            f"{text}; none was a frame map (type: frame)" if counters.received == counters.ignored else text
        )

    def close(self) -> None:
        """Release the port; `items` ends soon. May be called twice, and from any thread."""
        self._closed = True
        self._server.close()

    async def _serve(self, connection: "ServerConnection") -> None:
        from websockets.exceptions import ConnectionClosed

        self._connected += 1
        client = self._connected
        try:
            async for message in connection:
                self._put(client, message.encode() if isinstance(message, str) else message)
        except ConnectionClosed:
            pass
        finally:
            self._put(client, None)

    def _put(self, client: int, text: bytes | None) -> None:
        message = Message(client, text, time.monotonic() - self._opened)
        self.counters.late += self._inbox.put(client, message)

    def _receive(self, message: Message) -> None:
        if message.text is None:
            self._intake.leave(str(message.client), GONE)
            return
        self.counters.received += 1
        try:
            found = from_json(message.text)
            if found is not None:
                self.counters.see(found.type)
            self._intake.put(found, message.arrival, str(message.client))
        except FrameError as error:
            self.counters.reject(str(error))
