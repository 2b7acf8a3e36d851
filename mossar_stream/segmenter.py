"""Segmenter: frames of one performer in, events out."""

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.algorithm.frame_step import DONE, HAPPENED, RING_FULL, STOPS, TAKE_ENDS, advance
from mossar_stream.algorithm.noise import forget_noise
from mossar_stream.algorithm.row import records
from mossar_stream.algorithm.window_step import END, FOLLOW, LEVEL
from mossar_stream.engine.buffers import Desk
from mossar_stream.engine.curve_state import CurveState, curve_state
from mossar_stream.engine.engine import OUTBOX_FULL
from mossar_stream.engine.plan import Plan, move_row
from mossar_stream.errors import FrameError
from mossar_stream.events import Event, StreamEvent
from mossar_stream.frames import Frames, constant_times, performer_name, plain_array
from mossar_stream.settings import LevelName, Settings
from mossar_stream.skeleton import Skeleton
from mossar_stream.snapshot import pack_snapshot, unpack_snapshot

FLOAT32, FLOAT64 = np.dtype(np.float32), np.dtype(np.float64)
ONE_DONE, ONE_HAPPENED = STOPS + DONE, STOPS + HAPPENED
_ROWS = np.zeros(1, np.int64)
COUNTERS = ("frames", "out_of_order", "outliers", "held", "gaps")


class Seat(Protocol):
    """A row of a pool."""

    def vacate(self) -> None:
        """Give the row back."""


