"""Tally: counts of one performer since the page was opened, over all takes."""

import msgspec

from mossar_stream import BODY, Event, FollowEvent, MoveEvent, PoseEvent, RepetitionEvent


class Count(msgspec.Struct, frozen=True):
    """The counts.

    Args:
        followed: Performances that were done, by the name of the move that is followed.
        moves: Recognised moves, by name.
        latest: The recognised move that came last; empty before the first.
        repetitions: Of the body; None before the first.
        tempo: Of the repetitions, cycles a minute; None if it is not known.
        held: The pose that is being held; None while there is none.
    """

    followed: dict[str, int] = {}  # msgspec copies it
    moves: dict[str, int] = {}  # the same
    latest: str = ""
    repetitions: int | None = None
    tempo: float | None = None
    held: PoseEvent | None = None


class Tally:
    """Counts the events of one performer; its size is bounded by the number of moves.

    A take ends when the performer is not seen for a moment. The counts go on.
    """

    def __init__(self) -> None:
        self._take, self._total = 0, 0  # of the repetitions that came last
        self._clear()

    def _clear(self) -> None:
        self._followed: dict[str, int] = {}
        self._moves: dict[str, int] = {}
        self._latest = ""
        self._before = -self._total  # added to the repetitions of the take
        self._repeats = False
        self._tempo: float | None = None
        self._held: PoseEvent | None = None

    def begin_again(self) -> None:
        """Count from 0; the take goes on."""
        held = self._held
        self._clear()
        self._held = held

    def add(self, event: Event) -> None:
        """Count an event."""
        if isinstance(event, FollowEvent) and event.status == "done":
            self._followed[event.name] = self._followed.get(event.name, 0) + 1
        elif isinstance(event, MoveEvent):
            self._add_move(event)
        elif isinstance(event, RepetitionEvent) and event.channel == BODY:
            self._add_repetition(event)
        elif isinstance(event, PoseEvent):
            self._held = None if event.status == "left" else event

    @property
    def count(self) -> Count:
        """The counts so far."""
        total = max(self._before + self._total, 0) if self._repeats else None
        return Count(dict(self._followed), dict(self._moves), self._latest, total, self._tempo, self._held)

    def _add_move(self, event: MoveEvent) -> None:
        step = {"confirmed": 1, "withdrawn": -1}.get(event.status, 0)
        self._moves[event.name] = max(self._moves.get(event.name, 0) + step, 0)
        if step > 0:
            self._latest = event.name

    def _add_repetition(self, event: RepetitionEvent) -> None:
        if event.take != self._take:
            self._before, self._take = self._before + self._total, event.take
        self._total, self._repeats = event.total, True
        if event.tempo is not None or event.count == 1:
            self._tempo = event.tempo
