"""Counter: the repetitions of a limb, or of anybody without a row; those of the body are counted in its row."""

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.errors import SnapshotError
from mossar_stream.events import BODY, Event, RepetitionEvent
from mossar_stream.repetitions.counting import look
from mossar_stream.repetitions.preparing import is_sound, prepare
from mossar_stream.repetitions.sampling import (
    CHANGED,
    LOOK_DUE,
    NOTHING,
    TAKE_ENDS,
    count_frames,
    next_wanted,
)
from mossar_stream.repetitions.state import HEADER, RATE, SCRATCH, length, new_room
from mossar_stream.repetitions.telling import Telling, Told, as_said_last
from mossar_stream.skeleton import Skeleton

HELD = 64  # frames
CLOCK = ["begun", "origin", "latest", "wanted", "due"]  # of the header: all at once are read quicker

__all__ = ["CHANGED", "NOTHING", "TAKE_ENDS", "RepetitionCounter", "count_recording"]


class _Content(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    take: int
    told: Told
    header: bytes
    memory: bytes


def count_recording(
    skeleton: Skeleton,
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
    max_pause: float,
    channel: str = BODY,
) -> list[RepetitionEvent]:
    """Return the repetitions of a whole recording, as what was said of each at last.

    Args:
        skeleton: J joints.
        positions: (n, J, 3) m.
        times: (n,) s.
        max_pause: See `RepetitionCounter`; what is repeated after a pause is numbered anew.
        channel: See `RepetitionCounter`.
    """
    counter = RepetitionCounter(skeleton, "p1", 0, max_pause, channel)
    events: list[Event] = []
    used, stop = 0, CHANGED
    while stop != NOTHING:
        used, stop = counter.follow(positions, times, used)
        events += counter.end_take() if stop in {NOTHING, TAKE_ENDS} else counter.news()
    return as_said_last(events)


class RepetitionCounter:
    """Counts how often a movement is repeated; all state has a fixed size.

    Args:
        skeleton: The performer's joints.
        performer: Name that events carry.
        take: Number of the take that begins with the next frame.
        max_pause: s without frames, or back in time, after which another take begins.
        channel: That events carry. The way of the root is part of the body's posture, not of a limb's, and small
            swings of limbs are not counted: they sway along with what the body does.
    """

    def __init__(
        self, skeleton: Skeleton, performer: str, take: int, max_pause: float, channel: str = BODY
    ) -> None:
        self.take = take
        self._telling = Telling(skeleton, performer, channel)
        self._header = np.zeros(1, HEADER)
        prepare(self._header[0], skeleton, max_pause, channel)
        self._memory = np.zeros(length(len(skeleton)), np.float32)
        self._telling.look_into(self._header)
        self._row = self._header[0]
        self._clock = self._header[CLOCK]  # view
        self._max_pause = max_pause
        self._positions = np.zeros((HELD, len(skeleton), 3), np.float32)
        self._times = np.zeros(HELD)
        self._last_held = self._due = -math.inf  # s
        self._origin = 0.0  # s, of the take
        self._wanted = 0.0  # s, from when on a frame is taken into a sample
        self._begin()
        self._scratch, self._room = np.zeros(1, SCRATCH), new_room(len(skeleton))
        # No frame: kernels are compiled now, and never while frames come in.
        count_frames(self._header, self._memory, self._positions[:0], self._times[:0], 0)
        look(self._header, self._memory, self._room, self._scratch, math.inf)

    def _begin(self) -> None:
        self._telling.end()
        self._held = 0
        self._header[["begun", "clear", "dropped", "cycles"]] = 0
        self._set_due()

    @property
    def looks(self) -> int:
        """Samples at the last look."""
        return int(self._row["looked"])

    def table(self) -> NDArray[np.float64]:
        """Return (n, 3) begin, end and period of the repetitions that are remembered, s."""
        if not self._row["clear"]:
            return np.zeros((0, 3))
        cycles = self._row["cycle"][: self._row["cycles"]]
        begins, ends, periods = (cycles[name] for name in ("begins", "ends", "period"))
        periods = np.where(np.isnan(periods), ends - begins, periods)
        return np.stack([begins, ends, periods], axis=1) / RATE + [self._origin, self._origin, 0.0]

    def follow(
        self, positions: NDArray[np.float32], times: NDArray[np.float64], begin: int = 0
    ) -> tuple[int, int]:
        """Take frames in, up to and with the first that changes what is counted.

        Args:
            positions: (n, J, 3) m, NaN where a joint is missing.
            times: (n,) s.
            begin: The first frame to take.

        Returns:
            The first frame not taken, and one of `NOTHING`, `CHANGED` and `TAKE_ENDS`.
        """
        self._flush()
        used, stop = count_frames(self._header, self._memory, positions, times, begin)
        while stop == LOOK_DUE:
            if look(self._header, self._memory, self._room, self._scratch, times[used]):
                used, _ = count_frames(
                    self._header, self._memory, positions[: used + 1], times[: used + 1], used
                )
                stop = CHANGED
            else:
                used, stop = count_frames(self._header, self._memory, positions, times, used)
        self._set_due()
        return used, stop

    def hold(self, position: NDArray[np.float32], time: float) -> bool:
        """Keep one frame for later if no look is due with it, which is quicker than a kernel's call.

        Args:
            position: (J, 3) or (1, J, 3) m; copied.
            time: s.

        Returns:
            Whether it was kept; `follow` must take it otherwise.
        """
        held = self._held
        if held == HELD or not self._last_held < time < self._due:
            return False
        self._last_held = time
        if time >= self._wanted:
            self._wanted = next_wanted(self._origin, time)
            self._positions[held] = position
            self._times[held] = time
            self._held = held + 1
        return True

    def push(self, position: NDArray[np.float32], time: NDArray[np.float64]) -> list[Event]:
        """Take one frame in, and return what it changes.

        Args:
            position: (1, J, 3) m.
            time: (1,) s.
        """
        if self.hold(position[0], float(time[0])):
            return []
        events: list[Event] = []
        _, stop = self.follow(position, time)
        if stop == TAKE_ENDS:
            events = self.end_take()
            _, stop = self.follow(position, time)
        return [*events, *self.news()] if stop == CHANGED else events

    def _flush(self) -> None:
        """Count the frames that are held; none of them changes anything."""
        held, self._held = self._held, 0
        if held:
            count_frames(self._header, self._memory, self._positions[:held], self._times[:held], 0)
        self._row["latest"] = max(self._row["latest"], self._last_held)

    def _set_due(self) -> None:
        """Note from when on frames must go to the kernel: a look may be due, or the take may end."""
        begun, self._origin, self._last_held, self._wanted, due = self._clock.tolist()[0]
        self._due = min(due, self._last_held + self._max_pause) if begun else -math.inf

    def news(self) -> list[Event]:
        """Return what to say after `CHANGED`."""
        return self._telling.news(self.take)

    def look_once_more(self) -> bool:
        """Look at what the last frames of a take show, and return whether it changes anything."""
        self._flush()
        return bool(look(self._header, self._memory, self._room, self._scratch, math.inf))

    def end_take(self) -> list[Event]:
        """Return what the last frames change; the next frame begins a new take."""
        events = self.news() if self.look_once_more() else []
        self.take += int(self._row["begun"])
        self._begin()
        return events

    def snapshot(self) -> bytes:
        """Return everything the counter knows."""
        self._flush()
        content = _Content(self.take, self._telling.told(), self._header.tobytes(), self._memory.tobytes())
        return msgspec.msgpack.encode(content)

    def restore(self, blob: bytes) -> None:
        """Go on where the counter that made `blob` was.

        Raises:
            SnapshotError: If the bytes do not fit this skeleton or contradict themselves.
        """
        try:
            content = msgspec.msgpack.decode(blob, type=_Content)
        except msgspec.MsgspecError as error:
            raise SnapshotError(f"the snapshot's repetitions cannot be read: {error}") from None
        if len(content.header) != HEADER.itemsize or len(content.memory) != self._memory.nbytes:
            raise SnapshotError("the snapshot's repetitions are of another size")
        header = np.frombuffer(content.header, HEADER)
        if not is_sound(header[0], self._row):
            raise SnapshotError("the snapshot's repetitions contradict themselves")
        self.take = content.take
        self._header[:] = header
        self._telling.go_on(content.told)
        self._memory[:] = np.frombuffer(content.memory, np.float32)
        self._set_due()
