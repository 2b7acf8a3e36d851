"""Teaching: takes an example of a move from a live stream, after a countdown that leaves time to get ready."""

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Literal
from zlib import crc32

import msgspec
import numpy as np

from mossar_adapters.held_joints import HeldJoints
from mossar_adapters.source import Meta
from mossar_stream import Example, Frames, MossarError, Moves, MovesError
from mossar_tools.console import LOGGER
from mossar_tools.dashboard.recorder import unused
from mossar_tools.moves_file import changing, check_taught_name, read_moves, take_back
from mossar_tools.series import Series, Shown
from mossar_tools.taking import LONGEST, Movement, MovementTaker, TimedTaker

COUNTED = 3  # s
EARLY = 1.0  # s before the countdown ends at which a movement may begin
MOST_HELD = 16  # performers whose hidden joints are remembered
PATIENCE = LONGEST + 5.0  # s that a movement is waited for
SHOWN = 4.0  # s for which the outcome stands in large letters

Phase = Literal["idle", "count", "watch", "again", "taken", "failed"]


class TeachingState(msgspec.Struct, frozen=True):
    """Progress of teaching.

    Args:
        phase: The present phase; `again`: the movement was unlike the others of its name, and has to be repeated.
        name: Of the move that is or was shown.
        seconds: Of the countdown that are left, rounded up.
        message: The outcome, in words.
        can_keep: Whether the last movement was unlike the others, and `Teaching.keep` keeps it.
        can_undo: Whether there is an example that `Teaching.undo` takes back.
    """

    phase: Phase
    name: str = ""
    seconds: int = 0
    message: str = ""
    can_keep: bool = False
    can_undo: bool = False

    @property
    def runs(self) -> bool:
        """Whether a movement is waited for."""
        return self.phase in ("count", "watch", "again")


