"""Intake: frame and meta maps of live senders, counted and collected until the reader takes them."""

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Counters
from mossar_adapters.maps.decoder import MapDecoder
from mossar_adapters.maps.frame_maps import FrameMap, MetaMap
from mossar_adapters.receiving.batch import Batch
from mossar_adapters.receiving.pose import Pose
from mossar_adapters.source import Departure, Meta


class MapIntake:
    """Processes maps of any wire.

    Args:
        counters: Where maps of other types and gaps are counted.
        options: The user's fps and unit.
        performer: The user's name of the performer, or None.
        piped: Whether times of arrival may be meaningless, as those of a file that is read through a pipe.
    """

    def __init__(
        self,
        counters: Counters,
        options: ReadOptions | None = None,
        performer: str | None = None,
        *,
        piped: bool = False,
    ) -> None:
        options = options or ReadOptions()
        self.counters = counters
        self.batch = Batch(options.fps, counters, piped=piped)
        self.frames = 0  # frame maps that came, usable or not
        self._maps = MapDecoder(counters, options, performer)

    def put(self, found: FrameMap | MetaMap | None, arrival: float, sender: str = "") -> Meta | Pose | None:
        """Process one map, and return its content; None for another type, such as an event.

        Args:
            found: The decoded map; None for another type.
            arrival: Time of arrival, s.
            sender: Distinguishes connections, where that is known: a name belongs to one of them.

        Raises:
            FrameError: If it cannot be used.
        """
        if found is None:
            self.counters.ignored += 1
            return None
        self.frames += isinstance(found, FrameMap)
        said = self._maps.receive(found, arrival, sender)
        self.batch.put(said)
        return said

    def leave(self, sender: str, reason: str) -> None:
        """Report the departure of the performers of a closed connection."""
        for performer in self._maps.forget(sender):
            self.batch.put(Departure(performer, reason))
        self.batch.forget(sender)
