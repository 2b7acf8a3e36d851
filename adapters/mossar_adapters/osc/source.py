"""The OSC source: a UDP socket around `OscDecoder`."""

from collections.abc import Iterator

from mossar_adapters.address import Address
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Listener, Skipped
from mossar_adapters.osc.datagrams import DatagramSocket
from mossar_adapters.osc.decoder import OscDecoder
from mossar_adapters.source import Departure, Meta
from mossar_stream import Frames

POLL = 0.1  # s between two Nones while nothing comes
TICK = 0.004  # s between looks at open frames while nothing comes
SMALL_BUFFER = 1 << 20  # bytes; less than this loses datagrams when the program pauses for a moment


class OscSource:
    """Receives skeletons over OSC; implements `Source`.

    Args:
        address: `osc://HOST:PORT?profile=…`.
        options: Options beyond the URL; those in the URL take precedence.
        listener: Receives control messages.

    Raises:
        MossarError: If the port cannot be had or an option is wrong.

    Example:
        >>> from mossar_adapters.address import parse_url
        >>> source = OscSource(parse_url("osc://127.0.0.1:0"))
        >>> source.explain()[:20], source.close()
        ('osc://127.0.0.1:0: l', None)
    """

    live = True

    def __init__(
        self, address: Address, options: ReadOptions | None = None, listener: Listener | None = None
    ) -> None:
        self.name = address.url
        self.decoder = OscDecoder(address, options, listener)
        self.counters = self.decoder.counters
        self.notes: tuple[str, ...] = ()
        self._closed = self._running = False
        self._skipped = Skipped(self.counters)
        self._socket = DatagramSocket(address)
        self.host, self.port = self._socket.host, self._socket.port
        if self._socket.buffer < SMALL_BUFFER:
            self.notes = (_SMALL.format(self.name, self._socket.buffer >> 10),)

    def skip_waiting(self) -> None:
        """Discard all messages before now; their number is logged."""
        end, reached = self._socket.now, 0.0
        while reached < end and self._socket.waits():
            datagrams = self._socket.receive(0)
            # The first ones after the socket was opened may have the time of reading: Linux begins to stamp a bit later.
            reached = min((datagram.arrival for datagram in datagrams), default=end)
            self._skipped.add(self.decoder.receive(*datagrams))
        self._skipped.log(self.name)

    def items(self) -> Iterator[Meta | Frames | Departure | None]:
        """Yield metas, chunks of frames and departures as they come; None when nothing came for a tenth of a second."""
        self._running = True
        try:
            quiet = self._socket.now
            yield from self._skipped.kept
            while not self._closed:
                found = self._received()
                yield from found
                if found:
                    quiet = self._socket.now
                elif self._socket.now - quiet >= POLL:
                    quiet = self._socket.now
                    yield None
            yield from self.decoder.end()
        finally:
            self._socket.close()

    def _received(self) -> list[Meta | Frames | Departure]:
        """Return the poses that waiting datagrams complete, and frames that are closed by silence."""
        datagrams = self._socket.receive(TICK if self.decoder.pending else POLL)
        self.counters.kernel_drops = self._socket.kernel_drops
        found = self.decoder.receive(*datagrams)
        if self.decoder.pending and not self._socket.waits():
            found += self.decoder.idle(self._socket.now)
        return found

    def came(self, performer: str) -> float | None:
        """Return the time at which a performer's latest frame began to arrive, monotonic s; None if unknown."""
        arrival = self.decoder.came(performer)
        return None if arrival is None else self._socket.opened + arrival

    def explain(self) -> str:
        """Return one line: the bound address, the arrivals, a remedy."""
        counters = self.counters
        where = f"{self.name}: listening on UDP {self.host}:{self.port}"
        if counters.received == 0:
            hint = "" if self.host in {"0.0.0.0", "::"} else _OTHER_DEVICE.format(self.port)  # noqa: S104
            return f"{where}; no datagram came yet{hint}"
        senders = ", ".join(list(self.decoder.admission.hosts)[:4])
        text = f"{where}; {counters.received} datagrams came from {senders}"
        if counters.seen:
            seen = ", ".join(f"{address} ({self.decoder.fitting(address)})" for address in counters.seen)
            text += f"; addresses: {seen}"
        if counters.malformed:
            text += f"; {counters.malformed} malformed, the last: {counters.last_error}"
        if counters.ignored:
            better = self.decoder.better_profile()
            hint = f"profile={better}, or leave profile= out" if better else self._own_options()
            text += f"; {counters.ignored} ignored: try {hint}"
        return text

    def _own_options(self) -> str:
        """Return the URL that reads the messages which no profile wants."""
        options = self.decoder.hints.options()
        if options is None:
            return _OF_YOUR_OWN
        return f'"osc://{self.host}:{self.port}?{options}" (docs/osc.md)'

    def close(self) -> None:
        """End `items` soon. May be called twice, and from any thread."""
        self._closed = True
        if not self._running:
            self._socket.close()


_OF_YOUR_OWN = "profile=generic with a pattern= and args= of your own, see docs/osc.md"
_SMALL = (
    "{}: the system grants a receive buffer of {} KiB only; datagrams may get lost under load"
    " (Linux: sysctl net.core.rmem_max=4194304)"
)
_OTHER_DEVICE = "; a sender on another device needs osc://0.0.0.0:{} here and this computer's address there"
