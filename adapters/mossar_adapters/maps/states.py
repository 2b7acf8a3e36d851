"""States of the performers, for receivers that join late and missed the events."""

from collections.abc import Iterable, Iterator
from typing import Any

import msgspec
from msgspec import UNSET, UnsetType

from mossar_adapters.newest import Newest
from mossar_adapters.source import Meta
from mossar_stream import BODY, ActivityEvent, Event, FollowEvent, RepetitionEvent, SegmentState, StreamEvent

MOST = 400  # performers whose states are kept
_GONE = ("ended", "stalled")
VERSION = 1


class StateMap(msgspec.Struct):
    """The state of a performer for a receiver that joins late; sent once to that receiver, behind the meta.

    Args:
        performer: Name of the performer.
        take: Number of the latest take.
        present: Whether frames come: false once they have stalled, or the take has ended.
        activity: `moving` or `resting` for each channel, `body` or a limb; one that has not moved in the take rests.
        repetitions: Count of the take for each channel that has any, `body` or a limb.
        followed: How often each followed move was done in the take, by name.
        level: Of the segmentation; left out where it is not known.
        run: The run of the program that emits the events; left out where it is not known.
        v: Version of this layout.
        type: Always `state`.
    """

    performer: str
    take: int
    present: bool
    activity: dict[str, SegmentState] = {}
    repetitions: dict[str, int] = {}
    followed: dict[str, int] = {}
    level: str | float | UnsetType = UNSET
    run: str | UnsetType = UNSET
    v: int = VERSION
    type: str = "state"


class States:
    """Follows metas and events; performers without a take have no state.

    Example:
        >>> states = States()
        >>> states.follow([StreamEvent(performer="p1", event="started", take=3, run="a1")])
        >>> [(state.performer, state.take, state.present) for state in states]
        [('p1', 3, True)]
    """

    def __init__(self) -> None:
        self._levels: Newest[str, Any] = Newest(MOST)
        self._states: Newest[str, StateMap] = Newest(MOST)

    def __iter__(self) -> Iterator[StateMap]:
        for name, state in self._states.items():
            state.level = self._levels.get(name, UNSET)
            yield state

    def announce(self, meta: Meta) -> None:
        """Note a performer's level."""
        if meta.settings is not None:
            self._levels[meta.performer] = meta.settings.get("level", UNSET)

    def follow(self, events: Iterable[Event]) -> None:
        """Update the states with events."""
        for event in events:
            if isinstance(event, StreamEvent):
                self._follow_stream(event)
            elif (state := self._states.get(event.performer)) is None:
                continue
            elif isinstance(event, RepetitionEvent):
                state.repetitions[event.channel] = event.total
            elif isinstance(event, FollowEvent):
                state.followed[event.name] = event.count
            elif isinstance(event, ActivityEvent):
                state.activity[event.channel] = event.state

    def _follow_stream(self, event: StreamEvent) -> None:
        state = self._states.get(event.performer)
        if event.event == "started" or state is None:
            state = StateMap(event.performer, event.take, True, {BODY: "resting"})
            self._states[event.performer] = state
        state.present = event.event not in _GONE
        if event.run is not None:
            state.run = event.run
