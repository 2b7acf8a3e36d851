"""Control over ZeroMQ: a REP socket that answers JSON requests."""

import threading
from collections.abc import Callable

import zmq

from mossar_stream.errors import SettingsError

_POLL = 100  # ms


class ZmqControl:
    """Answers requests in a thread of its own until it is closed.

    Args:
        url: `zmq+bind://127.0.0.1:5560`, or `zmq+ipc:///tmp/mossar-control` where there are such sockets.
        answer: Called with each request, returns the answer; both are JSON.

    Raises:
        SettingsError: If the address cannot be bound.
    """

    def __init__(self, url: str, answer: Callable[[bytes], bytes]) -> None:
        self.url = url
        self._answer = answer
        self._socket = zmq.Context.instance().socket(zmq.REP)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.MAXMSGSIZE, 1 << 20)
        try:
            self._socket.bind(_endpoint(url))
        except (zmq.ZMQError, ValueError) as error:
            self._socket.close()
            raise SettingsError(f"{url}: cannot be bound: {str(error) or 'no such address'}") from None
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._serve, name=f"control {url}", daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """Number of the port that is bound."""
        endpoint = self._socket.getsockopt(zmq.LAST_ENDPOINT)
        return int(bytes(endpoint).rstrip(b"\0").rpartition(b":")[2])

    def close(self) -> None:
        """Stop answering. May be called twice."""
        self._closed.set()
        self._thread.join()

    def _serve(self) -> None:
        while not self._closed.is_set():
            if self._socket.poll(_POLL):
                parts = self._socket.recv_multipart()
                self._socket.send(self._answer(parts[0]))
        self._socket.close()


def _endpoint(url: str) -> str:
    scheme, colon, rest = url.partition(":")
    if scheme == "zmq+bind" and rest.startswith("//"):
        return f"tcp:{rest.replace('//localhost', '//127.0.0.1')}"
    if scheme in {"zmq+ipc", "ipc"} and colon:
        return f"ipc:{rest}"
    raise ValueError("control is bound at zmq+bind://HOST:PORT")
