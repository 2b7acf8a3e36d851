"""Receivers that die and come back, and must hear nothing but the truth."""

import contextlib
import socket
import threading

import msgspec
import zmq

from checks.soak.truth import Truth
from mossar_adapters.osc.messages import messages
from mossar_stream import Event

_LIFE, _DEATH = 3.0, 1.0  # s
_WAIT = 0.1  # s
_decoder = msgspec.msgpack.Decoder(Event)


class Receiver:
    """Hears events for a while, dies, and comes back, in a thread of its own.

    Args:
        name: For the user.
        truth: Checks the received events.
    """

    def __init__(self, name: str, truth: Truth) -> None:
        self.name = name
        self.lives = 0
        self.heard = 0
        self._truth = truth
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End."""
        self._stopped.set()
        self._thread.join()

    def live(self, ended: threading.Event) -> None:
        """Hear until `ended`; a subclass knows how."""
        raise NotImplementedError

    def hear(self, event: Event) -> None:
        """Note an event."""
        self.heard += 1
        if not self._truth.knows(event):
            self._truth.differ(f"{self.name} heard {event}")

    def _run(self) -> None:
        while not self._stopped.is_set():
            ended = threading.Event()
            timer = threading.Timer(_LIFE, ended.set)
            timer.start()
            self.live(ended)
            timer.cancel()
            self.lives += 1
            self._stopped.wait(_DEATH)


class Subscriber(Receiver):
    """Subscribes to the ZeroMQ sink.

    Args:
        endpoint: Of the sink.
        truth: Checks the received events.
    """

    def __init__(self, endpoint: str, truth: Truth) -> None:
        super().__init__("ZeroMQ subscriber", truth)
        self._endpoint = endpoint

    def live(self, ended: threading.Event) -> None:
        """Subscribe, listen, leave."""
        with zmq.Context() as context, context.socket(zmq.SUB) as opened:
            opened.setsockopt(zmq.LINGER, 0)
            opened.setsockopt(zmq.SUBSCRIBE, b"")
            opened.connect(self._endpoint)
            while not ended.is_set():
                if opened.poll(int(_WAIT * 1000)):
                    topic, data = opened.recv_multipart()
                    if not topic.startswith((b"mossar.meta.", b"mossar.state.")):
                        self.hear(_decoder.decode(data))


class OscReceiver(Receiver):
    """Listens to the OSC sink; while it is dead its port is closed.

    Args:
        truth: Not asked: OSC events lack an id. They must be well formed.
    """

    def __init__(self, truth: Truth) -> None:
        super().__init__("OSC receiver", truth)
        with self._bound(0) as first:
            self.port: int = first.getsockname()[1]

    def live(self, ended: threading.Event) -> None:
        """Bind, listen, close."""
        with self._bound(self.port) as opened:
            while not ended.is_set():
                with contextlib.suppress(TimeoutError):
                    for address, _ in messages(opened.recv(65536)):
                        self.heard += 1
                        if not address.startswith("/mossar/"):
                            self._truth.differ(f"{self.name} heard {address}")

    @staticmethod
    def _bound(port: int) -> socket.socket:
        opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        opened.settimeout(_WAIT)
        opened.bind(("127.0.0.1", port))
        return opened
