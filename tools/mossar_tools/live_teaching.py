"""Live teaching: `mossar teach` with a stream, from the first rest to the file of moves."""

import contextlib
import os
from pathlib import Path
from typing import TYPE_CHECKING

from mossar_adapters.pipeline import Pipeline
from mossar_stream import MossarError, Skeleton
from mossar_tools.console import LOGGER, Console, prints_unicode
from mossar_tools.errors import DONE, FAILED, UsageError
from mossar_tools.figures_in_text import example_lines
from mossar_tools.moves_file import read_moves, take_pose
from mossar_tools.opening import source_of
from mossar_tools.rest_to_rest import REST
from mossar_tools.series import Series, Shown
from mossar_tools.signals import stopping
from mossar_tools.streaming import check_streamable
from mossar_tools.taking import Movement, MovementTaker, TimedTaker

if TYPE_CHECKING:
    from mossar_tools.commands.teach import Options

LEAD = 3.0  # s before each example of a fixed length


class LiveTeaching:
    """Takes examples of a move, or a pose, from a stream. Nothing is in the file before `run` ends.

    Args:
        options: The user's options.
        console: Receives the words and figures.
    """

    def __init__(self, options: "Options", console: Console) -> None:
        self._options, self._console = options, console
        self._name = options.name or options.pose or ""
        self._wanted = options.times if options.pose is None else 1
        self._series: Series | None = None
        self._taken = 0
        self._pipeline: Pipeline | None = None

    def run(self) -> int:
        """Take examples until the series is whole or the stream ends, save them, and return the exit status."""
        options, console = self._options, self._console
        _check_file(Path(options.file))
        settings = options.segmentation.settings(options.sources[0])
        with contextlib.closing(
            source_of(options.sources[0], options.reading(), options.people, options.speed)
        ) as source:
            self._pipeline = Pipeline([source], [], settings, views=[self._taker()])
            check_streamable(settings)
            console.say(self._instruction())
            with stopping(self._pipeline.stop) as stop:
                outcome = self._pipeline.run()
        self._save()
        if stop.status:
            return stop.status
        if not self.is_whole:
            console.say(f"{self._taken} of {self._wanted} examples taken: the stream ended")
            return FAILED
        return FAILED if outcome.errors else DONE

    @property
    def is_whole(self) -> bool:
        """Whether all examples, or the pose, were taken."""
        return self._taken >= self._wanted

    def _taker(self) -> MovementTaker | TimedTaker:
        if self._options.pose is not None:
            return MovementTaker(self._take_pose, self._console.say, away=REST, from_rest=False)
        if self._options.seconds is not None:
            return TimedTaker(self._take, self._announce, self._options.seconds, LEAD)
        return MovementTaker(self._take, self._console.say)

    def _instruction(self) -> str:
        times = f"{self._wanted} time{'s' * (self._wanted != 1)}"
        if self._options.pose is not None:
            return f"rest, then take the pose {self._name!r} and hold it"
        if self._options.seconds is not None:
            return f"do {self._name!r} for {self._options.seconds:g} s when it says now; {times}"
        return f"rest, do {self._name!r}, rest; {times}"

    def _announce(self, text: str) -> None:
        if not self.is_whole:
            self._console.say(f"{self._name}: {text}")

    def _skeleton(self) -> Skeleton:
        if self._pipeline is None:
            raise RuntimeError("there is no stream before `run`")
        return self._pipeline.pool[self._pipeline.pool.names[0]].skeleton

    def _take_pose(self, movement: Movement) -> None:
        if self.is_whole:
            return
        hold = 1.0 if self._options.hold is None else self._options.hold
        try:
            take_pose(
                self._options.file, self._skeleton(), self._name, movement.positions, movement.fps, hold
            )
        except MossarError as error:
            self._console.say(f"not taken: {error}")
            return
        self._console.say(f"{self._name}: pose taken")
        self._count(1)

    def _take(self, movement: Movement) -> None:
        if self.is_whole:
            return
        try:
            if self._series is None:
                path, keeps = Path(self._options.file), self._options.keeps
                self._series = Series(path, self._skeleton(), self._name, keeps=keeps)
            shown = self._series.show(movement)
        except MossarError as error:
            self._console.say(f"not taken: {error}")
            return
        self._report(shown)
        self._count(shown.count)

    def _report(self, shown: Shown) -> None:
        """Report the outcome of a movement, and draw it."""
        for line in shown.unlike:
            LOGGER.warning("%s", line)
        if shown.is_first_dropped:
            self._console.say(f"{self._name}: the last two are alike and kept; the first is dropped")
        if shown.is_kept:
            self._console.say(
                f"{self._name}: example {shown.count} of {self._wanted} taken ({shown.seconds:.1f} s)"
            )
        else:
            self._console.say(f"{self._name}: not kept ({shown.seconds:.1f} s); do it again, or use --keep")
        for line in example_lines(shown.example, shown.skeleton, fine=prints_unicode(self._console.err)):
            self._console.say(f"  {line}")

    def _count(self, taken: int) -> None:
        self._taken = taken
        if self.is_whole and self._pipeline is not None:
            self._pipeline.stop()

    def _save(self) -> None:
        if self._series is None or not self._series.count:
            return
        self._series.save(Path(self._options.file))
        count = self._series.count
        self._console.say(
            f"{self._options.file}: {count} example{'s' * (count != 1)} of {self._name} saved; --undo takes the last one back"
        )


def _check_file(path: Path) -> None:
    """Check the file before the performer moves.

    Raises:
        MossarError: If it is there and cannot be read, or cannot be written.
    """
    if path.exists():
        read_moves(path)
    if not os.access(path.parent, os.W_OK):
        raise UsageError(f"{path} cannot be written: {path.parent} is no folder that can be written to")
