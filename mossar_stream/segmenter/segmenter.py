"""Segmenter: frames of one performer in, events out."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_stream.core.curve_state import CurveState, curve_state
from mossar_stream.core.intake import checked, has_said_size, look_at_steps
from mossar_stream.core.kernels import Channel, Performer, Workspace, at_once
from mossar_stream.core.plan import Plan
from mossar_stream.core.snapshot import (
    Following,
    pack_snapshot,
    reported_of,
    restored_following,
    unpack_snapshot,
)
from mossar_stream.events import Event
from mossar_stream.following.alignment import Alignment, Follow, FollowState, alignment_of, checked_follow
from mossar_stream.frames import Frames, constant_times, performer_name
from mossar_stream.moves.groups import groups_of
from mossar_stream.moves.moves import Moves
from mossar_stream.moves.recognition import Recognition
from mossar_stream.segmenter.followers import Followers, followers_of
from mossar_stream.segmenter.limbs import (
    joints_of_limbs,
    new_limbs,
    pack_limb,
    restored_limbs,
    settings_of_limbs,
)
from mossar_stream.settings import LevelName, Settings, settings_or_default
from mossar_stream.skeleton import Skeleton
from mossar_stream.steps.feet import feet_of

Steps: TypeAlias = list[tuple[Any, ...]]  # for `at_once`: compiled functions with their arguments
COUNTER_NAMES = ("frames", "out_of_order", "outliers", "held", "gaps", "unseen")


class Segmenter:
    """Online Mossar for one performer.

    The method is that of Paliyawan, Choensawat and Thawonmas, *Mossar: motion segmentation by using splitting and remerging
    strategies* (2018): velocity (equation 1), splitting (Algorithms 1 and 2), remerging (Algorithm 3) within a bounded window.

    Nothing is compiled at run time. The state grows only with the number of undecided key frames, up to
    `remerge_window`.

    Args:
        skeleton: The performer's joints.
        settings: Defaults to `Settings()`.
        performer: Name that events carry.
        fps: Nominal rate, Hz. Needed where `push` gets no times; otherwise only a hint.
        moves: Moves that are recognised, in their current state; events of type `MoveEvent` report them.
        follow: Names of the moves that are followed while they are made, or True for all; events of type `FollowEvent`
            report them.

    Attributes:
        performer: The name.
        joints: Number of joints.
        core: The owner of all memory, which processes the frames.

    A segmenter is used by one thread at a time; different ones may run in different threads.

    Each change is prepared first, and then made by compiled code in one step. Neither Ctrl-C nor an error leaves it half done,
    and events wait here until the caller has them.

    Raises:
        TypeError: If `skeleton` is no `Skeleton`.
        SettingsError: If `settings.range` is `file`, which a stream does not have.
        ValueError: If `fps` is not positive.
        FrameError: If the skeleton lacks joints that the moves or the limbs need.
        MovesError: If `follow` has a name that the moves lack.

    Example:
        >>> import numpy as np
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
        moves: Moves | None = None,
        follow: Iterable[str] | bool = (),
    ) -> None:
        if not isinstance(skeleton, Skeleton):
            raise TypeError(
                f"a segmenter needs a Skeleton, not {type(skeleton).__name__}; Skeleton(names, parents)"
            )
        if fps is not None:
            constant_times(0, fps)
        name = performer_name(performer)
        recognition = Recognition(moves, skeleton, name) if moves is not None else None
        plan = Plan(skeleton, settings_or_default(settings), fps)
        followed = checked_follow(follow, moves)
        following = followed, alignment_of(followed, moves, skeleton, plan.user_settings, name)
        followers = followers_of(plan, name, recognition, *following)
        body = Channel(plan, name, plan.new_row())
        self._begin(Workspace(), (body, *new_limbs(plan, name)), plan.user_settings.level, followers)

    def _begin(
        self,
        workspace: Workspace,
        channels: tuple[Channel, ...],
        level: LevelName | float,
        followers: Followers,
    ) -> None:
        body = channels[0]
        plan = body.plan
        self.performer = body.performer
        self.joints = len(plan.skeleton)
        self._is_measured = False
        self._apart: int | None = 0  # see `look_at_steps`
        self._followers, self._level = followers, level
        joints = joints_of_limbs(plan) if len(channels) > 1 else ()
        self.core = Performer(workspace, channels, joints, followers.readers, _has_phase(plan))
        self._pending = self.core.pending

    @classmethod
    def of_pool(
        cls,
        plan: Plan,
        name: str,
        workspace: Workspace,
        recognition: Recognition | None = None,
        following: tuple[Follow, Alignment | None] = ((), None),
    ) -> "Segmenter":
        """Return a segmenter that shares the workspace of a pool."""
        segmenter = cls.__new__(cls)
        channels = Channel(plan, name, plan.new_row()), *new_limbs(plan, name)
        followers = followers_of(plan, name, recognition, *following)
        segmenter._begin(workspace, channels, plan.user_settings.level, followers)  # noqa: SLF001 - its own class
        return segmenter

    def carry_on(self, counts: Mapping[str, int]) -> None:
        """Number takes and count frames on from the `counts` of another segmenter of the same performer."""
        for channel in self.core.channels:
            channel.carry_on(counts)

    @property
    def row(self) -> Channel:
        """The channel of the body, with its state."""
        return self.core.main

    @property
    def skeleton(self) -> Skeleton:
        """The performer's joints."""
        return self.row.plan.skeleton

    @property
    def settings(self) -> Settings:
        """The settings in force, with the present level."""
        return self.row.plan.user_settings.replace(level=self._level)

    @property
    def take(self) -> int:
        """Number of the take that is open, or of the next one."""
        return self.row.take

    @property
    def stats(self) -> dict[str, int]:
        """Processed frames; those out of order, after a gap, or without a single joint; joints too fast or far off, or held."""
        return {name: int(self.row.state["counters"][name]) for name in COUNTER_NAMES}

    @property
    def counts(self) -> dict[str, int]:
        """`take` and `stats`, for a segmenter that carries on."""
        return {"take": self.take, **self.stats}

    @property
    def state(self) -> CurveState | None:
        """The velocity curve at the last frame, None before the first."""
        return curve_state(self.row.memory, self.row.plan) if self.row.is_open else None

    @property
    def moves(self) -> Moves | None:
        """The moves that are recognised; None if none are.

        Setting them takes effect with the next frame; adding to a `Moves` that was set before does not. A move that was
        confirmed is final if it is not among them; that event comes with the next push.
        """
        return self.recognition.moves if self.recognition is not None else None

    @moves.setter
    def moves(self, moves: Moves | None) -> None:
        alignment = alignment_of(self.follow, moves, self.skeleton, self.settings, self.performer)
        fresh = None
        if moves is not None:
            fresh = Recognition(moves, self.skeleton, self.performer).follow_on(self.recognition)
        at_once([self.core], self.recognising(fresh, self.follow, alignment))

    def recognising(
        self, recognition: Recognition | None, follow: Follow, alignment: Alignment | None
    ) -> Steps:
        """Return the steps that replace the recognition and the following of moves."""
        fresh, events = self._followers.recognising(recognition, self.row.plan, self.performer, self.take)
        fresh, more = fresh.following(follow, alignment, self.take)
        return [(self._pending.extend, events + more), *self._going_on_with(fresh)]

    def _going_on_with(self, followers: Followers) -> Steps:
        """Return the steps that replace the readers."""
        phase = _has_phase(self.row.plan)
        return [
            (setattr, self, "_followers", followers),
            (self.core.set_readers, followers.readers, phase),
        ]

    @property
    def recognition(self) -> Recognition | None:
        """The recognition of the moves; None if there is none."""
        return self._followers.recognition

    @property
    def follow(self) -> Follow:
        """The names of the moves to follow, or True for all.

        Setting them takes effect with the next frame; performances under way are decided, and the events come with the next
        push. Moves that are set later are followed if their names are among these.

        Raises:
            MovesError: If there are no moves, or none of a name.
        """
        return self._followers.followed

    @follow.setter
    def follow(self, follow: Iterable[str] | bool) -> None:
        chosen = checked_follow(follow, self.moves)
        alignment = alignment_of(chosen, self.moves, self.skeleton, self.settings, self.performer)
        at_once([self.core], self.following_moves(chosen, alignment))

    def following_moves(self, follow: Follow, alignment: Alignment | None) -> Steps:
        """Return the steps of a change of the alignment; performances under way are decided."""
        fresh, events = self._followers.following(follow, alignment, self.take)
        return [(self._pending.extend, events), *self._going_on_with(fresh)]

    @property
    def following(self) -> dict[str, FollowState | None]:
        """State of each followed move at the last frame; None while it is not being made."""
        alignment = self._followers.alignment
        return {} if alignment is None else alignment.following

    @property
    def limbs(self) -> tuple[str, ...]:
        """The limbs that have key frames of their own (setting `limbs`), as the `channel` of events names them.

        Empty, too, if no joint of the skeleton can move against another: such a skeleton is segmented as without limbs.
        """
        return tuple(limb.name for limb in self.core.channels[1:])

    @property
    def limb_states(self) -> dict[str, CurveState | None]:
        """The velocity curve of each limb at the last frame; see `state`."""
        at_once([self.core], [(self.core.catch_up,)])
        return {
            limb.name: curve_state(limb.memory, limb.plan) if limb.is_open else None
            for limb in self.core.channels[1:]
        }

    @property
    def level(self) -> LevelName | float:
        """The level: `posture`, `motion`, `cluster` or a strength.

        A new level acts at once on the undecided key frames, without a new ranking; the events come with the next push. A
        name that needs other settings than those in force is refused with a `SettingsError`: `change(level=...)` starts
        a new take with them.
        """
        return self._level

    @level.setter
    def level(self, level: LevelName | float) -> None:
        at_once([self.core], self.moving_level(self.planned_level(level)))

    def planned_level(self, level: LevelName | float) -> LevelName | float:
        """Return a level if it can be set, and change nothing.

        Raises:
            SettingsError: If it is no level, or a name that works with other settings.
        """
        plan = self.row.plan
        chosen = plan.user_settings.replace(level=level).level
        plan.strength(chosen)
        return chosen

    def moving_level(self, level: LevelName | float, plans: Iterable[Plan] | None = None) -> Steps:
        """Return the steps by which the level moves.

        Args:
            level: As of `planned_level`.
            plans: Of body and limbs, if not as they are.
        """
        own = [channel.plan for channel in self.core.channels] if plans is None else plans
        strengths = tuple(plan.strength(level) for plan in own)
        return [(self.core.set_level, strengths), (setattr, self, "_level", level)]

    def change(self, **changes: object) -> list[Event]:
        """Change settings while running, and return the events of the take that this ends.

        A level and thresholds act at once. Other settings end the take, and the next push starts a new one: those of
        the curve or the summaries (window, smoothing, similarity, features and the like, or a named level that brings
        others), the tempo, repetitions, and limbs while repetitions are counted.

        Args:
            **changes: Fields of `Settings`.

        Raises:
            SettingsError: If a value is illegal, or FrameError if joints of the limbs lack; nothing is changed then.
        """
        at_once([self.core], self.adopting(*self.planned(changes)))
        return self._taken()

    def planned(self, changes: Mapping[str, object]) -> tuple[Plan, LevelName | float]:
        """Return the plan and the level that changes of settings would bring, and change nothing."""
        before = self.row.plan
        level = before.user_settings.replace(level=changes.get("level", self._level)).level
        changed = before.user_settings.replace(**{**changes, "level": before.user_settings.level}).at_level(
            level
        )
        groups_of(before.skeleton, changed.limbs)  # or FrameError
        if changed.steps:
            feet_of(before.skeleton, changed.feet)  # or FrameError
        return before.with_settings(changed), level

    def adopting(self, plan: Plan, level: LevelName | float) -> Steps:
        """Return the steps to go on with a plan and a level; the take ends if it cannot go on with them."""
        core, before, name = self.core, self.row.plan, self.performer
        goes_on = plan.continues(before)
        plans, limbs = self._limbs_with(plan)
        fresh, events = self._followers.adapted(
            plan, before.user_settings, name, self.take if goes_on else None
        )
        every = plan.user_settings.follow_every
        body: Steps = [(core.replan, 0, plan, plan.joint_limbs)]
        if not goes_on:
            body = [
                (core.end_take_for, "settings changed"),
                (core.restart, 0, Channel(plan, name, plan.new_row())),
            ]
        aligned: Steps = [] if fresh.alignment is None else [(fresh.alignment.set_every, every)]
        return [
            *body,
            *limbs,
            (self._pending.extend, events),
            *aligned,
            (setattr, self, "_followers", fresh),
            (core.set_readers, fresh.readers, _has_phase(plan)),
            *self.moving_level(level, plans),
        ]

    def _limbs_with(self, plan: Plan) -> tuple[list[Plan], Steps]:
        """Return the plans of body and limbs once the body has a plan, and the steps by which limbs go on."""
        core, current = self.core, self.core.channels[1:]
        if plan.user_settings.limbs != self.row.plan.user_settings.limbs:
            others = new_limbs(plan, self.performer)
            joints = joints_of_limbs(plan) if others else ()
            return [plan, *(limb.plan for limb in others)], [
                (core.end_limbs,),
                (core.set_limbs, others, joints),
            ]
        own, plans, steps = settings_of_limbs(plan.user_settings), [plan], list[tuple[Any, ...]]()
        for i, limb in enumerate(current, 1):
            before = limb.plan
            after = before if own == before.user_settings else before.with_settings(own)
            plans.append(after)
            if after is before:
                continue
            if after.continues(before):
                steps.append((core.replan, i, after, after.joint_limbs))
            else:
                steps.append((core.restart, i, Channel(after, limb.performer, after.new_row())))
        return plans, steps

    def _taken(self) -> list[Event]:
        """Return the events that wait, for the caller; no call in here, so that Ctrl-C finds them in one place."""
        pending = self._pending
        events = pending[:]
        del pending[:]
        return events

    def push(
        self,
        positions: ArrayLike | Frames,
        times: ArrayLike | None = None,
        confidence: ArrayLike | None = None,
        first_frame: int | None = None,
    ) -> list[Event]:
        """Process frames and return the events they cause, in order.

        Frames that come too late are dropped and counted; a long gap, or a long step back in time, ends the take
        and starts a new one. Frames may be cut into chunks in any way: the events are the same.

        After Ctrl-C in here the last frames may be left out; the events until then come with the next call.

        Args:
            positions: (n, J, 3) or, for one frame, (J, 3), metres, NaN where a joint is missing; or `Frames`. Lists of
                lists are taken, too, ten times as slowly as the frame itself.
            times: (n,) or a number, seconds on the source's clock. None counts frames at the nominal rate.
            confidence: (n, J) or (J,) in 0..1; 0 marks a joint as missing.
            first_frame: Number of the first frame; None to count on.

        Raises:
            FrameError: If the shapes do not fit the skeleton, or `first_frame` is a number that the take already had.
            RuntimeError: If another thread is using the segmenter.
            ValueError: If there are neither times nor a nominal rate.
        """
        if confidence is None and first_frame is None and self.core.process_one(positions, times):
            pending = self._pending
            if not pending:
                return []
            events = pending[:]
            del pending[:]
            return events
        if isinstance(positions, Frames):
            frames = positions
            self.process(frames.positions, frames.times, frames.confidence, frames.first_frame)
        else:
            self.process(positions, times, confidence, first_frame)
        return self._taken()

    def process(
        self,
        positions: ArrayLike,
        times: ArrayLike | None,
        confidence: ArrayLike | None = None,
        first_frame: int | None = None,
        *,
        looks_at_times: bool = True,
    ) -> None:
        """Process frames as `push`, and leave the events pending."""
        chunk, moments = checked(self.row, positions, times, confidence, first_frame)
        self.look_at_size(chunk, 5)
        if looks_at_times:
            self.look_at_times(moments, 5)
        self.core.process(chunk, moments, first_frame)

    def look_at_size(self, chunk: NDArray[Any], depth: int = 4) -> None:
        """Warn if the performer is far larger than people are; see `has_said_size`."""
        if not (self._is_measured or self.row.has_begun):
            self._is_measured = has_said_size(f"performer {self.performer}", chunk, depth)

    def look_at_times(self, times: NDArray[np.float64], depth: int = 4) -> None:
        """Warn if times are hardly seconds; see `look_at_steps`."""
        if self._apart is not None:
            self._apart = look_at_steps(self.row, times, self._apart, f"performer {self.performer}", depth)

    @property
    def repetitions(self) -> int:
        """Repetitions counted in the open take; 0 without the setting."""
        return self.row.repetitions

    @property
    def phase(self) -> float | None:
        """Position of the latest frame in the cycle of a repeated movement, 0 to 1; None outside a bout."""
        return self.row.phase

    def end_take(self, reason: str = "") -> list[Event]:
        """End the take: decide all key frames; the next push starts a new take.

        Args:
            reason: The reason of the `ended` event.

        Returns:
            The pending events; nothing more if no take is open.
        """
        at_once([self.core], [(self.core.end_take, reason)])
        return self._taken()

    def reset(self, reason: str = "") -> list[Event]:
        """End the take and forget the running range, as for another person."""
        at_once([self.core], [(self.core.reset, reason)])
        return self._taken()

    def release(self) -> None:
        """Free the memory at once; any later call raises a RuntimeError.

        Raises:
            RuntimeError: If another thread is using the segmenter, or its pool; nothing is freed then.
        """
        self.core.release()

    def __reduce__(self) -> tuple[Callable[..., "Segmenter"], tuple[bytes]]:
        """Copy and pickle by a snapshot: a copy goes on from here on its own, and begins with the events that wait here."""
        return Segmenter.restore, (self.snapshot(),)

    @property
    def state_bytes(self) -> int:
        """Bytes of the state, without shared memory."""
        rows = sum(len(channel.memory) for channel in self.core.channels)
        return rows + sum(len(reader.state) for reader in self._followers.readers)

    def snapshot(self, *, with_moves: bool = True) -> bytes:
        """Return the state of the segmenter as checksummed bytes; the segmenter is not changed.

        Args:
            with_moves: Whether the examples of moves, by far most of it, are in it; if not, `restore` needs them.
        """
        at_once([self.core], [(self.core.settle,)])
        row = self.row
        return pack_snapshot(
            row.plan,
            row.performer,
            self._level,
            self._pending,
            row.memory,
            self._known(with_moves=with_moves),
        )

    def _known(self, *, with_moves: bool) -> Following:
        """Return the state besides the row; see `snapshot`."""
        of = self._followers
        recognition, alignment, holding = of.recognition, of.alignment, of.holding
        return Following(
            moves=None if recognition is None or not with_moves else recognition.moves_text,
            digest=b"" if recognition is None else recognition.digest,
            recognition=None if recognition is None else recognition.to_bytes(),
            repetitions=reported_of(self.row),
            limbs=tuple(pack_limb(limb, self._level) for limb in self.core.channels[1:]),
            steps=None if of.stepping is None else of.stepping.to_bytes(),
            follow=of.followed,
            followed=None if alignment is None else alignment.to_bytes(),
            poses=None if holding is None else holding.to_bytes(),
            numbers=of.numbers(self.take),
        )

    @classmethod
    def restore(
        cls,
        blob: bytes,
        moves: Moves | None = None,
        follow: Follow | None = None,
        *,
        with_moves: bool = True,
    ) -> "Segmenter":
        """Return a segmenter that continues exactly from a snapshot.

        Args:
            blob: Of `snapshot`.
            moves: For a snapshot without them; they may differ from those that it was made with.
            follow: Names of the moves that are followed from now on, or True for all; None as when it was made.
            with_moves: Whether moves are recognised at all from now on, if they were before.

        Raises:
            SnapshotError: If the bytes are damaged, truncated, of another version, or lack the moves.
        """
        plan, performer, level, pending, content, recognition, known = unpack_snapshot(
            blob, moves, with_moves=with_moves
        )
        body = Channel(plan, performer, content)
        followed, alignment = restored_following(known, recognition, follow, plan, performer)
        followers = followers_of(plan, performer, recognition, followed, alignment)
        known.give_repetitions(body)
        if followers.stepping is not None:
            followers.stepping.go_on_from(known.steps)
        if followers.holding is not None and known.poses is not None:
            if recognition is not None and recognition.digest == known.digest:
                followers.holding.go_on_from(known.poses)
            else:
                followers.holding.count_on_from(known.numbers.poses)
        limbs = restored_limbs(plan, performer, known.limbs)
        segmenter = cls.__new__(cls)
        kept = followers._replace(kept=known.numbers, kept_take=body.take)
        segmenter._begin(Workspace(), (body, *limbs), level, kept)  # noqa: SLF001
        segmenter._pending += pending  # noqa: SLF001
        return segmenter


def _has_phase(plan: Plan) -> bool:
    """Return whether the phase of each frame is reported."""
    return plan.user_settings.phase and plan.reports_repetitions
