"""Upkeep: what is done for a run between frames, on the wall clock: stalls, silence, stats, snapshots."""

import hashlib
import logging
import math
import time
from collections.abc import Container
from pathlib import Path
from typing import NamedTuple

import msgspec

from mossar_adapters.abilities import HasPosition, Resumes, Syncs, offered
from mossar_adapters.pipeline.counting import counters_of, explanation
from mossar_adapters.pipeline.feed import Feed
from mossar_adapters.pipeline.inbox import Arrival
from mossar_adapters.pipeline.run import Run
from mossar_adapters.pipeline.slots_of_run import sources_with_slots
from mossar_adapters.pipeline.snapshot import Snapshot, write_snapshot
from mossar_adapters.pipeline.watch import Watch
from mossar_stream import MossarError, Moves, SnapshotError, StatsEvent

STOPPED = "frames stopped"  # why a take ended whose frames no longer come; `gap` is a step in their times
SILENCE = 3.0  # s without a frame after which a source explains itself
_JUST_NOW = 0.5  # s, in which too few frames come for a rate
_SHORTEST = 1e-9  # s that there must be for a rate; a clock of nonsense may have less
_TRAILING = 0.05  # s after the last frame in which the rest of its messages may come
_FEW = 5  # frames that may be dropped without a line
_MOST_LOGGED = 20  # performers that are logged for frames without any joint
_CHECK_EVERY = 0.02  # s between two checks

_log = logging.getLogger("mossar.pipeline")


class _Mark(NamedTuple):
    """What was counted of a performer: frames, the time of its stream that passed (s), and when (monotonic s)."""

    frames: int
    length: float
    at: float


_FIRST = _Mark(1, 0.0, -math.inf)


