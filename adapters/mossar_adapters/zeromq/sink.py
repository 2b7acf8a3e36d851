"""ZeroMQ sinks: PUB, as XPUB so that late joiners get the latest meta of every performer, and where each stands.

Two parts: topic `mossar.<type>.<performer>.`, of a limb `mossar.limb.<type>.<performer>.`, and a msgpack map, or JSON with `?encoding=json`. A receiver that
is too slow loses the newest messages; only it can count them, by `seq` and `rev`: ZeroMQ reports a full queue once,
and then leaves that receiver out until it has caught up. `dropped` counts these reports.
"""

import logging
import time
from collections.abc import Iterator, Sequence

import msgspec
import zmq

from mossar_adapters.address import Address
from mossar_adapters.maps.codec import to_json, to_msgpack
from mossar_adapters.maps.frame_maps import map_with_run, maps_of_frames
from mossar_adapters.maps.states import States
from mossar_adapters.newest import Newest
from mossar_adapters.source import Meta
from mossar_adapters.zeromq.endpoint import CURVE_OPTIONS, bound_at, can_read, open_socket
from mossar_adapters.zeromq.guarded import GuardedContext
from mossar_stream import BODY, Event, Frames, KeyFrameEvent, SegmentEvent

OPTIONS = {"encoding": "msgpack or json", **CURVE_OPTIONS}
FRAME_OPTIONS = {
    **OPTIONS,
    "wait": "seconds to wait for a first subscriber before the first frame; default 3",
}
QUEUE = 50_000  # messages kept for a subscriber that is slow
_METAS = 1024  # performers whose metas are kept for late joiners
_WAIT = 3.0  # s
_SUBSCRIBE = b"\x01"

_log = logging.getLogger("mossar.zeromq")


class ZmqSink:
    """Publishes events; implements `Sink`.

    Args:
        address: `zmq+bind://HOST:PORT`, `zmq://HOST:PORT` or an `ipc:` form.

    Raises:
        MossarError: If the socket cannot be had or an option is wrong.
    """

    prompt = True

    def __init__(self, address: Address) -> None:
        address.check(OPTIONS)
        self.name = address.url
        self.dropped = 0
        self._publisher = Publisher(address)
        self.endpoint = self._publisher.endpoint
        json = self._publisher.json
        self._encode = msgspec.json.Encoder().encode if json else msgspec.msgpack.Encoder().encode

    def announce(self, meta: Meta) -> None:
        """Publish a performer's meta, and keep it for late joiners."""
        self._publisher.announce(meta)

    def send(self, events: Sequence[Event]) -> None:
        """Publish events."""
        self._publisher.serve()
        self._publisher.states.follow(events)
        for event in events:
            topic = f"mossar.{_kind(event)}.{event.performer}.".encode()
            if not self._publisher.put(topic, self._encode(event)):
                self.dropped += 1

    def close(self) -> None:
        """Send the rest and release the port. May be called twice."""
        self._publisher.close()


def _kind(event: Event) -> str:
    """Return the kind in the topic: subscribers of the body's key frames do not get those of limbs."""
    tag = str(event.__struct_config__.tag)
    limb = isinstance(event, KeyFrameEvent | SegmentEvent) and event.channel != BODY
    return f"limb.{tag}" if limb else tag


class ZmqFrameSink:
    """Publishes frames; implements `FrameSink`.

    Args:
        address: As for `ZmqSink`; option `wait`.

    Raises:
        MossarError: If the socket cannot be had or an option is wrong.
    """

    def __init__(self, address: Address) -> None:
        address.check(FRAME_OPTIONS)
        self.name = address.url
        self.dropped = 0
        self._wait = address.number("wait", 0, 3600, _WAIT)
        self._publisher = Publisher(address)
        self.endpoint = self._publisher.endpoint
        self._encode = to_json if self._publisher.json else to_msgpack
        self._counts: dict[str, int] = {}  # frames sent of each performer

    def announce(self, meta: Meta) -> None:
        """Publish a performer's meta, and keep it for late joiners."""
        self._publisher.announce(meta)

    def send_frames(self, frames: Frames) -> None:
        """Publish frames, one message each."""
        if self._wait:
            self._publisher.await_subscriber(self._wait)
            self._wait = 0.0
        self._publisher.serve()
        count = self._counts.get(frames.performer, 0)
        topic = f"mossar.frame.{frames.performer}.".encode()
        for found in maps_of_frames(frames, count):
            if not self._publisher.put(topic, self._encode(found)):
                self.dropped += 1
        self._counts[frames.performer] = count + len(frames)

    def close(self) -> None:
        """Send the rest and release the port. May be called twice."""
        self._publisher.close()


class Publisher:
    """An XPUB socket with the latest metas.

    Args:
        address: Address of the socket.
    """

    def __init__(self, address: Address) -> None:
        self.json = address.choice("encoding", ("msgpack", "json"), "msgpack") == "json"
        self._encode = to_json if self.json else to_msgpack
        self._context = GuardedContext()
        try:
            wanted: dict[int, int | bytes] = {zmq.XPUB_VERBOSE: 1, zmq.XPUB_NODROP: 1, zmq.SNDHWM: QUEUE}
            self._socket = open_socket(self._context, zmq.XPUB, address, wanted)
        except BaseException:
            self._context.term()
            raise
        self.endpoint = bound_at(self._socket)
        self._metas: Newest[bytes, bytes] = Newest(_METAS)  # topic -> latest meta map
        self.states = States()
        self._subscribed = False  # whether there ever was a subscriber
        self._name, self._logged = address.url, False  # whether a slow receiver was logged

    def announce(self, meta: Meta) -> None:
        """Publish a meta and keep it."""
        found = map_with_run(meta)
        self.states.announce(meta)
        topic = f"mossar.meta.{meta.performer}.".encode()
        self._metas[topic] = self._encode(found)
        self.serve()
        self.put(topic, self._metas[topic])

    def serve(self) -> None:
        """Answer new subscriptions with the metas and states they ask for."""
        while can_read(self._socket):
            request = self._socket.recv()
            if request[:1] != _SUBSCRIBE:
                continue
            self._subscribed = True
            for topic, data in (*self._metas.items(), *self._standing()):
                if topic.startswith(request[1:]):
                    self.put(topic, data)

    def _standing(self) -> Iterator[tuple[bytes, bytes]]:
        for state in self.states:
            yield f"mossar.state.{state.performer}.".encode(), self._encode(state)

    def await_subscriber(self, seconds: float) -> None:
        """Wait for a subscriber, at most `seconds`."""
        deadline = time.monotonic() + seconds
        while not self._subscribed and (left := deadline - time.monotonic()) > 0:
            if self._socket.poll(int(min(left, 0.1) * 1000) + 1):
                self.serve()

    def put(self, topic: bytes, data: bytes) -> bool:
        """Publish, and return whether all subscribers get it."""
        try:
            self._socket.send_multipart((topic, data), zmq.NOBLOCK)
        except zmq.Again:  # a subscriber's queue is full: ZeroMQ reports it with this option only
            if not self._logged:
                self._logged = True
                _log.warning("%s: a receiver is too slow; it loses messages", self._name)
            self._socket.setsockopt(zmq.XPUB_NODROP, 0)
            try:
                self._socket.send_multipart((topic, data), zmq.NOBLOCK)  # to the others
            finally:
                self._socket.setsockopt(zmq.XPUB_NODROP, 1)
            return False
        return True

    def close(self) -> None:
        """Release the port. May be called twice."""
        self._socket.close()
        self._context.term()
