"""Slots: names for people that outlive the ids of a tracker.

Trackers give a new id to a person that was hidden for a moment. They exchange the ids of two people that cross, and
give a free id to another person. A slot follows the body instead:

- An id that goes on from frame to frame keeps its slot. If its pose leaps to where another person was, and that
  person is not there, the slots follow the bodies.
- An id that is new, or was away, is compared with all missing people: by place for two seconds, by the lengths of the
  bones for as long as a person is remembered. If two are about equally likely, the newcomer is observed for up to
  two seconds. If it is a new person, it gets a free slot.
- Where all slots are taken it is refused.

`SlotTable` is the memory of slots; `Slots` assigns people to them.
"""

from collections import OrderedDict
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_adapters.people.assignment import left_to_others
from mossar_adapters.people.body import PAUSE, Body
from mossar_adapters.people.given import (
    MOST,
    People,
    checked_moment,
    checked_pose,
    checked_seconds,
    checked_skeleton,
    nearby,
)
from mossar_adapters.people.likeness import LOST, Likeness
from mossar_adapters.people.newcomer import Newcomer
from mossar_adapters.people.samples import Samples
from mossar_adapters.people.slot_table import MOST_IDS, REFUSED, REMEMBERED, SET, Change, How, SlotTable
from mossar_stream import FrameError, Skeleton

UNDECIDED: Final = None  # instead of a slot

_AGAIN: Final = 0.25  # s between two looks at a refused id
_LOOK: Final = 0.1  # s between two looks at an id that is not decided
_WATCHED: Final = 2.0  # s for which a newcomer is observed
_CLEAR: Final = 4.0  # by which the likeliest must be ahead: 50 to 1
_KNOWN: Final = 4.0  # against a stranger with a known id, of a tracker that was never seen to reuse one
_KEPT: Final = 1.0  # for the person who had the id less than `LOST` ago, of such a tracker
_TOGETHER: Final = 4  # other observed people who are decided on together with the newcomers of a moment
_FAITHFUL: Final = 3.0  # by which another slot must be likelier than one's own
_UNLIKELY: Final = 3.0  # against strangers while a person is missed for less than `LOST`
_EXACT: Final = 1e-9  # s
BACK: Final = 1.0  # s; a step back beyond it is another clock


class _Option(NamedTuple):
    """A possible person of a newcomer: the evidence against it, and the slot; `stranger` for a new person there."""

    against: float
    number: int
    body: Body
    stranger: bool = False


