"""Selecting: some performers, joints or another root, of a source that does not select by itself."""

from collections.abc import Iterator, Mapping

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.pipeline.counting import counters_of, explanation
from mossar_adapters.source import Meta, Source
from mossar_stream.frames import Frames


class SelectingSource:
    """Passes on what is wanted of another source; implements `Source`.

    Args:
        source: The other one.
        joints: Names of the joints to keep, in this order; empty keeps all.
        root: Name of the joint that is the body centre.
        performer: Name of the only performer to pass on.
    """

    def __init__(
        self,
        source: Source,
        *,
        joints: tuple[str, ...] = (),
        root: str | None = None,
        performer: str | None = None,
    ) -> None:
        self.name = source.name
        self.live = source.live
        self.inner = source
        self._joints = joints
        self._root = root
        self._performer = performer
        self._kept: dict[str, NDArray[np.intp]] = {}  # of each performer the indices of the joints

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield what is left of the other source's items.

        Raises:
            FrameError: If a performer has no joint of a wanted name.
        """
        for item in self.inner.items():
            if item is None or (self._performer is not None and item.performer != self._performer):
                yield None
            elif isinstance(item, Meta):
                yield self._announced(item)
            else:
                yield self._taken(item)

    def close(self) -> None:
        """Close the other source."""
        self.inner.close()

    def explain(self) -> str:
        """Return what the other source knows about why no frames come."""
        return explanation(self.inner)

    @property
    def counters(self) -> Mapping[str, int]:
        """The other source's counters."""
        return counters_of(self.inner)

    def _announced(self, meta: Meta) -> Meta:
        skeleton = meta.skeleton
        if self._root is not None:
            skeleton = skeleton.with_root(self._root)
        if self._joints:
            self._kept[meta.performer] = np.array([skeleton.index(name) for name in self._joints], np.intp)
            skeleton = skeleton.select(self._joints)
        return msgspec.structs.replace(meta, skeleton=skeleton)

    def _taken(self, frames: Frames) -> Frames:
        kept = self._kept.get(frames.performer)
        if kept is None:
            return frames
        confidence = frames.confidence
        return msgspec.structs.replace(
            frames,
            positions=np.ascontiguousarray(frames.positions[:, kept]),
            confidence=None if confidence is None else np.ascontiguousarray(confidence[:, kept]),
        )
