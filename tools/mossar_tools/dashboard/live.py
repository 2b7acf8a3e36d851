"""Live: the show of a running pipeline; a sink of its events and frames that remembers the last seconds."""

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from mossar_adapters.pipeline.counting import explanation
from mossar_adapters.pipeline.slots_of_run import exchange, pin, slots_by_source
from mossar_adapters.source import Meta
from mossar_stream import CurveState, Event, Frames, LevelName, MossarError, Moves, Settings, Up
from mossar_tools.console import LOGGER
from mossar_tools.dashboard.followed_moves import States
from mossar_tools.dashboard.glimpse import Glimpse
from mossar_tools.dashboard.levels import needs_other_bundle, strength_of
from mossar_tools.dashboard.recorder import Recorder
from mossar_tools.dashboard.tables import WAITING
from mossar_tools.dashboard.teaching import Teaching
from mossar_tools.dashboard.track import RATE, Track
from mossar_tools.figures import check_picture
from mossar_tools.marks import Mark
from mossar_tools.moves_file import EVERY, followed
from mossar_tools.palette import Palette

if TYPE_CHECKING:
    from mossar_adapters.pipeline import Pipeline
    from mossar_adapters.pipeline.pool import Pool

MOST_PERFORMERS = 4  # shown; the pipeline follows all of them
_UNREAD = 256  # samples kept for the page
_BURST = 240.0  # Hz, of samples after a stall
_FOLLOWS_EVERY = 0.1  # s, looks at the settings in force
_EXPLAINS_EVERY = 1.0  # s
_REMEMBERED = 64  # performers whose last sample is remembered

_COUNTS = ("out_of_order", "outliers", "held", "gaps", "unseen")


_Task = Callable[["Pool"], list[Event]]


class _Sample(msgspec.Struct, frozen=True):
    """Data that the segmenting thread hands over to the page."""

    performer: str
    state: CurveState
    stats: dict[str, int]
    dropped: int
    following: States
    moves: Moves | None
    up: Up


