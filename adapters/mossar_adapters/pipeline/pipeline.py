"""Pipeline: sources -> inbox -> segmenters -> outlets.

    reader thread per source ──▶ inbox ──▶ this thread: pool of segmenters ──▶ outlet per sink, with a thread

Everything that changes a segmenter happens in the thread that calls `run`. Readers and writers have bounded
queues, so that neither a burst nor a slow receiver takes memory, and no sink stalls the stream.
"""

import logging
import math
import secrets
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import cast

import msgspec

from mossar_adapters.files.body import body_joints, body_meta
from mossar_adapters.files.selection import of_joints
from mossar_adapters.live import OutputClosedError
from mossar_adapters.pipeline.emission import Emission
from mossar_adapters.pipeline.inbox import Arrival
from mossar_adapters.pipeline.newcomers import Allowance
from mossar_adapters.pipeline.outcome import GUESSED_LIMBS, WITHOUT_LIMBS, Outcome, in_words
from mossar_adapters.pipeline.outlet import Outlet, Parcel
from mossar_adapters.pipeline.performer_record import LatestFrames, PerformerRecord
from mossar_adapters.pipeline.pool import Pool
from mossar_adapters.pipeline.run import Run
from mossar_adapters.pipeline.snapshot import Snapshot
from mossar_adapters.pipeline.take_starts import is_start, parts, take_starts
from mossar_adapters.pipeline.upkeep import Upkeep
from mossar_adapters.receiving.batch import MAX_PERFORMERS
from mossar_adapters.sink import FrameSink, Sink
from mossar_adapters.source import Departure, Meta, Occupant, Source
from mossar_stream import (
    Event,
    FrameError,
    Frames,
    Moves,
    Settings,
    SettingsError,
    StreamEvent,
    limbs_are_guessed,
)

_POLL = 0.05  # s between two looks at the clock when nothing comes
_IDLE = 2.0  # s without frames after which a performer makes room for a newcomer
_MOST_LOGGED = 20  # performers that cannot be followed and are logged
_LEAVE = 1.0  # s given to a reader to end
_RUN_BYTES = 6  # of a run's name: two of a million runs are called the same once in 280 million times
_NAMES = 4 * MAX_PERFORMERS  # names of a source, after which the least recently used are forgotten

_log = logging.getLogger("mossar.pipeline")


