"""The OSC decoder: datagrams in, metas and frames out. It never sees a socket, and no clock but that of the datagrams.

Four steps, each in one place:

1. admission: is this sender read at all (`receiving.admission`), and which one is it (`receiving.attribution`);
2. decoding: bytes to messages (`osc.messages`), each handed to the profile that it fits (`osc.profiles`);
3. assembly: messages of one joint each to poses, where the protocol needs it (`osc.assembly`);
4. batching: poses to announced, timed chunks of frames (`receiving.batch`).
"""

import math
from collections.abc import Iterable

from mossar_adapters.address import Address
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Counters, Listener
from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.osc.hints import Hints
from mossar_adapters.osc.messages import messages
from mossar_adapters.osc.profiles.profile import Context, Items, Message
from mossar_adapters.osc.profiles.routes import NAMES, OPTIONS, Routes
from mossar_adapters.receiving.admission import Admission
from mossar_adapters.receiving.attribution import Attribution
from mossar_adapters.receiving.batch import Batch
from mossar_adapters.receiving.senders import Senders
from mossar_adapters.source import Departure, Meta
from mossar_stream import FrameError, Frames

_CONTROL = "/mossar/set/", "/mossar/reset"


class OscDecoder:
    """Turns datagrams into metas, frames and departures.

    The caller hands datagrams over in the order of arrival. While `pending` is true and nothing more waits to be read,
    it soon calls `idle`: most protocols do not mark the end of a frame.

    Args:
        address: `osc://HOST:PORT?profile=…`, for its options.
        options: Options beyond the URL; those in the URL take precedence.
        listener: Receives control messages.

    Raises:
        SettingsError: If an option is wrong.

    Example:
        >>> from mossar_adapters.address import parse_url
        >>> from mossar_adapters.osc.encode import encode
        >>> decoder = OscDecoder(parse_url("osc://127.0.0.1:0"))
        >>> frame = encode("/mossar/frame", "sidb", "ann", 0, 0.5, bytes(24))
        >>> meta, frames = decoder.receive(Datagram(frame, "127.0.0.1", 9000, 0.0))
        >>> meta.performer, frames.positions.shape, frames.times.tolist()
        ('ann', (1, 2, 3), [0.5])
    """

    def __init__(
        self, address: Address, options: ReadOptions | None = None, listener: Listener | None = None
    ) -> None:
        address.check(OPTIONS)
        options = options or ReadOptions()
        self.counters = Counters()
        self.admission = Admission(address, self.counters)
        self._listener = listener
        senders = Senders(address.options.get("performer"))
        self._attribution: Attribution[Datagram] = Attribution(senders)
        self.hints = Hints()
        self._batch = Batch(options.fps, self.counters)
        self._profile = address.choice("profile", NAMES, "auto")
        context = Context(address, options, senders, self.counters)
        self._routes = Routes(self._profile, context)
        self._others = Routes("auto", context)  # asked only to explain silence

    @property
    def pending(self) -> bool:
        """Whether a frame is open or held back, so that `idle` should be called soon."""
        return self._attribution.pending or self._routes.pending() or self._batch.pending

    def receive(self, *datagrams: Datagram) -> list[Meta | Frames | Departure]:
        """Return the poses that these datagrams complete; frames of one performer that came together make one chunk.

        Malformed messages are counted, and no others are lost by them.
        """
        for datagram in datagrams:
            if self.admission.admits(datagram.host, datagram.port):
                self._decode_all(self._attribution.put(datagram))
        return self._batch.take()

    def idle(self, now: float) -> list[Meta | Frames | Departure]:
        """Return the frames that nothing more has come for.

        Args:
            now: s, on the clock of the datagrams' arrivals.
        """
        self._decode_all(self._attribution.settle(now))
        self._collect(self._routes.idle(now))
        return self._batch.take(now)

    def end(self) -> list[Meta | Frames | Departure]:
        """Return the frames that are held back: there are no more to come."""
        self._decode_all(self._attribution.settle(math.inf))
        return self._batch.take(math.inf)

    def came(self, performer: str) -> float | None:
        """Return the arrival of a performer's latest frame, s on the clock of the datagrams; None if there is none."""
        return self._batch.came(performer)

    def fitting(self, address: str) -> str:
        """Return the profile that an OSC address fits, for messages; also if another one was chosen."""
        message = Message(address, (), "", 0.0)
        fitting = self._routes.find(message) or self._others.find(message)
        if fitting is None:
            return "no profile"
        return fitting.name if self._profile in {"auto", fitting.name} else f"fits {fitting.name}"

    def better_profile(self) -> str | None:
        """Return the profile that messages fit which the chosen one does not want, None if none does."""
        if self._profile == "auto":
            return None
        for address in self.counters.seen:
            message = Message(address, (), "", 0.0)
            fitting = None if self._routes.find(message) else self._others.find(message)
            if fitting is not None:
                return fitting.name
        return None

    def _decode_all(self, found: Iterable[tuple[Datagram, str]]) -> None:
        for datagram, sender in found:
            self._decode(datagram, sender)

    def _decode(self, datagram: Datagram, sender: str) -> None:
        malformed, used = self.counters.malformed, False
        try:
            for address, arguments in messages(datagram.data):
                used |= self._use(Message(address, arguments, sender, datagram.arrival))
        except FrameError as error:
            self.counters.reject(str(error))
        if used or self.counters.malformed > malformed:
            self.admission.judge(datagram.host, datagram.port, sound=used)

    def _use(self, message: Message) -> bool:
        """Use a message; return whether a profile could."""
        self.counters.see(message.address)
        try:
            found = self._routes.receive(message)
        except FrameError as error:
            self.counters.reject(f"{message.address[:60]}: {error}")
            return False
        if found is not None:
            return self._collect(found, message.address)
        if not message.address.startswith(_CONTROL):
            self.counters.ignored += 1
            self.hints.add(message)
        elif self._listener is not None:
            self._listener.control(message.address, message.arguments)
        return False

    def _collect(self, found: Items, address: str = "idle") -> bool:
        """Batch the items of a profile; return whether all of them could be used."""
        sound = True
        for item in found:
            try:
                self._batch.put(item)
            except FrameError as error:
                self.counters.reject(f"{address[:60]}: {error}")
                sound = False
        return sound
