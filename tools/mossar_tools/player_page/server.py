"""Server of the page: a few files, and a line to each window, for this computer and invited devices.

One thread serves all windows. Connections, windows and messages are bounded as those of every WebSocket here. Each window gets
the newest state only, when it asks for it: a slow one sees fewer pictures, and nothing piles up. More orders of a window than
a person clicks are ignored.
"""

import asyncio
import json
import math
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

import msgspec

from mossar_adapters.address import Address
from mossar_adapters.extras import needed
from mossar_adapters.websocket_server import WebSocketServer
from mossar_stream import MossarError
from mossar_tools.console import LOGGER
from mossar_tools.dashboard.visitors import HERE, Visitors, is_loopback
from mossar_tools.player_page.content import KINDS, Content, own_files, policy
from mossar_tools.player_page.eye import Eye

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

PORT: Final = 8080
LINE: Final = "/live"
DASHBOARD: Final = "/dashboard"
_MAX_IN: Final = 1024  # bytes of a window's request
_PATIENCE: Final = 10.0  # s that a file may take to arrive
_TRIED: Final = 20  # ports, from the one that is wanted
_AT_ONCE: Final = 16  # orders that a window may give besides `next`: more than a person clicks
_A_SECOND: Final = 8.0  # further orders
_WAITS: Final = b"This page is starting; load it again in a moment.\n"
Say = dict[str, Any]


class Asked(msgspec.Struct, forbid_unknown_fields=True):
    """A request of a window.

    Args:
        do: `next` for the next state, `teach`, `cancel`, `keep`, `undo`, `forget`, `again`.
        name: Of the move to teach.
        place: Of the example to forget, from 0.
        mark: Of the same, see `dashboard.teaching.mark_of`.
    """

    do: str
    name: str = ""
    place: int = -1
    mark: str = ""


class Window:
    """A window that shows the page; used by the server's thread alone.

    Args:
        connection: Its line.
        is_here: Whether it is on this computer, and may show pictures of the camera.
    """

    def __init__(self, connection: "ServerConnection", *, is_here: bool) -> None:
        self.is_here = is_here
        self._connection = connection
        self._newest: bytes | str | None = None
        self._wants = False
        self._wake = asyncio.Event()
        self._left, self._ordered = float(_AT_ONCE), -math.inf  # orders; s, when the latest was given

    def offer(self, message: bytes | str) -> None:
        """Replace the message that waits for the window."""
        self._newest = message
        self._wake.set()

    def ask(self) -> None:
        """Note that the window has shown its last message."""
        self._wants = True
        self._wake.set()

    def may_order(self, now: float) -> bool:
        """Return whether the window may give an order now, s: orders wait for each other, and those of other windows, too."""
        self._left = min(_AT_ONCE, self._left + _A_SECOND * (now - self._ordered))
        self._ordered = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True

    async def pump(self) -> None:
        """Send the newest state whenever the window wants one."""
        from websockets.exceptions import ConnectionClosed

        try:
            while True:
                await self._wake.wait()
                self._wake.clear()
                if self._wants and self._newest is not None:
                    message, self._newest, self._wants = self._newest, None, False
                    await self._connection.send(message)
        except ConnectionClosed:
            return


