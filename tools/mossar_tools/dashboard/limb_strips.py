"""Limb strips: the states of limbs, and recognised moves and poses, of one live performer, all bounded."""

import math
from typing import TypeVar

from mossar_adapters.newest import Newest
from mossar_stream import MoveEvent, PoseEvent, SegmentEvent
from mossar_tools.marks import NamedMove, Stretch

_KEPT = 400  # segments of limbs, and moves
_Kept = TypeVar("_Kept", SegmentEvent, MoveEvent, PoseEvent)


class LimbStrips:
    """Remembers the last segments of limbs, and the last moves; not safe by itself between threads."""

    def __init__(self) -> None:
        self._segments: Newest[str, SegmentEvent] = Newest(_KEPT)
        self._moves: Newest[str, MoveEvent] = Newest(_KEPT)
        self._poses: Newest[str, PoseEvent] = Newest(_KEPT)

    def add_segment(self, event: SegmentEvent) -> None:
        """Add or update a segment of a limb."""
        _keep(self._segments, event)

    def add_move(self, event: MoveEvent) -> None:
        """Add or update a move."""
        _keep(self._moves, event)

    def add_pose(self, event: PoseEvent) -> None:
        """Add or update a held pose."""
        _keep(self._poses, event)

    def stretches(self, start: float) -> dict[str, list[Stretch]]:
        """Return the segments of each limb since a time, s; limbs in the order of their names."""
        found: dict[str, list[Stretch]] = {}
        for event in sorted(self._segments.values(), key=lambda event: (event.channel, event.start_time)):
            if event.end_time > start:
                found.setdefault(event.channel, []).append(
                    Stretch(event.start_time, event.end_time, event.state)
                )
        return found

    def moves(self, start: float) -> list[NamedMove]:
        """Return the moves and the poses since a time, s; a pose that is not left yet goes on."""
        moves = [NamedMove(e.start, e.end, e.name) for e in self._moves.values() if e.end > start]
        for event in self._poses.values():
            end = event.start + event.seconds if event.status == "left" else math.inf
            if end > start:
                moves.append(NamedMove(event.start, end, event.name))
        return moves


def _keep(kept: Newest[str, _Kept], event: _Kept) -> None:
    if event.status == "withdrawn":
        kept.pop(event.id, None)
    else:
        kept[event.id] = event