class LiveShow:
    """Remembers the output of a pipeline; implements `Sink` and `FrameSink`.

    Args:
        settings: Those that the pipeline starts with.
        moves: The file of moves that teaching adds to, made if it is not there; None for a new one.
        folder: Where a new one is made; None for here.
        has_people: Whether sources have slots.
        follow: Names of the moves to follow once they are there, or `all`.
        previews: Return the latest picture of a camera and the people in it (`Seen`), None while there is none.

    Raises:
        MossarError: If the file of moves cannot be read.
    """

    name = "the dashboard"
    dropped = 0
    recorded = False

    def __init__(
        self,
        settings: Settings,
        moves: Path | None = None,
        folder: Path | None = None,
        has_people: bool = False,
        previews: Sequence[Callable[[], Any]] = (),
        follow: Sequence[str] = (),
    ) -> None:
        self._follow_names = follow
        self.previews = previews
        self.has_people = has_people
        self.recorder = Recorder()
        self.teaching = Teaching(folder or Path.cwd(), moves, self._recognise)
        self.frozen = False
        self._said = ""  # reason why no frames come
        self._explained = 0.0  # monotonic s, time of the next question to the sources
        self.settings = settings  # as changed since
        self.level: LevelName | float = settings.level
        self._asked: list[_Task] = []  # before there was a pipeline
        self._under_way = 0  # requests of the page
        self._in_force: tuple[Settings, LevelName | float] | None = None  # in the pipeline, as seen last
        self._follows = 0.0  # monotonic s, when to look again
        self._pipeline: Pipeline | None = None
        self._tracks: dict[str, Track] = {}
        self._samples: deque[_Sample] = deque(maxlen=_UNREAD)
        self._latest: dict[str, _Sample] = {}
        self._rates: dict[str, deque[tuple[float, int]]] = {}  # monotonic s, frames so far
        self._due = 0.0  # monotonic s
        self._sampled: dict[str, float] = {}  # source time of the last sample of each performer, s
        self._lock = threading.Lock()
        self._shown: list[Glimpse] = []

    # Methods for the pipeline.

    def announce(self, meta: Meta) -> None:
        """Note a performer."""
        self.recorder.announce(meta)
        self.teaching.announce(meta)
        with self._lock:
            known = self._tracks.pop(meta.performer, None)
            if known is None or known.skeleton != meta.skeleton:
                known = Track(meta.performer, meta.skeleton)
            self._tracks[meta.performer] = known
            while len(self._tracks) > MOST_PERFORMERS:
                gone = next(iter(self._tracks))
                for kept in (self._tracks, self._latest, self._rates):
                    kept.pop(gone, None)

    def send(self, events: Sequence[Event]) -> None:
        """Process events."""
        with self._lock:
            for event in events:
                if event.performer in self._tracks:
                    self._tracks[event.performer].add_event(event)

    def send_frames(self, frames: Frames) -> None:
        """Process frames; record them while recording is on."""
        self.recorder.write(frames)
        self.teaching.send_frames(frames)
        with self._lock:
            track = self._tracks.get(frames.performer)
            if track is not None and len(frames):
                track.add_frames(frames)

    def close(self) -> None:
        """End the recording."""
        self.recorder.stop()

    def tick(self, pipeline: "Pipeline") -> None:
        """Sample the segmenters for the page, 30 times per second of the stream; called by the segmenting thread.

        After a stall, when frames come in a burst, they may come quicker, so that the curve has no holes.
        """
        now = time.monotonic()
        if not self._tracks and now >= self._explained:
            self._explain(pipeline, now)
        if now < self._due:
            return
        self._due = now + 1.0 / _BURST
        self._pipeline = pipeline
        while self._asked:
            self._carry_out(self._asked.pop(0), pipeline)
        if now >= self._follows:
            self._follows = now + _FOLLOWS_EVERY
            self._follow(pipeline.pool)
        for name in pipeline.pool.names[-MOST_PERFORMERS:]:
            performer = pipeline.performers[name]
            reached = performer.time.last or 0.0
            if 0 <= reached - self._sampled.get(name, -1.0) < 0.9 / RATE:
                continue
            self._sampled[name] = reached
            segmenter = pipeline.pool[name]
            state = segmenter.state
            if state is not None:
                dropped = pipeline.inbox.dropped[performer.source]
                following, moves = segmenter.following, pipeline.pool.moves
                up = segmenter.settings.up
                self._samples.append(_Sample(name, state, segmenter.stats, dropped, following, moves, up))
        while len(self._sampled) > _REMEMBERED:
            self._sampled.pop(next(iter(self._sampled)))

    def _explain(self, pipeline: "Pipeline", now: float) -> None:
        """Show the sources' explanation of why no frames come."""
        if self._explained:
            self._said = "; ".join(filter(None, (explanation(feed.source) for feed in pipeline.feeds)))
        self._explained = now + _EXPLAINS_EVERY

    def _follow(self, pool: "Pool") -> None:
        """Adopt settings that were changed elsewhere, as by `control`, once no request of the page is pending."""
        found = pool.settings, pool.level
        if self._under_way or found == self._in_force:
            return
        self._in_force = found
        settings, level = found
        if not isinstance(level, str):  # a number leaves the bundle
            settings = settings.replace(level=self.settings.level)
        self.settings, self.level = settings, level

    # Methods for the page.

    @property
    def waits_for(self) -> str:
        """Reason why there is nothing to see yet."""
        return self._said or WAITING

    def glimpses(self) -> list[Glimpse]:
        """Return the view, one performer each."""
        with self._lock:
            self._read_samples()
            if self.frozen:
                return self._shown
            level = self.strength
            found = [
                track.glimpse(level, self._statistics(name)) for name, track in sorted(self._tracks.items())
            ]
            self._shown = [glimpse for glimpse in found if glimpse is not None]
        return self._shown

    def marks(self) -> list[tuple[str, Mark]]:
        """Return the key frames that are remembered, with their performers."""
        with self._lock:
            level = self.strength
            return [
                (name, mark)
                for name, track in sorted(self._tracks.items())
                for mark in track.marks(level)
                if not mark.tentative
            ]

    def picture(self, palette: Palette) -> tuple[str, bytes]:
        """Return the first performer's name, and the page's picture of it as a PNG.

        Raises:
            MossarError: If matplotlib is missing, or no performer has moved yet.
        """
        check_picture("live.png")
        from mossar_tools.dashboard.live_picture import live_picture

        glimpse = next(iter(self.glimpses()), None)
        if glimpse is None:
            raise MossarError("there is nothing to draw yet")
        with self._lock:
            track = self._tracks.get(glimpse.performer)
            poses = track.key_poses() if track is not None else {}
        word = self.level if isinstance(self.level, str) else "level"
        return glimpse.performer, live_picture(glimpse, poses, (self.strength, word), palette)

    @property
    def strength(self) -> float:
        """The level as a strength."""
        return self.strength_of(self.level)

    def strength_of(self, level: LevelName | float) -> float:
        """Return the strength that a level stands for."""
        return strength_of(self.settings, level)

    def set_level(self, level: LevelName | float) -> None:
        """Move the level of all performers. A number is a strength; a name is that of `--level`.

        A name whose bundle is another one ends the takes, because its strengths are of other features.
        """
        other = needs_other_bundle(self.settings, level)
        if isinstance(level, str):
            self.settings = self.settings.replace(level=level)
        self.level = level
        if other:
            self._ask(lambda pool: self._begin_anew(pool, {"level": level}))
        else:
            self._ask(lambda pool: pool.set({"level": level}))

    def _begin_anew(self, pool: "Pool", changes: dict[str, object]) -> list[Event]:
        """Change the bundle of the strengths; earlier key frames stay as they were."""
        events = pool.set(changes)
        with self._lock:
            for name, track in self._tracks.items():
                if name in pool:
                    track.begin_with(pool[name].take)
        return events

    def change(self, changes: dict[str, object]) -> None:
        """Change settings of all performers.

        Raises:
            SettingsError: If a value is illegal.
        """
        self.settings = self.settings.replace(**changes)
        self._ask(lambda pool: pool.set(changes))

    def reset(self) -> None:
        """End all takes and forget the running ranges."""
        self._ask(lambda pool: pool.reset(reason="asked for"))

    def count_again(self) -> None:
        """Count from 0; takes and their key frames go on."""
        with self._lock:
            for track in self._tracks.values():
                track.tally.begin_again()

    @property
    def people(self) -> list[dict[str, object]]:
        """The used slots, and their people; see `Slots.table`."""
        if self._pipeline is None or not self.has_people:
            return []
        rows = [row for rows in slots_by_source(self._pipeline).values() for row in rows]
        return sorted(rows, key=lambda row: (len(str(row["slot"])), str(row["slot"])))

    def pin(self, slot: str, *, pinned: bool) -> None:
        """Keep a slot for its person, or no longer.

        Raises:
            SettingsError: If there is no such slot, or it was never used.
        """
        if self._pipeline is not None:
            pin(self._pipeline, slot, pinned=pinned)

    def exchange(self, one: str, other: str) -> None:
        """Let two people have each other's slots.

        Raises:
            SettingsError: If there are no two such slots.
        """
        if self._pipeline is not None:
            exchange(self._pipeline, one, other)

    @property
    def first_name(self) -> str:
        """Default name of the first taught move: that of a move to follow."""
        return next((name for name in self._follow_names if name != EVERY), "punch")

    def teach(self, name: str) -> None:
        """Have the first performer that is shown teach a move.

        Raises:
            MossarError: If there is no performer, or a move cannot have this name.
        """
        with self._lock:
            track = self._tracks[min(self._tracks)] if self._tracks else None
        if track is None:
            raise MossarError("there is no performer yet to show a move")
        self.teaching.begin(name, Meta(track.performer, track.skeleton))

    def _recognise(self, moves: Moves) -> None:
        """Recognise these moves from now on."""

        def task(pool: "Pool") -> list[Event]:
            pool.moves = moves
            if pool.follow != (now := followed(self._follow_names, moves)):
                pool.follow = now
            return []

        self._ask(task)

    def _ask(self, task: _Task) -> None:
        """Have something done by the thread that segments, and its events sent."""
        pipeline = self._pipeline
        with self._lock:
            self._under_way += 1
        if pipeline is None:
            self._asked.append(task)
        else:
            pipeline.ask(lambda: self._carry_out(task, pipeline))

    def _carry_out(self, task: _Task, pipeline: "Pipeline") -> None:
        """Do something to the performers and send its events; in the thread that segments."""
        try:
            pipeline.send(task(pipeline.pool))
        except MossarError as error:
            LOGGER.warning("%s", error)
        finally:
            with self._lock:
                self._under_way -= 1

    def _read_samples(self) -> None:
        while self._samples:
            sample = self._samples.popleft()
            if sample.performer in self._tracks:
                self._tracks[sample.performer].add_sample(sample.state)
                self._tracks[sample.performer].set_following(sample.following, sample.moves, sample.up)
                self._latest[sample.performer] = sample
                rates = self._rates.setdefault(sample.performer, deque(maxlen=int(2 * RATE)))
                rates.append((time.monotonic(), sample.stats["frames"]))

    def rate_of(self, performer: str) -> float | None:
        """Return the rate of a performer's frames, Hz; None before the first."""
        rates = self._rates.get(performer)
        if not rates:
            return None
        (first, before), (_, frames) = rates[0], rates[-1]
        span = time.monotonic() - first
        return (frames - before) / span if span > 0.2 else 0.0

    def _statistics(self, performer: str) -> list[tuple[str, str]]:
        sample, fps = self._latest.get(performer), self.rate_of(performer)
        if sample is None or fps is None:
            return []
        statistics = [("frames", f"{sample.stats['frames']:,}"), ("rate", f"{fps:.0f} fps")]
        known = self._pipeline.performers.get(performer) if self._pipeline else None
        quantiles = known.latency.quantiles_ms() if known else None
        if quantiles:
            statistics.append(("lag, median · 99 %", f"{quantiles[0]:.1f} · {quantiles[1]:.1f} ms"))
        statistics.append(("dropped", str(sample.dropped)))
        if sample.state.own_time is not None:
            statistics.append(("own time", f"{sample.state.own_time:.2f} s"))
        statistics += [
            (name.replace("_", " "), str(sample.stats[name])) for name in _COUNTS if sample.stats[name]
        ]
        return statistics
