"""Pipeline: sources -> inbox -> segmenters -> outlets.

    reader thread per source ──▶ inbox ──▶ this thread: pool of segmenters ──▶ outlet per sink, with a thread

Everything that changes a segmenter happens in the thread that calls `run`. Readers and writers have bounded
queues, so that neither a burst nor a slow receiver takes memory, and no sink stalls the stream.
"""

import logging
import time
from collections.abc import Callable, Sequence

import msgspec

from mossar_adapters.live import OutputClosedError
from mossar_adapters.pipeline.emission import Emission
from mossar_adapters.pipeline.feed import Feed
from mossar_adapters.pipeline.inbox import Arrival, Inbox
from mossar_adapters.pipeline.latency import Latency
from mossar_adapters.pipeline.naming import Naming
from mossar_adapters.pipeline.outlet import Outlet, Parcel
from mossar_adapters.pipeline.pool import Pool
from mossar_adapters.pipeline.snapshot import Snapshot
from mossar_adapters.pipeline.take_starts import take_starts
from mossar_adapters.pipeline.upkeep import Upkeep
from mossar_adapters.receiving.batch import MAX_PERFORMERS
from mossar_adapters.sink import FrameSink, Sink
from mossar_adapters.source import Left, Meta, Source
from mossar_stream.errors import FrameError, SettingsError
from mossar_stream.events import Event
from mossar_stream.frames import Frames
from mossar_stream.settings import Settings

_POLL = 0.05  # s between two looks at the clock when nothing comes
_LEAVE = 1.0  # s given to a reader to end
_NAMES = 4 * MAX_PERFORMERS  # names of a source, after which those unheard for longest are forgotten

_log = logging.getLogger("mossar.pipeline")


class Outcome(msgspec.Struct):
    """How a run went.

    Args:
        frames: Frames taken in.
        complete: Whether it came to its own end, instead of being stopped.
        errors: What went wrong with sources, in order.
        dead_sinks: Names of the sinks that failed.
        abandoned: Whether the reader of a sink went away (a closed pipe).
    """

    frames: int = 0
    complete: bool = False
    errors: list[Exception] = msgspec.field(default_factory=list)
    dead_sinks: list[str] = msgspec.field(default_factory=list)
    abandoned: bool = False


