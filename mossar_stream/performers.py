"""Performers: segmenters by name, for streams in which several people move.

Events wait at the rows of the performers, or with the pool, until the caller gets them. An exception from outside, such as
Ctrl-C, leaves them there, and the next call brings them. What is changed for all at once is finished by the next call.
"""

import functools
import weakref
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.core import engine
from mossar_stream.core.buffers import IN_USE, Buffers
from mossar_stream.core.intake import FLOAT32, given_positions, less_origin
from mossar_stream.core.plan import Plan
from mossar_stream.core.pool import Pools, Row, new_row
from mossar_stream.core.station import Desk
from mossar_stream.errors import FrameError, SettingsError, SnapshotError
from mossar_stream.events import BODY, Event
from mossar_stream.following.alignment import Alignment, Follow, alignment_of, checked_follow
from mossar_stream.frames import Frames, constant_times, performer_name, plain_array
from mossar_stream.moves.moves import Moves, copy_of
from mossar_stream.moves.recognition import Recognition
from mossar_stream.segmenter import Segmenter
from mossar_stream.segmenter.limbs import bytes_with_limbs
from mossar_stream.settings import LevelName, Settings, Up, settings_or_default
from mossar_stream.skeleton import Skeleton

MOST_PERFORMERS = 1024
MOST_MEMORY = 1 << 32  # bytes
ANYBODY = Skeleton(("a", "b"), (-1, 0))
MOST_KINDS = 8  # of performers that share examples: skeletons
MOST_POOLS = 48  # kinds of rows that are shared: skeletons, those of limbs too, rates, and settings
MOST_ABSENT = 1024  # performers who made room for others and are not forgotten yet


class _Absent(msgspec.Struct, frozen=True):
    """What outlasts a segmenter."""

    counts: dict[str, int]  # see `Segmenter.counts`
    own: Settings | None  # settings of the performer's own, as far as they are in
    fields: tuple[str, ...]

    @property
    def changes(self) -> dict[str, object]:
        """What the performer's own settings change."""
        return {field: getattr(self.own, field) for field in self.fields}


class _Lasting(msgspec.Struct, frozen=True):
    """What a pool knows besides its segmenters."""

    settings: Settings
    level: LevelName | float
    absent: dict[str, _Absent]
    first_take: int
    pending: list[Event] = []


