"""Upkeep: work for a run between frames, on the wall clock: stalls, silence, stats, snapshots."""

import hashlib
import logging
import time
from pathlib import Path

import msgspec

from mossar_adapters.abilities import HasPosition, Resumes, Syncs, offered
from mossar_adapters.pipeline.counting import counters_of, explanation
from mossar_adapters.pipeline.feed import Feed
from mossar_adapters.pipeline.inbox import Arrival
from mossar_adapters.pipeline.performer_record import PerformerRecord
from mossar_adapters.pipeline.run import Run
from mossar_adapters.pipeline.slots_of_run import sources_with_slots
from mossar_adapters.pipeline.snapshot import Snapshot, write_snapshot
from mossar_adapters.pipeline.tally import Counts
from mossar_stream import MossarError, Moves, SnapshotError, StatsEvent

STOPPED = "frames stopped"  # why a take ended whose frames no longer come; `gap` is a step in their times
SILENCE = 3.0  # s without a frame after which a source explains itself
_TRAILING = 0.05  # s after the last frame in which the rest of its messages may come
_FEW = 5  # frames that may be dropped without a line
_MOST_LOGGED = 20  # performers that are logged for frames without any joint, or for dropped ones
_CHECK_EVERY = 0.02  # s between two checks

_log = logging.getLogger("mossar.pipeline")


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
        self._checked = 0.0  # monotonic s
        self._stats_due = float("inf")
        self._snapshot_due = float("inf")
        self._received: dict[int, int] = {}  # messages of each silent source when its silence began
        self._explained: set[int] = set()  # sources whose silence was explained
        self._counts_due = 0.0  # monotonic s
        self._empty_logged = 0  # performers that were logged for frames without any joint
        self._dropped_logged = 0  # performers that were logged for dropped frames
        self._full: set[int] = set()  # sources whose full queue was logged

    def begin(self, run: Run) -> None:
        """Start the clocks."""
        now = time.monotonic()
        self._stats_due = now + self._stats if self._stats else float("inf")
        self._snapshot_due = now + self._period if self._path else float("inf")
        self._write(run, complete=False)  # from here on a run that is killed can go on with its outputs

    def heard(self, run: Run, arrival: Arrival, performer: PerformerRecord) -> bool:
        """Note that frames came; return whether they had stalled."""
        feed = run.feeds[arrival.source]
        feed.heard_at, feed.delivered = arrival.at, True
        self._explained.discard(arrival.source)
        if not feed.source.live:
            return False
        return performer.watch.heard(arrival.at, arrival.came)

    def check(self, run: Run) -> None:
        """Do the work that is due."""
        now = time.monotonic()
        if now - self._checked < _CHECK_EVERY:
            return
        self._checked = now
        self._look_for_stalls(run, now)
        self._look_for_silence(run, now)
        if now >= self._counts_due:
            self._counts_due = now + SILENCE
            self._look_at_counts(run)
        if now >= self._stats_due:
            self._stats_due = max(now, self._stats_due + (self._stats or 0.0))
            self.send_stats(run)
        if now >= self._snapshot_due:
            self._snapshot_due = now + self._period
            if all(outlet.drain(0.5) for outlet in run.outlets):
                self._write(run, complete=False)

    def send_stats(self, run: Run) -> None:
        """Send the counters of all performers, and log them."""
        for performer in sorted(run.pool.names):
            event = self.stats_of(run, performer)
            run.send([event])
            _log.info("stats: %s", _in_words(event))

    def stats_of(self, run: Run, performer: str) -> StatsEvent:
        """Return the counters of a performer; the rate is that since the last stats, on the source's clock."""
        record = run.performers[performer]
        counted = counters_of(run.feeds[record.source].source)
        quantiles = record.latency.quantiles_ms()
        stats = run.pool[performer].stats
        fps = record.tally.rate(stats["frames"], record.time.length, time.monotonic())
        return StatsEvent(
            performer=performer,
            fps=round(fps, 2),
            malformed=counted.get("malformed", 0) + record.unusable,
            kernel_drops=counted.get("kernel_drops", 0),
            retimed=counted.get("retimed", 0),
            queue_dropped=run.inbox.dropped[record.source]
            + run.beginnings[record.source].dropped
            + counted.get("skipped", 0),
            latency_p50_ms=quantiles[0] if quantiles else None,
            latency_p99_ms=quantiles[1] if quantiles else None,
            **stats,
        )

    def keeps_takes(self, run: Run) -> bool:
        """Return whether takes stay open at the end: the run was cut short and is to go on later."""
        return self._path is not None and not run.outcome.complete

    def end(self, run: Run) -> None:
        """Send the last stats, log losses, and write the last snapshot."""
        self._look_at_counts(run)
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
        """Continue from a snapshot.

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
        """Write a snapshot now, if any are written: the changes of a request are kept from its answer on."""
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
        # The reader decides on silence: after a pause of the whole machine, frames may wait in the socket.
        until = {i: feed.looked_at for i, feed in enumerate(run.feeds)} | run.inbox.oldest()
        for name in run.pool.names:
            performer = run.performers[name]
            findings = performer.watch.check(until.get(performer.source, now), run.max_pause(performer))
            if "stalled" in findings:
                run.send([run.stream_event(name, "stalled", "no frames for 0.3 s")])
            if "ended" in findings:
                run.end_take(name, STOPPED)
                performer.time.is_absent = True

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

    def _look_at_counts(self, run: Run) -> None:
        """Log once for each performer that its frames have no joints, and once that most of them are dropped."""
        for name in run.pool.names:
            stats, tally = run.pool[name].stats, run.performers[name].tally
            new = tally.since_last(Counts(stats["frames"], stats["unseen"], stats["out_of_order"]))
            if not tally.empty_is_logged and 0 < new.frames == new.unseen:
                tally.empty_is_logged = True
                self._log_empty(name)
            if not tally.dropped_is_logged and new.out_of_order > max(new.frames // 2, _FEW):
                tally.dropped_is_logged = True
                self._log_dropped(name, new)

    def _log_empty(self, name: str) -> None:
        self._empty_logged += 1
        # More, in a flood of names, would fill an unread pipe.
        if self._empty_logged <= _MOST_LOGGED:
            _log.warning(
                "%s: frames come without a tracked joint: all joints are missing, or more than 100 km away%s",
                name,
                "; others are not logged" if self._empty_logged == _MOST_LOGGED else "",
            )

    def _log_dropped(self, name: str, new: Counts) -> None:
        self._dropped_logged += 1
        if self._dropped_logged <= _MOST_LOGGED:
            _log.warning(
                "%s: %d of %d frames are dropped: their times are not later than those before",
                name,
                new.out_of_order,
                new.frames,
            )

    def _silence(self, feed: Feed, before: int) -> str:
        """Return the explanation of why no frames come, which differs for frames that never came and frames that stopped.

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
