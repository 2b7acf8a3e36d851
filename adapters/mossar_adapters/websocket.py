"""A WebSocket server for browser games: every event as one JSON text frame.

It runs on a thread of its own. Each client has a bounded queue; messages that a slow client does not take are dropped
for that client and counted. Clients that join late get the metas of all performers first, and the state of each.
"""

import asyncio
from collections.abc import Awaitable, Sequence
from typing import TYPE_CHECKING

from mossar_adapters.address import Address
from mossar_adapters.extras import needed
from mossar_adapters.maps.codec import to_json
from mossar_adapters.maps.frame_maps import map_with_run
from mossar_adapters.maps.states import States
from mossar_adapters.newest import Newest
from mossar_adapters.source import Meta
from mossar_adapters.websocket_server import OPTIONS, WebSocketServer
from mossar_stream import Event
from mossar_stream import to_json as event_to_json

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

QUEUE = 1000  # messages waiting for one client
_METAS = 400  # performers whose metas are kept for late joiners; with their states less than a client's queue
_MAX_IN = 1024  # bytes; messages of clients are not used


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
        self.name = address.url
        self.dropped = 0
        self._metas: Newest[str, str] = Newest(_METAS)
        self._states = States()
        self._clients: set[_Client] = set()
        self._server = WebSocketServer(address, self._serve, self._emptied, max_in=_MAX_IN)
        self.port = self._server.port

    @property
    def clients(self) -> int:
        """Number of clients that are connected."""
        return len(self._clients)

    def announce(self, meta: Meta) -> None:
        """Send a performer's meta, and keep it for late joiners."""
        if not self._server.call(self._keep, meta, to_json(map_with_run(meta)).decode()):
            self.dropped += 1

    def send(self, events: Sequence[Event]) -> None:
        """Hand events to every client."""
        texts = [event_to_json(event).decode() for event in events]
        if texts and not self._server.call(self._pass_on, list(events), texts):
            self.dropped += 1

    def close(self) -> None:
        """Give clients a moment to take the rest, and release the port. May be called twice."""
        self._server.close()

    def _emptied(self) -> list[Awaitable[None]]:
        return [client.emptied() for client in self._clients]

    async def _serve(self, connection: "ServerConnection") -> None:
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


async def _discard(connection: "ServerConnection") -> None:
    """Read the messages of a client, so that they cannot pile up."""
    from websockets.exceptions import ConnectionClosed

    try:
        async for _ in connection:
            pass
    except ConnectionClosed:
        return
