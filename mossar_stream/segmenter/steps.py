"""Steps: what a segmenter does in several steps, none of which an exception from outside may leave half done.

Ctrl-C comes between any two steps. Then the row is torn. The next call first repairs the row (`engine.mend`), then
finishes the interrupted step: everything here may be done again from any point.
"""

import functools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core import engine
from mossar_stream.core.intake import Single, less_origin, place_of
from mossar_stream.core.plan import Plan
from mossar_stream.core.pool import Row
from mossar_stream.core.snapshot import Following
from mossar_stream.core.station import Desk
from mossar_stream.following.alignment import Alignment, Follow
from mossar_stream.moves.groups import groups_of
from mossar_stream.moves.recognition import Recognition
from mossar_stream.segmenter.followers import Followers
from mossar_stream.settings import LevelName
from mossar_stream.steps.feet import feet_of


class Steps:
    """What is done with one performer, the body and all that follows; the events are pending then.

    Args:
        row: The performer's.
        followers: Of its frames.
        level: As it is now.

    Attributes:
        level: The same.
        single: What a single frame need not be asked; it is asked everything once a method here was called, until `push`.
    """

    def __init__(self, row: Row, followers: Followers, level: LevelName | float) -> None:
        self._row = row
        self._followers = followers
        self.level = level
        self.single = Single(len(row.plan.skeleton))
        self._unfinished: Callable[[], None] | None = None
        self._crowd: Desk | None = None

    def tear(self, crowd: Desk | None = None) -> None:
        """Take note that an exception came while something was done: `mend` comes before anything else.

        Args:
            crowd: Of the performers who were processed together.
        """
        self._row.is_torn = True
        self._crowd = crowd or self._crowd
        self.single.is_expected = False

    def mend(self) -> None:
        """Finish what an exception cut short, if one did."""
        if not self._row.is_torn:
            return
        try:
            self._followers.mend(self._crowd)
            self._crowd = None
            if self._unfinished is not None:
                self._carry_out(self._unfinished)
            self._row.is_torn = False
        except BaseException:
            self.tear()
            raise

    def known(self, *, with_moves: bool) -> Following:
        """Return what is known besides the row, for a snapshot; see `Segmenter.snapshot`."""
        self.mend()
        try:
            self._followers.apply_level()
            return self._followers.snapshot(with_moves=with_moves)
        except BaseException:
            self.tear()
            raise

    def push(self, chunk: NDArray[Any], moments: NDArray[np.float64], first_frame: int | None) -> None:
        """Process frames among which takes may begin, take by take.

        Args:
            chunk: (n, J, 3) m, in single or double precision.
            moments: (n,) s.
            first_frame: Number of the first frame; None to count on.
        """
        try:
            self._push(chunk, moments, first_frame)
        except BaseException:
            self.tear()
            raise

    def _push(self, chunk: NDArray[Any], moments: NDArray[np.float64], first_frame: int | None) -> None:
        row, followers, begin, count = self._row, self._followers, 0, len(moments)
        if row.is_level_new:
            followers.apply_level()
        while begin < count:
            end = count if row.is_placed else begin + self._settle(chunk[begin:])
            if first_frame is not None:
                row.clock["next_frame"] = first_frame + begin
            ended = engine.process(followers.desk, less_origin(row, chunk[begin:end]), moments[begin:end])
            if ended:
                begin += ended[0][1]
                self._end_take(engine.why_ended(row, moments[begin]))
            else:
                begin = end
        self.single.is_expected = row.is_placed

    def _settle(self, positions: NDArray[Any]) -> int:
        """Find the performer's place in the take; return how many frames to process then: those before anybody is seen."""
        origin, first = place_of(positions, self._row.plan.center)
        self._row.settle(origin if first == 0 else np.zeros(3), found=first == 0)
        return first or len(positions)

    def end_take(self, reason: str) -> None:
        """End the take."""
        self.mend()
        self._end_take(engine.reason_of(self._row, reason))

    def _end_take(self, reason: str) -> None:
        self._carry_out(functools.partial(self._followers.end_take, reason))

    def reset(self, reason: str) -> None:
        """End the take, and forget the running range."""
        self.mend()
        self._carry_out(functools.partial(self._reset, engine.reason_of(self._row, "reset"), reason))

    def _reset(self, ended: str, reason: str) -> None:
        row = self._row
        self._followers.end_take(ended)
        self._followers.forget_ranges()
        reset = [engine.stream_event(row, "reset", reason)]
        row.pending += reset
        self._unfinished = None  # no exception comes between these two lines: the event is reported once

    def recognise(self, recognition: Recognition | None, follow: Follow, alignment: Alignment | None) -> None:
        """Let something else recognise moves, and something else follow them."""
        self._carry_out(functools.partial(self._recognise, recognition, follow, alignment))

    def _recognise(
        self, recognition: Recognition | None, follow: Follow, alignment: Alignment | None
    ) -> None:
        self._followers.recognition = recognition
        self._followers.follow_moves(follow, alignment)

    def follow_moves(self, follow: Follow, alignment: Alignment | None) -> None:
        """Let something else follow moves; what is being made is decided."""
        self._carry_out(functools.partial(self._followers.follow_moves, follow, alignment))

    def planned_level(self, level: LevelName | float) -> LevelName | float:
        """Return a level that `set_level` can set, and change nothing.

        Raises:
            SettingsError: If it is none, or a name that works with other settings.
        """
        plan = self._row.plan
        chosen = plan.user_settings.replace(level=level).level
        plan.strength(chosen)
        return chosen

    def set_level(self, level: LevelName | float) -> None:
        """Move the level, which acts with the next push."""
        self._carry_out(functools.partial(self._set_level, level))

    def _set_level(self, level: LevelName | float) -> None:
        row = self._row
        row.state["plan"]["beta"] = row.plan.strength(level)
        self.level = level
        row.is_level_new = True
        self._followers.follow(level)

    def planned(self, changes: Mapping[str, object]) -> tuple[Plan, LevelName | float]:
        """Return the plan and the level that changes of settings would bring, and change nothing."""
        self.mend()
        before = self._row.plan
        level = before.user_settings.replace(level=changes.get("level", self.level)).level
        changed = before.user_settings.replace(**{**changes, "level": before.user_settings.level}).at_level(
            level
        )
        groups_of(before.skeleton, changed.limbs)  # or FrameError
        if changed.steps:
            feet_of(before.skeleton, changed.feet)  # or FrameError
        return before.with_settings(changed), level

    def adopt(self, plan: Plan, level: LevelName | float) -> None:
        """Go on with a plan and a level; the take ends if it cannot go on with them."""
        self.mend()
        self._carry_out(functools.partial(self._adopt, plan, level))

    def _adopt(self, plan: Plan, level: LevelName | float) -> None:
        row = self._row
        if plan.continues(row.plan):
            row.replan(plan)
        else:
            self._followers.end_take("settings changed")
            row.restart(plan)
        self._followers.adopt(level)
        self._set_level(level)

    def _carry_out(self, work: Callable[[], None]) -> None:
        """Do something, and take note of it until it is done."""
        try:
            self.single.is_expected = False
            self._unfinished = work
            work()
            self._unfinished = None
        except Exception:
            self._unfinished = None  # it would fail again
            self.tear()
            raise
        except BaseException:
            self.tear()
            raise