class Teaching:
    """Takes one movement of one performer for each `begin`. Any thread may call any method.

    Every page teaches with it. An example is on the disk before `state` reports it, so that no reported example is lost,
    however the program ends. A movement that is unlike the others of its name is not kept but has to be repeated.

    Args:
        folder: Where a new file `moves-1.json` is made if none is named.
        path: The file of moves, which may be there already; None for a new one.
        changed: Gets all moves whenever they change.
        clock: Monotonic s.

    Raises:
        MossarError: If the file cannot be read.
    """

    def __init__(
        self,
        folder: Path,
        path: Path | None,
        changed: Callable[[Moves], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.path = path
        self.moves = read_moves(path) if path is not None and path.exists() else None
        self._folder = folder
        self._changed = changed
        self._clock = clock
        self._phase: Phase = "idle"
        self._name = self._message = ""
        self._until = 0.0  # monotonic s, when the phase ends
        self._held: dict[str, HeldJoints] = {}  # of each performer, the latest last
        self._taker: MovementTaker | TimedTaker | None = None
        self._series: Series | None = None
        self._lock = threading.RLock()

    def announce(self, meta: Meta) -> None:
        """Remember, from now on, where the hidden joints of a performer were."""
        with self._lock:
            known = self._held.pop(meta.performer, None)
            if known is None or known.skeleton != meta.skeleton:
                known = HeldJoints(meta.skeleton)
            self._held[meta.performer] = known
            while len(self._held) > MOST_HELD:
                del self._held[next(iter(self._held))]

    def begin(self, name: str, meta: Meta, seconds: float | None = None) -> None:
        """Count down, then watch for a movement.

        Args:
            name: Of the move.
            meta: The performer.
            seconds: Length of the example, from the end of the countdown; None for a movement from rest to rest.

        Raises:
            MossarError: If a move cannot have this name, or the moves so far are of another skeleton.
        """
        check_taught_name(name)
        with self._lock:
            if self.moves is not None and self.moves.skeleton != meta.skeleton:
                raise MovesError(
                    f"{self.path} holds moves of another skeleton, with {len(self.moves.skeleton)} joints; "
                    f"{meta.performer} has {len(meta.skeleton)}"
                )
            self._name, self._message = name, ""
            self._series = Series(self.path, meta.skeleton, name)
            held = self._held.get(meta.performer)
            if seconds is None:
                self._taker = MovementTaker(self._take, self._hint, held)
                self._taker.since = np.inf
            else:
                self._taker = TimedTaker(self._take, lambda _: None, seconds, COUNTED, held)
            self._taker.announce(meta)
            self._enter("count", COUNTED)

    def cancel(self) -> None:
        """Stop counting or watching."""
        with self._lock:
            self._taker = self._series = None
            self._enter("idle", 0.0)

    def keep(self) -> None:
        """Keep the last movement although it is unlike the others of its name.

        Raises:
            MossarError: If the last movement was none of these, or the file cannot be written.
        """
        with self._lock:
            if self._series is None:
                raise MovesError("there is nothing to keep")
            self._save(self._series, self._series.keep())

    def undo(self) -> None:
        """Take back the last example.

        Raises:
            MossarError: If there is none, or the file cannot be written.
        """
        with self._lock:
            if self.path is None:
                raise MovesError("there are no examples")
            example, left = take_back(self.path)
            self._taker = self._series = None
            self._phase, self._message = (
                "idle",
                f"{example.name}: the last example is taken back; {left} left",
            )
            self._adopt(read_moves(self.path))

    def forget(self, place: int, mark: str) -> None:
        """Forget an example.

        Args:
            place: In the moves, from 0.
            mark: Its `mark_of`, so that no other one is removed.

        Raises:
            MossarError: If there is no such example any more, or the file cannot be written.
        """
        with self._lock:
            if self.path is None:
                raise MovesError("there are no examples")
            with changing(self.path) as moves:
                if not 0 <= place < len(moves) or mark_of(moves.examples[place]) != mark:
                    raise MovesError("this example is not there any more")
                name = moves.examples[place].name
                moves.remove_example(place)
            self._phase, self._message = "idle", f"an example of {name} is forgotten"
            self._adopt(moves)

    @property
    def state(self) -> TeachingState:
        """Progress, now."""
        with self._lock:
            left = self._until - self._clock()
            if self._phase == "count" and left <= 0:
                self._enter("watch", PATIENCE)
            elif self._phase == "watch" and left <= 0:
                self._fail(self._message or f"no movement came to rest within {PATIENCE:g} s")
            elif self._phase == "again" and left <= 0:
                self._fail(self._message)
            elif self._phase in ("taken", "failed") and left <= 0:
                self._phase = "idle"
            return TeachingState(
                self._phase,
                self._name,
                max(1, int(np.ceil(left))),
                self._message,
                can_keep=self._series is not None and self._series.has_refused,
                can_undo=self.moves is not None and len(self.moves) > 0,
            )

    def send_frames(self, frames: Frames) -> None:
        """Watch frames."""
        with self._lock:
            if self._taker is None or not len(frames):
                if frames.performer in self._held:
                    self._held[frames.performer].fill(frames.positions, frames.confidence)
                return
            if self.state.phase == "watch" and isinstance(self._taker, MovementTaker):
                self._taker.since = min(self._taker.since, float(frames.times[0]) - EARLY)
            self._taker.send_frames(frames)

    def _enter(self, phase: Phase, seconds: float) -> None:
        self._phase, self._until = phase, self._clock() + seconds

    def _take(self, movement: Movement) -> None:
        """Keep a movement as an example, on the disk before it is reported; or wait for it again."""
        if self._taker is None or self._series is None:
            return
        try:
            shown = self._series.show(movement)
            if shown.is_kept:
                self._save(self._series, shown)
                return
        except MossarError as error:
            self._fail(f"not taken: {error}")
            return
        # One reason without its figures is enough on a page; the log has all.
        self._message = f"not kept: {shown.unlike[-1].partition(' (cost')[0]}"
        self._enter("again", PATIENCE)
        LOGGER.info("not kept: %s", "; ".join(shown.unlike))

    def _save(self, series: Series, shown: Shown) -> None:
        path = self.path or unused(self._folder, "moves", ".json")
        moves = series.save(path)
        self.path, self._taker, self._series = path, None, None
        self._adopt(moves)
        count = sum(example.name == self._name for example in moves.examples)
        self._message = f"{self._name}: example {count} taken ({shown.seconds:.1f} s), in {path.name}"
        self._enter("taken", SHOWN)
        LOGGER.info("%s", self._message)

    def _hint(self, why: str) -> None:
        """Show why nothing was taken yet; the movement is waited for still."""
        self._message = why

    def _fail(self, why: str) -> None:
        self._taker = None
        self._message = why
        self._enter("failed", SHOWN)

    def _adopt(self, moves: Moves) -> None:
        self.moves = moves
        try:
            self._changed(moves)
        except MossarError as error:
            LOGGER.warning("%s", error)


def mark_of(example: Example) -> str:
    """Return a mark that identifies an example."""
    return f"{crc32(np.array(example.positions, np.int32).tobytes()):08x}"
