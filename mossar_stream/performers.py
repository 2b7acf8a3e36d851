"""Performers: segmenters by name, for streams in which several people move.

Events wait at the performers, or with the pool, until the caller gets them. An exception from outside, such as Ctrl-C, leaves
them there, and the next call brings them. A change for all is done as a whole, or not at all.
"""

from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, ClassVar

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.core.intake import given_positions
from mossar_stream.core.kernels import Performer, Workspace, at_once, process_together
from mossar_stream.core.plan import Plan, shared_plan
from mossar_stream.errors import FrameError, SettingsError, SnapshotError
from mossar_stream.events import Event
from mossar_stream.following.alignment import Alignment, Follow, alignment_of, checked_follow
from mossar_stream.frames import Frames, constant_times, performer_name, plain_array
from mossar_stream.moves.moves import Moves, copy_of
from mossar_stream.moves.recognition import Recognition
from mossar_stream.segmenter import Segmenter
from mossar_stream.segmenter.limbs import bytes_with_limbs
from mossar_stream.segmenter.segmenter import Steps
from mossar_stream.settings import LevelName, Settings, Up, settings_or_default
from mossar_stream.skeleton import Skeleton

MOST_PERFORMERS = 1024
MOST_MEMORY = 1 << 32  # bytes
ANYBODY = Skeleton(("a", "b"), (-1, 0))
MOST_KINDS = 8  # of performers that share examples: skeletons
MOST_ABSENT = 1024  # replaced performers that are remembered


class _Absent(msgspec.Struct, frozen=True):
    """The part of a performer that outlasts a segmenter."""

    counts: dict[str, int]  # see `Segmenter.counts`
    own: Settings | None  # settings of the performer's own, if it has any
    fields: tuple[str, ...]

    @property
    def changes(self) -> dict[str, object]:
        """The fields that the performer's own settings change."""
        return {field: getattr(self.own, field) for field in self.fields}


