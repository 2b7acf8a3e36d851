"""Slot table: the memory of slots.

Of each slot: the body in it, the sender's id, whether it is pinned. Of ids: the last person of each, and whether this tracker
was ever seen to give one to another person. If there is one slot, for the nearest or first: its person.
"""

from collections import OrderedDict, deque
from typing import Final, Literal

import msgspec
import numpy as np

from mossar_adapters.people.body import PAUSE, Body, centre
from mossar_adapters.people.given import MOST, People, checked_people, checked_seconds
from mossar_adapters.people.likeness import LOST
from mossar_adapters.people.memory import Memory, persons_of, put_person
from mossar_adapters.people.newcomer import Newcomer
from mossar_stream import SettingsError, SnapshotError

REMEMBERED: Final = 600.0  # s
REFUSED: Final = ""  # instead of a slot
CHOSEN: Final = "p1"  # the slot of the nearest, or first
MOST_IDS: Final = 256  # ids that are remembered

How = Literal["new", "place", "lengths", "swap", "chosen", "asked", "refused"]

_CANDIDATES: Final = 16  # people who are distinguished to find the nearest or first
_CHANGES: Final = 256
_NEARER: Final = 0.3  # m by which another must be nearer, so that two beside each other do not take turns
SET: Final = 0.1  # s that pass while a clock is set back


class Change(msgspec.Struct, frozen=True):
    """A slot got another id, or an id got none.

    Args:
        slot: Its name; empty if the id is refused.
        id: The sender's.
        time: s.
        how: Why.
        away: Time for which the slot's person was not seen, s.
        another: Whether it is another person than the last one in the slot.
    """

    slot: str
    id: str
    time: float
    how: How
    away: float = 0.0
    another: bool = False


