"""Annotations of a stream: its final results, written when the stream ends."""

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

from mossar_adapters.address import Address
from mossar_adapters.annotations.tiers import (
    Tier,
    follow_tiers,
    key_frame_tier,
    move_tier,
    of_limb,
    pose_tier,
    repetition_tier,
    segment_tier,
    step_tier,
)
from mossar_adapters.annotations.writing import check_annotations, write_annotations
from mossar_adapters.files.claim import Claim
from mossar_adapters.files.errors import FileError, UnwritableError
from mossar_adapters.source import Meta
from mossar_stream import (
    BODY,
    Event,
    FollowEvent,
    KeyFrameEvent,
    MoveEvent,
    PoseEvent,
    RepetitionEvent,
    SegmentEvent,
    StepEvent,
)

KEPT = 500_000  # events; of a stream that never ends the first are written


class AnnotationSink:
    """Keeps final results and writes them to an annotation file at the end; implements `Sink`.

    With several performers their names stand before those of the tiers. A run that goes on from a snapshot writes
    only later events.

    Args:
        address: A path; its suffix chooses the program, see `write_annotations`.
        force: Whether to replace a file that is there.

    Raises:
        MossarError: If there is such a file already, another run is writing it, it cannot be written, or the extra
            `annotate` is missing.
    """

    def __init__(self, address: Address, *, force: bool = False) -> None:
        self.name = address.url
        self.dropped = 0
        self._path = Path(address.path)
        check_annotations(self._path)
        if not self._path.parent.is_dir():
            raise UnwritableError(self._path, f"there is no folder {self._path.parent}")
        if self._path.exists() and not force:
            raise FileError(self._path, "there is a file already; --force replaces it")
        self._claim = Claim(self._path)
        self._level: str | float | None = None  # of the segmentation, as first announced
        self._origin: float | None = None  # s, of the first frame
        self._latest = -math.inf  # s
        self._kept = 0
        self._events: dict[str, dict[str, Event]] = defaultdict(dict)  # by performer and id
        self._closed = False

    def announce(self, meta: Meta) -> None:
        """Note the level: a named one is part of the tier's name."""
        if self._level is None and meta.settings is not None:
            self._level = meta.settings.get("level")

    def begin_take(self, performer: str, take: int, time: float) -> None:  # noqa: ARG002 - sinks share it
        """Let times count from the first frame of the first take."""
        if self._origin is None:
            self._origin = time

    def send(self, events: Sequence[Event]) -> None:
        """Keep final results."""
        for event in events:
            match event:
                case SegmentEvent(status="final") | MoveEvent(status="final") | FollowEvent(status="done"):
                    self._keep(event.performer, event.id, event)
                case PoseEvent(status="left"):
                    self._keep(event.performer, event.id, event)
                case KeyFrameEvent(status="final"):
                    self._keep(event.performer, event.id, event)
                    self._latest = max(self._latest, event.decided_time)
                case StepEvent():
                    self._keep(event.performer, event.id, event)
                    self._latest = max(self._latest, event.decided_time)
                case RepetitionEvent(status="counted"):
                    self._keep(event.performer, event.id, event)
                case RepetitionEvent():
                    self._kept -= self._events[event.performer].pop(event.id, None) is not None
                case _:
                    pass

    def close(self) -> None:
        """Write the file. May be called twice.

        Raises:
            AnnotationError: If it cannot be written.
        """
        if self._closed:
            return
        self._closed = True
        try:
            self._write()
        finally:
            self._claim.release()

    def _write(self) -> None:
        tiers = [tier for name, kept in sorted(self._events.items()) for tier in self._tiers(name, kept)]
        ends = [mark.end for tier in tiers for mark in tier.marks]
        write_annotations(self._path, tiers, max([0.0, self._latest - (self._origin or 0.0), *ends]))

    def _keep(self, performer: str, key: str, event: Event) -> None:
        kept = self._events[performer]
        if key not in kept:
            if self._kept == KEPT:
                self.dropped += 1
                return
            self._kept += 1
        kept[key] = event

    def _tiers(self, performer: str, kept: Mapping[str, Event]) -> list[Tier]:
        events = list(kept.values())
        every = [event for event in events if isinstance(event, SegmentEvent)]
        parts = [event for event in every if event.channel == BODY]
        keys = [event for event in events if isinstance(event, KeyFrameEvent) and event.channel == BODY]
        moves = [event for event in events if isinstance(event, MoveEvent)]
        counted = [event for event in events if isinstance(event, RepetitionEvent)]
        origin = (
            self._origin
            if self._origin is not None
            else min((part.start_time for part in parts), default=0.0)
        )
        tiers = [segment_tier(parts, self._level, origin), key_frame_tier(keys, origin)]
        tiers += [move_tier(moves, origin)] if moves else []
        poses = [event for event in events if isinstance(event, PoseEvent)]
        tiers += [pose_tier(poses, origin)] if poses else []
        tiers += follow_tiers([event for event in events if isinstance(event, FollowEvent)], origin)
        steps = [event for event in events if isinstance(event, StepEvent)]
        tiers += [step_tier(steps, origin)] if steps else []
        for channel in sorted({event.channel for event in counted}, key=lambda name: (name != BODY, name)):
            own = [event for event in counted if event.channel == channel]
            tiers.append(of_limb(channel, repetition_tier(own, origin)))
        for limb in sorted({event.channel for event in every} - {BODY}):
            tier = segment_tier([event for event in every if event.channel == limb], None, origin)
            tiers.append(of_limb(limb, tier))
        prefix = f"{performer} " if len(self._events) > 1 else ""
        return [Tier(prefix + tier.name, tier.marks, tier.moments) for tier in tiers]
