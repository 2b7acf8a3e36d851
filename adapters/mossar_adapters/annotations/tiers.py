"""Tiers: labelled stretches and moments of a recording, as annotation programs have them."""

from collections.abc import Iterable

import msgspec

from mossar_stream import KeyFrame, MossarError, RepetitionEvent, Segment


class AnnotationError(MossarError):
    """An annotation file cannot be read or written; the message names it and says why."""


class Mark(msgspec.Struct, frozen=True, order=True):
    """A labelled stretch; a moment ends where it starts.

    Args:
        start: s from the first frame.
        end: s.
        label: What annotators read.
    """

    start: float
    end: float
    label: str


class Tier(msgspec.Struct, frozen=True):
    """Marks of one kind, in the order of time.

    Args:
        name: Of the tier.
        marks: Stretches do not overlap.
        moments: Whether all marks are moments.
    """

    name: str
    marks: tuple[Mark, ...]
    moments: bool = False


def tiers_of(
    segments: Iterable[Segment],
    key_frames: Iterable[KeyFrame],
    repetitions: Iterable[RepetitionEvent] = (),
    origin: float = 0.0,
) -> list[Tier]:
    """Return a tier of segments, one of key frames, and one of repetitions if there are any.

    Args:
        segments: Of a recording, at a level.
        key_frames: Those that stand.
        repetitions: Those that are counted.
        origin: Time of the first frame, s.
    """
    stretches = [
        Mark(part.start_time - origin, part.end_time - origin, _label(part))
        for part in segments
        if part.end_time > part.start_time
    ]
    moments = [Mark(key.time - origin, key.time - origin, key.kind) for key in key_frames]
    tiers = [Tier("segments", tuple(stretches)), Tier("key frames", tuple(moments), moments=True)]
    counted = []
    latest = 0.0
    for event in repetitions:
        if event.start is None or event.end is None:
            continue
        start, end = max(event.start - origin, latest), event.end - origin
        if end > start:
            counted.append(Mark(start, end, str(event.count)))
            latest = end
    return [*tiers, Tier("repetitions", tuple(counted))] if counted else tiers


def _label(part: Segment) -> str:
    return " ".join([part.state, *part.active_joints[:1]]) if part.state == "moving" else part.state
