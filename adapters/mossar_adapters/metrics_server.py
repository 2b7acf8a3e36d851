"""An HTTP server for the few clients of the metrics. Any number of connections cannot exhaust it.

Each connection has a thread and a time-out. Beyond `MAX_CLIENTS` the oldest one is cut off, so that a new
request is always answered, however many idle clients stay connected.
"""

import socket
import sys
import threading
from collections.abc import Callable
from socketserver import ThreadingMixIn
from typing import Any, ClassVar
from wsgiref.simple_server import WSGIRequestHandler, WSGIServer

MAX_CLIENTS = 16
PATIENCE = 5.0  # s that a client may be silent


class _Handler(WSGIRequestHandler):
    """Answers one request, without a word to the log."""

    timeout: ClassVar[float] = PATIENCE

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - the name is the library's
        """Log nothing."""


class MetricsServer(ThreadingMixIn, WSGIServer):
    """Serves a WSGI application in threads, of which there are never many.

    Args:
        host: Where to listen.
        port: 0 takes a free one.
        application: What answers.

    Raises:
        OSError: If the port cannot be had.
    """

    daemon_threads = True
    request_queue_size = 64

    def __init__(self, host: str, port: int, application: Callable[..., Any]) -> None:
        family, _, _, _, place = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        self.address_family = family
        self._open: dict[Any, None] = {}  # sockets, the oldest first
        self._lock = threading.Lock()
        super().__init__((str(place[0]), port), _Handler)
        self.set_app(application)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer in a thread; cut the oldest connection off if there are too many."""
        with self._lock:
            self._open[request] = None
            oldest = next(iter(self._open)) if len(self._open) > MAX_CLIENTS else None
            self._open.pop(oldest, None)
        if oldest is not None:
            self._cut_off(oldest)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Forget a connection that is done."""
        with self._lock:
            self._open.pop(request, None)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of clients that were too slow or went away."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)

    @staticmethod
    def _cut_off(request: Any) -> None:
        try:
            request.shutdown(socket.SHUT_RDWR)  # its thread reads the end, and closes it
        except OSError:  # it has just gone
            return
