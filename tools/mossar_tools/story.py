"""Story: the built-in performer in a terminal, in lines that can be read aloud."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from mossar_adapters.source import Meta, Source
from mossar_stream import BODY, ActivityEvent, Event, Frames, KeyFrameEvent, Skeleton, StreamEvent
from mossar_tools.bars import bar
from mossar_tools.character_figure import COLUMNS, ROWS, figure
from mossar_tools.console import Console
from mossar_tools.elapsed import clock
from mossar_tools.live_view import LiveView
from mossar_tools.score import TOLERANCE
from mossar_tools.wording import counted

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mossar_adapters.demo import Cut
    from mossar_adapters.pipeline import Pipeline

_LOWEST: Final = 2 * ROWS  # lines of a terminal that has room for the figure
_TEXT: Final = 42  # columns of a line about a key frame, before the delay
_NARROW: Final = 38  # the same in a narrow terminal
NEXT: Final = (
    "Next:",
    "  mossar view demo:          the same in a browser",
    "  mossar segment take.bvh    for a recording of yours",
    "  mossar run 39539           for a live sender: VMC apps, Kinect bridges",
)
_FOUND: Final = "1;32"  # the colour of a key frame at a true cut


class Story(LiveView):
    """Shows a performance: the performer, `moving` and `resting` at once, each key frame once, when it is decided.

    Args:
        console: Receives the lines.
        sources: The built-in performers; their true cuts are the truth.
        options: Of `LiveView`.
    """

    judged_status = "final"

    def __init__(self, console: Console, sources: Sequence[Source], **options: Any) -> None:
        super().__init__(console, sources, **options)
        self._others = 0  # final key frames that are at no true cut
        self._found: dict[str, set[int]] = {}  # frames of the true cuts that were found, of each performer
        # The latest pose of each performer.
        self._bodies: dict[str, tuple[Skeleton, NDArray[Any] | None]] = {}
        self._states: dict[str, str] = {}

    def announce(self, meta: Meta) -> None:
        """Note the view of the performer."""
        self._bodies[meta.performer] = (meta.skeleton, None)

    def send_frames(self, frames: Frames) -> None:
        """Note the latest pose, and of the time."""
        super().send_frames(frames)
        if frames.performer in self._bodies:
            self._bodies[frames.performer] = (self._bodies[frames.performer][0], frames.positions[-1])

    def tick(self, pipeline: "Pipeline") -> None:
        """Draw the performer, or show a line where there is no room."""
        if not self._console.live:
            return
        if not self.visible or self._console.height() < _LOWEST or len(self._bodies) != 1:
            super().tick(pipeline)
            return
        ((name, (skeleton, pose)),) = self._bodies.items()
        if pose is not None and name in pipeline.pool:
            state = pipeline.pool[name].state
            self._console.picture(
                self._scene(name, figure(pose, skeleton, fine=self._console.unicode), state)
            )

    def _judge(self, now: dict[str, float]) -> None:
        """Count the true cuts at the end: a key frame is decided later than it would be missed."""
        if float("inf") in now.values():
            self.score.judge(now)

    def _scene(self, name: str, drawn: list[str], state: Any) -> list[str]:
        value = 0.0 if state is None else state.value
        beside = {
            2: clock(self._elapsed.seconds),
            4: self._states.get(name, "resting"),
            5: f"speed {bar(value, 10, fine=self._console.unicode)}",
            7: counted(self.final, "key frame"),
        }
        return [f"{line:<{COLUMNS}}  {beside.get(row, '')}".rstrip() for row, line in enumerate(drawn)]

    def _show(self, event: Event) -> None:
        if isinstance(event, KeyFrameEvent):
            if event.channel == BODY and event.status == "final":
                self._console.line(self._key_line(event))
        elif isinstance(event, ActivityEvent):
            if event.channel == BODY:
                self._show_activity(event)
        elif not isinstance(event, StreamEvent):  # the figure shows when the performance begins and ends
            super()._show(event)

    def _show_activity(self, event: ActivityEvent) -> None:
        self._states[event.performer] = event.state
        text = f"{self._moment(event.performer, event.start)}  {event.state}"
        self._console.line(self._console.colour(self._cut(text), "33"))

    def _key_line(self, event: KeyFrameEvent) -> str:
        """Return the line of a key frame: the states that it separates, and the delay of the decision."""
        cut = self._cut_at(event)
        self._others += cut is None
        mark, said = (
            ("✓", f"{_words(cut.before)} → {_words(cut.after)}") if cut else ("·", self._within(event))
        )
        text = self._console.plain(f"{self._moment(event.performer, event.time)}  {mark} {said}")
        delay = f"{event.decided_time - event.time:.1f} s"
        return self._console.colour(self._with_delay(text, delay), _FOUND if cut else "2")

    def _with_delay(self, text: str, delay: str) -> str:
        """Return a line about a key frame, and when it was decided, in as many words as there is room for."""
        for column, later in ((_TEXT, f"decided {delay} later"), (_NARROW, f"+{delay}")):
            if self._console.width() >= column + len(later):
                return f"{text:<{column}}{later}"
        return self._cut(text)

    def _moment(self, performer: str, time: float) -> str:
        of = f"{performer} " if len(self._bodies) > 1 else ""
        return f"{of}{clock(self._elapsed.since(performer, time)):>8}"

    def _cut_at(self, event: KeyFrameEvent) -> "Cut | None":
        """Return the true cut that a key frame finds, if no other one has found it."""
        found = self._found.setdefault(event.performer, set())
        near = [
            cut
            for cut in self._cuts_of(event.performer)
            if abs(cut.time - event.time) <= TOLERANCE and cut.frame not in found
        ]
        if not near:
            return None
        cut = min(near, key=lambda cut: abs(cut.time - event.time))
        found.add(cut.frame)
        return cut

    def _within(self, event: KeyFrameEvent) -> str:
        """Return the move within which a key frame lies."""
        before = [cut for cut in self._cuts_of(event.performer) if cut.time <= event.time]
        after = [cut for cut in self._cuts_of(event.performer) if cut.time > event.time]
        name = before[-1].after if before else after[0].before if after else "rest"
        return f"within {_words(name)}"

    def _cuts_of(self, performer: str) -> "Sequence[Cut]":
        return self.score.cuts_of(performer)

    def summary(self) -> list[str]:
        """Return the numbers of events, their delays, and commands to try next."""
        if not self.visible:
            return super().summary()
        found = sum(map(len, self._found.values()))
        lines = [
            f"✓ {found} of {self.score.cuts} changes of move in the script were found, each at most {TOLERANCE:g} s off."
        ]
        if self._others:
            lines.append(
                f"· {counted(self._others, 'more key frame')} within moves, between single movements, as between two punches."
            )
        lines += self._counts()
        if self._delays["activity"] and self._delays["final"]:
            lines.append(
                f"Moving and resting (activity) were reported within {max(self._delays['activity']):.2f} s; "
                f"a key frame was decided (final) after {self._delay('final'):.1f} s, median."
            )
        lines += NEXT
        return [part for line in ["", *lines] for part in self._console.fold(line)]


def _words(move: str) -> str:
    return move.replace("_", " ")
