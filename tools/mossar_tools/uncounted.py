"""Uncounted: why performances of a followed move were given up; once for each move that is repeated but not counted."""

from collections.abc import Sequence

from mossar_adapters.newest import Newest
from mossar_adapters.source import Meta
from mossar_stream import Event, FollowEvent
from mossar_tools.console import LOGGER

REPEATED = 2  # performances that ended but were not done, after which that is logged
WHY = {
    "unfinished": "it did not come to the end of the example",
    "movement": "the movement differs too much from the example",
    "once": "the movement differs from the example; it may count once it is repeated",
    "another": "another followed move fits better",
    "hidden": "no bone was seen for long enough",
    "gap": "frames were missing",
}
ENDED = ("movement", "once", "another", "hidden")  # reasons of performances that came to an end
ADVICE = "add an example of this person, or of more people"
_MOST = 1024  # performers and names that are remembered


class UncountedMoves:
    """A view of events that logs why followed moves are not counted.

    Args:
        explains: Whether to log a line about each performance that was given up; otherwise one line for each performer
            and move, as soon as `REPEATED` performances in a row came to an end but were not done.
    """

    name = "uncounted moves"
    dropped = 0  # lines are never dropped

    def __init__(self, *, explains: bool = False) -> None:
        self._explains = explains
        self._missed: Newest[tuple[str, str], int] = Newest(_MOST)
        self._logged: Newest[tuple[str, str], bool] = Newest(_MOST)

    def announce(self, meta: Meta) -> None:
        """Do nothing: lines name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Log a line about performances that were not counted."""
        for event in events:
            if isinstance(event, FollowEvent) and event.status in ("done", "left"):
                self._hear(event)

    def _hear(self, event: FollowEvent) -> None:
        key = event.performer, event.name
        if event.status == "done":
            self._missed.pop(key, None)
            return
        if self._explains:
            LOGGER.info("%s", line_of_left(event))
        if event.reason not in ENDED:
            return
        self._missed[key] = self._missed.get(key, 0) + 1
        if self._missed[key] >= REPEATED and key not in self._logged:
            self._logged[key] = True
            LOGGER.info(
                "%s repeats a movement near %r that is not counted: %s; %s",
                event.performer, event.name, WHY[event.reason], ADVICE,
            )  # fmt: skip

    def close(self) -> None:
        """Do nothing."""


def line_of_left(event: FollowEvent) -> str:
    """Return a line about a performance that was given up, with the reason.

    Args:
        event: With the status `left`.
    """
    return (
        f"{event.performer}, {event.start:.2f} to {event.time:.2f} s: {event.name} not done at a progress of "
        f"{event.progress:.2f}, deviation {event.deviation:.0f}°: {WHY[event.reason]}"
    )
