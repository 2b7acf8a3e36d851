"""Server: viser's, closed to pages of other sites and to devices that were not invited.

A browser lets any site open a WebSocket to 127.0.0.1; only the `Origin` that it sends tells such a site from our own
page. viser has no option to look at it, so the function that it serves with is wrapped while it starts.
"""

import asyncio
import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from http import HTTPStatus
from typing import Any

import websockets.asyncio.server
from viser import ViserServer

from mossar_tools.console import LOGGER
from mossar_tools.dashboard.asking import HEADER
from mossar_tools.dashboard.visitors import Visitors

_Asked = Callable[[Any, Any], Any]
Answers = Mapping[str, Callable[[str], None]]


def open_server(host: str, port: int, answers: Answers, visitors: Visitors) -> ViserServer:
    """Return a server.

    Args:
        host: Address of this computer where it listens.
        port: Where; the next free one if it is in use, 0 for any.
        answers: What the page's own parts may ask for, by path; called with what stands behind the question mark.
        visitors: Who may ask.
    """
    with _guarded(answers, visitors):
        return ViserServer(host=host, port=port, label="mossar", verbose=False)


@contextmanager
def _guarded(answers: Answers, visitors: Visitors) -> Iterator[None]:
    """Have servers that start meanwhile ask where each visitor comes from."""
    serve = websockets.asyncio.server.serve

    def serving(*arguments: Any, process_request: _Asked | None = None, **options: Any) -> Any:
        asyncio.get_running_loop().set_exception_handler(_note_visitor)
        guard = _guard(process_request, answers, visitors)
        return serve(*arguments, process_request=guard, logger=_quiet(), **options)

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


def _note_visitor(_: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Log what a visitor sends that is no value of a control: one line for those who debug, instead of a traceback."""
    LOGGER.debug("the dashboard: %s: %s", context.get("message"), context.get("exception"))


def _guard(then: _Asked | None, answers: Answers, visitors: Visitors) -> _Asked:
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
        return None if then is None else then(connection, request)

    return process_request


def _answer(connection: Any, answer: Callable[[str], None], value: str) -> Any:
    """Do what a part of the page asks for."""
    try:
        answer(value)
    except ValueError:
        return connection.respond(HTTPStatus.BAD_REQUEST, "That is no number.\n")
    return connection.respond(HTTPStatus.OK, "")
