"""Tiers: labelled stretches and moments of a recording, as annotation programs have them."""

from collections.abc import Iterable, Sequence

import msgspec

from mossar_adapters.spans import Spanning, span
from mossar_stream import (
    BODY,
    FollowEvent,
    KeyFrame,
    KeyFrameEvent,
    MossarError,
    MoveEvent,
    PoseEvent,
    RepetitionEvent,
    Segment,
    SegmentEvent,
    StepEvent,
)

SEGMENTS, KEY_FRAMES, REPETITIONS, MOVES = "segments", "key frames", "repetitions", "moves"
STEPS, EVENTS, FOLLOWED, POSES = "steps", "events", "followed", "poses"


class AnnotationError(MossarError):
    """An annotation file cannot be read or written; the message names it and the reason."""


class Mark(msgspec.Struct, frozen=True, order=True):
    """A labelled stretch; a moment ends where it starts.

    Args:
        start: s from the first frame.
        end: s.
        label: The text that annotators read.
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
        on_clock: Whether times are on the recording's clock, and do not count from the first frame.
    """

    name: str
    marks: tuple[Mark, ...]
    moments: bool = False
    on_clock: bool = False


def segment_tier(parts: Iterable[Segment | SegmentEvent], level: object, origin: float) -> Tier:
    """Return the tier of the segments at a level, which is part of its name if the level has one.

    Args:
        parts: In the order of time.
        level: A name, or else a strength.
        origin: Time of the first frame, s.
    """
    marks = [Mark(part.start_time - origin, part.end_time - origin, _label(part)) for part in parts]
    return Tier(f"{SEGMENTS} {level}" if isinstance(level, str) else SEGMENTS, without_overlaps(marks))


def key_frame_tier(keys: Iterable[KeyFrame | KeyFrameEvent], origin: float) -> Tier:
    """Return the tier of key frames; as `segment_tier`."""
    marks = sorted(Mark(key.time - origin, key.time - origin, key.kind) for key in keys)
    return Tier(KEY_FRAMES, tuple(marks), moments=True)


def repetition_tier(events: Iterable[RepetitionEvent], origin: float) -> Tier:
    """Return the tier of the repetitions that are counted; as `segment_tier`."""
    return Tier(REPETITIONS, _marks([(event, str(event.count)) for event in events], origin))


def of_limb(channel: str, tier: Tier) -> Tier:
    """Return a tier by the name that it has for a limb; the body's stays as it is."""
    return tier if channel == BODY else Tier(f"{channel} {tier.name}", tier.marks, tier.moments)


def move_tier(events: Iterable[MoveEvent], origin: float) -> Tier:
    """Return the tier of moves; as `segment_tier`."""
    return Tier(MOVES, _marks([(event, event.name) for event in events], origin))


def pose_tier(events: Iterable[PoseEvent], origin: float) -> Tier:
    """Return the tier of held poses; as `segment_tier`."""
    return Tier(POSES, _marks([(event, event.name) for event in events], origin))


def follow_tiers(events: Iterable[FollowEvent], origin: float) -> list[Tier]:
    """Return a tier for each move that was followed: `followed NAME`, labelled with counts; as `segment_tier`."""
    done: dict[str, list[tuple[FollowEvent, str]]] = {}
    for event in events:
        done.setdefault(event.name, []).append((event, str(event.count)))
    return [Tier(f"{FOLLOWED} {name}", _marks(own, origin)) for name, own in done.items()]


def step_tier(events: Iterable[StepEvent], origin: float) -> Tier:
    """Return the tier of steps, labelled as `left strike`; as `segment_tier`."""
    marks = sorted(Mark(e.time - origin, e.time - origin, f"{e.side} {e.status}") for e in events)
    return Tier(STEPS, tuple(mark for mark in marks if mark.start >= 0), moments=True)


def _marks(labelled: Sequence[tuple[Spanning, str]], origin: float) -> tuple[Mark, ...]:
    spans = [(*span(event), label) for event, label in labelled if event.start is not None]
    return without_overlaps(Mark(start - origin, end - origin, label) for start, end, label in spans)


def without_overlaps(marks: Iterable[Mark]) -> tuple[Mark, ...]:
    """Return stretches in the order of time, none of which begins before the end of the one before."""
    kept: list[Mark] = []
    latest = 0.0
    for mark in sorted(marks):
        if mark.end > max(mark.start, latest):
            kept.append(Mark(max(mark.start, latest), mark.end, mark.label))
            latest = mark.end
    return tuple(kept)


def _label(part: Segment | SegmentEvent) -> str:
    return " ".join([part.state, *part.active_joints[:1]]) if part.state == "moving" else part.state
