"""Run: the parts of a run, and its state.

The pipeline drives it; upkeep looks after it between frames, and needs no more than this.
"""

import logging
from collections.abc import Sequence

from mossar_adapters.pipeline.beginning import Beginning
from mossar_adapters.pipeline.feed import Feed
from mossar_adapters.pipeline.inbox import Inbox
from mossar_adapters.pipeline.naming import Naming
from mossar_adapters.pipeline.outcome import Outcome, in_words
from mossar_adapters.pipeline.outlet import Outlet, Parcel
from mossar_adapters.pipeline.performer_record import PerformerRecord
from mossar_adapters.pipeline.pool import Pool
from mossar_adapters.source import Source
from mossar_stream import Event, Settings, StreamChange, StreamEvent

_log = logging.getLogger("mossar.pipeline")


class Run:
    """Sources with their readers, performers with their segmenters, sinks with their writers, and counters.

    Args:
        sources: At least one.
        settings: Settings of the segmenters.
        pool: The segmenters.
        seconds: How much of each performer's time is wanted; None for all.
        run_id: Name of the run.

    Attributes:
        inbox: Arrivals from readers, until they are processed.
        feeds: The reader of each source.
        beginnings: Frames that each source has dropped because they were old at the start.
        running: Whether each source still delivers.
        naming: Our names of the performers, and the record of each.
        live: Whether a source is live.
        outlets: The writer of each sink that works.
        outcome: Outcome of the run.
    """

    def __init__(
        self, sources: Sequence[Source], settings: Settings, pool: Pool, seconds: float | None, run_id: str
    ) -> None:
        self.settings = settings
        self.pool = pool
        self.seconds = seconds
        self.run_id = run_id
        self.inbox = Inbox([source.live for source in sources])
        self.feeds = [Feed(source, i, self.inbox) for i, source in enumerate(sources)]
        self.beginnings = [Beginning(source) for source in sources]
        self.running = [True] * len(sources)
        self.naming = Naming([source.name for source in sources])
        self.live = any(source.live for source in sources)
        self.outlets: list[Outlet] = []
        self.outcome = Outcome()

    @property
    def performers(self) -> dict[str, PerformerRecord]:
        """The record of each performer, by its name in events."""
        return self.naming.performers

    def is_over(self) -> bool:
        """Return whether every present performer has reached the wanted end, and there is one."""
        if self.seconds is None:
            return False
        times = [performer.time for performer in self.performers.values() if performer.time.last is not None]
        return any(time.is_over for time in times) and all(time.is_over or time.is_absent for time in times)

    def max_pause(self, performer: PerformerRecord) -> float:
        """Return the longest pause of a performer's frames before its take ends, s."""
        if performer.max_pause is None:
            name = performer.name
            settings = self.pool[name].settings if name in self.pool else self.pool.settings
            performer.max_pause = settings.max_pause
        return performer.max_pause

    def send(self, events: list[Event], arrived_at: float | None = None) -> None:
        """Hand events to all sinks."""
        if events:
            parcel = Parcel(events, arrived_at)
            for outlet in self.outlets:
                outlet.put(parcel)

    def end_takes(self, source: int, reason: str) -> None:
        """End the takes of all performers of a source."""
        for performer in self.naming.of_source(source):
            self.end_take(performer.name, reason)

    def end_take(self, performer: str, reason: str) -> None:
        """End the take of a performer, if there is one."""
        if performer not in self.pool:
            return
        try:
            self.send(self.pool[performer].end_take(reason))
        except Exception as error:  # noqa: BLE001 - no error of one performer may end the run
            _log.warning("the take of %s cannot be ended: %s", performer, in_words(error))

    def stream_event(self, performer: str, event: StreamChange, reason: str = "") -> StreamEvent:
        """Return an event about the latest take of a performer."""
        take = self.pool[performer].take
        return StreamEvent(performer=performer, event=event, take=take, reason=reason)
