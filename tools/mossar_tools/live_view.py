"""Live view: key frames as they come, line by line, in a terminal; and a summary at the end."""

import statistics
import threading
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING

from mossar_adapters.demo import DemoSource
from mossar_adapters.newest import Newest
from mossar_adapters.pipeline.emission import Emission
from mossar_adapters.source import Meta, Source
from mossar_stream import (
    BODY,
    ActivityEvent,
    Event,
    FollowEvent,
    Frames,
    KeyFrameEvent,
    MoveEvent,
    PoseEvent,
    RepetitionEvent,
    StepEvent,
    StreamEvent,
)
from mossar_tools.bars import bar
from mossar_tools.console import Console
from mossar_tools.elapsed import Elapsed, clock
from mossar_tools.score import Score, Verdict
from mossar_tools.wording import counted, judged, straying

if TYPE_CHECKING:
    from mossar_adapters.pipeline import Pipeline

SHOWN = ("confirmed", "final")  # statuses of key frames that get a line

_COLOURS = {"onset": "32", "offset": "35", "minimum": "36", "final": "1"}
# Columns with alignment and width, and in which order they give way where the terminal is narrow.
_COLUMNS = {
    "performer": "<12",
    "time": ">10",
    "frame": ">9",
    "key frame": "<12",
    "kind": "<9",
    "delay": ">8",
    "velocity": "<14",
}
_SET_OFF = ("key frame", "velocity")  # that follow a column on the right
_DISPENSABLE = ("velocity", "frame", "delay", "kind", "performer")
_STARTED = "started"
OVER = ("done", "left")  # statuses of followed moves that are not being made any more
MOST_FOLLOWED = 2  # performers whose followed moves the status line shows
_NAMES = 4096  # performers that are remembered


