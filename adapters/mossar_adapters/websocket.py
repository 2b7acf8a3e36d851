"""A WebSocket server for browser games: every event as one JSON text frame.

It runs on a thread of its own. Each client has a bounded queue; what a slow client does not take is dropped
for that client and counted. Clients that join late get the metas of all performers first, and where each stands.

A browser lets any page connect to this computer and says which page it is: by default only pages of this computer
are served, and programs, which name no page.
"""

import asyncio
import errno
import logging
import re
import threading
from collections.abc import Sequence
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

from mossar_adapters.address import Address
from mossar_adapters.extras import needed
from mossar_adapters.maps.codec import to_json
from mossar_adapters.maps.frame_maps import map_with_run
from mossar_adapters.maps.states import States
from mossar_adapters.source import Meta
from mossar_stream import Event, MossarError
from mossar_stream import to_json as event_to_json

if TYPE_CHECKING:
    from websockets.asyncio.server import Server, ServerConnection
    from websockets.http11 import Request, Response

OPTIONS = {
    "origin": "the only pages that may connect, as https://game.example; several separated by commas, * for all;"
    " default: pages of this computer"
}
QUEUE = 1000  # messages waiting for one client
MAX_CLIENTS = 64
MAX_WAITING = 64  # connections that have not asked for a WebSocket yet; beyond them the oldest is cut off
_METAS = 400  # performers whose metas are kept for late joiners; with their states less than a client's queue
_MAX_IN = 1024  # bytes; what clients send is not used
_LOCAL = re.compile(r"https?://(localhost|127\.0\.0\.1|\[::1\])(:\d{1,5})?")
_CLOSE = 0.5  # s that clients have to say goodbye
_DRAIN = 0.25  # s that clients have to take the last messages


class WebSocketSink:
    """Serves events to browsers; implements `Sink`.

    Args:
        address: `ws://HOST:PORT`; option `origin`. Port 0 takes a free one.

    Raises:
        MossarError: If the port cannot be had, an option is wrong or the extra `web` is not installed.
    """

    prompt = True

    def __init__(self, address: Address) -> None:
        needed("websockets", "web", address.url)
        address.check(OPTIONS)
        if address.path not in {"", "/"}:
            raise address.error("there is no path in it: ws://HOST:PORT")
        self.name = address.url
        self.dropped = 0
        self.port = address.required_port()
        self._address = address
        self._metas: dict[str, str] = {}
        self._states = States()
        self._clients: set[_Client] = set()
        self._waiting: dict[Any, None] = {}  # transports of those that have not asked yet, the oldest first
        self._loop = asyncio.new_event_loop()
        self._stop = asyncio.Event()
        self._started = threading.Event()
        self._error: OSError | None = None
        self._thread = threading.Thread(target=self._run, name=self.name, daemon=True)
        self._thread.start()
        self._started.wait()
        if self._error is not None:
            self._thread.join()
            raise MossarError(f"{self.name}: {_why(self._error, address)}")

    @property
    def clients(self) -> int:
        """Number of clients that are connected."""
        return len(self._clients)

    def announce(self, meta: Meta) -> None:
        """Send a performer's meta, and keep it for late joiners."""
        self._call(self._keep, meta, to_json(map_with_run(meta)).decode())

    def send(self, events: Sequence[Event]) -> None:
        """Hand events to every client."""
        texts = [event_to_json(event).decode() for event in events]
        if texts:
            self._call(self._pass_on, list(events), texts)

    def close(self) -> None:
        """Give clients a moment to take what is left, and release the port. May be called twice."""
        self._call(self._stop.set)
        self._thread.join(2 * _CLOSE + _DRAIN)

    def arrived(self, transport: Any) -> None:
        """Take note of a connection; called by the server's thread."""
        self._waiting[transport] = None
        if len(self._waiting) > MAX_WAITING:
            oldest = next(iter(self._waiting))
            del self._waiting[oldest]
            oldest.abort()

    def went(self, transport: Any) -> None:
        """Forget a connection that has ended, or has become a client."""
        self._waiting.pop(transport, None)

    def _call(self, function: Any, *arguments: Any) -> None:
        try:
            self._loop.call_soon_threadsafe(function, *arguments)
        except RuntimeError:  # the loop has ended
            self.dropped += 1 if arguments else 0

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve())
        except OSError as error:
            self._error = error
        finally:
            self._started.set()
            self._leave()
            self._loop.close()

    def _leave(self) -> None:
        """End what still waits for clients."""
        waiting = asyncio.all_tasks(self._loop)
        for task in waiting:
            task.cancel()
        self._loop.run_until_complete(asyncio.gather(*waiting, return_exceptions=True))

    async def _serve(self) -> None:
        from websockets.asyncio.server import serve

        server: Server = await serve(
            self._client,
            self._address.host or "127.0.0.1",
            self._address.port,
            process_request=self._refusal,
            create_connection=_counted_by(self),
            max_size=_MAX_IN,
            close_timeout=_CLOSE,
            compression=None,
            logger=_logger(),
        )
        self.port = next(iter(server.sockets)).getsockname()[1]
        self._started.set()
        await self._stop.wait()
        waiting = [client.emptied() for client in self._clients]
        if waiting:
            _, late = await asyncio.wait([asyncio.ensure_future(task) for task in waiting], timeout=_DRAIN)
            for task in late:
                task.cancel()
        server.close()
        # Whoever has not even asked yet for a WebSocket would be waited for much longer.
        await asyncio.wait([asyncio.ensure_future(server.wait_closed())], timeout=_CLOSE)
        for transport in (*self._waiting, *(client.connection.transport for client in self._clients)):
            transport.abort()  # or the other end would wait for ours for ever
        await asyncio.sleep(0)

    def _refusal(self, connection: "ServerConnection", request: "Request") -> "Response | None":
        """Return an answer that refuses a page, None for those that are welcome."""
        origins = request.headers.get_all("Origin")
        if all(welcome(origin, self._address.options.get("origin")) for origin in origins):
            return None
        return connection.respond(HTTPStatus.FORBIDDEN, "this page may not connect; see the option origin\n")

    async def _client(self, connection: "ServerConnection") -> None:
        self.went(connection.transport)
        if len(self._clients) >= MAX_CLIENTS:
            await connection.close(1013, "too many clients")
            return
        client = _Client(connection)
        for text in (*self._metas.values(), *(to_json(state).decode() for state in self._states)):
            client.offer(text)
        self._clients.add(client)
        pump = asyncio.ensure_future(client.pump())
        try:
            await _discard(connection)  # ends with the connection
        finally:
            pump.cancel()
            self._clients.discard(client)

    def _keep(self, meta: Meta, text: str) -> None:
        self._states.announce(meta)
        self._metas.pop(meta.performer, None)
        if len(self._metas) == _METAS:
            del self._metas[next(iter(self._metas))]
        self._metas[meta.performer] = text
        self._spread([text])

    def _pass_on(self, events: Sequence[Event], texts: Sequence[str]) -> None:
        self._states.follow(events)
        self._spread(texts)

    def _spread(self, texts: Sequence[str]) -> None:
        for client in self._clients:
            for text in texts:
                if not client.offer(text):
                    self.dropped += 1


