"""What a user wants of a source whose skeletons are known only while it runs: joints, root, one performer."""

import logging
from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.selection import selected_skeleton
from mossar_adapters.source import Came, Item, Left, Meta, Source
from mossar_stream import FrameError, Frames

_NAMES = 4096  # performers that are remembered
_MOST_LOGGED = 8  # performers that are logged

_log = logging.getLogger("mossar.source")


class SelectedSource:
    """Passes on some of a source; everything else about it (counters, explain, pacer) is the source's own.

    Args:
        source: Where frames come from.
        options: `joints`, `root` and `performer` count here.
    """

    def __init__(self, source: Source, options: ReadOptions) -> None:
        self._source = source
        self._options = options
        self._columns: dict[str, NDArray[np.intp]] = {}
        self._others: set[str] = set()  # performers that are not wanted, as far as they were logged
        self._fits: dict[str, bool] = {}  # whether each performer has what is wanted
        self.name, self.live = source.name, source.live

    def __getattr__(self, name: str) -> Any:
        return getattr(self._source, name)

    def items(self) -> Iterator[Item]:
        """Yield what is wanted.

        Raises:
            FrameError: If the first performer lacks a joint or the root, or the root is none of the joints. Later
                ones are passed over, so that a newcomer does not end a stream that goes well.
        """
        for item in self._source.items():
            if item is None:
                yield None
            elif self._options.performer not in {None, item.performer}:
                self._tell_of(item)
            else:
                wanted = self._of_interest(item)
                if wanted is not None:
                    yield wanted

    def close(self) -> None:
        """Close the source."""
        self._source.close()

    def _of_interest(self, item: Meta | Frames | Left | Came) -> Item:
        if isinstance(item, Meta):
            return self._announced(item)
        if not self._fits.get(item.performer):
            return None
        return self._frames(item) if isinstance(item, Frames) else item

    def _tell_of(self, item: Meta | Frames | Left | Came) -> None:
        if isinstance(item, Meta) and len(self._others) < _MOST_LOGGED and item.performer not in self._others:
            self._others.add(item.performer)
            _log.info(
                "%s: %s is left out, only %s is wanted", self.name, item.performer, self._options.performer
            )

    def _announced(self, meta: Meta) -> Meta | None:
        try:
            found = self._meta(meta)
        except FrameError as error:
            if not self._fits:
                raise
            self._fits[meta.performer] = False
            _log.warning("%s: %s is left out: %s", self.name, meta.performer, error)
            return None
        self._fits[meta.performer] = True
        if len(self._fits) > _NAMES:
            oldest = next(iter(self._fits))
            del self._fits[oldest]
            self._columns.pop(oldest, None)
        return found

    def _meta(self, meta: Meta) -> Meta:
        skeleton, note = selected_skeleton(meta.skeleton, self._options)
        if note:
            _log.info("%s: %s", self.name, note)
        if self._options.joints:
            columns = [meta.skeleton.index(name) for name in self._options.joints]
            self._columns[meta.performer] = np.array(columns, dtype=np.intp)
        return msgspec.structs.replace(meta, skeleton=skeleton)

    def _frames(self, frames: Frames) -> Frames:
        columns = self._columns.get(frames.performer)
        if columns is None:
            return frames
        confidence = None if frames.confidence is None else frames.confidence[:, columns]
        return msgspec.structs.replace(frames, positions=frames.positions[:, columns], confidence=confidence)
