"""What a user wants of a source whose skeletons are known only while it runs: joints, root, one performer."""

from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.source import Meta, Source
from mossar_stream.frames import Frames


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
        self.name, self.live = source.name, source.live

    def __getattr__(self, name: str) -> Any:
        return getattr(self._source, name)

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield what is wanted.

        Raises:
            FrameError: If a performer lacks a joint or the root.
        """
        for item in self._source.items():
            if item is None:
                yield None
            elif self._options.performer in {None, item.performer}:
                yield self._meta(item) if isinstance(item, Meta) else self._frames(item)

    def close(self) -> None:
        """Close the source."""
        self._source.close()

    def _meta(self, meta: Meta) -> Meta:
        skeleton = meta.skeleton
        if self._options.root is not None:
            skeleton = skeleton.with_root(self._options.root)
        if self._options.joints:
            columns = [skeleton.index(name) for name in self._options.joints]
            self._columns[meta.performer] = np.array(columns, dtype=np.intp)
            skeleton = skeleton.select(self._options.joints)
        return msgspec.structs.replace(meta, skeleton=skeleton)

    def _frames(self, frames: Frames) -> Frames:
        columns = self._columns.get(frames.performer)
        if columns is None:
            return frames
        confidence = None if frames.confidence is None else frames.confidence[:, columns]
        return msgspec.structs.replace(frames, positions=frames.positions[:, columns], confidence=confidence)
