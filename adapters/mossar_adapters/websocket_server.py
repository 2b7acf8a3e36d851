"""The WebSocket server under the sink and the source: a thread of its own, few connections, known pages only.

A browser lets any page connect to this computer and names the page: by default only pages of this computer
are served, and programs, which name no page.
"""

import asyncio
import errno
import logging
import re
import threading
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

from mossar_adapters.address import Address
from mossar_adapters.extras import needed
from mossar_stream import MossarError

if TYPE_CHECKING:
    from websockets.asyncio.server import Server, ServerConnection
    from websockets.http11 import Request, Response

OPTIONS = {
    "origin": "the only pages that may connect, as https://game.example; several separated by commas, * for all;"
    " default: pages of this computer"
}
MAX_CLIENTS = 64
MAX_WAITING = 64  # connections that have not asked for a WebSocket yet; beyond them the oldest is cut off
_LOCAL = re.compile(r"https?://(localhost|127\.0\.0\.1|\[::1\])(:\d{1,5})?")
_CLOSE = 0.5  # s for the closing handshake of clients
_DRAIN = 0.25  # s that clients have to take the last messages
Serve = Callable[["ServerConnection"], Awaitable[None]]
Drain = Callable[[], list[Awaitable[None]]]
Answer = Callable[["ServerConnection", "Request"], "Awaitable[Response | None] | Response | None"]


class WebSocketServer:
    """Listens on a thread of its own.

    Args:
        address: `HOST:PORT` and the option `origin`. Port 0 takes a free one.
        serve: Called on the server's thread for each client; when it returns, the connection is closed.
        drain: Called on it before the connections are closed; the server waits for it for a moment.
        max_in: Bytes of the longest message that clients may send.
        answer: Called with each request; returns an answer that is no WebSocket, such as a page or a refusal, or None to let
            the client in. By default it refuses pages by the option `origin`.
        patience: Seconds that an answer may take to arrive, and for the closing handshake.

    Attributes:
        port: Where it listens.

    Raises:
        MossarError: If the port cannot be had or the extra `web` is not installed.
    """

    def __init__(
        self,
        address: Address,
        serve: Serve,
        drain: Drain = list,
        *,
        max_in: int,
        answer: Answer | None = None,
        patience: float = _CLOSE,
    ) -> None:
        needed("websockets", "web", address.url)
        if address.path not in {"", "/"}:
            raise address.error(f"there is no path in it: {address.scheme}://HOST:PORT")
        self.port = address.required_port()
        self._address, self._serve_client, self._drain, self._max_in = address, serve, drain, max_in
        self._answer, self._patience = answer or self._refusal, patience
        self._clients: set[ServerConnection] = set()
        self._waiting: dict[Any, None] = {}  # transports of those that have not asked yet, the oldest first
        self._loop = asyncio.new_event_loop()
        self._stop = asyncio.Event()
        self._started = threading.Event()
        self._error: OSError | None = None
        self._thread = threading.Thread(target=self._run, name=address.url, daemon=True)
        self._thread.start()
        self._started.wait()
        if self._error is not None:
            self._thread.join()
            raise MossarError(f"{address.url}: {_why(self._error, address)}")

    @property
    def clients(self) -> int:
        """Number of clients that are connected."""
        return len(self._clients)

    def call(self, function: Any, *arguments: Any) -> bool:
        """Call a function on the server's thread, soon; False if that has ended."""
        try:
            self._loop.call_soon_threadsafe(function, *arguments)
        except RuntimeError:  # the loop has ended
            return False
        return True

    def close(self) -> None:
        """Give clients a moment to take the rest, and release the port. May be called twice."""
        self.call(self._stop.set)
        self._thread.join(2 * _CLOSE + _DRAIN)

    def connection_made(self, transport: Any) -> None:
        """Note a connection; called by the server's thread."""
        self._waiting[transport] = None
        if len(self._waiting) > MAX_WAITING:
            oldest = next(iter(self._waiting))
            del self._waiting[oldest]
            oldest.abort()

    def connection_lost(self, transport: Any) -> None:
        """Forget a connection that has ended, or has become a client."""
        self._waiting.pop(transport, None)

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
        """End the tasks that still wait for clients."""
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
            process_request=self._answer,
            create_connection=_counted_by(self),
            max_size=self._max_in,
            close_timeout=self._patience,
            compression=None,
            logger=_logger(),
        )
        self.port = next(iter(server.sockets)).getsockname()[1]
        self._started.set()
        await self._stop.wait()
        waiting = self._drain()
        if waiting:
            _, late = await asyncio.wait([asyncio.ensure_future(task) for task in waiting], timeout=_DRAIN)
            for task in late:
                task.cancel()
        server.close()
        # A client that has not even asked for a WebSocket would delay this much longer.
        await asyncio.wait([asyncio.ensure_future(server.wait_closed())], timeout=_CLOSE)
        for transport in (*self._waiting, *(client.transport for client in self._clients)):
            transport.abort()  # or the other end would wait for ours for ever
        await asyncio.sleep(0)

    def _refusal(self, connection: "ServerConnection", request: "Request") -> "Response | None":
        """Return an answer that refuses a page, None for allowed ones."""
        origins = request.headers.get_all("Origin")
        if all(is_allowed(origin, self._address.options.get("origin")) for origin in origins):
            return None
        return connection.respond(HTTPStatus.FORBIDDEN, "this page may not connect; see the option origin\n")

    async def _client(self, connection: "ServerConnection") -> None:
        self.connection_lost(connection.transport)
        if len(self._clients) >= MAX_CLIENTS:
            await connection.close(1013, "too many clients")
            return
        self._clients.add(connection)
        try:
            await self._serve_client(connection)
        finally:
            self._clients.discard(connection)


def _counted_by(server: WebSocketServer) -> Any:
    """Return the class of connections that report to the server as soon as they are made.

    A silent client occupies a descriptor all the same, and a process has few.
    """
    from websockets.asyncio.server import ServerConnection

    class Counted(ServerConnection):
        def connection_made(self, transport: asyncio.BaseTransport) -> None:
            super().connection_made(transport)
            server.connection_made(transport)

        def connection_lost(self, exc: Exception | None) -> None:
            server.connection_lost(self.transport)
            super().connection_lost(exc)

    return Counted


class _Strangers(logging.Filter):
    """Drops the log messages about clients that speak another protocol or disconnect: port scanners, browsers."""

    def filter(self, record: logging.LogRecord) -> bool:
        from websockets.exceptions import WebSocketException

        error = record.exc_info[1] if record.exc_info else None
        return not isinstance(error, WebSocketException | OSError | EOFError)


_STRANGERS = _Strangers()


def _logger() -> logging.Logger:
    logger = logging.getLogger("websockets.mossar")
    logger.addFilter(_STRANGERS)
    return logger


def is_allowed(origin: str, named: str | None) -> bool:
    """Return whether a page may connect.

    Args:
        origin: The browser's header: scheme and host of the page, `null` for files.
        named: Pages that the user named, separated by commas; None if none were.

    Example:
        >>> is_allowed("http://localhost:8000", None), is_allowed("https://evil.example", None)
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