class Pipeline:
    """Segments what sources deliver and hands the events to sinks.

    Args:
        sources: At least one.
        sinks: Sinks of events; those that have `send_frames` get the frames, too.
        views: Sinks that get every event, whatever `emit` says.
        settings: Settings of the segmenters.
        emit: Which events go out, see `Emission`.
        seconds: Stop after so much time of the stream, for each performer.
        upkeep: What is done between frames; by default stalls and silence are noticed.
        resume: Snapshot of a run that was cut short, to go on with.
        tick: Called about every 0.05 s from the thread that segments.

    Raises:
        SettingsError: If a setting or `emit` is impossible for a stream.
        SnapshotError: If the snapshot does not belong to this run.
    """

    def __init__(
        self,
        sources: Sequence[Source],
        sinks: Sequence[Sink | FrameSink],
        settings: Settings | None = None,
        *,
        views: Sequence[Sink] = (),
        emit: Sequence[str] = (),
        seconds: float | None = None,
        upkeep: Upkeep | None = None,
        resume: Snapshot | None = None,
        tick: Callable[[], None] = lambda: None,
    ) -> None:
        self.settings = settings or Settings()
        if self.settings.range == "file":
            raise SettingsError(
                "setting range=file needs a whole recording: use mossar segment, or range=running here"
            )
        self.pool = Pool(self.settings, MAX_PERFORMERS)
        self.outcome = Outcome()
        self.latency: dict[str, Latency] = {}  # of each performer
        self.times: dict[str, tuple[float, float]] = {}  # first and last time of each performer, s
        self.unusable: dict[str, int] = {}  # frames of each performer that did not fit
        self._metas: dict[str, Meta] = {}  # as announced last, of each performer
        self.inbox = Inbox([source.live for source in sources])
        self.feeds = [Feed(source, i, self.inbox) for i, source in enumerate(sources)]
        self.running = [True] * len(sources)  # whether each source still delivers
        self.naming = Naming([source.name for source in sources])
        self.live = any(source.live for source in sources)
        emission = Emission(emit)
        self.outlets = [self._outlet(sink, emission) for sink in sinks]
        self.outlets += [self._outlet(view, Emission()) for view in views]
        # Those who are fed by this thread come before threads wake up that want the processor.
        self.outlets.sort(key=lambda outlet: not outlet.prompt)
        self.upkeep = upkeep or Upkeep()
        self._seconds = seconds
        self._tick = tick
        self._stopping = False
        if resume is not None:
            self.upkeep.resume(self, resume)

    def run(self) -> Outcome:
        """Run until all sources have ended or `stop` is called; then flush and close everything."""
        for outlet in self.outlets:
            outlet.start()
        for feed in self.feeds:
            feed.start()
        self.upkeep.begin(self)
        try:
            while not self._stopping and any(self.running):
                arrival = self.inbox.get(_POLL)
                if arrival is not None:
                    self._take(arrival)
                self._check_outlets()
                self.upkeep.look(self)
                self._tick()
            self.outcome.complete = not self._stopping
        finally:
            self._finish()
        return self.outcome

    def stop(self) -> None:
        """Make `run` flush, close and return. Signal handlers and other threads may call it."""
        self._stopping = True

    def ask(self, request: Callable[[], None]) -> None:
        """Have something done by the thread that segments. Any thread may call it."""
        self.inbox.ask(request)

    def send(self, events: list[Event], arrived_at: float | None = None) -> None:
        """Hand events to all sinks."""
        if events:
            parcel = Parcel(events, arrived_at)
            for outlet in self.outlets:
                outlet.put(parcel)

    def end_takes(self, source: int, reason: str) -> None:
        """End the takes of all performers of a source."""
        for performer in self.naming.of_source(source):
            if performer in self.pool:
                self.send(self.pool[performer].end_take(reason))

    def _outlet(self, sink: Sink | FrameSink, emission: Emission) -> Outlet:
        return Outlet(
            sink,
            waits=not self.live,
            delivered=self._delivered,
            gives_up=lambda: self._stopping,
            emission=emission,
        )

    def _delivered(self, parcel: Parcel) -> None:
        if parcel.arrived_at is not None and isinstance(parcel.item, list):
            latency = self.latency.get(parcel.item[0].performer)
            if latency is not None:
                latency.add(time.monotonic() - parcel.arrived_at)

    def _take(self, arrival: Arrival) -> None:
        item = arrival.item
        if isinstance(item, Meta):
            self._announce(item, arrival.source)
        elif isinstance(item, Frames):
            self._push(item, arrival)
        elif isinstance(item, Left):
            self._let_go(item, arrival.source)
        elif isinstance(item, Exception) or item is None:
            self._end_source(arrival.source, item)
        else:
            item()

    def _name(self, source: int, performer: str) -> str:
        """Return our name for a performer of a source; a flood of names does not take memory."""
        if len(self.naming) > _NAMES * len(self.feeds):
            self.naming.forget(self.pool.names, MAX_PERFORMERS)
            kept = self.naming.names
            self.upkeep.keep(kept)
            for table in (self.latency, self.times, self.unusable, self._metas):
                for name in set(table) - kept:
                    del table[name]
        return self.naming.name(source, performer)

    def _announce(self, meta: Meta, source: int) -> None:
        self._follow(msgspec.structs.replace(meta, performer=self._name(source, meta.performer)), source)

    def _follow(self, meta: Meta, source: int) -> None:
        self._metas[meta.performer] = meta
        try:
            events = self.pool.announce(meta.performer, meta.skeleton, meta.fps)
        except FrameError as error:
            _log.warning("%s: %s", self.feeds[source].source.name, error)
            return
        self.latency.setdefault(meta.performer, Latency())
        self.send(events)
        for outlet in self.outlets:
            outlet.put(Parcel(meta))

    def _push(self, frames: Frames, arrival: Arrival) -> None:
        name = self._name(arrival.source, frames.performer)
        self.naming.count(arrival.source, frames)
        if frames.performer != name:
            frames = msgspec.structs.replace(frames, performer=name)
        if name not in self.pool and name in self._metas:  # others had taken its place
            self.upkeep.leave(name)
            self._follow(self._metas[name], arrival.source)
        self.upkeep.heard(self, arrival, name)
        before = self.times.get(name, (0.0, None))[1]
        frames = self._within_time(frames)
        if not len(frames):
            return
        try:
            events = self.pool.push(frames)
        except FrameError as error:
            self._refuse(frames, error)
            return
        self.outcome.frames += len(frames)
        parcels = [Parcel(frames, arrival.at)]
        parcels += map(Parcel, take_starts(events, frames, before, self.settings.max_pause))
        if events:
            parcels.append(Parcel(events, arrival.at))
        for outlet in self.outlets:
            for parcel in parcels:
                outlet.put(parcel)

    def _let_go(self, left: Left, source: int) -> None:
        name = self.naming.known(source, left.performer)
        if name is not None and name in self.pool:
            self.send(self.pool[name].end_take(left.reason))
            self.upkeep.leave(name)

    def _within_time(self, frames: Frames) -> Frames:
        """Return the frames before the end that was asked for; stop when all performers have reached it."""
        first = self.times.get(frames.performer, (float(frames.times[0]), 0.0))[0]
        self.times[frames.performer] = (first, float(frames.times[-1]))
        if self._seconds is None or float(frames.times[-1]) - first < self._seconds:
            return frames
        kept = int((frames.times - first < self._seconds).sum())
        if all(last - begin >= self._seconds for begin, last in self.times.values()):
            self.running = [False] * len(self.running)
        return msgspec.structs.replace(
            frames,
            positions=frames.positions[:kept],
            times=frames.times[:kept],
            confidence=None if frames.confidence is None else frames.confidence[:kept],
        )

    def _refuse(self, frames: Frames, error: FrameError) -> None:
        count = self.unusable.get(frames.performer, 0)
        if not count:
            _log.warning("frames of %s cannot be used and are counted: %s", frames.performer, error)
        self.unusable[frames.performer] = count + len(frames)

    def _end_source(self, source: int, error: Exception | None) -> None:
        self.running[source] = False
        if error is not None:
            name = self.feeds[source].source.name
            text = str(error) if str(error).startswith(name) else f"{name}: {error}"
            _log.error("%s", " ".join(text.split()))
            self.outcome.errors.append(error)
        self.end_takes(source, "end of stream" if error is None else "source failed")
        self.upkeep.forget(source)

    def _check_outlets(self) -> None:
        for outlet in list(self.outlets):
            if outlet.error is None:
                continue
            self.outlets.remove(outlet)
            if isinstance(outlet.error, OutputClosedError):
                self.outcome.abandoned = True
                self.stop()
                continue
            _log.error("%s failed and gets no more events: %s", outlet.sink.name, outlet.error)
            self.outcome.dead_sinks.append(outlet.sink.name)
            if not self.outlets:
                self.stop()

    def _finish(self) -> None:
        self.inbox.close()
        for feed in self.feeds:
            feed.stop()
        if not self.upkeep.keeps_takes(self):
            for source in range(len(self.feeds)):
                self.end_takes(source, "end of stream" if self.outcome.complete else "stopped")
        self.upkeep.end(self)
        for outlet in self.outlets:  # all at once: some take half a second for receivers that do not read
            outlet.end()
        for outlet in self.outlets:
            outlet.close()
        self._check_outlets()
        for feed in self.feeds:
            feed.join(_LEAVE)
