"""The OSC source: a UDP socket, profiles, frames."""

from collections.abc import Iterator

from mossar_adapters.address import Address
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Counters, Listener
from mossar_adapters.osc.datagrams import Datagram, DatagramSocket
from mossar_adapters.osc.messages import messages
from mossar_adapters.osc.profiles.profile import Intake, Message
from mossar_adapters.osc.profiles.routes import NAMES, OPTIONS, Routes
from mossar_adapters.receiving.batch import Batch
from mossar_adapters.receiving.nuisance import Nuisances
from mossar_adapters.receiving.senders import AllowList, Senders
from mossar_adapters.source import Left, Meta
from mossar_stream.errors import FrameError
from mossar_stream.frames import Frames

POLL = 0.1  # s between two Nones while nothing comes
TICK = 0.004  # s between looks at open frames while nothing comes
SMALL_BUFFER = 1 << 20  # bytes; less than this loses datagrams when the program pauses for a moment
_CONTROL = "/mossar/set/", "/mossar/reset"


class OscSource:
    """Receives skeletons over OSC; implements `LiveSource`.

    Args:
        address: `osc://HOST:PORT?profile=…`.
        options: What the user says beyond the URL; the URL's own options go before.
        listener: Is told of control messages.

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
        address.check(OPTIONS)
        self.name = address.url
        self.counters = Counters()
        self.notes: tuple[str, ...] = ()
        self._listener = listener
        self._profile = address.choice("profile", NAMES, "auto")
        self._allow = AllowList(address)
        self._senders = Senders(address.options.get("performer"))
        options = options or ReadOptions()
        self._batch = Batch(options.fps)
        intake = Intake(address, options, self._batch, self._senders, self.counters)
        self._routes = Routes(self._profile, intake)
        self._others = Routes("auto", intake)  # asked only to explain silence
        self._hosts: dict[str, int] = {}
        self._nuisances = Nuisances()
        self._used = 0  # messages that a profile took
        self._closed = self._running = False
        self._socket = DatagramSocket(address)
        self.host, self.port = self._socket.host, self._socket.port
        if self._socket.buffer < SMALL_BUFFER:
            self.notes = (_SMALL.format(self.name, self._socket.buffer >> 10),)

    def items(self) -> Iterator[Meta | Frames | Left | None]:
        """Yield metas, chunks of frames and who has left as they come; None when nothing came for a tenth of a second."""
        self._running = True
        try:
            quiet = self._socket.now
            while not self._closed:
                for datagram in self._socket.receive(TICK if self._pending() else POLL):
                    self.take(datagram)
                found = self.collected()
                yield from found
                if found:
                    quiet = self._socket.now
                elif self._socket.now - quiet >= POLL:
                    quiet = self._socket.now
                    yield None
        finally:
            self._socket.close()

    def take(self, datagram: Datagram) -> None:
        """Use a datagram; `items` does so with those of the socket."""
        counters = self.counters
        counters.received += 1
        counters.kernel_drops = self._socket.kernel_drops
        if not self._allow.welcome(datagram.host):
            counters.ignored += 1
            return
        if datagram.host in self._hosts or len(self._hosts) < 64:
            self._hosts[datagram.host] = self._hosts.get(datagram.host, 0) + 1
        sender = datagram.host, datagram.port
        if self._nuisances.skips(sender):
            counters.malformed += 1
            return
        malformed, used = counters.malformed, self._used
        suffix = self._senders.suffix(*sender)
        try:
            for address, arguments in messages(datagram.data):
                self._message(Message(address, arguments, suffix, datagram.arrival))
        except FrameError as error:
            counters.reject(str(error))
        if self._used > used:
            self._nuisances.judge(sender, sound=True)
        elif counters.malformed > malformed:
            self._nuisances.judge(sender, sound=False)

    def collected(self) -> list[Meta | Frames | Left]:
        """Return what has come together since the last call, frames that nothing more comes for included."""
        if self._pending() and not self._socket.waits():
            self._idle()
        return self._batch.take()

    def explain(self) -> str:
        """Return one line that says what is bound, what came, and what to try."""
        counters = self.counters
        where = f"{self.name}: listening on UDP {self.host}:{self.port}"
        if counters.received == 0:
            hint = "" if self.host in {"0.0.0.0", "::"} else _OTHER_DEVICE.format(self.port)  # noqa: S104
            return f"{where}; no datagram came yet{hint}"
        senders = ", ".join(list(self._hosts)[:4])
        text = f"{where}; {counters.received} datagrams came from {senders}"
        if counters.seen:
            seen = ", ".join(f"{address} ({self._fitting(address)})" for address in counters.seen)
            text += f"; addresses: {seen}"
        if counters.malformed:
            text += f"; {counters.malformed} malformed, the last: {counters.last_error}"
        if counters.ignored:
            text += f"; {counters.ignored} ignored: try profile=generic&pattern=/pose/{{performer}}/{{joint}}"
        return text

    def close(self) -> None:
        """End `items` soon. May be called twice, and from any thread."""
        self._closed = True
        if not self._running:
            self._socket.close()

    def _pending(self) -> bool:
        return any(profile.pending() for profile in self._routes.profiles)

    def _message(self, message: Message) -> None:
        self.counters.see(message.address)
        profile = self._routes.find(message)
        if profile is not None:
            try:
                profile.take(message)
                self._used += 1
            except FrameError as error:
                self.counters.reject(f"{message.address[:60]}: {error}")
        elif message.address.startswith(_CONTROL):
            if self._listener is not None:
                self._listener.control(message.address, message.arguments)
        else:
            self.counters.ignored += 1

    def _idle(self) -> None:
        for profile in self._routes.profiles:
            try:
                profile.idle(self._socket.now)
            except FrameError as error:
                self.counters.reject(str(error))

    def _fitting(self, address: str) -> str:
        """Return the profile that an address fits, also if another one was chosen."""
        message = Message(address, (), "", 0.0)
        fitting = self._routes.find(message) or self._others.find(message)
        if fitting is None:
            return "no profile"
        return fitting.name if self._profile in {"auto", fitting.name} else f"fits {fitting.name}"


_SMALL = (
    "{}: the system grants a receive buffer of {} KiB only; datagrams may get lost under load"
    " (Linux: sysctl net.core.rmem_max=4194304)"
)
_OTHER_DEVICE = "; a sender on another device needs osc://0.0.0.0:{} here and this computer's address there"
