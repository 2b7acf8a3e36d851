"""Server: viser's, closed to pages of other sites and to devices that were not invited.

A browser lets any site open a WebSocket to 127.0.0.1; only the `Origin` that it sends distinguishes such a site from our own
page. viser 1.1 has no hook to look at it, and a server before it would leave viser's own port open. So the function that
it serves with is replaced while it starts, for viser's call alone.
"""

import asyncio
import logging
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from http import HTTPStatus
from typing import Any

import viser
import websockets.asyncio.server

from mossar_tools.console import LOGGER
from mossar_tools.dashboard.asking import HEADER
from mossar_tools.dashboard.visitors import Visitors
from mossar_tools.errors import UsageError

_Asked = Callable[[Any, Any], Any]
Answers = Mapping[str, Callable[[str], None]]
_starting = threading.Lock()  # each start puts the function back that it found


def open_server(host: str, port: int, answers: Answers, visitors: Visitors) -> viser.ViserServer:
    """Return a server.

    Args:
        host: Address of this computer where it listens.
        port: Port; the next free one if it is in use, 0 for any.
        answers: Requests of the page's own parts, by path; called with the text behind the question mark.
        visitors: The admitted visitors.

    Raises:
        UsageError: If the host is no address of this computer, for which viser would wait without a word.
    """
    _check_host(host)
    with _starting, _guarded(answers, visitors):
        return viser.ViserServer(host=host, port=port, label="mossar", verbose=False)


def _check_host(host: str) -> None:
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        socket.create_server((host, 0), family=family).close()
    except OSError:
        raise UsageError(
            f"--host {host[:80]}: it is not an address of this computer; 0.0.0.0 listens on all of them"
        ) from None


@contextmanager
def _guarded(answers: Answers, visitors: Visitors) -> Iterator[None]:
    """Have viser's servers that start meanwhile ask where each visitor comes from."""
    serve = websockets.asyncio.server.serve

    def serving(*arguments: Any, process_request: _Asked | None = None, **options: Any) -> Any:
        if getattr(process_request, "__module__", "").partition(".")[0] == viser.__name__:
            asyncio.get_running_loop().set_exception_handler(_note_visitor)
            process_request = _guard(process_request, answers, visitors)
            options["logger"] = _quiet()
        return serve(*arguments, process_request=process_request, **options)

    websockets.asyncio.server.serve = serving  # type: ignore[assignment, misc]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]


def _quiet() -> logging.Logger:
    """Return a logger that drops the errors of visitors, who get an answer and are disconnected."""
    logger = logging.getLogger("mossar.visitors")
    logger.setLevel(logging.CRITICAL)
    return logger


def _note_visitor(_: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Log an invalid value that a visitor sends for a control: one line at level debug, instead of a traceback."""
    LOGGER.debug("the dashboard: %s: %s", context.get("message"), context.get("exception"))


def _guard(then: Any, answers: Answers, visitors: Visitors) -> _Asked:
    def process_request(connection: Any, request: Any) -> Any:
        refusal = visitors.refusal(connection, request)
        if refusal is not None:
            return refusal
        path, _, value = request.path.partition("?")
        if path.removeprefix("/") in answers:
            if request.headers.get(HEADER) is None or not visitors.asks_from_the_page(connection, request):
                return connection.respond(
                    HTTPStatus.FORBIDDEN, "The dashboard answers to pages of its own only.\n"
                )
            return _answer(connection, answers[path.removeprefix("/")], value)
        return then(connection, request)

    return process_request


def _answer(connection: Any, answer: Callable[[str], None], value: str) -> Any:
    """Carry out a request of a part of the page."""
    try:
        answer(value)
    except ValueError:
        return connection.respond(HTTPStatus.BAD_REQUEST, "That is no number.\n")
    return connection.respond(HTTPStatus.OK, "")
