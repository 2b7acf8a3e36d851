"""Control over ZeroMQ: a REP socket that answers JSON requests."""

import threading
from collections.abc import Callable

import zmq

from mossar_adapters.address import Address
from mossar_adapters.zeromq.endpoint import CURVE_OPTIONS, bound_at, open_socket
from mossar_adapters.zeromq.guarded import GuardedContext
from mossar_stream import MossarError

_POLL = 100  # ms


class ZmqControl:
    """Answers requests in a thread of its own until it is closed.

    Args:
        address: `zmq+bind://127.0.0.1:5560` or a bound `ipc:` form.
        answer: Called with each request, returns the answer; both are JSON.

    Raises:
        MossarError: If the address cannot be bound.
    """

    def __init__(self, address: Address, answer: Callable[[bytes], bytes]) -> None:
        address.check(CURVE_OPTIONS)
        self.name = address.url
        self._answer = answer
        self._context = GuardedContext()
        try:
            self._socket = open_socket(self._context, zmq.REP, address, {})
        except MossarError:
            self._context.term()
            raise
        self.endpoint = bound_at(self._socket)
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._serve, name=f"control {self.name}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop answering. May be called twice."""
        self._closed.set()
        self._thread.join()

    def _serve(self) -> None:
        while not self._closed.is_set():
            if self._socket.poll(_POLL):
                self._socket.send(self._answer(self._socket.recv_multipart()[0]))
        self._socket.close(0)
        self._context.term()