class Upkeep:
    """Notices stalls and silence, sends stats, writes snapshots.

    Args:
        stats: Seconds between two stats events; None for none.
        snapshot: File for snapshots; None for none.
        period: Seconds between two snapshots.
    """

    def __init__(
        self, *, stats: float | None = None, snapshot: Path | None = None, period: float = 5.0
    ) -> None:
        self._stats = stats
        self._path = snapshot
        self._period = period
        self._unwritten = False  # whether the latest snapshot could not be written
        self._moves: Moves | None = None  # those of the digest:
        self._moves_digest = b""
        self._watch = Watch(lambda _: 1.0)
        self._checked = 0.0  # monotonic s
        self._stats_due = float("inf")
        self._snapshot_due = float("inf")
        self._received: dict[int, int] = {}  # messages of each silent source when its silence began
        self._explained: set[int] = set()  # sources whose silence was explained
        # Frames of each performer, and those without joints, at the last check.
        self._nobody: dict[str, tuple[int, int]] = {}
        self._late: dict[
            str, tuple[int, int]
        ] = {}  # of each performer at the last check: frames, and dropped ones
        self._dropped: set[str] = set()  # performers of whom it was logged that most frames are dropped
        self._empty: set[str] = set()  # performers whose frames without joints were logged
        self._nobody_due = 0.0  # monotonic s
        self._logged = 0  # how often that was logged
        self._full: set[int] = set()  # sources whose full queue was logged
        self._counted: dict[
            str, tuple[_Mark, _Mark]
        ] = {}  # of each performer at the last stats, and at those before

    def begin(self, run: Run) -> None:
        """Start the clocks."""
        now = time.monotonic()
        self._watch = Watch(run.max_pause)
        self._stats_due = now + self._stats if self._stats else float("inf")
        self._snapshot_due = now + self._period if self._path else float("inf")
        self._write(run, complete=False)  # from here on a run that is killed can go on with its outputs

    def heard(self, run: Run, arrival: Arrival, performer: str) -> bool:
        """Take note that frames came; return whether they had stalled."""
        feed = run.feeds[arrival.source]
        feed.heard_at, feed.delivered = arrival.at, True
        self._explained.discard(arrival.source)
        if not feed.source.live:
            return False
        return self._watch.heard(performer, arrival.source, arrival.at, arrival.came)

    def forget(self, source: int) -> None:
        """Stop watching a source that has ended."""
        self._watch.forget(source)

    def keep(self, performers: Container[str]) -> None:
        """Stop watching all others."""
        self._watch.keep(performers)
        for table in (self._counted, self._nobody, self._late):
            for name in [name for name in table if name not in performers]:
                del table[name]
        self._empty = {name for name in self._empty if name in performers}
        self._dropped = {name for name in self._dropped if name in performers}

    def leave(self, performer: str) -> None:
        """Stop watching a performer who has left."""
        self._watch.leave(performer)

    def check(self, run: Run) -> None:
        """Do what is due."""
        now = time.monotonic()
        if now - self._checked < _CHECK_EVERY:
            return
        self._checked = now
        self._look_for_stalls(run, now)
        self._look_for_silence(run, now)
        if now >= self._nobody_due:
            self._nobody_due = now + SILENCE
            self._look_for_nobody(run)
            self._look_for_dropped(run)
        if now >= self._stats_due:
            self._stats_due = max(now, self._stats_due + (self._stats or 0.0))
            self.send_stats(run)
        if now >= self._snapshot_due:
            self._snapshot_due = now + self._period
            if all(outlet.drain(0.5) for outlet in run.outlets):
                self._write(run, complete=False)

    def send_stats(self, run: Run) -> None:
        """Send the counters of all performers, and say them."""
        for performer in sorted(run.pool.names):
            event = self.stats_of(run, performer)
            run.send([event])
            _log.info("stats: %s", _in_words(event))

    def stats_of(self, run: Run, performer: str) -> StatsEvent:
        """Return the counters of a performer; the rate is that since the last stats, on the source's clock."""
        source = run.naming.source_of(performer)
        counted = counters_of(run.feeds[source].source)
        quantiles = run.latency[performer].quantiles_ms() if performer in run.latency else None
        stats = run.pool[performer].stats
        fps = self._rate(performer, stats["frames"], run.stream_time.lengths.get(performer, 0.0))
        return StatsEvent(
            performer=performer,
            fps=round(fps, 2),
            malformed=counted.get("malformed", 0) + run.unusable.get(performer, 0),
            kernel_drops=counted.get("kernel_drops", 0),
            retimed=counted.get("retimed", 0),
            queue_dropped=run.inbox.dropped[source]
            + run.beginnings[source].dropped
            + counted.get("skipped", 0),
            latency_p50_ms=quantiles[0] if quantiles else None,
            latency_p99_ms=quantiles[1] if quantiles else None,
            **stats,
        )

    def _rate(self, performer: str, frames: int, length: float) -> float:
        """Return the rate since the last stats, Hz, or since those before if the last ones were sent just now."""
        mark = _Mark(frames, length, time.monotonic())
        last, before = self._counted.get(performer, (_FIRST, _FIRST))
        if mark.at - last.at < _JUST_NOW:
            last = before
        else:
            self._counted[performer] = mark, last
        passed = mark.length - last.length
        return (mark.frames - last.frames) / passed if passed > _SHORTEST else 0.0

    def keeps_takes(self, run: Run) -> bool:
        """Return whether takes stay open at the end: the run was cut short and is to go on later."""
        return self._path is not None and not run.outcome.complete

    def end(self, run: Run) -> None:
        """Send the last stats, say what was lost, and write the last snapshot."""
        self._look_for_nobody(run)
        self._look_for_dropped(run)
        if self._stats or self._path is not None:  # the delays of all events count, and none may be lost
            for outlet in run.outlets:
                outlet.settle()
        if self._stats:
            self.send_stats(run)
        if self._path is not None:
            self._write(run, complete=run.outcome.complete and not run.outcome.errors)
            if self._unwritten:
                run.outcome.dead_sinks.append(str(self._path))
        for feed, dropped in zip(run.feeds, run.inbox.dropped, strict=True):
            if dropped:
                _log.warning(
                    "%s: %d frames were dropped, they came faster than they were used",
                    feed.source.name,
                    dropped,
                )

    def resume(self, run: Run, snapshot: Snapshot) -> None:
        """Go on where a snapshot was written.

        Raises:
            SnapshotError: If it is of other sources or settings.
        """
        if not run.naming.fits(snapshot.sources):
            names = ", ".join(position.name for position in snapshot.sources)
            raise SnapshotError(f"the snapshot is of other sources ({names}); delete it to start anew")
        if snapshot.settings != msgspec.json.encode(run.settings):
            raise SnapshotError("the snapshot was made with other settings; delete it to start anew")
        run.pool.restore(snapshot.performers, snapshot.pool)
        if snapshot.moves != self._digest(run.pool.moves):
            _log.warning("moves are not those of the snapshot; those of now are recognised from here on")
        run.naming.resume(snapshot.sources)
        for number, slots in sources_with_slots(run).items():
            slots.recall(snapshot.people[number] if number < len(snapshot.people) else b"")
        for feed, position in zip(run.feeds, snapshot.sources, strict=True):
            if (source := offered(feed.source, Resumes)) is not None:
                source.resume(position.frames)

    def save(self, run: Run) -> None:
        """Write a snapshot now, if any are written: what a request changed is kept from its answer on."""
        self._write(run, complete=False)

    def _digest(self, moves: Moves | None) -> bytes:
        """Return a digest of moves; empty without moves."""
        if moves is not self._moves:
            self._moves = moves
            self._moves_digest = b"" if moves is None else hashlib.sha256(moves.to_json()).digest()
        return self._moves_digest

    def _write(self, run: Run, *, complete: bool) -> None:
        """Write a snapshot, after the outputs that it counts on."""
        if self._path is None:
            return
        sinks = [outlet.sink for outlet in run.outlets]
        try:
            for sink in sinks:
                if (written := offered(sink, Syncs)) is not None:
                    written.sync()
            slots = sources_with_slots(run)
            snapshot = Snapshot(
                settings=msgspec.json.encode(run.settings),
                complete=complete,
                sources=run.naming.positions(),
                performers=run.pool.snapshot(),
                pool=run.pool.lasting(),
                moves=self._digest(run.pool.moves),
                sinks={
                    sink.name: own.position()
                    for sink in sinks
                    if (own := offered(sink, HasPosition)) is not None
                },
                run=run.run_id,
                people=tuple(slots[i].to_bytes() if i in slots else b"" for i in range(len(run.feeds))),
            )
            write_snapshot(self._path, snapshot)
        except MossarError as error:
            if not self._unwritten:
                _log.error("%s", error)
            self._unwritten = True
        else:
            self._unwritten = False

    def _look_for_stalls(self, run: Run, now: float) -> None:
        # Silence is what a reader has heard: after a pause of the whole machine, frames may wait in the socket.
        until = {i: feed.looked_at for i, feed in enumerate(run.feeds)} | run.inbox.oldest()
        for performer, finding in self._watch.check(now, until):
            if performer not in run.pool:  # others have taken its place
                self._watch.leave(performer)
            elif finding == "stalled":
                run.send([run.stream_event(performer, "stalled", "no frames for 0.3 s")])
            else:
                run.end_take(performer, STOPPED)
                run.stream_time.absent(performer)

    def _look_for_silence(self, run: Run, now: float) -> None:
        for i, feed in enumerate(run.feeds):
            quiet = 0.0 if i in run.inbox.oldest() else now - feed.heard_at
            if not run.running[i] or quiet < _TRAILING:
                self._received.pop(i, None)
            elif i not in self._received:
                self._received[i] = counters_of(feed.source).get("received", 0)
            if run.running[i] and quiet > SILENCE and i not in self._explained:
                self._explained.add(i)
                _log.warning("%s", self._silence(feed, self._received[i]))
            if run.inbox.dropped[i] and i not in self._full:
                self._full.add(i)
                _log.warning(
                    "%s: frames come faster than they are used; the oldest are dropped", feed.source.name
                )

    def _look_for_nobody(self, run: Run) -> None:
        """Log once for each performer that its frames have no joints."""
        for performer in run.pool.names:
            stats = run.pool[performer].stats
            frames, unseen = self._nobody.get(performer, (0, 0))
            self._nobody[performer] = stats["frames"], stats["unseen"]
            if performer not in self._empty and 0 < stats["frames"] - frames == stats["unseen"] - unseen:
                self._empty.add(performer)
                self._logged += 1
                if (
                    self._logged <= _MOST_LOGGED
                ):  # more, in a flood of names, would fill a pipe that nobody reads
                    _log.warning(
                        "%s: frames come without a tracked joint: all joints are missing, or more than 100 km away%s",
                        performer,
                        "; others are not logged" if self._logged == _MOST_LOGGED else "",
                    )

    def _look_for_dropped(self, run: Run) -> None:
        """Log once for each performer that most of its frames are dropped."""
        for performer in run.pool.names:
            stats = run.pool[performer].stats
            frames, late = self._late.get(performer, (0, 0))
            self._late[performer] = stats["frames"], stats["out_of_order"]
            came, dropped = stats["frames"] - frames, stats["out_of_order"] - late
            if performer in self._dropped or dropped <= max(came // 2, _FEW):
                continue
            self._dropped.add(performer)
            if len(self._dropped) <= _MOST_LOGGED:
                _log.warning(
                    "%s: %d of %d frames are dropped: their times are not later than those before",
                    performer,
                    dropped,
                    came,
                )

    def _silence(self, feed: Feed, before: int) -> str:
        """Return what is known of why no frames come: what never came is another matter than what stopped.

        Args:
            feed: Whose source is silent.
            before: Messages that had come when the silence began.
        """
        name, why = feed.source.name, explanation(feed.source)
        if not feed.delivered:
            return why or f"{name}: no frames for {SILENCE:.0f} s"
        came = counters_of(feed.source).get("received", 0) - before
        if came:
            return f"{name}: the frames have stopped; {came} messages came since, without a frame. {why}"
        return f"{name}: the frames have stopped, and nothing else comes; is the sender still running?"


def _in_words(event: StatsEvent) -> str:
    words = [event.performer, f"{event.frames} frames", f"{event.fps:.1f} fps"]
    if event.latency_p50_ms is not None:
        words.append(f"latency {event.latency_p50_ms:.2f} ms median, {event.latency_p99_ms:.2f} ms 99 %")
    names = (
        "out_of_order",
        "outliers",
        "held",
        "gaps",
        "unseen",
        "malformed",
        "kernel_drops",
        "queue_dropped",
        "retimed",
    )
    words += [f"{getattr(event, name)} {name.replace('_', ' ')}" for name in names if getattr(event, name)]
    return ", ".join(words)