class _Lasting(msgspec.Struct, frozen=True):
    """The state of a pool besides its segmenters."""

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

    Attributes:
        looks_at_times: Whether times that are hardly seconds cause a warning.

    Example:
        >>> import numpy as np
        >>> pool = Performers()
        >>> _ = pool.announce("ann", Skeleton(("hip", "hand"), (-1, 0)))
        >>> events = pool.push(Frames(np.zeros((1, 2, 3), np.float32), np.zeros(1), performer="ann"))
        >>> events[0].event
        'started'
    """

    looks_at_times: ClassVar[bool] = True

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
        self._workspace = Workspace()
        self._pending: list[Event] = []  # of performers that left, and of a call that an exception cut short
        # In the order in which they were last used.
        self._segmenters: OrderedDict[str, Segmenter] = OrderedDict()
        self._absent: dict[str, _Absent] = {}  # in the order in which they left
        # Of newcomers: after all takes of forgotten performers, so that ids stay unique.
        self._first_take = 0

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
        """Settings of new performers, with the present level."""
        return self._settings.replace(level=self._level)

    def announce(self, performer: str, skeleton: Skeleton, fps: float | None = None) -> list[Event]:
        """Add a performer, or give it a new skeleton, which ends its take.

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
        name = performer_name(performer)
        known = self._segmenters.get(name)
        if known is not None and known.skeleton == skeleton:
            return self._taken(())
        if fps is not None:
            constant_times(0, fps)
        self._check_memory(shared_plan(skeleton, self._settings, fps), name)
        segmenter = self._new_segmenter(name, skeleton, fps)
        leaving = self._leaving(name)
        steps, absent, first_take = self._dismissing(leaving, name)
        before = absent.pop(name, None)
        if before is not None:
            segmenter.carry_on(before.counts)
        elif first_take:
            segmenter.carry_on({**segmenter.counts, "take": first_take})
        steps += [
            (setattr, self, "_absent", absent),
            (setattr, self, "_first_take", first_take),
            (self._segmenters.__setitem__, name, segmenter),
        ]
        at_once(self._cores(leaving), steps)
        return self._taken(())

    def _cores(self, names: Iterable[str]) -> list[Performer]:
        return [self._segmenters[name].core for name in names]

    def _dismissing(self, leaving: Sequence[str], for_whom: str) -> tuple[Steps, dict[str, _Absent], int]:
        """Return the steps by which performers leave, and the remembered state of all that have left then.

        Args:
            leaving: Their names.
            for_whom: The performer that is announced.

        Returns:
            The steps; the absent performers; and the first take of newcomers.
        """
        steps, absent, first_take = list[tuple[Any, ...]](), dict(self._absent), self._first_take
        for name in leaving:
            segmenter, fields = self._segmenters[name], tuple(self._own_changes(name))
            counts = segmenter.counts
            counts["take"] += segmenter.row.is_open
            absent[name] = _Absent(counts, segmenter.settings if fields else None, fields)
            steps += self._leaving_with(
                name, "another skeleton" if name == for_whom else "too many performers"
            )
        while len(absent) > MOST_ABSENT:
            oldest = next(iter(absent))
            first_take = max(first_take, absent.pop(oldest).counts["take"])
        return steps, absent, first_take

    def _leaving_with(self, name: str, reason: str) -> Steps:
        """Return the steps by which a performer's take ends, and its memory is freed; its events wait with the pool."""
        core = self._segmenters[name].core
        return [
            (core.end_take, reason),
            (core.hand_over, self._pending),
            (self._segmenters.pop, name),
        ]

    def _taken(self, names: Iterable[str]) -> list[Event]:
        """Return the events that wait with the pool and at performers, for the caller; no call once they are taken."""
        pending = self._pending
        for name in names:
            self._segmenters[name].core.hand_over(pending)
        events = pending[:]
        del pending[:]
        return events

    def _leaving(self, name: str) -> tuple[str, ...]:
        """Return the performers that are dismissed when one is announced: itself, or those idle for longest."""
        if name in self._segmenters:
            return (name,)
        return self.names[: max(0, len(self._segmenters) - self._most + 1)]

    def _new_segmenter(self, name: str, skeleton: Skeleton, fps: float | None) -> Segmenter:
        """Return a segmenter for a performer, with the performer's own settings."""
        recognition = self._recognition_of(name, skeleton)
        following = self._follow, self._alignment_of(name, skeleton, self._settings)
        segmenter = Segmenter.of_pool(
            shared_plan(skeleton, self._settings, fps), name, self._workspace, recognition, following
        )
        if segmenter.level != self._level:
            segmenter.level = self._level  # the threshold only: the bundle stays that of the settings
        segmenter.change(**self._own_changes(name))
        return segmenter

    def _own_changes(self, name: str) -> dict[str, object]:
        """Return the settings in which a performer differs from all."""
        if name not in self._segmenters:
            return self._absent[name].changes if name in self._absent else {}
        own, common = (msgspec.structs.asdict(s) for s in (self._segmenters[name].settings, self.settings))
        return {field: value for field, value in own.items() if value != common[field]}

    @property
    def moves(self) -> Moves | None:
        """The moves that are recognised; setting them takes effect with each performer's next frame.

        Raises:
            FrameError: If a performer's skeleton lacks joints that they need; nothing is changed then.
        """
        return self._moves

    @moves.setter
    def moves(self, moves: Moves | None) -> None:
        before = self._moves, self._stores, self._banks
        taught = copy_of(moves) if moves is not None else None
        own, steps = self._segmenters, list[tuple[Any, ...]]()
        try:
            self._moves, self._stores, self._banks = taught, {}, {}
            for name, segmenter in own.items():
                recognition = self._recognition_of(name, segmenter.skeleton)
                aligned = self._alignment_of(name, segmenter.skeleton, segmenter.settings)
                if recognition is not None:
                    recognition.follow_on(segmenter.recognition)
                steps += segmenter.recognising(recognition, self._follow, aligned)
            after = self._moves, self._stores, self._banks
        finally:
            self._moves, self._stores, self._banks = before
        steps += [
            (setattr, self, name, value)
            for name, value in zip(("_moves", "_stores", "_banks"), after, strict=True)
        ]
        at_once(self._cores(own), steps)

    @property
    def follow(self) -> Follow:
        """The names of the moves to follow, or True for all; setting them takes effect with each performer's next frame.

        Raises:
            MovesError: If there are no moves, or none of a name; nothing is changed then.
        """
        return self._follow

    @follow.setter
    def follow(self, follow: Iterable[str] | bool) -> None:
        before = self._follow, self._banks
        chosen, own, steps = checked_follow(follow, self._moves), self._segmenters, list[tuple[Any, ...]]()
        try:
            self._follow, self._banks = chosen, {}
            for name, segmenter in own.items():
                aligned = self._alignment_of(name, segmenter.skeleton, segmenter.settings)
                steps += segmenter.following_moves(chosen, aligned)
            banks = self._banks
        finally:
            self._follow, self._banks = before
        steps += [(setattr, self, "_follow", chosen), (setattr, self, "_banks", banks)]
        at_once(self._cores(own), steps)

    def _alignment_of(self, name: str, skeleton: Skeleton, settings: Settings) -> Alignment | None:
        """Return the alignment of a performer's followed moves."""
        key = skeleton, settings.up
        alignment = alignment_of(self._follow, self._moves, skeleton, settings, name, self._banks.get(key))
        if alignment is not None:
            while len(self._banks) >= MOST_KINDS and key not in self._banks:
                del self._banks[next(iter(self._banks))]
            self._banks[key] = alignment.store
        return alignment

    def _recognition_of(self, name: str, skeleton: Skeleton) -> Recognition | None:
        """Return the recognition of a performer's moves."""
        if self._moves is None:
            return None
        recognition = Recognition(self._moves, skeleton, name, self._stores.get(skeleton))
        while len(self._stores) >= MOST_KINDS and skeleton not in self._stores:
            del self._stores[next(iter(self._stores))]
        self._stores[skeleton] = recognition.store
        return recognition

    def _check_memory(self, plan: Plan, name: str) -> None:
        """Raise FrameError if the state of another performer would exceed the memory limit."""
        own = bytes_with_limbs(plan)
        others = sum(s.state_bytes for other, s in self._segmenters.items() if other != name)
        if own + others > self._most_memory:
            raise FrameError(
                f"{len(plan.skeleton)} joints of performer {name!r} need {own / 2**20:,.0f} MiB; with those of the others that is "
                f"more than the {self._most_memory / 2**20:,.0f} MiB that performers may take"
            )

    def _check_growth(self, plans: Mapping[str, Plan]) -> None:
        """Raise FrameError if new plans make the states larger than the memory limit."""
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

    def push(self, frames: Frames) -> list[Event]:
        """Process frames of one performer, and return the events they cause.

        Raises:
            FrameError: If the performer was not announced or the shapes do not fit its skeleton.
        """
        name = frames.performer if frames.performer in self._segmenters else performer_name(frames.performer)
        segmenter = self._segmenters.get(name)
        if segmenter is None:
            raise FrameError(f"performer {frames.performer!r} was not announced")
        segmenter.process(
            frames.positions,
            frames.times,
            frames.confidence,
            frames.first_frame,
            looks_at_times=self.looks_at_times,
        )
        self._segmenters.move_to_end(name)
        return self._taken((name,))

    def push_many(self, performers: Sequence[str], positions: ArrayLike, times: ArrayLike) -> list[Event]:
        """Process the same number of frames of many performers in one call, faster than one performer after another.

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
        names, frames, moments = self._checked(performers, given_positions(positions), times)
        cores = self._cores(names)
        for name, chunk, own in zip(names, frames, moments, strict=True):
            self._segmenters[name].look_at_size(chunk)
            if self.looks_at_times:
                self._segmenters[name].look_at_times(own)
        if cores:
            process_together(cores, frames, moments)
        return self._taken(names)

    def _checked(
        self, performers: Sequence[str], frames: NDArray[Any], times: ArrayLike
    ) -> tuple[list[str], NDArray[Any], NDArray[np.float64]]:
        """Return their names, their frames and (P, n) times; see `push_many`."""
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
        return names, frames, plain_array(np.broadcast_to(moments, frames.shape[:2]), np.float64)

    def change(self, performer: str | None = None, **changes: object) -> list[Event]:
        """Change settings of one performer, or of all and of those to come; see `Segmenter.change`.

        Raises:
            SettingsError: If a value is illegal; nothing is changed then.
            FrameError: If there is no such performer, or all would take more than `most_memory`; nothing is changed then.
        """
        if performer is not None:
            self._chosen(performer)
            segmenter = self._segmenters[performer]
            plan, level = segmenter.planned(changes)
            self._check_growth({performer: plan})
            at_once([segmenter.core], segmenter.adopting(plan, level))
            return self._taken((performer,))
        level = self._settings.replace(level=changes.pop("level", self._level)).level
        settings = self._settings.replace(**changes).at_level(level)
        Plan(ANYBODY, settings, None)  # all or nothing: new performers must be able to start with them
        plans = {
            name: segmenter.planned({**changes, "level": level})
            for name, segmenter in self._segmenters.items()
        }
        self._check_growth({name: plan for name, (plan, _) in plans.items()})
        steps: Steps = [(setattr, self, "_settings", settings), (setattr, self, "_level", level)]
        for name, (plan, own_level) in plans.items():
            steps += self._segmenters[name].adopting(plan, own_level)
        at_once(self._cores(plans), steps)
        return self._taken(plans)

    def _chosen(self, performer: str | None) -> tuple[str, ...]:
        """Return a performer, or all for None.

        Raises:
            FrameError: If there is no such performer.
        """
        if performer is None:
            return self.names
        if performer not in self._segmenters:
            raise FrameError(
                f"no performer called {performer!r}; there are {', '.join(self.names) or 'none'}"
            )
        return (performer,)

    def reset(self, performer: str | None = None, reason: str = "") -> list[Event]:
        """End the take of one performer, or of all, and forget the running range.

        Raises:
            FrameError: If there is no such performer.
        """
        chosen = self._chosen(performer)
        cores = self._cores(chosen)
        at_once(cores, [(core.reset, reason) for core in cores])
        return self._taken(chosen)

    def end_takes(self, reason: str = "") -> list[Event]:
        """End the takes of all performers."""
        cores = self._cores(self._segmenters)
        at_once(cores, [(core.end_take, reason) for core in cores])
        return self._taken(self._segmenters)

    def remove(self, performer: str, reason: str = "") -> list[Event]:
        """End a performer's take and forget the performer."""
        at_once(self._cores((performer,)), self._leaving_with(performer, reason))
        return self._taken(())

    def snapshot(self) -> dict[str, bytes]:
        """Return the state of all segmenters, by performer, without the examples of moves: those are the pool's."""
        return {name: segmenter.snapshot(with_moves=False) for name, segmenter in self._segmenters.items()}

    def lasting(self) -> bytes:
        """Return the rest of the pool's state: present settings, and the takes of replaced performers."""
        return msgspec.msgpack.encode(
            _Lasting(self._settings, self._level, self._absent, self._first_take, self._pending)
        )

    def restore(self, blobs: Mapping[str, bytes], lasting: bytes = b"") -> None:
        """Replace the segmenters by those of a snapshot.

        The moves of this pool are recognised from then on. If they differ from those of the snapshot, a move that was
        confirmed and not final yet is forgotten.

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
            self._absent = known.absent
        self._pending = pending
        self._segmenters = ordered

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
        chosen = self._settings.replace(level=level).level
        self._settings.strength(chosen)
        steps: Steps = [(setattr, self, "_level", chosen)]
        for segmenter in self._segmenters.values():
            steps += segmenter.moving_level(segmenter.planned_level(level))  # all or nothing
        at_once(self._cores(self._segmenters), steps)


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
