"""Targets that read sockets and pipes: OSC, ZeroMQ, JSON lines."""

import contextlib
import io
import itertools
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from checks.fuzz.target import Feed, Target
from mossar_adapters.address import parse_url
from mossar_adapters.demo import DemoSource
from mossar_adapters.jsonlines import JsonLinesSource
from mossar_adapters.live import Counters
from mossar_adapters.maps.codec import to_json, to_msgpack
from mossar_adapters.maps.frame_maps import FrameMap, MetaMap, map_of_meta, maps_of_frames
from mossar_adapters.osc.datagrams import Datagram, DatagramSocket
from mossar_adapters.osc.decoder import OscDecoder
from mossar_adapters.osc.encode import bundle, encode
from mossar_adapters.osc.frame_sink import open_osc_frame_sink
from mossar_adapters.source import Departure, Meta
from mossar_adapters.zeromq.decoder import ZmqDecoder, ZmqMessage
from mossar_stream import FrameError, Frames, MossarError, Performers

_GENERIC = "generic&pattern=/pose/{performer}/{joint}"
# The listener, and the profiles of its samples.
_PROFILES = {
    "auto": ("auto", ("mossar", "osceleton", "kinectv2", "nimate", "flat", "vmc")),
    "vmc": ("vmc", ("vmc", "vmc&positions=no")),
    "osceleton": ("osceleton", ("osceleton",)),
    "kinectv2": ("kinectv2", ("kinectv2",)),
    "nimate": ("nimate", ("nimate",)),
    "flat": ("flat", ("flat",)),
    "generic": (_GENERIC, (_GENERIC,)),
    "mossar": ("mossar", ("mossar",)),
}
_EXTRA_MESSAGES = (
    encode("/new_user", "i", 2),
    encode("/lost_user", "i", 1),
    encode("/mossar/set/level", "s", "motion"),
    encode("/mossar/reset", ""),
    encode("/pose", "i", 0),
    bundle([encode("/joint/head/1", "fff", 0.1, 0.2, 0.3), bundle([b"/a\0\0,T\0\0"])]),
)
_OSC_WORDS = (
    b",sifff",
    b",fff",
    b",b",
    b",[T]",
    b",h",
    b"#bundle\0",
    b"/joint",
    b"/VMC/Ext/Bone/Pos",
    b"Hips\0\0\0\0",
)
_MAP_WORDS = (
    b"xyz",
    b"conf",
    b"shape",
    b"names",
    b"parents",
    b"performer",
    b'"t":1e999',
    b"[null,1,2]",
    b"-1",
)
_TOGETHER = 8  # messages between two looks for frames that are over
_HOSTS = ("127.0.0.1", "10.0.0.7", "fe80::1%eth0")


def wire_targets() -> list[Target]:
    """Return the targets."""
    metas, chunks = _performance()
    osc = [
        Target(f"osc {name}", 8.0, _osc_opener(listens), _datagrams(metas, chunks, sent), _OSC_WORDS)
        for name, (listens, sent) in _PROFILES.items()
    ]
    maps: list[FrameMap | MetaMap] = [
        *map(map_of_meta, metas),
        *(found for chunk in chunks for found in maps_of_frames(chunk, 0)),
    ]
    packed, written = [to_msgpack(found) for found in maps], [to_json(found) for found in maps]
    lines = [b"\n".join(written[i : i + 3]) + b"\n" for i in range(0, len(written), 3)]
    return [
        *osc,
        Target("zeromq msgpack", 16.0, _zeromq_two_parts, packed, _MAP_WORDS),
        Target("zeromq json", 10.0, _zeromq_one_part, written, _MAP_WORDS),
        Target("json lines", 2.0, _json_lines, lines, _MAP_WORDS),
    ]


class Consumer:
    """Segments the frames that a target accepts, as a pipeline would."""

    def __init__(self) -> None:
        self._pool = Performers(most=4)

    def use(self, items: Sequence[Meta | Frames | Departure]) -> None:
        """Take metas and frames; those that do not fit are refused.

        Raises:
            FrameError: If some were.
        """
        refused: MossarError | None = None
        for item in items:
            try:
                if isinstance(item, Meta):
                    self._pool.announce(item.performer, item.skeleton, item.fps)
                elif isinstance(item, Frames):
                    self._pool.push(item)
                elif item.performer in self._pool:
                    self._pool[item.performer].end_take(item.reason)
            except FrameError as error:
                refused = error
        if refused is not None:
            raise refused


def _performance() -> tuple[list[Meta], list[Frames]]:
    """Return a meta and a few frames of two performers, some joints missing."""
    items = list(DemoSource(2, performers=2, seconds=0.1, speed="max").items())
    metas = [item for item in items if isinstance(item, Meta)]
    chunks = [item for item in items if isinstance(item, Frames)]
    chunks[0].positions[0, 3] = np.nan
    return metas, chunks


def _datagrams(metas: Sequence[Meta], chunks: Sequence[Frames], profiles: Sequence[str]) -> list[bytes]:
    """Return the datagrams of our own senders in these profiles."""
    socket = DatagramSocket(parse_url("osc://127.0.0.1:0"))
    found: list[bytes] = list(_EXTRA_MESSAGES)
    for profile in profiles:
        sink = open_osc_frame_sink(parse_url(f"osc://127.0.0.1:{socket.port}?profile={profile}"))
        for meta in metas:
            sink.announce(meta)
        for chunk in chunks:
            sink.send_frames(chunk)
            found += [datagram.data for datagram in socket.receive(0)]
        sink.close()
    socket.close()
    return found


def _osc_opener(listens: str) -> Callable[[], contextlib.AbstractContextManager[Feed]]:
    def opened() -> contextlib.AbstractContextManager[Feed]:
        decoder = OscDecoder(parse_url(f"osc://127.0.0.1:0?profile={listens}"))

        def received(data: bytes, n: int) -> list[Meta | Frames | Departure]:
            found = decoder.receive(Datagram(data, _HOSTS[n % 3], 9000 + n % 2, n * 0.002))
            if n % _TOGETHER == 0 and decoder.pending:
                found += decoder.idle(n * 0.002)
            return found

        return contextlib.nullcontext(_live(received, decoder.counters))

    return opened


def _zeromq_two_parts() -> contextlib.AbstractContextManager[Feed]:
    return _zeromq((b"mossar.frame.p1.",))


def _zeromq_one_part() -> contextlib.AbstractContextManager[Feed]:
    return _zeromq(())


def _zeromq(topic: tuple[bytes, ...]) -> contextlib.AbstractContextManager[Feed]:
    decoder = ZmqDecoder()

    def received(data: bytes, n: int) -> list[Meta | Frames | Departure]:
        return decoder.receive(ZmqMessage((*topic, data), n * 0.002))

    return contextlib.nullcontext(_live(received, decoder.counters))


def _live(received: Callable[[bytes, int], Sequence[Meta | Frames | Departure]], counters: Counters) -> Feed:
    """Return a feed for a decoder, which counts refused messages instead of raising."""
    consumer = Consumer()
    numbers = itertools.count(1)

    def feed(data: bytes) -> None:
        refused = counters.malformed
        consumer.use(received(data, next(numbers)))
        if counters.malformed > refused:
            raise FrameError(counters.last_error)

    return feed


@contextlib.contextmanager
def _json_lines() -> Iterator[Feed]:
    address = parse_url("-")
    consumer = Consumer()

    def feed(data: bytes) -> None:
        for item in JsonLinesSource(address, stream=io.BytesIO(data)).items():
            if item is not None:
                consumer.use([item])

    yield feed
