"""Segmenter: frames of one performer in, events out."""

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.algorithm.noise import forget_noise
from mossar_stream.engine import engine
from mossar_stream.engine.curve_state import CurveState, curve_state
from mossar_stream.engine.plan import Plan
from mossar_stream.engine.pool import Row, pool_of_one
from mossar_stream.errors import FrameError
from mossar_stream.events import Event
from mossar_stream.frames import Frames, constant_times, performer_name, plain_array
from mossar_stream.repetitions.counter import NOTHING, TAKE_ENDS, RepetitionCounter
from mossar_stream.settings import LevelName, Settings
from mossar_stream.skeleton import Skeleton
from mossar_stream.snapshot import pack_snapshot, unpack_snapshot

FLOAT32, FLOAT64 = np.dtype(np.float32), np.dtype(np.float64)
NUMBERS = (float, int, np.floating, np.integer)  # what a time may be
LARGEST_PERSON = 100.0  # m; who seems larger is not given in metres
COUNTERS = ("frames", "out_of_order", "outliers", "held", "gaps")


class Segmenter:
    """Online Mossar for one performer.

    Kernels are compiled when the first segmenter with a similarity measure is built (seconds, once per
    installation; `precompile` does it on two cores), never while frames come in. All state has a fixed size.

    Args:
        skeleton: The performer's joints.
        settings: Defaults to `Settings()`.
        performer: Name that events carry.
        fps: Nominal rate, Hz. Needed where `push` gets no times; otherwise only a hint.

    A segmenter is used by one thread at a time; different ones may run in different threads.

    Raises:
        TypeError: If `skeleton` is no `Skeleton`.
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
        if not isinstance(skeleton, Skeleton):
            raise TypeError(
                f"a segmenter needs a Skeleton, not {type(skeleton).__name__}; Skeleton(names, parents)"
            )
        if fps is not None:
            constant_times(0, fps)
        plan = Plan(skeleton, settings or Settings(), fps)
        self._begin(pool_of_one(plan, performer_name(performer)), plan.given.level)

    def _begin(self, row: Row, level: LevelName | float) -> None:
        self.performer = row.name
        self.joints = len(row.plan.skeleton)
        self._row = row
        self._level = level
        self._one_shape = (self.joints, 3)
        self._fast_shape: tuple[int, int] | None = (
            self._one_shape
        )  # None while a moved level waits for a push
        self._one_frame = np.zeros((1, self.joints, 3), np.float32)
        self._one_time = np.zeros(1)
        self._is_measured = False
        self._renew_counter()

    def _renew_counter(self) -> None:
        """Begin to count repetitions anew, or stop, as the settings say."""
        row, given = self._row, self._row.plan.given
        self._counter = (
            RepetitionCounter(row.plan.skeleton, row.name, int(row.clock["take"]), given.max_pause)
            if given.repetitions
            else None
        )

    @classmethod
    def of_row(cls, row: Row) -> "Segmenter":
        """Return a segmenter whose state is a row of a pool."""
        segmenter = cls.__new__(cls)
        segmenter._begin(row, row.plan.given.level)  # noqa: SLF001 - its own class
        return segmenter

    @property
    def row(self) -> Row:
        """Where the state lies, for those who run the rows of a pool."""
        return self._row

    def carry_on(self, counts: Mapping[str, int]) -> None:
        """Number takes and count frames on from the `counts` of another segmenter of the same performer."""
        self._row.clock["take"] = counts["take"]
        for name in COUNTERS:
            self._row.state["counters"][name] = counts[name]
        if self._counter is not None:
            self._counter.take = counts["take"]

    @property
    def skeleton(self) -> Skeleton:
        """The performer's joints."""
        return self._row.plan.skeleton

    @property
    def settings(self) -> Settings:
        """The settings in force; `level` as it is now."""
        return self._row.plan.given.replace(level=self._level)

    @property
    def take(self) -> int:
        """Number of the take that is open, or of the next one."""
        return int(self._row.clock["take"])

    @property
    def stats(self) -> dict[str, int]:
        """Frames taken in, and those that were out of order, had outliers or held joints, or came after a gap."""
        return {name: int(self._row.state["counters"][name]) for name in COUNTERS}

    @property
    def counts(self) -> dict[str, int]:
        """`take` and `stats`, for a segmenter that carries on."""
        return {"take": self.take, **self.stats}

    @property
    def state(self) -> CurveState | None:
        """The velocity curve at the last frame, None before the first."""
        return curve_state(self._row.memory[0], self._row.plan) if self._row.clock["open"] else None

    @property
    def level(self) -> LevelName | float:
        """The level: `posture`, `motion`, `cluster` or a strength.

        Setting it acts at once on the undecided key frames and computes nothing again; the events come with the
        next push.
        """
        return self._level

    @level.setter
    def level(self, level: LevelName | float) -> None:
        self._level = self._row.plan.given.replace(level=level).level
        row = self._row
        row.state["plan"]["beta"] = row.plan.strength(self._level)
        row.is_level_new = True
        self._fast_shape = None

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
        return self.adopt(*self.planned(**changes))

    def planned(self, **changes: object) -> tuple[Plan, LevelName | float]:
        """Return the plan and the level that `change` would bring, and change nothing."""
        before = self._row.plan
        level = before.given.replace(level=changes.pop("level", self._level)).level
        return Plan(self.skeleton, before.given.replace(**changes), before.fps, before.shape.ring), level

    def adopt(self, plan: Plan, level: LevelName | float) -> list[Event]:
        """Go on with what `planned` returned, and return the events of the take that this ends."""
        row, given, before = self._row, plan.given, self._row.plan.given
        events: list[Event] = []
        if plan.continues(row.plan):
            row.replan(plan)
        else:
            events = self.end_take("settings changed")
            row.restart(plan)
        if (given.repetitions, given.max_pause) != (before.repetitions, before.max_pause):
            events += [] if self._counter is None else self._counter.end_take()
            self._renew_counter()
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
            FrameError: If the shapes do not fit the skeleton, or `first_frame` is a number that the take already had.
            RuntimeError: If another thread is using the segmenter.
            ValueError: If there are neither times nor a nominal rate.
        """
        row = self._row
        if (
            isinstance(times, NUMBERS)
            and type(positions) is np.ndarray
            and positions.shape == self._fast_shape
            and confidence is None
            and first_frame is None
            and row.is_live
            and positions.dtype.kind in "fiu"
        ):
            # One frame of a take that goes on. Checking it as chunks are checked would cost more than the frame itself.
            self._one_time[0] = times
            one = positions
            if not (positions.dtype is FLOAT32 and positions.flags.carray):
                self._one_frame[0] = positions
                one = self._one_frame[0]
            if self._counter is None or self._counter.hold(one, float(times)):
                return engine.push_frame(row, one[None], self._one_time)
            return self._push_counted(self._counter, one[None], self._one_time, None)
        if isinstance(positions, Frames):
            frames = positions
            return self.push(frames.positions, frames.times, frames.confidence, frames.first_frame)
        chunk, moments = self._check(positions, times, confidence, first_frame)
        if not row.is_live:
            self._look_at_size(chunk)
        self._fast_shape = self._one_shape
        if self._counter is not None:
            return self._push_counted(self._counter, chunk, moments, first_frame)
        return engine.push(row, chunk, moments, first_frame)

    def _push_counted(
        self,
        counter: RepetitionCounter,
        chunk: NDArray[np.float32],
        moments: NDArray[np.float64],
        first_frame: int | None,
    ) -> list[Event]:
        """Push frames in pieces that end where a repetition is told of, so that chunks do not matter."""
        row, begin = self._row, 0
        end, stop = counter.follow(chunk, moments)
        if len(moments) == 1 and stop == NOTHING and row.is_live and first_frame is None:
            return engine.push_frame(row, chunk, moments)
        events: list[Event] = []
        while True:
            first = None if first_frame is None else first_frame + begin
            if end > begin or begin == 0:
                events += engine.push(row, chunk[begin:end], moments[begin:end], first)
            if stop == TAKE_ENDS:
                events += counter.end_take()
            elif stop != NOTHING:
                events += counter.news()
            if stop == NOTHING or (end == len(moments) and stop != TAKE_ENDS):
                return events
            begin = end
            end, stop = counter.follow(chunk, moments, begin)

    @property
    def repetitions(self) -> int:
        """Repetitions counted in the open take; 0 without the setting."""
        return 0 if self._counter is None else self._counter.total

    @property
    def phase(self) -> float | None:
        """Where in the cycle of a repeated movement the latest frame is, 0 to 1; None when nothing repeats."""
        return None if self._counter is None else self._counter.phase()

    def end_take(self, reason: str = "") -> list[Event]:
        """End the take: decide everything, and let the next push start a new one.

        Args:
            reason: What the `ended` event says.

        Returns:
            The pending events; nothing more if no take is open.
        """
        counted: list[Event] = [] if self._counter is None else [*self._counter.end_take()]
        return counted + engine.end_take(self._row, reason)

    def reset(self, reason: str = "") -> list[Event]:
        """End the take and forget the running range, as for another person."""
        events = self.end_take("reset")
        events.append(engine.stream_event(self._row, "reset", reason))
        self._row.state["range"]["largest"] = 0.0
        forget_noise(self._row.state["noise"])
        return events

    def snapshot(self) -> bytes:
        """Return everything the segmenter knows as checksummed bytes; it goes on undisturbed."""
        row = self._row
        row.pending = engine.take_pending(row)
        counted = b"" if self._counter is None else self._counter.snapshot()
        return pack_snapshot(row.plan, row.name, self._level, row.pending, row.memory[0], counted)

    @classmethod
    def restore(cls, blob: bytes) -> "Segmenter":
        """Return a segmenter that goes on exactly where the one that made `blob` was.

        Raises:
            SnapshotError: If the bytes are damaged, truncated, or of a newer version.
        """
        plan, performer, level, pending, content, counted = unpack_snapshot(blob)
        row = pool_of_one(plan, performer, content)
        row.pending = pending
        segmenter = cls.__new__(cls)
        segmenter._begin(row, level)  # noqa: SLF001 - its own class
        if segmenter._counter is not None:  # noqa: SLF001 - its own class
            segmenter._counter.restore(counted)  # noqa: SLF001 - its own class
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
            fps = self._row.plan.fps
            if fps is None:
                raise ValueError("push needs times, or the segmenter fps")
            begin = int(self._row.clock["next_frame"]) if first_frame is None else first_frame
            moments = constant_times(len(chunk), fps, begin)
        else:
            moments = np.atleast_1d(_as_array(times, FLOAT64))
        if moments.shape != chunk.shape[:1]:
            raise FrameError(f"{len(chunk)} frames but times of shape {moments.shape}")
        if first_frame is not None:
            self._check_number(first_frame, moments)
        if confidence is not None:
            sure = np.atleast_2d(np.asarray(confidence, np.float32))
            if sure.shape != chunk.shape[:2]:
                raise FrameError(
                    f"{len(chunk)} frames of {joints} joints but confidence of shape {sure.shape}"
                )
            chunk = np.where(sure[:, :, None] > 0, chunk, np.float32(np.nan))
        return chunk, moments

    def _check_number(self, first_frame: int, times: NDArray[np.float64]) -> None:
        """Raise FrameError for a frame number that would give two key frames one id."""
        clock = self._row.clock
        goes_on = (
            bool(clock["open"])
            and len(times) > 0
            and abs(times[0] - clock["time"]) <= self.settings.max_pause
        )
        if first_frame < (int(clock["next_frame"]) if goes_on else 0):
            raise FrameError(
                f"first_frame is {first_frame}, but the take is at frame {int(clock['next_frame'])}"
            )

    def _look_at_size(self, chunk: NDArray[np.float32]) -> None:
        """Warn once if a person is far larger or smaller than people are: the unit must be another one."""
        if self._is_measured or not len(chunk) or not np.isfinite(chunk[0]).any():
            return
        self._is_measured = True
        seen = chunk[0][np.isfinite(chunk[0]).all(axis=1)]
        size = float(np.ptp(seen, axis=0).max()) if len(seen) else 0.0
        if size > LARGEST_PERSON:
            message = f"performer {self.performer} is {size:,.0f} m tall; positions are in metres, these look like millimetres or centimetres"
            warnings.warn(message, stacklevel=3)


def _as_array(values: ArrayLike, kind: "np.dtype[Any]") -> NDArray[Any]:
    """Return an array of a kind; most come in the right form, and seeing to it takes as long as a frame."""
    if type(values) is np.ndarray and values.dtype is kind and values.flags.carray:
        return values
    return plain_array(values, kind)