class PlayerServer:
    """Serves the page until it is closed; `attach` sets its content.

    Args:
        port: Where; the next free one if it is in use, 0 for any.
        host: Address of this computer where it listens; other devices then need a URL that serves once.
        eye: The camera of the browser, if that is the sensor.
        dark: Whether to begin in dark.
        mirrored: Whether bodies are shown as in a mirror.

    Raises:
        MossarError: If no port can be had, or the extra `web` is not installed.
    """

    def __init__(
        self,
        port: int = PORT,
        host: str = HERE,
        *,
        eye: Eye | None = None,
        dark: bool = False,
        mirrored: bool = False,
    ) -> None:
        needed("websockets", "web", "the page")
        self.visitors = Visitors(host, _tell_invitation)
        self._eye, self._about = eye, {"dark": dark, "mirrored": mirrored}
        self._windows: dict[Window, None] = {}
        self._hear: Callable[[Asked], None] | None = None  # None until there is something to show
        self._examples: Content = lambda: b"[]"
        self._open_dashboard: Callable[[], int] | None = None
        self._files = own_files()
        self._server = self._opened(host, port)
        self.port = self._server.port
        if port not in (0, self.port):
            LOGGER.info("port %d is in use; the page took %d", port, self.port)
        self.url = f"http://{HERE}:{self.port}/"

    @property
    def windows(self) -> int:
        """Number of windows that show the page."""
        return len(self._windows)

    def attach(
        self, hear: Callable[[Asked], None], examples: Content, open_dashboard: Callable[[], int] | None
    ) -> None:
        """Show something.

        Args:
            hear: Carries out a request of a window; called by the server's thread, so it must return at once.
            examples: Returns the taught examples as JSON.
            open_dashboard: Opens the dashboard, if that was not done, and returns its port; None if there is none.
        """
        self._examples, self._open_dashboard = examples, open_dashboard
        self._hear = hear
        LOGGER.info("the page is at %s", self.url)
        if self.visitors.admits_others:
            _tell_invitation(self.visitors.invitation(self.port))

    def spread(self, text: str, picture: bytes | None = None) -> None:
        """Hand a state over to all windows.

        Args:
            text: Of windows elsewhere, and of those here without a picture.
            picture: Of windows on this computer.
        """
        self._server.call(self._offer, text, picture)

    def close(self) -> None:
        """Release the port. May be called twice."""
        self._server.close()

    def _opened(self, host: str, port: int) -> WebSocketServer:
        """Return a server at a port, or the next free one."""
        for number in range(port, port + (_TRIED if port else 1)):
            address = Address(f"the page at port {number}", "http", host, number)
            try:
                return WebSocketServer(
                    address, self._serve, max_in=_MAX_IN, answer=self._answer, patience=_PATIENCE
                )
            except MossarError as error:
                failure = error
                if "is in use" not in str(error):
                    break
        raise failure

    def _offer(self, text: str, picture: bytes | None) -> None:
        for window in self._windows:
            window.offer(picture if window.is_here and picture is not None else text)

    async def _serve(self, connection: "ServerConnection") -> None:
        from websockets.exceptions import ConnectionClosed

        window = Window(connection, is_here=is_loopback(connection.remote_address[0]))
        self._windows[window] = None
        pump = asyncio.ensure_future(window.pump())
        try:
            async for message in connection:
                self._listen(window, message)
        except ConnectionClosed:
            return
        finally:
            pump.cancel()
            del self._windows[window]

    def _listen(self, window: Window, message: str | bytes) -> None:
        try:
            asked = msgspec.json.decode(message, type=Asked)
        except msgspec.DecodeError:
            return  # no page of ours sends such a thing
        if asked.do == "next":
            window.ask()
        elif self._hear is not None and window.may_order(asyncio.get_running_loop().time()):
            self._hear(asked)

    def _answer(
        self, connection: "ServerConnection", request: "Request"
    ) -> "Awaitable[Response | None] | Response | None":
        """Return an answer to a request; None for a window that asks for its line."""
        refusal: Response | None = self.visitors.refusal(connection, request)
        if refusal is not None:
            return refusal
        path, host = request.path.partition("?")[0], request.headers.get("Host", "")
        origins = request.headers.get_all("Origin")
        if not self.visitors.asks_from_the_page(connection, request) or any(
            origin != f"http://{host}" for origin in origins
        ):
            return self._respond(HTTPStatus.FORBIDDEN, b"This page answers to itself only.\n")
        if path == LINE:
            return None
        if path == DASHBOARD:
            return self._to_dashboard(host)
        return self._file(path, is_here=is_loopback(connection.remote_address[0]))

    def _file(self, path: str, *, is_here: bool) -> "Response":
        """Return a file of the page; the browser's camera is for windows on this computer."""
        if self._hear is None and path in {"/", "/about.json"}:
            return self._respond(HTTPStatus.SERVICE_UNAVAILABLE, _WAITS)
        eye = self._eye if is_here else None
        if path == "/about.json":
            about = {
                **self._about,
                "here": is_here,
                "dashboard": self._open_dashboard is not None,
                "eye": None if eye is None else eye.about,
            }
            return self._respond(HTTPStatus.OK, json.dumps(about).encode(), ".json")
        if path == "/examples.json":
            return self._respond(HTTPStatus.OK, self._examples(), ".json")
        found = self._files.get(path) or (eye.files.get(path) if eye is not None else None)
        if found is None:
            return self._respond(HTTPStatus.NOT_FOUND, b"There is no such page.\n")
        return self._respond(HTTPStatus.OK, found(), PurePath(path).suffix or ".html")

    async def _to_dashboard(self, host: str) -> "Response":
        """Open the dashboard, and send the browser there."""
        if self._open_dashboard is None:
            return self._respond(HTTPStatus.NOT_FOUND, b"The dashboard needs: pip install viser\n")
        try:
            port = await asyncio.get_running_loop().run_in_executor(None, self._open_dashboard)
        except MossarError as error:
            return self._respond(HTTPStatus.SERVICE_UNAVAILABLE, f"{error}\n".encode())
        answer = self._respond(HTTPStatus.SEE_OTHER, b"")
        answer.headers["Location"] = f"http://{host.rpartition(':')[0] or host}:{port}/"
        return answer

    def _respond(self, status: HTTPStatus, body: bytes, kind: str = ".txt") -> "Response":
        from websockets.datastructures import Headers
        from websockets.http11 import Response

        headers = Headers(
            {
                "Content-Type": KINDS[kind],
                "Content-Length": str(len(body)),
                "Content-Security-Policy": policy(() if self._eye is None else (self._eye.line,)),
                "X-Content-Type-Options": "nosniff",
                "Referrer-Policy": "no-referrer",
                "Cache-Control": "no-cache",
                "Connection": "close",
            }
        )
        return Response(status.value, status.phrase, headers, body)


def _tell_invitation(url: str) -> None:
    LOGGER.info("the page for one other device, which this URL lets in once: %s", url)
