"""Server: viser's, bound to this computer and closed to pages of other sites.

A browser lets any site open a WebSocket to 127.0.0.1; only the `Origin` that it sends tells such a site from our own
page. viser has no option to look at it, so the function that it serves with is wrapped while it starts.
"""

import logging
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from http import HTTPStatus
from typing import Any

import websockets.asyncio.server
from viser import ViserServer

from mossar_tools.dashboard.asking import HEADER

_OURS = re.compile(r"https?://(127\.0\.0\.1|localhost|\[::1\])(:\d+)?")  # any port: it may be forwarded
_Asked = Callable[[Any, Any], Any]
Answers = Mapping[str, Callable[[str], None]]


def open_server(port: int, answers: Answers) -> ViserServer:
    """Return a server on this computer.

    Args:
        port: Where; the next free one if it is in use, 0 for any.
        answers: What the page's own parts may ask for, by path; called with what stands behind the question mark.
    """
    with _guarded(answers):
        return ViserServer(host="127.0.0.1", port=port, label="mossar", verbose=False)


@contextmanager
def _guarded(answers: Answers) -> Iterator[None]:
    """Have servers that start meanwhile ask where each visitor comes from."""
    serve = websockets.asyncio.server.serve

    def serving(*arguments: Any, process_request: _Asked | None = None, **options: Any) -> Any:
        return serve(*arguments, process_request=_guard(process_request, answers), logger=_quiet(), **options)

    websockets.asyncio.server.serve = serving  # type: ignore[assignment, misc]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]


def _quiet() -> logging.Logger:
    """Return a logger that keeps to itself what visitors do wrong; they are told, and hung up on."""
    logger = logging.getLogger("mossar.visitors")
    logger.setLevel(logging.CRITICAL)
    return logger


def _guard(then: _Asked | None, answers: Answers) -> _Asked:
    def process_request(connection: Any, request: Any) -> Any:
        origin = request.headers.get("Origin")  # programs that are no browsers send none
        if origin is not None and not _OURS.fullmatch(origin):
            return connection.respond(
                HTTPStatus.FORBIDDEN, "The dashboard answers to pages of its own only.\n"
            )
        path, _, value = request.path.partition("?")
        if path.removeprefix("/") in answers:
            return _answer(connection, request, answers[path.removeprefix("/")], value)
        return None if then is None else then(connection, request)

    return process_request


def _answer(connection: Any, request: Any, answer: Callable[[str], None], value: str) -> Any:
    """Do what a part of the page asks for."""
    host = request.headers.get("Host", "")
    if request.headers.get(HEADER) is None or not _OURS.fullmatch(f"http://{host}"):
        return connection.respond(HTTPStatus.FORBIDDEN, "The dashboard answers to pages of its own only.\n")
    try:
        answer(value)
    except ValueError:
        return connection.respond(HTTPStatus.BAD_REQUEST, "That is no number.\n")
    return connection.respond(HTTPStatus.OK, "")