class Performers:
    """A pool of segmenters with the same settings, one for each announced performer; the method is that of `Segmenter`.

    Args:
        settings: Defaults to `Settings()`.
        most: Largest number of performers at a time. A new one replaces the one idle for longest, which
            continues with its next take when it is announced again.
        most_memory: Largest size of all their states, bytes; a performer that would need more is refused. States may grow by a
            third later.
        moves: Moves that are recognised for all performers; they share the examples.
        follow: Names of the moves that are followed, or True for all; see `Segmenter`.

    Example:
        >>> import numpy as np
        >>> pool = Performers()
        >>> _ = pool.announce("ann", Skeleton(("hip", "hand"), (-1, 0)))
        >>> events = pool.push(Frames(np.zeros((1, 2, 3), np.float32), np.zeros(1), performer="ann"))
        >>> events[0].event
        'started'
    """

    def __init__(
        self,
        settings: Settings | None = None,
        most: int = MOST_PERFORMERS,
        most_memory: int = MOST_MEMORY,
        moves: Moves | None = None,
        follow: Iterable[str] | bool = (),
    ) -> None:
        if most < 1:
            raise ValueError(f"at least one performer must be followed, not {most}")
        self._most_memory = most_memory
        self._settings = settings_or_default(settings)
        self._level = self._settings.level
        self._moves = copy_of(moves) if moves is not None else None
        self._stores: dict[Skeleton, NDArray[np.uint8]] = {}  # the moves' examples, described for a skeleton
        self._follow = checked_follow(follow, moves)
        # The same of the moves that are followed, by the axis that points upwards, too.
        self._banks: dict[tuple[Skeleton, Up], NDArray[np.uint8]] = {}
        self._most = most
        self._buffers = Buffers()
        self._pools: dict[tuple[Skeleton, float | None, Settings, str], Pools] = {}
        self._pending: list[Event] = []  # of those who left, and of a call that an exception cut short
        self._left: list[Segmenter] = []  # whose rows are to be given back
        self._unfinished: Callable[[], None] | None = None  # what such a call was to do for all
        self._segmenters: OrderedDict[str, Segmenter] = (
            OrderedDict()
        )  # in the order in which they were last used
        self._absent: dict[str, _Absent] = {}  # in the order in which they left
        self._first_take = (
            0  # of newcomers: after all takes of those who were forgotten, so that ids stay unique
        )

    def __contains__(self, performer: str) -> bool:
        return performer in self._segmenters

    def __getitem__(self, performer: str) -> Segmenter:
        return self._segmenters[performer]

    def __len__(self) -> int:
        return len(self._segmenters)

    @property
    def names(self) -> tuple[str, ...]:
        """The performers that are followed."""
        return tuple(self._segmenters)

    @property
    def settings(self) -> Settings:
        """Settings of the performers to come; `level` as it is now."""
        return self._settings.replace(level=self._level)

    def announce(self, performer: str, skeleton: Skeleton, fps: float | None = None) -> list[Event]:
        """Take note of a performer, or of its new skeleton, which ends its take.

        The next take has the next number, and settings of the performer's own stay in force.

        Args:
            performer: Name.
            skeleton: Joints in the order of the frames to come.
            fps: Nominal rate, Hz, if known.

        Returns:
            The events of takes that this ends.

        Raises:
            FrameError: If there is no memory for the performer, or the skeleton lacks joints that the moves or the
                limbs need.
        """
        self._mend()
        name = performer_name(performer)
        known = self._segmenters.get(name)
        if known is not None and known.skeleton == skeleton:
            return self._taken(())
        leaving = self._leaving(name)
        self._check_idle(leaving)
        self._check_memory(Plan(skeleton, self._settings, fps), name)
        segmenter = self._new_segmenter(
            name, skeleton, fps
        )  # all that may fail comes before anything is changed
        self._unfinished = functools.partial(self._admit, name, segmenter, leaving)
        self._mend()
        return self._taken(())

    def _admit(self, name: str, segmenter: Segmenter, leaving: Sequence[str]) -> None:
        """Follow a performer in place of others; may be done again from any point, as all that `_mend` does."""
        if self._segmenters.get(name) is segmenter:
            return
        for one in leaving:
            if one in self._segmenters:
                self._dismiss(one, "another skeleton" if one == name else "too many performers")
        before = self._absent.get(name)
        if before is not None:
            segmenter.carry_on(before.counts)
        elif self._first_take:
            segmenter.carry_on({**segmenter.counts, "take": self._first_take})
        self._segmenters[name] = segmenter
        if before is not None:
            del self._absent[name]

    def _mend(self) -> None:
        """Do what is to be done for all, or finish what an exception cut short of it."""
        work = self._unfinished
        if work is None:
            return
        try:
            work()
            self._unfinished = None
        except Exception:
            self._unfinished = None  # it would fail again
            raise

    def _taken(self, rows: Iterable[Row]) -> list[Event]:
        """Return the events that wait with the pool and at rows, for the caller; see `Row.take_pending`."""
        self._gather(rows)
        pending = self._pending
        events = pending[:]
        del pending[:]
        return events

    def _gather(self, rows: Iterable[Row]) -> None:
        """Let the events of rows wait with the pool; no call in the loop, so that Ctrl-C finds them in one place."""
        pending = self._pending
        for row in rows:
            if row.pending:
                pending += row.pending
                del row.pending[:]

    def _leaving(self, name: str) -> tuple[str, ...]:
        """Return the performers that are dismissed when one is announced: itself, or those idle for longest."""
        if name in self._segmenters:
            return (name,)
        return self.names[: max(0, len(self._segmenters) - self._most + 1)]

    def _check_idle(self, performers: Sequence[str]) -> None:
        """Raise RuntimeError if another thread is using one of the performers, before anything is changed."""
        if any(self._segmenters[name].row.buffers.is_busy for name in performers):
            raise RuntimeError(IN_USE)

    def _new_segmenter(self, name: str, skeleton: Skeleton, fps: float | None) -> Segmenter:
        """Return a segmenter for a performer, with the performer's own settings."""
        recognition = self._recognition_of(name, skeleton)
        following = self._follow, self._alignment_of(name, skeleton, self._settings)
        row = self._pools_for(skeleton, fps, self._settings).allocate(name)

        # The segmenter must not lead back here: the memory of a pool would be kept until the collector comes by.
        here = weakref.ref(self)

        def new_limb(plan: Plan, pending: list[Event]) -> Row:
            pool = here()
            if pool is None:
                return new_row(plan, row.buffers, name, pending)
            pools = pool._pools_for(plan.skeleton, plan.fps, plan.user_settings, plan.channel)  # noqa: SLF001 - its own class
            return pools.allocate(name, pending)

        try:
            segmenter = Segmenter.of_row(row, recognition, following, new_limb)
            if segmenter.level != self._level:
                segmenter.level = self._level  # the threshold only: the bundle stays that of the settings
            segmenter.change(**self._own_changes(name))
        except BaseException:
            row.release()
            raise
        return segmenter

    def _own_changes(self, name: str) -> dict[str, object]:
        """Return what a performer's own settings change of those of all."""
        if name not in self._segmenters:
            return self._absent[name].changes if name in self._absent else {}
        own, common = (msgspec.structs.asdict(s) for s in (self._segmenters[name].settings, self.settings))
        return {field: value for field, value in own.items() if value != common[field]}

    @property
    def moves(self) -> Moves | None:
        """The moves that are recognised; setting them takes effect with everybody's next frame.

        Raises:
            FrameError: If a performer's skeleton lacks joints that they need; nothing is changed then.
        """
        return self._moves

    @moves.setter
    def moves(self, moves: Moves | None) -> None:
        self._mend_all()
        before = self._moves, self._stores, self._banks
        self._moves, self._stores, self._banks = copy_of(moves) if moves is not None else None, {}, {}
        own = self._segmenters
        try:
            found = {name: self._recognition_of(name, s.skeleton) for name, s in own.items()}
            aligned = {name: self._alignment_of(name, s.skeleton, s.settings) for name, s in own.items()}
            fresh = {name: one and one.follow_on(own[name].recognition) for name, one in found.items()}
            self._unfinished = functools.partial(self._recognise, fresh, aligned)
        except BaseException:
            self._moves, self._stores, self._banks = before
            raise
        self._mend()

    def _recognise(
        self, fresh: Mapping[str, Recognition | None], aligned: Mapping[str, Alignment | None]
    ) -> None:
        """Let something else recognise and follow the moves of all."""
        for name, recognition in fresh.items():
            self._segmenters[name].steps.recognise(recognition, self._follow, aligned[name])

    @property
    def follow(self) -> Follow:
        """The names of the moves to follow, or True for all; setting them takes effect with everybody's next frame.

        Raises:
            MovesError: If there are no moves, or none of a name; nothing is changed then.
        """
        return self._follow

    @follow.setter
    def follow(self, follow: Iterable[str] | bool) -> None:
        self._mend_all()
        before = self._follow, self._banks
        self._follow, self._banks = checked_follow(follow, self._moves), {}
        own = self._segmenters.items()
        try:
            aligned = {name: self._alignment_of(name, s.skeleton, s.settings) for name, s in own}
            self._unfinished = functools.partial(self._follow_moves, aligned)
        except BaseException:
            self._follow, self._banks = before
            raise
        self._mend()

    def _follow_moves(self, aligned: Mapping[str, Alignment | None]) -> None:
        """Let something else follow the moves of all."""
        for name, alignment in aligned.items():
            self._segmenters[name].steps.follow_moves(self._follow, alignment)

    def _mend_all(self) -> None:
        """Finish what an exception cut short, of all performers.

        Raises:
            RuntimeError: If another thread is using one of them; nothing is changed then.
        """
        self._check_idle(self.names)
        self._mend()
        for segmenter in self._segmenters.values():
            segmenter.steps.mend()

    def _alignment_of(self, name: str, skeleton: Skeleton, settings: Settings) -> Alignment | None:
        """Return what follows the moves of a performer."""
        key = skeleton, settings.up
        alignment = alignment_of(self._follow, self._moves, skeleton, settings, name, self._banks.get(key))
        if alignment is not None:
            while len(self._banks) >= MOST_KINDS and key not in self._banks:
                del self._banks[next(iter(self._banks))]
            self._banks[key] = alignment.store
        return alignment

    def _recognition_of(self, name: str, skeleton: Skeleton) -> Recognition | None:
        """Return what recognises the moves of a performer."""
        if self._moves is None:
            return None
        recognition = Recognition(self._moves, skeleton, name, self._stores.get(skeleton))
        while len(self._stores) >= MOST_KINDS and skeleton not in self._stores:
            del self._stores[next(iter(self._stores))]
        self._stores[skeleton] = recognition.store
        return recognition

    def _check_memory(self, plan: Plan, name: str) -> None:
        """Raise FrameError if the state of another performer would be more than there may be."""
        own = bytes_with_limbs(plan)
        others = sum(s.state_bytes for other, s in self._segmenters.items() if other != name)
        if own + others > self._most_memory:
            raise FrameError(
                f"{len(plan.skeleton)} joints of performer {name!r} need {own / 2**20:,.0f} MiB; with those of the others that is "
                f"more than the {self._most_memory / 2**20:,.0f} MiB that performers may take"
            )

    def _check_growth(self, plans: Mapping[str, Plan]) -> None:
        """Raise FrameError if plans to come make states larger, and so all of them more than there may be."""
        now = sum(segmenter.state_bytes for segmenter in self._segmenters.values())
        growth = sum(
            bytes_with_limbs(plan) - bytes_with_limbs(self._segmenters[name].row.plan)
            for name, plan in plans.items()
        )
        if growth > 0 and now + growth > self._most_memory:
            raise FrameError(
                f"with these settings performers need {(now + growth) / 2**20:,.0f} MiB, more than the "
                f"{self._most_memory / 2**20:,.0f} MiB that they may take"
            )

    def _dismiss(self, name: str, reason: str) -> None:
        """End a performer's take and free its memory, but keep in mind where it was."""
        segmenter = self._end(name, reason)
        fields = tuple(self._own_changes(name))
        absent = _Absent(segmenter.counts, segmenter.settings if fields else None, fields)
        self._left += [segmenter]
        self._absent[name] = absent
        del self._segmenters[name]
        self._release()
        while len(self._absent) > MOST_ABSENT:
            oldest, forgotten = next(iter(self._absent.items()))
            self._first_take = max(self._first_take, forgotten.counts["take"])
            del self._absent[oldest]

    def _end(self, name: str, reason: str) -> Segmenter:
        """End a performer's take and return its segmenter, whose events wait with the pool then."""
        segmenter = self._segmenters[name]
        segmenter.steps.end_take(reason)
        self._gather((segmenter.row,))
        return segmenter

    def _release(self) -> None:
        """Give back the rows of those who left; `Row.release` may be called again."""
        while self._left:
            self._left[-1].release()
            del self._left[-1]

    def _pools_for(
        self, skeleton: Skeleton, fps: float | None, settings: Settings, channel: str = BODY
    ) -> Pools:
        """Return where the rows of performers, or limbs, with this skeleton, rate and settings lie."""
        key = skeleton, fps, settings, channel
        self._release()
        if key not in self._pools:
            for pools in self._pools.values():
                pools.drop_empty()
            while len(self._pools) >= MOST_POOLS:  # who has a row in them keeps it
                del self._pools[next(iter(self._pools))]
            if fps is not None:
                constant_times(0, fps)
            self._pools[key] = Pools(Plan(skeleton, settings, fps, channel=channel), self._buffers)
        return self._pools[key]

    def push(self, frames: Frames) -> list[Event]:
        """Take frames of one performer in and return the events they cause.

        Raises:
            FrameError: If the performer was not announced or the shapes do not fit its skeleton.
        """
        self._mend()
        name = frames.performer if frames.performer in self._segmenters else performer_name(frames.performer)
        segmenter = self._segmenters.get(name)
        if segmenter is None:
            raise FrameError(f"performer {frames.performer!r} was not announced")
        segmenter.process(frames.positions, frames.times, frames.confidence, frames.first_frame)
        self._segmenters.move_to_end(name)
        return self._taken((segmenter.row,))

    def push_many(self, performers: Sequence[str], positions: ArrayLike, times: ArrayLike) -> list[Event]:
        """Process as many frames of each of many performers at once, which is quicker than one after the other.

        Args:
            performers: P names, each once.
            positions: (P, n, J, 3), metres, NaN where a joint is missing.
            times: (P, n), or (n,) for all of them, seconds.

        Returns:
            The events; those of each performer in order.

        Raises:
            FrameError: If a performer was not announced or is named twice, or the shapes do not fit; nothing is
                processed then.
        """
        self._mend()
        segmenters, frames, moments = self._checked(performers, given_positions(positions), times)
        together: dict[tuple[int, int], list[int]] = {}
        for k, segmenter in enumerate(segmenters):
            station = segmenter.station
            if station is None:
                segmenter.process(frames[k], moments[k])
            else:  # those who share buffers and parameters; a restored performer has its own
                key = id(station.params), id(segmenter.row.buffers)
                together.setdefault(key, []).append(k)
        for chosen in together.values():
            self._process_together([segmenters[k] for k in chosen], chosen, frames, moments)
        return self._taken([segmenter.row for segmenter in segmenters])

    def _process_together(
        self,
        segmenters: Sequence[Segmenter],
        chosen: Sequence[int],
        frames: NDArray[Any],
        times: NDArray[np.float64],
    ) -> None:
        """Process frames of performers in one call; who must be looked after, as a take ends, is on its own from there.

        Args:
            segmenters: Of the performers.
            chosen: Their places in the arrays.
            frames: (P, n, J, 3) m, in single or double precision.
            times: (P, n) s.
        """
        count, begins = frames.shape[1], [k * frames.shape[1] for k in chosen]
        positions, moments = frames, times
        if frames.dtype is not FLOAT32 or any(own.row.origin is not None for own in segmenters):
            rows = [(own.row, frames[k]) for own, k in zip(segmenters, chosen, strict=True)]
            positions = np.stack([less_origin(*pair) for pair in rows])
            moments, begins = times[chosen], [k * count for k in range(len(chosen))]
        stations = [station for own in segmenters if (station := own.station) is not None]
        desk = Desk(stations, begins, count)
        together = positions.reshape(-1, *frames.shape[2:]), moments.reshape(-1)
        try:
            ended = engine.process(desk, *together)
        except BaseException:
            for own in segmenters:
                own.steps.tear(desk)
            raise
        for place, used in ended:
            k = chosen[place]
            segmenters[place].process(frames[k, used:], times[k, used:])

    def _checked(
        self, performers: Sequence[str], frames: NDArray[Any], times: ArrayLike
    ) -> tuple[list[Segmenter], NDArray[Any], NDArray[np.float64]]:
        """Return the segmenters, their frames and (P, n) times; see `push_many`."""
        moments = plain_array(times, np.float64)
        names = [name if name in self._segmenters else performer_name(name) for name in performers]
        try:
            segmenters = [self._segmenters[name] for name in names]
        except KeyError as unknown:
            raise FrameError(f"performer {unknown.args[0]!r} was not announced") from None
        if len(set(names)) != len(names):
            raise FrameError("a performer is named twice")
        if frames.ndim != 4 or len(frames) != len(names) or frames.shape[3] != 3:
            raise FrameError(
                f"positions have shape {frames.shape}; {len(names)} performers need ({len(names)}, n, J, 3)"
            )
        if moments.shape not in (frames.shape[:2], frames.shape[1:2]):
            raise FrameError(f"positions have shape {frames.shape} but times {moments.shape}")
        if {segmenter.joints for segmenter in segmenters} - {frames.shape[2]}:
            other = next(segmenter for segmenter in segmenters if segmenter.joints != frames.shape[2])
            raise FrameError(
                f"positions have {frames.shape[2]} joints; performer {other.performer!r} has {other.joints}"
            )
        for name in names:
            self._segmenters.move_to_end(name)
        # Writeable, too: what is broadcast is not, and would be another type to the compiler.
        return segmenters, frames, plain_array(np.broadcast_to(moments, frames.shape[:2]), np.float64)

    def change(self, performer: str | None = None, **changes: object) -> list[Event]:
        """Change settings of one performer, or of all and of those to come; see `Segmenter.change`.

        Raises:
            SettingsError: If a value is illegal; nothing is changed then.
            FrameError: If there is no such performer, or all would take more than `most_memory`; nothing is changed then.
        """
        self._mend()
        if performer is not None:
            (segmenter,) = self._chosen(performer)
            plan, level = segmenter.steps.planned(changes)
            self._check_growth({performer: plan})
            segmenter.steps.adopt(plan, level)
            return self._taken((segmenter.row,))
        level = self._settings.replace(level=changes.pop("level", self._level)).level
        settings = self._settings.replace(**changes).at_level(level)
        Plan(ANYBODY, settings, None)  # all or nothing: those to come must be able to start with them
        plans = {
            name: segmenter.steps.planned({**changes, "level": level})
            for name, segmenter in self._segmenters.items()
        }
        self._check_growth({name: plan for name, (plan, _) in plans.items()})
        self._check_idle(self.names)
        self._unfinished = functools.partial(self._adopt, settings, level, plans)
        self._mend()
        return self._taken([segmenter.row for segmenter in self._segmenters.values()])

    def _adopt(
        self,
        settings: Settings,
        level: LevelName | float,
        plans: Mapping[str, tuple[Plan, LevelName | float]],
    ) -> None:
        """Go on with other settings of all."""
        self._settings, self._level, self._pools = settings, level, {}
        for name, plan in plans.items():
            self._segmenters[name].steps.adopt(*plan)

    def _chosen(self, performer: str | None) -> list[Segmenter]:
        """Return the segmenter of a performer, or those of all for None.

        Raises:
            FrameError: If there is no such performer.
        """
        if performer is None:
            return list(self._segmenters.values())
        if performer not in self._segmenters:
            raise FrameError(
                f"no performer called {performer!r}; there are {', '.join(self.names) or 'none'}"
            )
        return [self._segmenters[performer]]

    def reset(self, performer: str | None = None, reason: str = "") -> list[Event]:
        """End the take of one performer, or of all, and forget the running range.

        After Ctrl-C in here some performers may be left out.

        Raises:
            FrameError: If there is no such performer.
        """
        self._mend()
        chosen = self._chosen(performer)
        self._check_idle([segmenter.performer for segmenter in chosen])
        for segmenter in chosen:
            segmenter.steps.reset(reason)
        return self._taken([segmenter.row for segmenter in chosen])

    def end_takes(self, reason: str = "") -> list[Event]:
        """End the takes of all performers; after Ctrl-C in here some may be left out."""
        self._mend()
        self._check_idle(self.names)
        for segmenter in self._segmenters.values():
            segmenter.steps.end_take(reason)
        return self._taken([segmenter.row for segmenter in self._segmenters.values()])

    def remove(self, performer: str, reason: str = "") -> list[Event]:
        """End a performer's take and forget the performer."""
        self._mend()
        self._left += [self._end(performer, reason)]
        del self._segmenters[performer]
        self._release()
        return self._taken(())

    def snapshot(self) -> dict[str, bytes]:
        """Return what all segmenters know, by performer, without the examples of moves: those are the pool's."""
        self._mend()
        return {name: segmenter.snapshot(with_moves=False) for name, segmenter in self._segmenters.items()}

    def lasting(self) -> bytes:
        """Return what the pool knows besides: settings as they are now, and the takes of those who made room."""
        self._mend()
        return msgspec.msgpack.encode(
            _Lasting(self._settings, self._level, self._absent, self._first_take, self._pending)
        )

    def restore(self, blobs: Mapping[str, bytes], lasting: bytes = b"") -> None:
        """Go on where the segmenters of a snapshot were, in place of those that are here.

        The moves of this pool are recognised from then on. If they are others than when the snapshot was made, a move that
        was confirmed and not final yet is forgotten.

        Args:
            blobs: Of `snapshot`.
            lasting: Of `lasting`, at the same time; nothing to keep the settings that there are.

        Raises:
            SnapshotError: If one of them is damaged; nothing is changed then.
        """
        segmenters = {
            name: Segmenter.restore(blob, self._moves, self._follow, with_moves=self._moves is not None)
            for name, blob in blobs.items()
        }
        ordered, pending = OrderedDict(segmenters), list[Event]()
        if lasting:
            try:
                known = msgspec.msgpack.decode(lasting, type=_Lasting)
                Plan(ANYBODY, known.settings, None)
                known.settings.strength(known.level)
                pending = known.pending
            except (msgspec.MsgspecError, SettingsError, ValueError) as error:
                raise SnapshotError(f"the snapshot's settings cannot be read: {error}") from None
            self._settings, self._level, self._first_take = known.settings, known.level, known.first_take
            self._absent, self._pools = known.absent, {}
        self._pending = pending
        self._segmenters, self._left, self._unfinished = ordered, [], None

    def __reduce__(self) -> "tuple[Callable[..., Performers], tuple[object, ...]]":
        """Copy and pickle by snapshots: a copy goes on from here on its own, and begins with the events that wait here."""
        moves = None if self._moves is None else self._moves.to_json()
        limits = self._most, self._most_memory
        return _restored, (*limits, moves, self._follow, self.snapshot(), self.lasting())

    @property
    def level(self) -> LevelName | float:
        """The level of all performers; setting it acts at once, as of a `Segmenter`."""
        return self._level

    @level.setter
    def level(self, level: LevelName | float) -> None:
        self._mend()
        chosen = self._settings.replace(level=level).level
        self._settings.strength(chosen)
        for segmenter in self._segmenters.values():
            segmenter.steps.planned_level(level)  # all or nothing
        self._check_idle(self.names)
        self._unfinished = functools.partial(self._set_level, chosen)
        self._mend()

    def _set_level(self, level: LevelName | float) -> None:
        """Move the level of all."""
        self._level = level
        for segmenter in self._segmenters.values():
            segmenter.level = level


def _restored(
    most: int,
    most_memory: int,
    moves: bytes | None,
    follow: Follow,
    blobs: Mapping[str, bytes],
    lasting: bytes,
) -> Performers:
    """Return a copy of a pool."""
    known = None if moves is None else Moves.from_json(moves)
    pool = Performers(None, most, most_memory, known, follow)
    pool.restore(blobs, lasting)
    return pool
