"""Frame and meta maps from outside, turned into batches: shared by ZeroMQ and standard input."""

import numpy as np

from mossar_adapters.files.options import METRES, ReadOptions
from mossar_adapters.joint_sets import by_count
from mossar_adapters.live import Counters
from mossar_adapters.maps.frame_maps import (
    FrameMap,
    MetaMap,
    confidence_of_map,
    meta_of_map,
    positions_of_map,
)
from mossar_adapters.receiving.batch import Batch
from mossar_adapters.receiving.senders import Senders
from mossar_adapters.receiving.sequence import Sequences
from mossar_adapters.source import Meta
from mossar_stream.frames import performer_name
from mossar_stream.skeleton import Skeleton


class MapIntake:
    """Takes maps and collects frames.

    Args:
        batch: Where frames go.
        counters: Where gaps are counted.
        options: The user's unit.
        performer: What the user calls the performer, or None.
    """

    def __init__(
        self, batch: Batch, counters: Counters, options: ReadOptions, performer: str | None = None
    ) -> None:
        self._batch = batch
        self._sequences = Sequences(counters)
        self._scale = METRES.get(options.unit, 1.0)
        self._names = None if performer is None else Senders(performer)
        self._made_up: dict[int, Skeleton] = {}

    def take(self, found: FrameMap | MetaMap, arrival: float) -> None:
        """Use a map.

        Args:
            found: The map.
            arrival: When it came, s.

        Raises:
            FrameError: If it cannot be used.
        """
        name = performer_name(found.performer)
        if self._names is not None:
            name = self._names.name("", name)
        if isinstance(found, MetaMap):
            meta = meta_of_map(found)
            self._batch.announce(Meta(name, meta.skeleton, meta.fps or self._batch.fps, meta.unit))
            return
        positions = positions_of_map(found)
        if self._batch.skeleton(name) is None:
            self._batch.announce(Meta(name, self._skeleton(len(positions)), self._batch.fps))
        if found.seq is not None:
            self._sequences.count(name, found.seq)
        self._batch.add(
            name,
            positions if self._scale == 1.0 else (positions * np.float32(self._scale)),
            arrival=arrival,
            time=found.t,
            confidence=confidence_of_map(found, len(positions)),
        )

    def _skeleton(self, joints: int) -> Skeleton:
        """Return a skeleton for a sender that never described it."""
        found = self._made_up.get(joints)
        if found is None:
            plain = Skeleton(tuple(f"joint{i}" for i in range(joints)), root=-1)
            found = self._made_up[joints] = by_count(joints) or plain
        return found
