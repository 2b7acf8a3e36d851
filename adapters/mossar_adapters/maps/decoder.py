"""The one decoder of frame and meta maps: those of ZeroMQ, of JSON lines and of `.msk` files."""

import numpy as np

from mossar_adapters.files.options import METRES, ReadOptions
from mossar_adapters.live import Counters
from mossar_adapters.maps.frame_maps import (
    FrameMap,
    MetaMap,
    confidence_of_map,
    meta_of_map,
    positions_of_map,
)
from mossar_adapters.receiving.names import distinct_name
from mossar_adapters.receiving.owners import Owners
from mossar_adapters.receiving.pose import Pose, check_time
from mossar_adapters.receiving.senders import Senders
from mossar_adapters.receiving.sequence import Sequences
from mossar_adapters.source import Meta


class MapDecoder:
    """Turns maps into metas and poses.

    Args:
        counters: They count gaps.
        options: The user's fps and unit.
        performer: The user's name of the performer, or None.
    """

    def __init__(self, counters: Counters, options: ReadOptions, performer: str | None = None) -> None:
        self._sequences = Sequences(counters)
        self._fps = options.fps
        self._scale = METRES.get(options.unit, 1.0)
        self._names = None if performer is None else Senders(performer)
        self._owners = Owners()

    def forget(self, sender: str) -> list[str]:
        """Forget a sender that is gone for good; return the performers that were its own."""
        return self._owners.forget(sender)

    def receive(self, found: FrameMap | MetaMap, arrival: float, sender: str = "") -> Meta | Pose:
        """Return the content of a map.

        Args:
            found: The map.
            arrival: Time of arrival, s.
            sender: Distinguishes connections, where that is known: a name belongs to one of them.

        Raises:
            FrameError: If it cannot be used.
        """
        name = distinct_name(found.performer)
        if self._names is not None:
            name = self._names.name("", name)
        if sender:
            name = self._owners.name(sender, name, arrival)
        if isinstance(found, MetaMap):
            meta = meta_of_map(found)
            return Meta(name, meta.skeleton, meta.fps or self._fps, meta.unit)
        check_time(found.t)
        positions = positions_of_map(found)
        confidence = confidence_of_map(found, len(positions))
        if found.seq is not None:
            self._sequences.count(name, found.seq)
        if self._scale != 1.0:
            positions = positions * np.float32(self._scale)
        return Pose(name, positions, arrival, found.t, confidence, sender=sender)