class Segmenter:
    """Online Mossar for one performer.

    Kernels are compiled when the first segmenter with a similarity measure is built (seconds, once per
    installation; `precompile` does it on two cores), never while frames come in. All state has a fixed size.

    Args:
        skeleton: The performer's joints.
        settings: Defaults to `Settings()`.
        performer: Name that events carry.
        fps: Nominal rate, Hz. Needed where `push` gets no times; otherwise only a hint.

    Raises:
        ValueError: If `settings.range` is `file`, which a stream does not have, or `fps` is not positive.

    Example:
        >>> from mossar_stream import KeyFrameEvent
        >>> skeleton = Skeleton(("hip", "hand"), (-1, 0))
        >>> segmenter = Segmenter(skeleton, Settings(window=0.1), fps=30)
        >>> frames = np.zeros((90, 2, 3), np.float32)
        >>> frames[30:60, 1, 0] = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 30))
        >>> frames[60:, 1, 0] = 1
        >>> events = segmenter.push(frames)
        >>> [e.kind for e in events if isinstance(e, KeyFrameEvent) and e.status == "confirmed"]
        ['onset', 'offset']
    """

    def __init__(
        self,
        skeleton: Skeleton,
        settings: Settings | None = None,
        performer: str = "p1",
        fps: float | None = None,
    ) -> None:
        if fps is not None:
            constant_times(0, fps)
        plan = Plan(skeleton, settings or Settings(), fps)
        self._begin(plan, performer_name(performer))
        self._adopt(plan, plan.new_rows(1), Desk(plan))

    def _begin(self, plan: Plan, performer: str) -> None:
        self.performer = performer
        self.seat: Seat | None = None
        self._level: LevelName | float = plan.given.level
        self.pending: list[Event] = []  # for the next push
        self.joints = len(plan.skeleton)
        self._one_shape = (self.joints, 3)
        self._one_time = np.zeros(1)
        self._end, self._cursor = np.zeros(1, np.int64), np.zeros(2, np.int64)

    def _adopt(self, plan: Plan, memory: NDArray[np.uint8], desk: Desk) -> None:
        """Take a plan, a row laid out by it, and a desk for it."""
        self._plan = plan
        self._desk = desk
        self._params = plan.params
        self._memory = memory
        self._state = records(memory[0])
        self._clock = self._state["clock"]
        self._names = {int(self._clock["row"]): self.performer}
        self._live = bool(self._clock["open"])

    @classmethod
    def at_row(
        cls,
        plan: Plan,
        memory: NDArray[np.uint8],
        desk: Desk,
        performer: str,
        seat: "Seat | None" = None,
    ) -> "Segmenter":
        """Return a segmenter whose state is a row that there is already.

        Args:
            plan: Of the row.
            memory: (1, row) bytes, prepared.
            desk: May be shared with others, if they are used one after the other.
            performer: Name that events carry.
            seat: The row's place in a pool.
        """
        segmenter = cls.__new__(cls)
        segmenter._begin(plan, performer)  # noqa: SLF001 - its own class
        segmenter._adopt(plan, memory, desk)  # noqa: SLF001
        segmenter.seat = seat
        return segmenter

    def carry_on(self, counts: Mapping[str, int]) -> None:
        """Number takes and count frames on from the `counts` of another segmenter of the same performer."""
        self._clock["take"] = counts["take"]
        for name in COUNTERS:
            self._state["counters"][name] = counts[name]

    def opened(self) -> StreamEvent:
        """Return the event that a take has started; for who runs the row of a pool."""
        self._live = True
        return self._stream_event("started")

    def take_pending(self) -> list[Event]:
        """Return the events that wait for the next push."""
        events, self.pending = self.pending, []
        return events

    def vacate(self) -> None:
        """Leave the row of the pool, if the state lies in one."""
        if self.seat is not None:
            self.seat.vacate()
            self.seat = None

    @property
    def skeleton(self) -> Skeleton:
        """The performer's joints."""
        return self._plan.skeleton

    @property
    def settings(self) -> Settings:
        """The settings in force; `level` as it is now."""
        return self._plan.given.replace(level=self._level)

    @property
    def take(self) -> int:
        """Number of the take that is open, or of the next one."""
        return int(self._clock["take"])

    @property
    def stats(self) -> dict[str, int]:
        """Frames taken in, and those that were out of order, had outliers or held joints, or came after a gap."""
        return {name: int(self._state["counters"][name]) for name in COUNTERS}

    @property
    def counts(self) -> dict[str, int]:
        """`take` and `stats`, for a segmenter that carries on."""
        return {"take": self.take, **self.stats}

    @property
    def state(self) -> CurveState | None:
        """The velocity curve at the last frame, None before the first."""
        return curve_state(self._memory[0], self._plan) if self._clock["open"] else None

    @property
    def level(self) -> LevelName | float:
        """The level: `posture`, `motion`, `cluster` or a strength.

        Setting it acts at once on the undecided key frames and computes nothing again; the events come with the
        next push.
        """
        return self._level

    @level.setter
    def level(self, level: LevelName | float) -> None:
        self._level = self._plan.given.replace(level=level).level
        self._state["plan"]["beta"] = self._plan.strength(self._level)
        self._act(LEVEL, self.pending)

    def change(self, **changes: object) -> list[Event]:
        """Change settings while running.

        The level and thresholds act at once. What changes the curve or the summaries (window, smoothing,
        similarity, features and the like), or the tempo, which is known only to those who followed it from the start,
        ends the take, and the next push starts a new one.

        Args:
            **changes: Fields of `Settings`.

        Returns:
            The events of the take that this ends.

        Raises:
            SettingsError: If a value is illegal; nothing is changed then.
        """
        level = changes.pop("level", self._level)
        level = self._plan.given.replace(level=level).level
        plan = Plan(self.skeleton, self._plan.given.replace(**changes), self._plan.fps, self._plan.shape.ring)
        events: list[Event] = []
        if plan.continues(self._plan):
            self._plan = plan
            plan.prepare(self._memory[0], int(self._clock["row"]))
        else:
            events = self.end_take("settings changed")
            counts = self.counts
            self.vacate()
            self._adopt(plan, plan.new_rows(1), Desk(plan))
            self.carry_on(counts)
        self.level = level
        return events

    def push(
        self,
        positions: ArrayLike | Frames,
        times: ArrayLike | None = None,
        confidence: ArrayLike | None = None,
        first_frame: int | None = None,
    ) -> list[Event]:
        """Take frames in and return the events they cause, in order.

        Frames that come too late are dropped and counted; a long gap, or a long step back in time, ends the take
        and starts a new one. Frames may be cut into chunks in any way: the events are the same.

        Args:
            positions: (n, J, 3) or, for one frame, (J, 3), metres, NaN where a joint is missing; or `Frames`.
            times: (n,) or a number, seconds on the source's clock. None counts frames at the nominal rate.
            confidence: (n, J) or (J,) in 0..1; 0 marks a joint as missing.
            first_frame: Number of the first frame; None to count on.

        Raises:
            FrameError: If the shapes do not fit the skeleton.
            ValueError: If there are neither times nor a nominal rate.
        """
        events = self.pending
        if (
            type(times) is float
            and type(positions) is np.ndarray
            and positions.shape == self._one_shape
            and positions.dtype is FLOAT32
            and positions.flags.carray
            and confidence is None
            and first_frame is None
            and self._live
        ):
            # One frame of a take that goes on. Checking and converting would cost more than the frame itself.
            chunk, moments = positions[None], self._one_time
            moments[0] = times
            code = advance(self._memory, 0, self._params, chunk, moments)
            if code == ONE_DONE and not events:
                return []
            self.pending = []
            if code == ONE_HAPPENED:
                self._act(FOLLOW, events)
            if code >= STOPS:
                return events
        elif isinstance(positions, Frames):
            frames = positions
            return self.push(frames.positions, frames.times, frames.confidence, frames.first_frame)
        else:
            chunk, moments = self._check(positions, times, confidence, first_frame)
            if first_frame is not None:
                self._clock["next_frame"] = first_frame
            self.pending = []
        self._run(chunk, moments, events, first_frame)
        return events

    def _run(
        self,
        chunk: NDArray[np.float32],
        moments: NDArray[np.float64],
        events: list[Event],
        first_frame: int | None,
    ) -> None:
        """Take frames in, and do what the kernel asks for, until they are used up."""
        self._end[0] = len(moments)
        self._cursor[:] = 0
        stop = OUTBOX_FULL
        while stop != DONE:
            stop = self._desk.run(self._memory, _ROWS, _ROWS, self._end, self._cursor, chunk, moments)
            if not self._live and self._clock["open"]:
                events.append(self.opened())
            events += self._desk.empty(self._names)
            if stop == TAKE_ENDS:
                done = int(self._cursor[1])
                later = moments[done] > self._clock["time"]
                events += self.end_take("gap" if later else "clock stepped back")
                if first_frame is not None:
                    self._clock["next_frame"] = first_frame + done
            elif stop == RING_FULL:
                self._enlarge()

    def end_take(self, reason: str = "") -> list[Event]:
        """End the take: decide everything, and let the next push start a new one.

        Args:
            reason: What the `ended` event says.

        Returns:
            The pending events; nothing more if no take is open.
        """
        events = self.take_pending()
        if self._clock["open"]:
            ended = self._stream_event("ended", reason)
            self._act(END, events)
            events.append(ended)
            self._live = False
        return events

    def reset(self, reason: str = "") -> list[Event]:
        """End the take and forget the running range, as for another person."""
        events = self.end_take("reset")
        events.append(self._stream_event("reset", reason))
        self._state["range"]["largest"] = 0.0
        forget_noise(self._state["noise"])
        return events

    def snapshot(self) -> bytes:
        """Return everything the segmenter knows as checksummed bytes; it goes on undisturbed."""
        return pack_snapshot(self._plan, self.performer, self._level, self.pending, self._memory[0])

    @classmethod
    def restore(cls, blob: bytes) -> "Segmenter":
        """Return a segmenter that goes on exactly where the one that made `blob` was.

        Raises:
            SnapshotError: If the bytes are damaged, truncated, or of a newer version.
        """
        plan, performer, level, pending, row = unpack_snapshot(blob)
        segmenter = cls.at_row(plan, row.reshape(1, -1), Desk(plan), performer)
        segmenter._level, segmenter.pending = level, pending  # noqa: SLF001 - its own class
        return segmenter

    def _check(
        self,
        positions: ArrayLike,
        times: ArrayLike | None,
        confidence: ArrayLike | None,
        first_frame: int | None,
    ) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """Return frames and times in the form that the kernels take."""
        joints = self.joints
        # Writeable and contiguous: other arrays would be another type to the compiler.
        chunk = _as_array(positions, FLOAT32)
        if chunk.ndim == 2:
            chunk = chunk[None]
        if chunk.ndim != 3 or chunk.shape[1:] != (joints, 3):
            raise FrameError(
                f"positions have shape {np.shape(positions)}; this skeleton needs (n, {joints}, 3)"
            )
        if times is None:
            if self._plan.fps is None:
                raise ValueError("push needs times, or the segmenter fps")
            begin = int(self._clock["next_frame"]) if first_frame is None else first_frame
            moments = constant_times(len(chunk), self._plan.fps, begin)
        else:
            moments = np.atleast_1d(_as_array(times, FLOAT64))
        if moments.shape != chunk.shape[:1]:
            raise FrameError(f"{len(chunk)} frames but times of shape {moments.shape}")
        if confidence is not None:
            sure = np.atleast_2d(np.asarray(confidence, np.float32))
            if sure.shape != chunk.shape[:2]:
                raise FrameError(
                    f"{len(chunk)} frames of {joints} joints but confidence of shape {sure.shape}"
                )
            chunk = np.where(sure[:, :, None] > 0, chunk, np.float32(np.nan))
        return chunk, moments

    def _act(self, reason: int, events: list[Event]) -> None:
        """Let the compiled part do what is due and append its events."""
        self._desk.act(self._memory, 0, reason)
        events += self._desk.empty(self._names)

    def _stream_event(self, change: str, reason: str = "") -> StreamEvent:
        return StreamEvent(performer=self.performer, event=change, take=self.take, reason=reason)  # type: ignore[arg-type]

    def _enlarge(self) -> None:
        """Double the velocity ring: the source is quicker than its nominal rate."""
        plan = self._plan.larger(ring=2)
        memory = plan.new_rows(1)
        move_row(self._memory[0], self._plan, memory[0], plan)
        self.vacate()
        self._adopt(plan, memory, Desk(plan))


def _as_array(values: ArrayLike, kind: "np.dtype[Any]") -> NDArray[Any]:
    """Return an array of a kind; most come in the right form, and seeing to it takes as long as a frame."""
    if type(values) is np.ndarray and values.dtype is kind and values.flags.carray:
        return values
    return plain_array(values, kind)