class Pipeline(Run):
    """Segments the frames of sources and hands the events to sinks: a `Run` with its loop.

    Args:
        sources: At least one.
        sinks: Sinks of events; those that have `send_frames` get the frames, too.
        views: Sinks that get every event, independent of `emit`.
        settings: Settings of the segmenters.
        emit: Which events go out, see `Emission`.
        seconds: Stop after so much time of the stream, for each performer.
        upkeep: Work between frames; by default stalls and silence are noticed.
        moves: That are recognised of all performers.
        follow: Names of those that are followed, or True for all.
        resume: Snapshot of a run that was cut short, to go on with; its name comes before `run_id`.
        run_id: Name of the run, by which receivers distinguish its events from those of other runs; a new one if None.
        tick: Called about every 0.05 s from the thread that segments.

    Raises:
        SettingsError: If a setting or `emit` is impossible for a stream.
        MovesError: If `follow` has a name that the moves lack.
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
        moves: Moves | None = None,
        follow: Iterable[str] | bool = (),
        resume: Snapshot | None = None,
        run_id: str | None = None,
        tick: Callable[[], None] = lambda: None,
    ) -> None:
        settings = settings or Settings()
        if settings.range == "file":
            raise SettingsError(
                "setting range=file needs a whole recording: use mossar segment, or range=running here"
            )
        pool = Pool(settings, MAX_PERFORMERS, moves=moves, follow=follow)
        name = (resume.run if resume is not None else "") or run_id or new_run_id()
        super().__init__(sources, settings, pool, seconds, name)
        self._unfollowed_logged = 0  # performers that cannot be followed and were logged
        self._ended: set[int] = set()  # sources that were refused
        self._came = False  # whether a performer was ever followed
        self._limbs_lack = False  # whether it was logged that a performer has no limbs, or none with names
        self._allowances = [Allowance() for _ in sources]  # of each source
        self._put_off: set[int] = set()  # sources of which it was logged that they bring too much that is new
        emission = Emission(emit)
        self.outlets = [self._outlet(sink, emission) for sink in sinks]
        self.outlets += [self._outlet(view, Emission()) for view in views]
        # Sinks of this thread come before other threads wake up and take the processor.
        self.outlets.sort(key=lambda outlet: not outlet.prompt)
        self.upkeep = upkeep or Upkeep()
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
            while not self._stopping and any(self.running) and not self.is_over():
                arrival = self.inbox.get(_POLL)
                if arrival is not None:
                    self._take(arrival)
                self._check_outlets()
                self.upkeep.check(self)
                self._tick()
            self.outcome.complete = not self._stopping
            self.outcome.none_followed = not self.outcome.frames and any(
                performer.is_unfollowed for performer in self.performers.values()
            )
        finally:
            self._finish()
        return self.outcome

    def stop(self) -> None:
        """Make `run` flush, close and return. Signal handlers and other threads may call it."""
        self._stopping = True

    def ask(self, request: Callable[[], None]) -> None:
        """Have something done by the thread that segments. Any thread may call it."""
        self.inbox.ask(request)

    def set(self, changes: Mapping[str, object], performer: str | None = None) -> bool:
        """Change settings of a performer, or of all and of new ones, and send the events of takes that this ends.

        Returns:
            Whether a take ended.

        Raises:
            SettingsError: If a name is unknown or a value is illegal.
            FrameError: If there is no such performer.
        """
        for record in self.performers.values():
            record.max_pause = None
        events = self.pool.set(changes, performer)
        self.send(events)
        for name in self.pool.names if performer is None else (performer,):
            self._announce_settings(self.performers[name])
        return any(isinstance(event, StreamEvent) and event.event == "ended" for event in events)

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
            performer = self.performers.get(parcel.item[0].performer)
            if performer is not None:
                performer.latency.add(time.monotonic() - parcel.arrived_at)

    def _take(self, arrival: Arrival) -> None:
        item = arrival.item
        if arrival.source in self._ended:  # earlier items of a source that was refused
            return
        if isinstance(item, Meta):
            self._announce(item, arrival)
        elif isinstance(item, Frames):
            self._push(item, arrival)
        elif isinstance(item, Departure):
            self._end_departed(item, arrival.source)
        elif isinstance(item, Occupant):
            self._change_occupant(item, arrival.source)
        elif isinstance(item, Exception) or item is None:
            self._end_source(arrival.source, item)
        else:
            item()

    def _performer(self, source: int, own: str) -> PerformerRecord:
        """Return the record of a performer of a source; a flood of names takes no memory."""
        if len(self.performers) > _NAMES * len(self.feeds):
            self.naming.forget(self.pool.names, MAX_PERFORMERS)
        return self.naming.performer(source, own)

    def _announce(self, meta: Meta, arrival: Arrival) -> None:
        performer = self._performer(arrival.source, meta.performer)
        has_room = performer.name in self.pool or len(self.pool) < MAX_PERFORMERS
        # Otherwise it is followed with its first frames, if there is room then.
        if has_room and self._may_be_new(performer, meta, arrival):
            self._follow(performer, meta)

    def _may_be_new(self, performer: PerformerRecord, meta: Meta, arrival: Arrival) -> bool:
        """Return whether a performer or a skeleton is known, or its live source may bring something new."""
        skeleton = body_meta(self._described(performer, meta)).skeleton
        if performer.name in self.pool and self.pool[performer.name].skeleton == skeleton:
            return True
        if not self.feeds[performer.source].source.live:
            return True
        return self._allowances[performer.source].grants(len(skeleton), arrival.at)

    def _described(self, performer: PerformerRecord, meta: Meta) -> Meta:
        """Return a meta; of a sender that has not described its skeleton since it was last forgotten, with the known one.

        Senders describe it once. A run that goes on from a snapshot did not hear that.
        """
        if not meta.assumed:
            return meta
        if performer.name in self.pool:
            known = self.pool[performer.name].skeleton
        elif performer.followed is not None:
            known = performer.followed.skeleton
        else:
            return meta
        return meta if len(known) != len(meta.skeleton) else msgspec.structs.replace(meta, skeleton=known)

    def _follow(self, performer: PerformerRecord, meta: Meta) -> None:
        """Add a performer, or set its new skeleton."""
        performer.meta = meta
        whole = self._described(performer, meta)
        meta = performer.followed = body_meta(whole)
        performer.body = body_joints(whole.skeleton, whole.reference)
        try:
            events = self.pool.announce(performer.name, meta.skeleton, meta.fps)
        except FrameError as error:
            if self._names_joints():
                text = f"{performer.name} cannot be followed: {error}"
                self._refuse_source(performer.source, FrameError(text))
            else:
                self._log_unfollowed(performer, error)
            return
        except Exception as error:  # noqa: BLE001 - no error of one performer may end the run
            self._log_unfollowed(performer, error)
            return
        self._came = True
        performer.is_refused = performer.is_unfollowed = False
        self._look_for_limbs(performer)
        self.send(events)
        for outlet in self.outlets:
            outlet.put(
                self._announcement(performer) if outlet.takes_events else Parcel(_called(whole, performer))
            )

    def _names_joints(self) -> bool:
        """Return whether the first performer is to have joints that the user names: else the name is wrong."""
        named = (self.settings.limbs, self.settings.feet)
        now = (self.pool.settings.limbs, self.pool.settings.feet)
        return not self._came and now == named and any(isinstance(text, str) and text for text in named)

    def _refuse_source(self, source: int, error: FrameError) -> None:
        """End a source whose first performer lacks joints that the user names, as `SelectedSource` does."""
        self.feeds[source].stop()
        self._ended.add(source)
        self._end_source(source, error)

    def _announce_settings(self, performer: PerformerRecord) -> None:
        """Announce a performer whose settings have changed once more, to sinks of events."""
        if performer.followed is not None:
            for outlet in self.outlets:
                if outlet.takes_events:
                    outlet.put(self._announcement(performer))

    def _announcement(self, performer: PerformerRecord) -> Parcel:
        """Return the meta of a followed performer with the fields that receivers of events need."""
        settings = msgspec.to_builtins(self.pool[performer.name].settings)
        meta = _called(cast("Meta", performer.followed), performer)
        return Parcel(msgspec.structs.replace(meta, settings=settings, run=self.run_id))

    def _look_for_limbs(self, performer: PerformerRecord) -> None:
        """Log, once in a run, that limbs are wanted of a performer whose skeleton leaves none or does not name them."""
        segmenter = self.pool[performer.name]
        if self._limbs_lack or not segmenter.settings.limbs:
            return
        where = self._source_name(performer)
        if not segmenter.limbs:
            _log.warning("%s: %s has no limbs, as %s", where, performer.name, WITHOUT_LIMBS)
        elif segmenter.settings.limbs is True and limbs_are_guessed(segmenter.skeleton):
            _log.info("%s: %s: %s", where, performer.name, GUESSED_LIMBS)
        else:
            return
        self._limbs_lack = True

    def _log_unfollowed(self, performer: PerformerRecord, error: Exception) -> None:
        """Log once for a performer why it cannot be followed; among many, only for the first ones."""
        if not performer.is_unfollowed and self._unfollowed_logged < _MOST_LOGGED:
            self._unfollowed_logged += 1
            more = "; others are not logged any more" if self._unfollowed_logged == _MOST_LOGGED else ""
            where, name = self._source_name(performer), performer.name
            _log.warning("%s: %s cannot be followed: %s%s", where, name, in_words(error), more)
        performer.is_unfollowed = True

    def _ensure_followed(self, performer: PerformerRecord, frames: Frames, arrival: Arrival) -> bool:
        """Give a performer a segmenter if it has none; return whether it has one. If not, its frames are counted."""
        meta = arrival.meta
        if meta is None or (performer.meta is meta and performer.name in self.pool):
            return True
        if not self._has_room(performer, frames, arrival):
            self._turn_away(performer, len(frames))
            return False
        if not self._may_be_new(performer, meta, arrival):
            self._put_it_off(performer, len(frames))
            return False
        if performer.name not in self.pool:  # others may have taken its place
            performer.watch.leave()
        self._follow(performer, meta)
        return True

    def _has_room(self, performer: PerformerRecord, frames: Frames, arrival: Arrival) -> bool:
        """Return whether a performer can be followed, if need be in place of one that no frames come of."""
        if performer.name in self.pool or len(self.pool) < MAX_PERFORMERS:
            return True
        longest = self.performers[self.pool.names[0]]  # that is idle for longest
        if longest.latest is None:
            return True
        if self.feeds[longest.source].source.live:
            return arrival.at - longest.latest.at > _IDLE
        return longest.source == performer.source and float(frames.times[0]) - longest.latest.time > _IDLE

    def _push(self, frames: Frames, arrival: Arrival) -> None:
        if self.beginnings[arrival.source].is_old(arrival, len(frames)):
            return
        performer = self._performer(arrival.source, frames.performer)
        performer.received += len(frames)
        if frames.performer != performer.name:
            frames = msgspec.structs.replace(frames, performer=performer.name)
        if not self._ensure_followed(performer, frames, arrival):
            return
        performer.latest = LatestFrames(arrival.at, float(frames.times[-1]))
        resumed = self.upkeep.heard(self, arrival, performer)
        max_pause = self.max_pause(performer)
        frames = performer.time.within(frames, math.inf if self.seconds is None else self.seconds, max_pause)
        if not len(frames):
            return
        odd = performer.steps.finding(frames, max_pause)
        if odd:
            _log.warning("%s: %s: %s", self._source_name(performer), performer.name, odd)
        for part in parts(frames, max_pause):
            self._segment(performer, part, arrival.at, resumed=resumed)
            resumed = False

    def _segment(
        self, performer: PerformerRecord, whole: Frames, arrived_at: float, *, resumed: bool
    ) -> None:
        """Push frames, and hand them on with the events that they cause.

        Args:
            performer: Whose frames they are.
            whole: The frames, with all joints of the source.
            arrived_at: Monotonic s.
            resumed: Whether frames had stalled before.
        """
        frames = of_joints(whole, performer.body)
        try:
            events = self.pool.push(frames)
        except Exception as error:  # noqa: BLE001 - no error of one performer may end the run
            self._refuse(performer, len(frames), error)
            return
        self.outcome.frames += len(frames)
        starts = take_starts(events, frames)
        if starts:
            events = [_of_run(event, self.run_id) for event in events]
            events = performer.reasons.add_to(events, starts[0].time)
        performer.reasons.seen(float(frames.times[-1]))
        if resumed:
            place = max((i for i, event in enumerate(events, 1) if is_start(event)), default=0)
            events.insert(place, self.stream_event(performer.name, "resumed"))
        parcels = [*map(Parcel, starts)]
        if events:
            parcels.append(Parcel(events, arrived_at))
        for outlet in self.outlets:
            outlet.put(Parcel(frames if outlet.takes_events else whole, arrived_at))
            for parcel in parcels:
                outlet.put(parcel)

    def _turn_away(self, performer: PerformerRecord, count: int) -> None:
        """Count the frames of a newcomer without room; log the first."""
        # The latest comes first: in a flood of names it was refused, and the search ends there.
        if not any(other.is_refused for other in reversed(self.performers.values())):
            _log.warning(
                "%d performers are followed and all of them move: %s and other newcomers are refused, and counted",
                MAX_PERFORMERS,
                performer.name,
            )
        performer.is_refused = True
        performer.unusable += count

    def _put_it_off(self, performer: PerformerRecord, count: int) -> None:
        """Count the frames of new performers beyond the allowance; log it once for each source."""
        if performer.source not in self._put_off:
            self._put_off.add(performer.source)
            _log.warning(
                "%s: more new performers or skeletons come than one second allows; %s and others wait, and their frames "
                "are counted",
                self._source_name(performer),
                performer.name,
            )
        performer.unusable += count

    def _end_departed(self, departure: Departure, source: int) -> None:
        performer = self.naming.known(source, departure.performer)
        if performer is not None and performer.name in self.pool:
            self.end_take(performer.name, departure.reason)
            performer.watch.leave()
            performer.time.is_absent = True

    def _change_occupant(self, occupant: Occupant, source: int) -> None:
        """Note the person whose frames follow; for another person, range and noise are reset."""
        performer = self._performer(source, occupant.performer)
        performer.reasons.set_occupant(occupant.id, another=occupant.another)
        if occupant.another and performer.name in self.pool:
            self.send(self.pool.reset(performer.name, "another person"))

    def _refuse(self, performer: PerformerRecord, count: int, error: Exception) -> None:
        if not performer.unusable and not performer.is_unfollowed:  # otherwise the reason was logged before
            _log.warning("frames of %s cannot be used and are counted: %s", performer.name, in_words(error))
        performer.unusable += count

    def _end_source(self, source: int, error: Exception | None) -> None:
        self.running[source] = False
        if error is not None:
            name = self.feeds[source].source.name
            text = str(error) if str(error).startswith(name) else f"{name}: {error}"
            _log.error("%s", " ".join(text.split()))
            self.outcome.errors.append(error)
        self.end_takes(source, "end of stream" if error is None else "source failed")
        for performer in self.naming.of_source(source):
            performer.watch.leave()
            performer.time.is_absent = True

    def _source_name(self, performer: PerformerRecord) -> str:
        return self.feeds[performer.source].source.name

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


def _called(meta: Meta, performer: PerformerRecord) -> Meta:
    name = performer.name
    return meta if meta.performer == name else msgspec.structs.replace(meta, performer=name)


def _of_run(event: Event, run: str) -> Event:
    return msgspec.structs.replace(event, run=run) if is_start(event) else event


def new_run_id() -> str:
    """Return a name that no other run has."""
    return secrets.token_hex(_RUN_BYTES)
