"""Reporting: the state of the reports; out.pxi makes the events."""

import math
from collections.abc import Iterable

import msgspec

from mossar_stream.events import Event, RepetitionEvent


class Reported(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The reports so far.

    Args:
        total: Repetitions of the take.
        revisions: Latest revision by number of the repetition, for those that may still change.
        phase: Time of the last phase, s, and whether it was a number.
    """

    total: int = 0
    revisions: dict[int, int] = {}
    phase: tuple[float, bool] = (-math.inf, False)


def latest_repetitions(events: Iterable[Event]) -> list[RepetitionEvent]:
    """Return the latest event of each repetition, without those that were withdrawn.

    `total` becomes the number of repetitions up to this one.
    """
    latest = {event.id: event for event in events if isinstance(event, RepetitionEvent)}
    return [
        msgspec.structs.replace(event, total=number_of(event))
        for event in latest.values()
        if event.status == "counted"
    ]


def number_of(event: RepetitionEvent) -> int:
    """Return the number of a repetition in its take, from 1."""
    return int(event.id.rpartition("/r")[2])