class Slots(SlotTable):
    """Gives people slots `p1` to `pN`, independent of the tracker's ids.

    Poses come in the order of their times. Memory is fixed by the number of slots.

    Args:
        people: How many; `"nearest"`: one slot, for the person nearest to the origin; `"first"`: one, for the one that
            came first and is still there.
        remember: Time for which an absent person keeps its slot, s; then others get it as a new one.
        watch: Time for which an ambiguous newcomer is observed, s; 0 decides at first sight.

    Raises:
        SettingsError: If there cannot be so many, or times are no numbers from 0.

    Example:
        >>> import numpy as np
        >>> left, right = np.zeros((2, 3)), np.full((2, 3), 2.0)
        >>> slots = Slots(2)
        >>> slots.follow("7", left, 0.0), slots.follow("9", right, 0.0)
        ('p1', 'p2')
        >>> slots.follow("9", left + 0.01, 0.03), slots.follow("7", right + 0.01, 0.03)  # exchanged by the tracker
        ('p1', 'p2')
    """

    def __init__(self, people: People, remember: float = REMEMBERED, watch: float = _WATCHED) -> None:
        super().__init__(people, remember)
        self.watch = checked_seconds("watch", watch)
        self.refused = 0  # frames
        self._newcomers: OrderedDict[str, Newcomer] = OrderedDict()
        self._skeletons: OrderedDict[str, Skeleton] = OrderedDict()
        self._separate: OrderedDict[str, None] = OrderedDict()  # ids that may be of other senders
        self._likeness = Likeness()

    def announce(self, ident: str, skeleton: Skeleton) -> None:
        """Say which skeleton the poses of an id have, so that its bones can be measured.

        Raises:
            FrameError: If the id is no text, or the skeleton none.
        """
        checked_skeleton(ident, skeleton)
        self._skeletons[ident] = skeleton
        self._skeletons.move_to_end(ident)
        if len(self._skeletons) > MOST_IDS:
            self._skeletons.popitem(last=False)

    def separate(self, ident: str) -> None:
        """Note that an id may be of another sender than the others.

        Its frames do not come together with theirs, so a missing person is noticed a moment later.
        """
        self._separate[ident] = None
        if len(self._separate) > MOST_IDS:
            self._separate.popitem(last=False)

    def follow(self, ident: str, pose: ArrayLike, time: float) -> str | None:
        """Return the slot of a pose.

        Args:
            ident: The sender's.
            pose: (J, 3), metres, NaN where a joint is missing.
            time: s, not before those of earlier poses.

        Returns:
            The slot's name; `REFUSED` if all are taken, `UNDECIDED` while the id is observed.

        Raises:
            FrameError: If the id is no text, the time no finite number, or the pose not (J, 3) numbers of the joints
                that were announced. Nothing is changed then.
        """
        given, moment = nearby(checked_pose(pose)), checked_moment(ident, time)
        skeleton = self._skeletons.get(ident)
        if skeleton is not None and len(skeleton) != len(given):
            raise FrameError(
                f"the pose of {ident[:40]!r} has {len(given)} joints, its skeleton {len(skeleton)}"
            )
        body = self._ids.get(ident)
        if body is not None:
            self._now = max(self._now, moment)
            if body.follow(given, moment):
                return self._name(body, moment)
        return self.decide(moment, [(ident, given)])[0]

    def run(self, ident: str, positions: NDArray[Any], times: NDArray[np.float64]) -> tuple[str | None, int]:
        """Follow frames of one id as long as nothing has to be decided.

        Args:
            ident: The sender's.
            positions: (n, J, 3), metres.
            times: (n,), s.

        Returns:
            The slot, and the number of frames from the first on.
        """
        body = self._ids.get(ident)
        if body is None:
            return self._run_newcomer(ident, positions, times)
        if self._chooses is not None and len(times) > 1:
            return UNDECIDED, 0  # the choice is made frame by frame
        count = body.run(positions, times)
        if not count:
            return UNDECIDED, 0
        self._now = max(self._now, float(times[count - 1]))
        return self._name(body, self._now), count

    def _run_newcomer(
        self,
        ident: str,
        positions: NDArray[Any],
        times: NDArray[np.float64],
    ) -> tuple[str | None, int]:
        """Pass over frames of an id that it is not time to look at again."""
        known = self._newcomers.get(ident)
        if known is None:
            return UNDECIDED, 0
        if known.refused and times[-1] >= known.due and not self._has_room(known):
            known.due = max(known.due, float(times[-1]) + _AGAIN)
        count = int(times.searchsorted(known.due))
        if count:
            known.last = float(times[count - 1])
            self._now = max(self._now, known.last)
            if known.refused:
                self.refused += count
            else:
                for pose, time in zip(positions[:count], times[:count], strict=True):
                    known.samples.add(pose, float(time))
        return (REFUSED if known.refused else UNDECIDED), count

    def decide(
        self, time: float, found: Sequence[tuple[str, NDArray[Any]]], *, chunks: bool = False
    ) -> list[str | None]:
        """Return the slots of the poses of one moment.

        Args:
            time: s.
            found: Each id with its pose; none twice.
            chunks: Whether others may have been followed to later times; `restart` handles a clock set back then.
        """
        if time < self._now - BACK and not chunks:
            self.restart(time)
        self._now = max(self._now, time)
        verdicts: dict[str, Body | str | None] = {}
        others = []
        for ident, given in found:
            pose = nearby(given)
            body = self._ids.get(ident)
            if body is not None and (body.time > time or body.follow(pose, time) or np.isnan(pose).all()):
                verdicts[ident] = body
            elif np.isnan(pose).all():
                verdicts[ident] = self._unseen(ident, time)
            else:
                others.append((ident, pose))
        if others:
            verdicts |= self._place(time, others)
            for ident, verdict in verdicts.items():
                # An id without a joint in this frame may have lost its slot to another one that is seen there.
                if isinstance(verdict, Body) and self._ids.get(ident) is not verdict:
                    verdicts[ident] = self._unseen(ident, time)
        return [
            self._name(verdict, time) if isinstance(verdict, Body) else verdict
            for verdict in (verdicts[ident] for ident, _ in found)
        ]

    def restart(self, time: float, passed: float = SET) -> float:
        """Go on with a clock that was set back to a time (s); return the shift, s.

        No id is observed afterwards: settle undecided ones before.

        Args:
            time: s, on the new clock.
            passed: s that have passed since the latest frame.
        """
        self._newcomers.clear()
        return super().restart(time, passed)

    def settle(self, ident: str) -> str | None:
        """Decide on an observed id with the evidence up to now, and return its slot."""
        known = self._newcomers.get(ident)
        if known is None or known.refused:
            return REFUSED
        self._place(known.last, [(ident, known.pose)], at_once=True)
        body = self._ids.get(ident)
        return self._name(body, known.last) if body is not None else REFUSED

    def waiting(self) -> list[tuple[str, float]]:
        """Return the observed ids, and the last time of each, s."""
        return [(known.id, known.last) for known in self._newcomers.values() if not known.refused]

    def leave(self, ident: str) -> None:
        """Note that a tracker has given an id up."""
        super().leave(ident)
        self._newcomers.pop(ident, None)

    def knows(self, ident: str) -> bool:
        """Return whether an id has a slot, or is observed or refused."""
        return ident in self._ids or ident in self._newcomers

    def went_back(self, ident: str, time: float) -> bool:
        """Return whether a time (s) is another clock's than that of the id's frames so far, if there were any."""
        known = self._ids.get(ident) or self._newcomers.get(ident)
        if known is None:
            return time < self._now - BACK
        return time < (known.time if isinstance(known, Body) else known.last) - BACK

    def _place(
        self, time: float, found: Sequence[tuple[str, NDArray[Any]]], *, at_once: bool = False
    ) -> dict[str, Body | str | None]:
        """Find the slots of poses that do not go on from the frame before."""
        newcomers = [self._newcomer(ident, pose, time) for ident, pose in found]
        against = self._against(newcomers)
        verdicts: dict[str, Body | str | None] = {}
        while newcomers:
            # The clearest cases first; their slots are no longer open to the others.
            options = self._together(newcomers, against)
            newcomers.sort(key=lambda one: -_lead(options[one.id]))
            taken: set[int] = set()
            for one in newcomers:
                if taken.isdisjoint(o.number for o in options[one.id]) and self._is_decided(
                    one, options[one.id], time, at_once=at_once
                ):
                    body = self._settled(one, options[one.id], time)
                    verdicts[one.id] = body
                    taken.add(body.number)
            newcomers = [one for one in newcomers if one.id not in verdicts]
            if not taken:
                break
        for one in newcomers:
            verdicts[one.id] = self._unsettled(one, options[one.id], time, at_once=at_once)
        return verdicts

    def _against(self, newcomers: Sequence[Newcomer]) -> dict[str, list[float]]:
        """Return the evidence against newcomers of a moment, and other observed people, being each slot's person."""
        here = {one.id for one in newcomers}
        waiting = [one for one in self._newcomers.values() if not one.refused and one.id not in here]
        rows = [*newcomers, *waiting[:_TOGETHER]]
        owners = [self._ids.get(one.id) for one in rows]
        found = self._likeness.against(rows, self._bodies, owners).tolist()
        return {one.id: row for one, row in zip(rows, found, strict=True)}

    def _unseen(self, ident: str, time: float) -> str | None:
        """Skip a frame without a joint, of an id without a slot: it shows no person who could get one."""
        known = self._newcomers.get(ident)
        if known is None:
            return UNDECIDED
        known.last = time
        return REFUSED if known.refused else UNDECIDED

    def _newcomer(self, ident: str, pose: NDArray[Any], time: float) -> Newcomer:
        known = self._newcomers.get(ident)
        if known is not None and known.refused and self._has_room(known):
            known.first, known.seen = time, pose  # it is a newcomer again
        if known is None or time - known.last > 2 * PAUSE:
            known = Newcomer(
                ident, time, time, time, Samples(len(pose), 0.0), pose, pose, self._skeletons.get(ident)
            )
            self._newcomers[ident] = known
            if len(self._newcomers) > MOST_IDS:
                self._newcomers.popitem(last=False)
        known.pose, known.last = pose, time
        known.samples.add(pose, time)
        return known

    def _options(self, newcomer: Newcomer, speaks: Sequence[float]) -> list[_Option]:
        """Return the people that an id may be, the likeliest first.

        Args:
            newcomer: The id.
            speaks: The evidence against its being the person of each slot.
        """
        own = self._ids.get(newcomer.id)
        start = newcomer.first
        missed = self._missed(start)
        if len(missed) == 1 and missed[0] is own and start - own.time <= LOST:
            return [_Option(0.0, own.number, own)]  # no one else is missing
        found = []
        for body in missed:
            against = speaks[body.number]
            if against == float("inf"):
                continue
            if body.pinned and self._is_strange(against, start - body.time):
                continue  # the slot is kept for its person
            if body.id == newcomer.id and start - body.time <= LOST and not self._reuses:
                against -= _KEPT
            found.append(_Option(against, body.number, body))
        room = self._room(start)
        empty = [o for o in found if start - o.body.time > LOST and not o.body.pinned]
        if room is not None and (not room.used or self._is_forgotten(room, start) or not empty):
            against = self._likeness.against_stranger()
            if any(start - body.time <= LOST for body in missed):
                against += _UNLIKELY
            if not self._reuses and any(body.id == newcomer.id for body in missed):
                against += _KNOWN
            found.append(_Option(against, room.number, room, stranger=True))
        return sorted(found, key=lambda option: option[:2])

    def _together(
        self, newcomers: Sequence[Newcomer], against: dict[str, list[float]]
    ) -> dict[str, list[_Option]]:
        """Return the options of each newcomer with their costs for the others, the likeliest first."""
        here = {one.id for one in newcomers}
        waiting = [one for one in self._newcomers.values() if one.id in against and one.id not in here]
        rows = [*newcomers, *waiting][: MOST + _TOGETHER]
        options = {one.id: self._options(one, against[one.id]) for one in (*newcomers, *waiting)}
        if len(rows) < 2 or all(len(options[one.id]) < 2 for one in newcomers):
            return options
        costs = np.full((len(rows), len(self._bodies)), np.inf)
        for row, one in zip(costs, rows, strict=True):
            for option in options[one.id]:
                row[option.number] = min(row[option.number], option.against)
        left = left_to_others(costs, self._likeness.against_stranger() + _CLEAR).tolist()
        for row, one in zip(left, newcomers, strict=False):
            if len(options[one.id]) > 1:
                options[one.id] = _with_others(options[one.id], row)
        return options

    def _has_room(self, newcomer: Newcomer) -> bool:
        return any(not body.used or body.time < newcomer.last - PAUSE for body in self._bodies)

    def _is_strange(self, against: float, away: float) -> bool:
        """Return whether a newcomer is another person than the one who was away for so long, s."""
        return away > LOST and against > self._likeness.against_stranger() + _CLEAR

    def _is_decided(self, newcomer: Newcomer, options: list[_Option], time: float, *, at_once: bool) -> bool:
        """Return whether it is clear by now in which slot a newcomer belongs."""
        if self._is_own_leap(newcomer):
            return True
        if self._waits_for_others(newcomer, time) and not at_once:
            return False
        watched = time - newcomer.first >= self.watch - _EXACT
        return bool(options) and (at_once or watched or _lead(options) >= _CLEAR)

    def _settled(self, newcomer: Newcomer, options: list[_Option], time: float) -> Body:
        """Give a newcomer the slot where it belongs."""
        if self._is_own_leap(newcomer):
            return self._give(_faithful(self._ids[newcomer.id], options), newcomer, time)
        self._ids.pop(newcomer.id, None)
        return self._give(options[0], newcomer, time)

    def _unsettled(
        self, newcomer: Newcomer, options: list[_Option], time: float, *, at_once: bool
    ) -> str | None:
        """Look at a newcomer for longer, or refuse it if there is no slot for it."""
        self._ids.pop(newcomer.id, None)
        if self._waits_for_others(newcomer, time) and not at_once:
            newcomer.due, newcomer.refused = newcomer.first + _LOOK, False
            return UNDECIDED
        if not options:
            return self._refuse(newcomer, time)
        newcomer.due, newcomer.refused = time + _LOOK, False
        return UNDECIDED

    def _waits_for_others(self, newcomer: Newcomer, time: float) -> bool:
        """Return whether the next frames of other senders have yet to show which person is missing."""
        return newcomer.id in self._separate and time - newcomer.first < _LOOK - _EXACT

    def _is_own_leap(self, newcomer: Newcomer) -> bool:
        """Return whether the id has a slot, which it leaves only if its pose belongs into another."""
        own = self._ids.get(newcomer.id)
        return own is not None and own.time < newcomer.first <= own.time + PAUSE

    def _give(self, option: _Option, newcomer: Newcomer, time: float) -> Body:
        """Put a newcomer into the slot of an option."""
        body = option.body
        away = newcomer.first - body.time if body.used else 0.0
        another = body.used and (option.stranger or self._is_strange(option.against, away))
        how: How = "new" if another or option.stranger else "place" if away <= LOST else "lengths"
        if newcomer.id in self._ids and how == "place":
            how = "swap" if self._ids[newcomer.id] is not body else "place"
        self._newcomers.pop(newcomer.id, None)
        self._put(newcomer, body, time, how, another=another)
        return body

    def _refuse(self, newcomer: Newcomer, time: float) -> str:
        if not newcomer.refused and self._chooses is None:
            self._changes.append(Change(REFUSED, newcomer.id, time, "refused"))
        newcomer.refused = True
        newcomer.due = time + _AGAIN
        self.refused += 1
        return REFUSED


def _lead(options: list[_Option]) -> float:
    """Return the lead of the likeliest slot over the next one."""
    others = (option.against for option in options if option.body is not options[0].body)
    return next(others, float("inf")) - options[0].against if options else float("inf")


def _with_others(options: list[_Option], left: list[float]) -> list[_Option]:
    """Return options with the cost of each slot for the others, relative to the best; the likeliest first."""
    best = min(left[option.number] for option in options)
    found = [_Option(o.against + left[o.number] - best, *o[1:]) for o in options]
    return sorted(found, key=lambda option: option[:2])


def _faithful(own: Body, options: list[_Option]) -> _Option:
    """Return the slot of an id that has one: another only if its pose belongs there."""
    stay = next(
        (o for o in options if o.body is own and not o.stranger), _Option(float("inf"), own.number, own)
    )
    best = next((o for o in options if not o.stranger), stay)
    return best if best.against + _FAITHFUL < stay.against else stay