class SlotTable:
    """The present and the last person of each slot.

    Args:
        people: How many slots; `"nearest"` or `"first"`: one, for the person nearest to the origin, or for the one that came
            first and is still there.
        remember: Time for which an absent person keeps its slot, s; then others get it as a new one.

    Raises:
        SettingsError: If there cannot be so many, or `remember` is no number from 0.
    """

    def __init__(self, people: People, remember: float = REMEMBERED) -> None:
        self.people = checked_people(people)
        self.remember = checked_seconds("remember", remember)
        self._chooses = self.people if isinstance(self.people, str) else None
        count = self.people if isinstance(self.people, int) else _CANDIDATES
        self._bodies = [Body(f"p{i + 1}", i) for i in range(count)]
        self._ids: dict[str, Body] = {}
        self._former: OrderedDict[str, int] = OrderedDict()  # last person of each id: `Body.met`
        self._reuses = False  # whether an id was seen to go from one person to another
        self._met = 0  # people so far
        self._chosen: Body | None = None
        self._given = -np.inf  # s, when the only slot was given last
        self._now = -np.inf  # s
        self._changes: deque[Change] = deque(maxlen=_CHANGES)

    @property
    def names(self) -> tuple[str, ...]:
        """The slots."""
        return (CHOSEN,) if self._chooses else tuple(body.name for body in self._bodies)

    @property
    def chooses(self) -> bool:
        """Whether there is one slot, for the nearest or first."""
        return self._chooses is not None

    def slot_of(self, ident: str) -> str | None:
        """Return the slot of an id, None if it has none."""
        body = self._ids.get(ident)
        if body is None or (self._chooses is not None and body is not self._chosen):
            return None
        return CHOSEN if self._chooses else body.name

    def table(self) -> list[dict[str, object]]:
        """Return each slot that was used: its name, the sender's id, whether it is there now, and pinned."""
        bodies = [self._chosen] if self._chooses else self._bodies
        return [
            {
                "slot": CHOSEN if self._chooses else body.name,
                "id": body.id,
                "there": self._now - body.time <= PAUSE,
                "pinned": body.pinned,
            }
            for body in bodies
            if body is not None and body.used
        ]

    @property
    def changed(self) -> bool:
        """Whether there are changes that `changes` has not returned."""
        return bool(self._changes)

    def changes(self) -> list[Change]:
        """Return the changes since the last call."""
        found = list(self._changes)
        self._changes.clear()
        return found

    def to_bytes(self) -> bytes:
        """Return the memory of people, for `recall`."""
        chosen = None if self._chosen is None else self._chosen.number
        former = dict(self._former)
        people = persons_of(self._bodies)
        now = self._now if people else 0.0
        return Memory(self.people, now, self._met, self._reuses, former, chosen, people).to_bytes()

    def recall(self, data: bytes) -> None:
        """Continue with the people of an earlier run; `restart` sets the time. Slots beyond the present number are left out.

        Raises:
            SnapshotError: If the bytes are damaged, or the only slot was for others.
        """
        memory = Memory.from_bytes(data)
        if self._chooses != (memory.people if isinstance(memory.people, str) else None):
            raise SnapshotError(f"the people of the snapshot were followed with --people {memory.people}")
        # An id belongs to the person who was seen with it last.
        for person in sorted(memory.slots, key=lambda person: person.time):
            if person.number < len(self._bodies):
                body = self._bodies[person.number]
                put_person(body, person)
                if person.id is not None:
                    self._ids[person.id] = body
                if person.number == memory.chosen:
                    self._chosen = body
        self._former = OrderedDict(memory.former)
        self._met, self._reuses = memory.met, memory.reuses
        self._now = memory.now if memory.slots else -np.inf

    def restart(self, time: float, passed: float = SET) -> float:
        """Go on with a clock that was set back to a time (s); return the shift, s.

        Args:
            time: s, on the new clock.
            passed: s that have passed since the latest frame.
        """
        if self._now == -np.inf:
            return 0.0
        seconds = time - passed - self._now
        for body in self._bodies:
            if body.used:
                body.shift(seconds)
        self._given += seconds
        self._now = time
        return seconds

    def leave(self, ident: str) -> None:
        """Note that a tracker has given an id up."""
        self._ids.pop(ident, None)

    def resize(self, people: int) -> None:
        """Follow more people from now on, or fewer: the last slots go.

        Raises:
            SettingsError: If there cannot be so many, or the only slot is for the nearest or first.
        """
        if self._chooses or not 1 <= people <= MOST:
            raise SettingsError(
                f"people must be 1 to {MOST}, and not nearest or first, to be changed to {people}"
            )
        gone = self._bodies[people:]
        self._ids = {ident: body for ident, body in self._ids.items() if body not in gone}
        self._bodies = self._bodies[:people]
        self._bodies += [Body(f"p{i + 1}", i) for i in range(len(self._bodies), people)]
        self.people = people

    def exchange(self, one: str, other: str) -> None:
        """Let two people have each other's slots from now on.

        Raises:
            SettingsError: If there are no two such slots.
        """
        first, second = self._slot(one), self._slot(other)
        if first is second:
            raise SettingsError(f"{one} cannot be exchanged with itself")
        first.name, second.name = second.name, first.name
        first.number, second.number = second.number, first.number
        self._bodies.sort(key=lambda body: body.number)
        for body in (first, second):
            if body.used:
                self._changes.append(Change(body.name, body.id or "", self._now, "asked", another=True))

    def pin(self, slot: str, *, pinned: bool = True) -> None:
        """Keep a slot for its person, however long that person is away; or no longer.

        Raises:
            SettingsError: If there is no such slot, or no person was in it.
        """
        body = self._slot(slot)
        if not body.used:
            raise SettingsError(f"nobody was in {slot} yet")
        body.pinned = pinned

    def _slot(self, name: str) -> Body:
        if self._chooses:
            raise SettingsError(f"there is one slot, for the {self._chooses}")
        for body in self._bodies:
            if body.name == name:
                return body
        raise SettingsError(f"there is no slot {repr(name)[:40]}; there are {', '.join(self.names)}")

    def _missed(self, time: float) -> list[Body]:
        """Return the bodies of people who are away at a time (s), and not forgotten."""
        longest = max(self.remember, LOST)
        return [b for b in self._bodies if b.met and b.time < time and (time - b.time <= longest or b.pinned)]

    def _room(self, time: float) -> Body | None:
        """Return the body of the slot that a stranger would get: never used, forgotten, or empty for longest."""
        for body in self._bodies:
            if not body.used:
                return body
        empty = [body for body in self._bodies if time - body.time > LOST and not body.pinned]
        return min(empty, key=lambda body: (body.time, body.number), default=None)

    def _is_forgotten(self, body: Body, time: float) -> bool:
        return time - body.time > max(self.remember, LOST) and not body.pinned

    def _put(self, newcomer: Newcomer, body: Body, time: float, how: How, *, another: bool) -> None:
        """Put a newcomer into a slot.

        Args:
            newcomer: The newcomer.
            body: The body whose slot it gets.
            time: s.
            how: The reason.
            another: Whether it is another person than the last one in the slot.
        """
        before, away = body.id, newcomer.first - body.time if body.used else 0.0
        if before is not None and self._ids.get(before) is body:
            del self._ids[before]
        if another or not body.used:
            self._met += 1
            body.met = self._met
        if another or len(body.pose) != len(newcomer.pose) or body.skeleton != newcomer.skeleton:
            body.begin(newcomer.pose, time, newcomer.skeleton)
        else:
            body.settle(newcomer.pose, time)
        if how != "swap":
            self._learn_of(newcomer.id, body)
        body.id = newcomer.id
        self._ids[newcomer.id] = body
        if before != newcomer.id or another or away > PAUSE:
            self._report(body, Change(body.name, newcomer.id, time, how, away, another))

    def _report(self, body: Body, change: Change) -> None:
        if self._chooses is None:
            self._changes.append(change)
        elif body is self._chosen:
            self._changes.append(msgspec.structs.replace(change, slot=CHOSEN))

    def _learn_of(self, ident: str, body: Body) -> None:
        """Note the person of an id: a tracker that gives an id to another person may do so again."""
        if self._former.get(ident, body.met) != body.met:
            self._reuses = True
        self._former[ident] = body.met
        self._former.move_to_end(ident)
        if len(self._former) > MOST_IDS:
            self._former.popitem(last=False)

    def _name(self, body: Body, time: float) -> str:
        if self._chooses is None:
            return body.name
        self._choose(time)
        if body is not self._chosen:
            return REFUSED
        self._given = time
        return CHOSEN

    def _choose(self, time: float) -> None:
        """Choose the nearest, or first, person."""
        there = [body for body in self._bodies if body.used and time - body.time <= PAUSE]
        chosen = self._chosen
        if self._chooses == "first":
            if chosen is not None and time - chosen.time <= LOST:
                return
            best = min(there, key=lambda body: body.met, default=None)
        else:
            best = min(there, key=_depth, default=None)
        if best is None or best is chosen:
            return
        if self._given >= time:
            return  # another was in the slot in this very frame
        if self._chooses == "nearest" and chosen in there and _depth(chosen) - _depth(best) < _NEARER:
            return
        self._chosen = best
        self._changes.append(Change(CHOSEN, best.id or "", time, "chosen", another=chosen is not None))


def _depth(body: Body) -> float:
    middle = centre(body.pose)
    return float(np.sqrt(middle @ middle))
