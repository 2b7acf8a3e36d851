"""Emission: which events go out. Filtering never changes `rev`: the core counts, this only withholds."""

from collections.abc import Sequence

from mossar_stream import (
    FOLLOW_STATUSES,
    KEY_FRAME_STATUSES,
    MOVE_STATUSES,
    POSE_STATUSES,
    REPETITION_STATUSES,
    SEGMENT_STATUSES,
    STEP_STATUSES,
    ActivityEvent,
    Event,
    FollowEvent,
    KeyFrameEvent,
    MoveEvent,
    PhaseEvent,
    PoseEvent,
    RepetitionEvent,
    SegmentEvent,
    SettingsError,
    StepEvent,
    StreamEvent,
)

_KINDS: dict[str, tuple[str, ...]] = {
    "key_frame": KEY_FRAME_STATUSES,
    "segment": SEGMENT_STATUSES,
    "move": MOVE_STATUSES,
    "repetition": REPETITION_STATUSES,
    "phase": ("",),
    "step": STEP_STATUSES,
    "stream": ("",),
    "stats": ("",),
    "activity": ("",),
    "follow": FOLLOW_STATUSES,
    "pose": POSE_STATUSES,
}


class Emission:
    """Tells which events are wanted.

    Args:
        wanted: Types (`key_frame`), statuses (`confirmed`), or both (`key_frame.final`); empty is everything.

    Raises:
        SettingsError: If there is no such type or status.

    Example:
        >>> sorted(Emission(("stream", "key_frame.final")).allowed)
        [('key_frame', 'final'), ('stream', '')]
    """

    def __init__(self, wanted: Sequence[str] = ()) -> None:
        pairs = [(kind, status) for kind, statuses in _KINDS.items() for status in statuses]
        chosen = {pair for word in wanted for pair in _meant(word, pairs)}
        self.allowed = frozenset(chosen if wanted else pairs)
        self._everything = len(self.allowed) == len(pairs)

    @property
    def kinds(self) -> set[str]:
        """The types of which any event is wanted."""
        return {kind for kind, _ in self.allowed}

    def of(self, events: list[Event]) -> list[Event]:
        """Return the wanted ones among events."""
        if self._everything:
            return events
        return [event for event in events if _pair(event) in self.allowed]


def _meant(word: str, pairs: list[tuple[str, str]]) -> list[tuple[str, str]]:
    kind, _, status = word.partition(".")
    found = [p for p in pairs if (word in p) or (status and p == (kind, status))]
    if not found:
        statuses = dict.fromkeys(status for _, status in pairs if status)
        raise SettingsError(
            f"no events called {word[:40]!r}; there are {', '.join(_KINDS)}, the statuses {', '.join(statuses)}, "
            "and both together as in key_frame.final"
        )
    return found


def _pair(event: Event) -> tuple[str, str]:
    if isinstance(event, KeyFrameEvent):
        return "key_frame", event.status
    if isinstance(event, SegmentEvent):
        return "segment", event.status
    if isinstance(event, MoveEvent):
        return "move", event.status
    if isinstance(event, FollowEvent):
        return "follow", event.status
    if isinstance(event, PoseEvent):
        return "pose", event.status
    if isinstance(event, RepetitionEvent):
        return "repetition", event.status
    if isinstance(event, ActivityEvent):
        return "activity", ""
    if isinstance(event, PhaseEvent):
        return "phase", ""
    if isinstance(event, StepEvent):
        return "step", event.status
    return ("stream" if isinstance(event, StreamEvent) else "stats"), ""
