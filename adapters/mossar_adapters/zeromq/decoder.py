"""The ZeroMQ decoder: messages in, metas and frames out. It never sees a socket.

Accepted are two parts, topic and a msgpack or JSON map, or a single JSON part. Events and stats that pass by are left
alone.
"""

from collections.abc import Sequence
from typing import NamedTuple

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Counters
from mossar_adapters.maps.codec import from_json, from_msgpack
from mossar_adapters.maps.intake import MapIntake
from mossar_adapters.source import Departure, Meta
from mossar_stream import FrameError, Frames


class ZmqMessage(NamedTuple):
    """A message: its parts, and the time of arrival (s since the socket opened)."""

    parts: Sequence[bytes]
    arrival: float


class ZmqDecoder:
    """Turns messages into metas and frames.

    Args:
        options: The user's fps and unit.
        performer: The user's name of the performer, or None.

    Example:
        >>> decoder = ZmqDecoder()
        >>> text = b'{"type": "frame", "performer": "ann", "t": 0.5, "xyz": [[0, 1, 0]]}'
        >>> meta, frames = decoder.receive(ZmqMessage((b"mossar.frame.ann.", text), 0.0))
        >>> meta.performer, frames.times.tolist()
        ('ann', [0.5])
    """

    def __init__(self, options: ReadOptions | None = None, performer: str | None = None) -> None:
        self.counters = Counters()
        self._intake = MapIntake(self.counters, options, performer)

    @property
    def frames(self) -> int:
        """Frame maps that came, usable or not."""
        return self._intake.frames

    def receive(self, *messages: ZmqMessage) -> list[Meta | Frames | Departure]:
        """Return the content of these messages; malformed ones are counted and skipped."""
        for message in messages:
            self.counters.received += 1
            try:
                self._decode(message)
            except FrameError as error:
                self.counters.reject(str(error))
        return self._intake.batch.take()

    def idle(self, now: float) -> list[Meta | Frames | Departure]:
        """Return the frames held back after which nothing came until `now`, s."""
        return self._intake.batch.take(now)

    def _decode(self, message: ZmqMessage) -> None:
        parts = message.parts
        if len(parts) > 2:
            raise FrameError(
                f"a message of {len(parts)} parts; two (topic, map) or one (JSON) are understood"
            )
        if len(parts) == 2:
            self.counters.see(parts[0][:80].decode("utf-8", "replace"))
        data = parts[-1]
        found = from_json(data) if len(parts) == 1 or data.lstrip()[:1] == b"{" else from_msgpack(data)
        self._intake.put(found, message.arrival)
