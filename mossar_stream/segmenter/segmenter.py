"""Segmenter: frames of one performer in, events out."""

import functools
from collections.abc import Callable, Iterable, Mapping

from numpy.typing import ArrayLike

from mossar_stream.core import engine
from mossar_stream.core.buffers import Buffers
from mossar_stream.core.curve_state import CurveState, curve_state
from mossar_stream.core.intake import checked, has_said_size
from mossar_stream.core.plan import Plan
from mossar_stream.core.pool import Row, new_row, restored_row
from mossar_stream.core.snapshot import pack_snapshot, restored_following, unpack_snapshot
from mossar_stream.core.station import Station
from mossar_stream.events import Event
from mossar_stream.following.alignment import Alignment, Follow, FollowState, alignment_of, checked_follow
from mossar_stream.frames import Frames, constant_times, performer_name
from mossar_stream.moves.moves import Moves
from mossar_stream.moves.recognition import Recognition
from mossar_stream.segmenter.followers import Followers
from mossar_stream.segmenter.limbs import NewRow, carry_on
from mossar_stream.segmenter.steps import Steps
from mossar_stream.settings import LevelName, Settings, settings_or_default
from mossar_stream.skeleton import Skeleton

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
        row: Where the state lies, for those who run the rows of a pool.
        steps: What is done with it in several steps.

    A segmenter is used by one thread at a time; different ones may run in different threads.

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
        self._begin(new_row(plan, Buffers(), name), plan.user_settings.level, recognition, following)

    def _begin(
        self,
        row: Row,
        level: LevelName | float,
        recognition: Recognition | None,
        following: tuple[Follow, Alignment | None] = ((), None),
        new_limb: NewRow | None = None,
    ) -> None:
        self.performer = row.name
        self.joints = len(row.plan.skeleton)
        self.row = row
        self._is_measured = False
        # Nothing here may lead back to the segmenter: it would keep its memory until the collector comes by.
        own = functools.partial(_new_limb, row.buffers, row.name)
        self._followers = Followers(row, level, recognition, following, new_limb or own)
        self.steps = Steps(row, self._followers, level)
        self._single = self.steps.single

    @classmethod
    def of_row(
        cls,
        row: Row,
        recognition: Recognition | None = None,
        following: tuple[Follow, Alignment | None] = ((), None),
        new_limb: NewRow | None = None,
    ) -> "Segmenter":
        """Return a segmenter whose state is a row of a pool; those of limbs come from `new_limb`, or have own pools."""
        segmenter = cls.__new__(cls)
        segmenter._begin(row, row.plan.user_settings.level, recognition, following, new_limb)  # noqa: SLF001 - its own class
        return segmenter

    def carry_on(self, counts: Mapping[str, int]) -> None:
        """Number takes and count frames on from the `counts` of another segmenter of the same performer."""
        carry_on(self.row, counts)
        self._followers.carry_on(counts)

    @property
    def station(self) -> Station | None:
        """The performer as the loop knows it, if frames can be pushed with those of others; None if they must be checked."""
        return self._followers.station if self._single.is_expected else None

    @property
    def skeleton(self) -> Skeleton:
        """The performer's joints."""
        return self.row.plan.skeleton

    @property
    def settings(self) -> Settings:
        """The settings in force; `level` as it is now."""
        return self.row.plan.user_settings.replace(level=self.steps.level)

    @property
    def take(self) -> int:
        """Number of the take that is open, or of the next one."""
        return int(self.row.clock["take"])

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
        return curve_state(self.row.memory, self.row.plan) if self.row.clock["open"] else None

    @property
    def moves(self) -> Moves | None:
        """The moves that are recognised; None if none are.

        Setting them takes effect with the next frame; adding to a `Moves` that was set before does not. A move that was
        confirmed is final if it is not among them; that event comes with the next push.
        """
        return self.recognition.moves if self.recognition is not None else None

    @moves.setter
    def moves(self, moves: Moves | None) -> None:
        self.steps.mend()
        alignment = alignment_of(self.follow, moves, self.skeleton, self.settings, self.performer)
        fresh = None
        if moves is not None:
            fresh = Recognition(moves, self.skeleton, self.performer).follow_on(self.recognition)
        self.steps.recognise(fresh, self.follow, alignment)

    @property
    def recognition(self) -> Recognition | None:
        """What recognises the moves; None if nothing does."""
        return self._followers.recognition

    @property
    def follow(self) -> Follow:
        """The names of the moves to follow, or True for all.

        Setting them takes effect with the next frame; what is being made then is decided, and the events come with the next
        push. Moves that are set later are followed if their names are among these.

        Raises:
            MovesError: If there are no moves, or none of a name.
        """
        return self._followers.followed

    @follow.setter
    def follow(self, follow: Iterable[str] | bool) -> None:
        self.steps.mend()
        chosen = checked_follow(follow, self.moves)
        alignment = alignment_of(chosen, self.moves, self.skeleton, self.settings, self.performer)
        self.steps.follow_moves(chosen, alignment)

    @property
    def following(self) -> dict[str, FollowState | None]:
        """Where the performer is in each move that is followed at the last frame; None while it is not being made."""
        alignment = self._followers.alignment
        return {} if alignment is None else alignment.following

    @property
    def limbs(self) -> tuple[str, ...]:
        """The limbs that have key frames of their own (setting `limbs`), as the `channel` of events names them.

        Empty, too, if no joint of the skeleton can move against another: such a skeleton is segmented as without limbs.
        """
        return () if self._followers.limbs is None else self._followers.limbs.names

    @property
    def limb_states(self) -> dict[str, CurveState | None]:
        """The velocity curve of each limb at the last frame; see `state`."""
        limbs = self._followers.limbs
        return {} if limbs is None else limbs.states

    @property
    def level(self) -> LevelName | float:
        """The level: `posture`, `motion`, `cluster` or a strength.

        Setting it acts at once on the undecided key frames and computes nothing again; the events come with the
        next push. A name that works with other settings than those in force is refused with a `SettingsError`:
        `change(level=...)` starts a new take with them.
        """
        return self.steps.level

    @level.setter
    def level(self, level: LevelName | float) -> None:
        chosen = self.steps.planned_level(level)
        self.steps.mend()
        self.steps.set_level(chosen)

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
        self.steps.adopt(*self.steps.planned(changes))
        return self.row.take_pending()

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
        row, single = self.row, self._single
        if single.is_expected and confidence is None and first_frame is None:
            try:
                if engine.process_one(self._followers.desk, positions, times, single.frame, row.origin):
                    return row.take_pending() if row.pending else []
            except BaseException:
                self.steps.tear()
                raise
        if isinstance(positions, Frames):
            frames = positions
            self.process(frames.positions, frames.times, frames.confidence, frames.first_frame)
        else:
            self.process(positions, times, confidence, first_frame)
        return row.take_pending()

    def process(
        self,
        positions: ArrayLike,
        times: ArrayLike | None,
        confidence: ArrayLike | None = None,
        first_frame: int | None = None,
    ) -> None:
        """Process frames as `push`, and leave the events pending at the row."""
        row = self.row
        self.steps.mend()
        chunk, moments = checked(row, positions, times, confidence, first_frame)
        if not (row.is_live or self._is_measured):
            self._is_measured = has_said_size(f"performer {self.performer}", chunk, 4)
        self.steps.push(chunk, moments, first_frame)

    @property
    def repetitions(self) -> int:
        """Repetitions counted in the open take; 0 without the setting."""
        row = self.row
        return row.reporter.total if row.reporter is not None and row.clock["open"] else 0

    @property
    def phase(self) -> float | None:
        """Where in the cycle of a repeated movement the latest frame is, 0 to 1; None when nothing repeats."""
        row = self.row
        if row.reporter is None or not row.clock["open"]:
            return None
        return row.reporter.phase(float(row.clock["time"]))

    def end_take(self, reason: str = "") -> list[Event]:
        """End the take: decide everything, and let the next push start a new one.

        Args:
            reason: What the `ended` event says.

        Returns:
            The pending events; nothing more if no take is open.
        """
        self.steps.end_take(reason)
        return self.row.take_pending()

    def reset(self, reason: str = "") -> list[Event]:
        """End the take and forget the running range, as for another person."""
        self.steps.reset(reason)
        return self.row.take_pending()

    def release(self) -> None:
        """Give the rows back that the state lies in; the segmenter is of no use afterwards."""
        self.row.release()
        self._followers.release()

    def __reduce__(self) -> tuple[Callable[..., "Segmenter"], tuple[bytes]]:
        """Copy and pickle by a snapshot: a copy goes on from here on its own, and begins with the events that wait here."""
        return Segmenter.restore, (self.snapshot(),)

    @property
    def state_bytes(self) -> int:
        """Bytes of the state, besides what is shared with others."""
        return self.row.plan.row_bytes + self._followers.bytes_taken

    def snapshot(self, *, with_moves: bool = True) -> bytes:
        """Return everything the segmenter knows as checksummed bytes; it goes on undisturbed.

        Args:
            with_moves: Whether the examples of moves, by far most of it, are in it; if not, `restore` needs them.
        """
        following, row = self.steps.known(with_moves=with_moves), self.row
        return pack_snapshot(row.plan, row.name, self.steps.level, row.pending, row.memory, following)

    @classmethod
    def restore(
        cls,
        blob: bytes,
        moves: Moves | None = None,
        follow: Follow | None = None,
        *,
        with_moves: bool = True,
    ) -> "Segmenter":
        """Return a segmenter that goes on exactly where the one that made `blob` was.

        Args:
            blob: Of `snapshot`.
            moves: Of a snapshot without them; others than it was made with are recognised from now on.
            follow: Names of the moves that are followed from now on, or True for all; None as when it was made.
            with_moves: Whether moves are recognised at all from now on, if they were before.

        Raises:
            SnapshotError: If the bytes are damaged, truncated, of another version, or lack the moves.
        """
        plan, performer, level, pending, content, recognition, known = unpack_snapshot(
            blob, moves, with_moves=with_moves
        )
        row = restored_row(plan, Buffers(), performer, content)
        row.pending += pending
        segmenter = cls.__new__(cls)
        following = restored_following(known, recognition, follow, plan, performer)
        segmenter._begin(row, level, recognition, following)  # noqa: SLF001
        segmenter._followers.restore(known)  # noqa: SLF001
        return segmenter


def _new_limb(buffers: Buffers, performer: str, plan: Plan, pending: list[Event]) -> Row:
    """Return a row for a limb of a performer who has no pool."""
    return new_row(plan, buffers, performer, pending)