def _counted_by(sink: WebSocketSink) -> Any:
    """Return what makes connections that tell the sink of themselves before they have said a word.

    Whoever connects and says nothing has a descriptor all the same, and those of a process are few.
    """
    from websockets.asyncio.server import ServerConnection

    class Counted(ServerConnection):
        def connection_made(self, transport: asyncio.BaseTransport) -> None:
            super().connection_made(transport)
            sink.arrived(transport)

        def connection_lost(self, exc: Exception | None) -> None:
            sink.went(self.transport)
            super().connection_lost(exc)

    return Counted


class _Client:
    """The messages that wait for one client."""

    def __init__(self, connection: "ServerConnection") -> None:
        self.connection = connection
        self._queue: asyncio.Queue[str] = asyncio.Queue(QUEUE)

    def offer(self, text: str) -> bool:
        try:
            self._queue.put_nowait(text)
        except asyncio.QueueFull:
            return False
        return True

    async def pump(self) -> None:
        from websockets.exceptions import ConnectionClosed

        try:
            while True:
                await self.connection.send(await self._queue.get())
                self._queue.task_done()
        except ConnectionClosed:
            return

    async def emptied(self) -> None:
        await self._queue.join()


class _Strangers(logging.Filter):
    """Keeps quiet about those who connect and speak something else: port scanners, browsers that go away."""

    def filter(self, record: logging.LogRecord) -> bool:
        from websockets.exceptions import WebSocketException

        error = record.exc_info[1] if record.exc_info else None
        return not isinstance(error, WebSocketException | OSError | EOFError)


_STRANGERS = _Strangers()


def _logger() -> logging.Logger:
    logger = logging.getLogger("websockets.mossar")
    logger.addFilter(_STRANGERS)
    return logger


async def _discard(connection: "ServerConnection") -> None:
    """Read what a client sends, so that it cannot pile up."""
    from websockets.exceptions import ConnectionClosed

    try:
        async for _ in connection:
            pass
    except ConnectionClosed:
        return


def welcome(origin: str, named: str | None) -> bool:
    """Return whether a page may connect.

    Args:
        origin: What the browser says: scheme and host of the page, `null` for files.
        named: Pages that the user named, separated by commas; None if none were.

    Example:
        >>> welcome("http://localhost:8000", None), welcome("https://evil.example", None)
        (True, False)
    """
    if named is not None:
        return "*" in named.split(",") or origin in {page.strip() for page in named.split(",")}
    return origin == "null" or _LOCAL.fullmatch(origin) is not None


def _why(error: OSError, address: Address) -> str:
    if error.errno == errno.EADDRINUSE:
        return f"port {address.port} is in use; close the program that has it, or take another port"
    if error.errno == errno.EADDRNOTAVAIL:
        return f"{address.host} is not an address of this computer"
    return f"cannot serve: {error.strerror or error}"
