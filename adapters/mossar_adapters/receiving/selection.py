"""The user's selection from a source whose skeletons are known only while it runs: joints, root, one performer."""

import logging
from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.selection import of_joints, selected_skeleton
from mossar_adapters.newest import Newest
from mossar_adapters.source import Departure, Item, Meta, Occupant, Source
from mossar_stream import FrameError, Frames

_NAMES = 4096  # performers that are remembered
_MOST_LOGGED = 8  # performers that are logged

_log = logging.getLogger("mossar.source")


class SelectedSource:
    """Passes on some of a source; everything else about it (counters, explain, pacer) is the source's own.

    Args:
        source: Source of the frames.
        options: `joints`, `root` and `performer` count here.
    """

    def __init__(self, source: Source, options: ReadOptions) -> None:
        self._source = source
        self._options = options
        self._others: set[str] = set()  # unwanted performers that were logged
        # The joints that are wanted of each performer, by number; none for all, None if it lacks one.
        self._joints: Newest[str, NDArray[np.intp] | None] = Newest(_NAMES)
        self.name, self.live = source.name, source.live

    def __getattr__(self, name: str) -> Any:
        return getattr(self._source, name)

    def items(self) -> Iterator[Item]:
        """Yield the selected items.

        Raises:
            FrameError: If the first performer lacks a joint or the root, or the root is none of the joints. Later
                ones are passed over, so that a newcomer does not end a stream that goes well.
        """
        for item in self._source.items():
            if item is None:
                yield None
            elif self._options.performer not in {None, item.performer}:
                self._log_left_out(item)
            else:
                wanted = self._of_interest(item)
                if wanted is not None:
                    yield wanted

    def close(self) -> None:
        """Close the source."""
        self._source.close()

    def _of_interest(self, item: Meta | Frames | Departure | Occupant) -> Item:
        if isinstance(item, Meta):
            return self._announced(item)
        if isinstance(item, Occupant) and item.performer not in self._joints:
            return item  # the occupant of a slot comes before its skeleton
        joints = self._joints.get(item.performer)
        if joints is None:
            return None
        return of_joints(item, joints) if isinstance(item, Frames) else item

    def _log_left_out(self, item: Meta | Frames | Departure | Occupant) -> None:
        if isinstance(item, Meta) and len(self._others) < _MOST_LOGGED and item.performer not in self._others:
            self._others.add(item.performer)
            _log.info(
                "%s: %s is left out, only %s is wanted", self.name, item.performer, self._options.performer
            )

    def _announced(self, meta: Meta) -> Meta | None:
        try:
            skeleton, note = selected_skeleton(meta.skeleton, self._options)
        except FrameError as error:
            if not self._joints:
                raise
            self._joints[meta.performer] = None
            _log.warning("%s: %s is left out: %s", self.name, meta.performer, error)
            return None
        if note:
            _log.info("%s: %s", self.name, note)
        joints = [meta.skeleton.index(name) for name in self._options.joints]
        self._joints[meta.performer] = np.array(joints, dtype=np.intp)
        reference = () if self._options.joints else meta.reference
        return msgspec.structs.replace(meta, skeleton=skeleton, reference=reference)
