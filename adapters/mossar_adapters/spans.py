"""Spans: begin and end of the stretch that an event reports."""

from mossar_stream import FollowEvent, MoveEvent, PoseEvent, RepetitionEvent

Spanning = RepetitionEvent | MoveEvent | PoseEvent | FollowEvent


def span(event: Spanning) -> tuple[float, float]:
    """Return begin and end of a repetition, move, held pose or performance, s on the source's clock."""
    match event:
        case PoseEvent():
            return event.start, event.start + event.seconds
        case FollowEvent():
            return event.start, event.time
        case _:
            return event.start or 0.0, event.end or 0.0  # only a withdrawn repetition has neither
