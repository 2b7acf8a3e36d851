"""Followers: readers of a performer's frames besides the segmentation of the body. All are off by default.

Limbs have rows of their own; moves, moves that are followed, held poses, and steps are readers; the phase is reported for
every frame. A change gives a segmenter a new record of these and leaves the old one as it is, so that an exception leaves
no half change.
"""

from typing import NamedTuple

from mossar_stream.core.kernels import Reader
from mossar_stream.core.plan import Plan
from mossar_stream.core.snapshot import Numbers
from mossar_stream.events import BODY, Event
from mossar_stream.following.alignment import Alignment, Follow
from mossar_stream.moves.recognition import Recognition
from mossar_stream.poses.holding import Holding, holding_of
from mossar_stream.settings import Settings
from mossar_stream.steps.stepping import Stepping

OF_STEPS = ("steps", "feet", "step_sensitivity", "up")  # settings


class Followers(NamedTuple):
    """The readers of one performer's frames, besides limbs.

    Attributes:
        recognition: Of moves.
        followed: Moves to follow.
        alignment: Their alignment.
        holding: The recognition of held poses.
        stepping: Steps.
        kept: Numbers of the last events of the readers that were removed in take `kept_take`; numbering continues from them.
    """

    recognition: Recognition | None = None
    followed: Follow = ()
    alignment: Alignment | None = None
    holding: Holding | None = None
    stepping: Stepping | None = None
    kept: Numbers = Numbers()
    kept_take: int = 0

    @property
    def readers(self) -> tuple[Reader, ...]:
        """The readers of the frames, in the order of their reports."""
        recognition = self.recognition if self.recognition is not None and self.recognition.names else None
        readers: tuple[Reader | None, ...] = recognition, self.alignment, self.holding, self.stepping
        return tuple(reader for reader in readers if reader is not None)

    def numbers(self, take: int, followed: tuple[int, dict[str, int]] | None = None) -> Numbers:
        """Return the numbers of the last events: of the present readers, else of the last ones in this take.

        Args:
            take: Number of the take.
            followed: `Alignment.numbers`, if not as they are.
        """
        known = self.kept if take == self.kept_take else Numbers(moves=self.kept.moves)
        if followed is None:
            followed = (
                (known.performances, known.counts) if self.alignment is None else self.alignment.numbers
            )
        return Numbers(
            moves=known.moves if self.recognition is None else self.recognition.number,
            performances=followed[0],
            counts=known.counts | followed[1],
            poses=known.poses if self.holding is None else self.holding.number,
            steps=known.steps if self.stepping is None else self.stepping.number(take),
        )

    def recognising(
        self, recognition: Recognition | None, plan: Plan, performer: str, take: int
    ) -> tuple["Followers", list[Event]]:
        """Return the readers with another recognition of moves, and the events of the change; nothing here is changed.

        Args:
            recognition: From now on; it may be the same.
            plan: Of the body, from now on.
            performer: Name.
            take: Number of the take.
        """
        numbers, events = self.numbers(take), list[Event]()
        holding = _holding_of(recognition, plan, performer)
        if holding is not None:
            holding.count_on_from(numbers.poses)
        if recognition is not None:
            recognition.count_on_from(numbers.moves)
        if self.holding is not None:
            events += self.holding.left(take)
        if self.recognition is not None and (recognition is None or not recognition.is_undecided):
            events += self.recognition.last_word()
        fresh = self._replace(recognition=recognition, holding=holding, kept=numbers, kept_take=take)
        return fresh, events

    def following(
        self, followed: Follow, alignment: Alignment | None, take: int
    ) -> tuple["Followers", list[Event]]:
        """Return the readers with another alignment, and the events that the change decides.

        Args:
            followed: Moves to follow.
            alignment: Their alignment.
            take: Number of the take.
        """
        events, counted = ([], None) if self.alignment is None else self.alignment.decided(take)
        numbers = self.numbers(take, counted)
        if alignment is not None:
            alignment.count_on_from(numbers.performances, numbers.counts)
        return self._replace(followed=followed, alignment=alignment, kept=numbers, kept_take=take), events

    def _stepping(self, plan: Plan, performer: str, take: int | None) -> "Followers":
        """Return the readers with other settings of steps; the numbers of one take go on."""
        stepping = stepping_of(plan, performer)
        if take is None:
            return self._replace(stepping=stepping)
        numbers = self.numbers(take)
        if stepping is not None:
            stepping.count_on_from(take, numbers.steps)
        return self._replace(stepping=stepping, kept=numbers, kept_take=take)

    def adapted(
        self, plan: Plan, before: Settings, performer: str, take: int | None
    ) -> tuple["Followers", list[Event]]:
        """Return the readers with other settings, and the events of the change.

        Args:
            plan: Of the body, from now on.
            before: The settings so far.
            performer: Name.
            take: Number of the take; None if it ends before.
        """
        current, fresh, events = plan.user_settings, self, list[Event]()
        if any(getattr(current, name) != getattr(before, name) for name in OF_STEPS):
            fresh = fresh._stepping(plan, performer, take)
        if current.up == before.up:
            return fresh, events
        if take is None:
            alignment = self.alignment and self.alignment.with_upward_axis(current)
            holding = _holding_of(self.recognition, plan, performer)
            return fresh._replace(alignment=alignment, holding=holding), events
        if fresh.alignment is not None:
            fresh, events = fresh.following(fresh.followed, fresh.alignment.with_upward_axis(current), take)
        fresh, more = fresh.recognising(fresh.recognition, plan, performer, take)
        return fresh, events + more


def followers_of(
    plan: Plan,
    performer: str,
    recognition: Recognition | None,
    followed: Follow,
    alignment: Alignment | None,
) -> Followers:
    """Return the readers of a new performer.

    Args:
        plan: Of the body.
        performer: Name.
        recognition: Of moves.
        followed: Moves to follow.
        alignment: Their alignment.
    """
    holding = _holding_of(recognition, plan, performer)
    return Followers(recognition, followed, alignment, holding, stepping_of(plan, performer))


def _holding_of(recognition: Recognition | None, plan: Plan, performer: str) -> Holding | None:
    """Return the recognition of the poses among the moves."""
    if recognition is None:
        return None
    return holding_of(recognition.moves, plan.skeleton, plan.user_settings.up, performer)


def stepping_of(plan: Plan, performer: str) -> Stepping | None:
    """Return the reader of steps, if they are wanted."""
    wanted = plan.user_settings.steps and plan.channel == BODY
    return Stepping(plan.skeleton, plan.user_settings, performer) if wanted else None