class LiveView:
    """Shows key frames; implements `Sink` and takes frames. Counts them even when nothing is shown.

    Args:
        console: Receives the lines.
        sources: True cuts of the built-in performers among them are shown, too.
        visible: Whether to show anything before the end.
        emission: Which events are shown; all are counted.
    """

    name = "the terminal"
    judged_status = "confirmed"  # of key frames that may hit true cuts
    dropped = 0

    def __init__(
        self,
        console: Console,
        sources: Sequence[Source],
        *,
        visible: bool,
        emission: Emission | None = None,
    ) -> None:
        self.confirmed = 0
        self.final = 0
        self.score = Score([source for source in sources if isinstance(source, DemoSource)])
        self._console = console
        self._emission = emission or Emission()
        self._repetitions: dict[tuple[str, str], int] = {}  # count of the take by performer and channel
        # The latest, by performer and name of the move.
        self._followed: Newest[tuple[str, str], FollowEvent] = Newest(_NAMES)
        self.visible = visible
        self.prompt = not visible  # counting takes no time; a terminal may be paused
        # s, from a change of activity to its event, and from a key frame to each status.
        self._delays = {name: deque[float](maxlen=10_000) for name in ("activity", *SHOWN)}
        self._times: dict[str, float] = {}  # s, of the last frame of each performer
        self._elapsed = Elapsed()
        self._recognised: Newest[tuple[str, str], int] = Newest(_NAMES)  # moves, by performer and name
        self._steps: Newest[str, int] = Newest(_NAMES)  # of each performer
        self._limbs: dict[str, int] = {}  # confirmed key frames by channel; there are few channels
        self._headed = False
        self._lock = threading.Lock()

    def announce(self, meta: Meta) -> None:
        """Do nothing: lines name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Count events, and show those that are wanted."""
        for event in events:
            if isinstance(event, KeyFrameEvent) and event.channel != BODY:
                self._limbs[event.channel] = self._limbs.get(event.channel, 0) + (event.status == "confirmed")
            elif isinstance(event, KeyFrameEvent):
                self._count(event)
            elif isinstance(event, ActivityEvent) and event.channel == BODY:
                self._delays["activity"].append(event.decided_time - event.start)
            elif isinstance(event, FollowEvent):
                self._followed[event.performer, event.name] = event
            elif isinstance(event, RepetitionEvent):
                self._repetitions[event.performer, event.channel] = event.total
            elif isinstance(event, MoveEvent) and event.status == "confirmed":
                key = event.performer, event.name
                self._recognised[key] = self._recognised.get(key, 0) + 1
            elif isinstance(event, StepEvent) and event.status == "strike":
                self._steps[event.performer] = self._steps.get(event.performer, 0) + 1
        if self.visible:
            for event in self._emission.of(list(events)):
                self._show(event)

    def _show(self, event: Event) -> None:
        """Show an event, if it is of a kind that has a line."""
        if isinstance(event, KeyFrameEvent):
            if event.channel == BODY and event.status in SHOWN:
                self._show_key_frame(event)
        elif isinstance(event, MoveEvent):
            if event.status != "final":
                self._console.line(self._move_line(event))
        elif isinstance(event, FollowEvent):
            if event.status == "done":
                self._console.line(self._done_line(event))
        elif isinstance(event, PoseEvent):
            if event.status != "entered":
                self._console.line(self._pose_line(event))
        elif isinstance(event, ActivityEvent):
            if event.channel == BODY:
                self._console.line(self._activity_line(event))
        elif isinstance(event, RepetitionEvent):
            self._console.line(self._repetition_line(event))
        elif isinstance(event, StreamEvent) and event.event != _STARTED:
            text = f"{event.performer:<12}{event.event} {event.reason}".rstrip()
            self._console.line(self._dim(self._cut(text)))

    def close(self) -> None:
        """Judge the last cuts."""
        self._judge(dict.fromkeys(self._times, float("inf")))

    def send_frames(self, frames: Frames) -> None:
        """Note the time; judge the true cuts that have had theirs."""
        # Frames come in line with the events, so that no verdict overtakes a key frame.
        self._elapsed.see(frames.performer, float(frames.times[0]), float(frames.times[-1]))
        self._times[frames.performer] = float(frames.times[-1])
        if len(self._times) > _NAMES:
            del self._times[next(iter(self._times))]
        if self.visible:
            self._judge(self._times)

    def tick(self, pipeline: "Pipeline") -> None:
        """Show the status line; from the thread that segments."""
        if self._console.live:
            self._console.status(self._status(pipeline))

    def summary(self) -> list[str]:
        """Return the summary at the end."""
        lines = self._counts()
        if self.score.cuts:
            spread = (
                statistics.median(abs(error) for error in self.score.errors) if self.score.errors else 0.0
            )
            lines.append(
                f"true cuts hit: {self.score.hits} of {self.score.cuts} within 0.25 s by a {self.judged_status} key frame, "
                f"median distance {spread * 1000:.0f} ms"
            )
        lines.append(
            f"key frames: {self.confirmed} confirmed, {self.final} of them final, in {self._elapsed.seconds:.1f} s"
        )
        if self._limbs:
            counts = ", ".join(f"{channel} {count}" for channel, count in self._limbs.items())
            lines.append(f"key frames of limbs, confirmed: {counts}")
        soon = [f"{name} {self._delay(name):.2f} s" for name, delays in self._delays.items() if delays]
        if soon:
            lines.append(f"reported after (median): {', '.join(soon)}")
        return lines

    def _delay(self, name: str) -> float:
        return statistics.median(self._delays[name])

    def _counts(self) -> list[str]:
        """Return the counts of repetitions, recognised and followed moves."""
        lines = []
        for (performer, channel), total in self._repetitions.items():
            of = performer if channel == BODY else f"{performer}, {channel}"
            lines.append(f"repetitions of {of} in the last take: {total}")
        for (performer, name), event in self._followed.items():
            lines.append(f"{name}, {performer}: {event.count} done in the last take")
        for key, number in self._recognised.items():
            if key not in self._followed:  # which has its own count
                lines.append(f"{key[1]}, {key[0]}: recognised {counted(number, 'time')}")
        for performer, number in self._steps.items():
            lines.append(f"{performer}: {counted(number, 'step')}")
        return lines

    def _count(self, event: KeyFrameEvent) -> None:
        with self._lock:
            if event.status == "confirmed":
                self.confirmed += 1
            elif event.status == "final":
                self.final += 1
            if event.status in SHOWN:
                self._delays[event.status].append(event.decided_time - event.time)
            if event.status == self.judged_status:
                self.score.add(event)

    def _show_key_frame(self, event: KeyFrameEvent) -> None:
        if not self._headed:
            self._headed = True
            self._console.line(self._dim(self._row({name: name for name in _COLUMNS}).rstrip()))
        self._console.line(self._line(event))

    def _line(self, event: KeyFrameEvent) -> str:
        delay = (event.decided_time - event.time) * 1000
        wide = f"{delay:.0f} ms" if delay < 1000 else f"{delay / 1000:.1f} s"
        colour = _COLOURS[event.status if event.status == "final" else event.kind]
        cells = {
            "performer": event.performer,
            "time": f"{self._since(event, event.time):.2f} s",
            "frame": str(event.frame),
            "key frame": event.status,
            "kind": event.kind,
            "delay": wide,
        }
        text = self._row(cells)
        moment = f"  {bar(event.velocity, 10, fine=self._console.unicode)}"
        room = len(text) + len(moment) <= self._console.width()
        return self._console.colour(text, colour) + moment * room

    def _shown(self) -> dict[str, str]:
        """Return the columns that the terminal has room for, with their widths."""
        shown = dict(_COLUMNS)
        for name in _DISPENSABLE:
            if sum(int(width[1:]) for width in shown.values()) > self._console.width():
                del shown[name]
        return shown

    def _row(self, cells: dict[str, str]) -> str:
        """Return a line of the table."""
        text = "".join(
            f"{'  ' * (name in _SET_OFF) + cells[name]:{width}}"
            for name, width in self._shown().items()
            if name in cells
        )
        return self._cut(text)

    def _move_line(self, event: MoveEvent) -> str:
        start, end = self._since(event, event.start), self._since(event, event.end)
        span = f"{start:>8.2f} s to {end:.2f} s"
        text = f"{event.performer:<12}{span:<22} {event.status:<10}{event.name} ({event.limb})"
        return self._console.colour(text, "1" if event.status == "confirmed" else "2")

    def _repetition_line(self, event: RepetitionEvent) -> str:
        """Return the count of the take, and how quick the bout is."""
        tempo = "" if event.tempo is None else f", {event.tempo:.0f} a minute"
        channel = "" if event.channel == BODY else f" of {event.channel}"
        word = "withdrawn" if event.status == "withdrawn" else f"{event.count} in a row{tempo}"
        text = (
            f"{event.performer:<12}{self._since(event, event.decided_time):>8.2f} s  "
            f"{counted(event.total, 'repetition')}{channel} ({word})"
        )
        return self._console.colour(self._cut(text), "1;34")

    def _done_line(self, event: FollowEvent) -> str:
        """Return the count of a followed move, and how the performance went."""
        text = f"{event.performer:<12}{self._since(event, event.time):>8.2f} s  {event.name} {event.count}, {judged(event)}"
        return self._console.colour(self._cut(text), "1;32")

    def _pose_line(self, event: PoseEvent) -> str:
        """Return the duration of a held pose, and the limb that strays."""
        text = (
            f"{event.performer:<12}{self._since(event, event.decided_time):>8.2f} s  {event.name} {event.status}, "
            f"{event.seconds:.1f} s,"
            f" {event.deviation:.0f}° ({event.joint})"
        )
        return self._console.colour(self._cut(text), "1;32" if event.status == "held" else "2")

    def _activity_line(self, event: ActivityEvent) -> str:
        lasted = "" if event.previous is None else f", after {event.previous:.1f} s"
        limb = "" if event.limb is None or event.state != "moving" else f" ({event.limb})"
        start = self._since(event, event.start)
        text = f"{event.performer:<12}{start:>8.2f} s  {event.state}{limb}{lasted}"
        return self._console.colour(self._cut(text), "33")

    def _since(self, event: Event, time: float) -> float:
        return self._elapsed.since(event.performer, time)

    def _judge(self, now: dict[str, float]) -> None:
        with self._lock:
            verdicts = self.score.judge(now)
        for verdict in verdicts if self.visible else ():
            self._console.line(self._cut_line(verdict))

    def _cut_line(self, verdict: Verdict) -> str:
        cut = verdict.cut
        text = f"{verdict.performer:<12}{self._elapsed.since(verdict.performer, cut.time):>8.2f} s{cut.frame:>9}  true cut  {cut.before} → {cut.after}"
        word = "✗ missed" if verdict.error is None else f"✓ {verdict.error * 1000:+.0f} ms"
        said = self._console.plain(f" {word}")
        room = max(min(66, self._console.width() - len(said)), 0)
        return self._console.colour(
            f"{self._cut(text, room):<{room}}{said}", "31" if verdict.error is None else "1;33"
        )

    def _cut(self, text: str, room: int | None = None) -> str:
        """Return a text, cut to the room in the line; the terminal's width if None."""
        text, more = self._console.plain(text), self._console.plain("…")
        room = self._console.width() if room is None else room
        return text if len(text) <= room else f"{text[: max(room - len(more), 0)]}{more}"[:room]

    def _status(self, pipeline: "Pipeline") -> str:
        parts = []
        for performer in sorted(pipeline.pool.names)[:3]:
            state = pipeline.pool[performer].state
            if state is not None:
                word = "moving " if state.moving else "resting"
                moment = bar(state.value, 12, fine=self._console.unicode)
                since = clock(self._elapsed.since(performer, state.time))
                parts.append(f"{performer} {since} {word} {moment}")
        parts += [self._progress(event) for event in self._under_way()[:MOST_FOLLOWED]]
        counts = f"{counted(self.confirmed, 'key frame')}, {self.final} final"
        totals = [total for (_, channel), total in self._repetitions.items() if channel == BODY]
        counts += f", {counted(sum(totals), 'repetition')}" if totals else ""
        return " · ".join([*parts, counts]) if parts else "waiting for frames"

    def _under_way(self) -> list[FollowEvent]:
        """Return the followed moves that are being made, the likeliest of each performer; else those done last."""
        leading: dict[str, FollowEvent] = {}
        for event in list(self._followed.values()):
            before = leading.get(event.performer)
            if before is None or _rank(event) > _rank(before):
                leading[event.performer] = event
        return [leading[name] for name in sorted(leading)]

    def _progress(self, event: FollowEvent) -> str:
        """Return the progress of a followed move, its count, and the limb that strays most."""
        if event.status in OVER:
            return f"{event.name} {event.count} done"
        moment = bar(event.progress, 12, fine=self._console.unicode)
        return f"{event.name} {event.count} done {moment} {event.progress:4.0%} {straying(event)}"

    def _dim(self, text: str) -> str:
        return self._console.colour(text, "2")


def _rank(event: FollowEvent) -> tuple[bool, float, float]:
    """Return a sort key of a performer's followed moves: the one that is most likely being made is last."""
    active = event.status not in OVER
    return active, event.certainty * active, event.time
