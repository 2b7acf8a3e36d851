"""The body in a stream: a unit that fits it, and joints that are no part of it, found while it runs."""

import logging
from collections.abc import Iterator
from typing import Any, Final, cast

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.abilities import Orders
from mossar_adapters.files.body import (
    body_joints,
    body_meta,
    body_root,
    body_skeleton,
    fitting_factor,
    has_candidates,
    limits_of,
    multiplied,
    reference_joints,
    reference_note,
    size_note,
)
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.selection import of_joints
from mossar_adapters.files.units import height
from mossar_adapters.newest import Newest
from mossar_adapters.source import Item, Meta, Source
from mossar_stream import Frames

HELD: Final = 5  # frames of a size that no body has, by which the unit is decided
LOOKS: Final = (1, 15, 60, 240, 960)  # frames after which joints are judged
_NAMES: Final = 4096  # performers that are remembered
_MOST_LOGGED: Final = 8

_log = logging.getLogger("mossar.source")


class _Line(msgspec.Struct):
    """State of one performer."""

    meta: Meta
    watched: bool  # whether a joint is still to be judged
    factor: float | None = None  # factor of positions, None until it is decided
    held: list[Frames] = msgspec.field(default_factory=list)
    seen: list[NDArray[Any]] = msgspec.field(default_factory=list)
    looks: int = 0
    reference: tuple[str, ...] = ()


class CheckedSource:
    """Passes on a live source, in a unit that fits the body; everything else about it is the source's own.

    The size is decided by the first frame in which half of the joints are seen, or, where no body is so small or tall, by
    `HELD` frames, which wait so long. A joint that is no part of the body is named in a new `Meta`. Frames keep it.

    Args:
        source: Source of the frames.
        options: The user's unit and centre take precedence.
    """

    def __init__(self, source: Source, options: ReadOptions) -> None:
        self._source, self._options = source, options
        self._lines: Newest[str, _Line] = Newest(_NAMES)
        self._logged = 0
        self.name, self.live = source.name, source.live

    def __getattr__(self, name: str) -> Any:
        return getattr(self._source, name)

    def items(self) -> Iterator[Item]:
        """Yield the items, checked."""
        for item in self._source.items():
            if isinstance(item, Meta):
                yield from self._release(item.performer)
                yield self._announced(item)
            elif isinstance(item, Frames):
                yield from self._taken(item)
            else:
                if item is None:
                    yield from self._release_all()
                else:
                    yield from self._release(item.performer)
                yield item
        yield from self._release_all()

    def close(self) -> None:
        """Close the source."""
        self._source.close()

    def _announced(self, meta: Meta) -> Meta:
        known = self._lines.get(meta.performer)
        if known is not None and known.meta.skeleton == meta.skeleton:
            known.meta = meta
            return _named(meta, known.reference)
        self._lines[meta.performer] = _Line(meta, has_candidates(meta.skeleton))
        return meta

    def _taken(self, frames: Frames) -> Iterator[Item]:
        line = self._lines.get(frames.performer)
        if line is None or not len(frames):
            yield frames
            return
        if line.watched:
            yield from self._judged(line, frames)
        if line.factor is None and not line.held and self._height(line, [frames]) <= 0:
            yield frames  # nothing to measure yet
            return
        if line.factor is None:
            self._measure(line, frames)
        if line.factor is None:
            line.held.append(frames)
            return
        for waiting in (*line.held, frames):
            yield _as_large(waiting, line.factor)
        line.held = []

    def _measure(self, line: _Line, frames: Frames) -> None:
        """Decide on the factor of positions, if the body can be measured."""
        waiting = [*line.held, frames]
        tall = self._height(line, waiting)
        factor = fitting_factor(tall, limits_of(body_skeleton(line.meta.skeleton, line.reference).names))
        if factor == 1.0 or sum(map(len, waiting)) >= HELD:
            self._decide(line, tall, factor)

    def _height(self, line: _Line, frames: list[Frames]) -> float:
        joints = body_joints(line.meta.skeleton, line.reference)
        positions = np.concatenate([chunk.positions for chunk in frames])
        return height(positions[:, joints] if len(joints) else positions)

    def _decide(self, line: _Line, tall: float, factor: float | None) -> None:
        given = self._options.unit != "auto"
        note = size_note(tall, factor, 1.0, given=given)
        if note:
            self._log(line.meta.performer, note)
        line.factor = 1.0 if factor is None or given else factor

    def _judged(self, line: _Line, frames: Frames) -> Iterator[Item]:
        """Yield the items to come before the frames if these show that a joint is no part of the body."""
        line.seen.append(frames.positions)
        count = sum(map(len, line.seen))
        if count < LOOKS[line.looks]:
            return
        while line.looks < len(LOOKS) and count >= LOOKS[line.looks]:
            line.looks += 1
        skeleton = line.meta.skeleton
        root = self._options.root if self._options.root in skeleton.names else None
        found = reference_joints(skeleton, np.concatenate(line.seen), root)
        if found or line.looks == len(LOOKS):
            line.watched, line.seen = False, []
        if found:
            line.reference = found
            self._log(line.meta.performer, reference_note(found))
            yield from self._release(line.meta.performer)
            yield _named(line.meta, found)

    def _release(self, performer: str) -> Iterator[Item]:
        line = self._lines.get(performer)
        if line is not None and line.held:
            tall = self._height(line, line.held)
            names = body_skeleton(line.meta.skeleton, line.reference).names
            self._decide(line, tall, fitting_factor(tall, limits_of(names)))
            for frames in line.held:
                yield _as_large(frames, line.factor or 1.0)
            line.held = []

    def _release_all(self) -> Iterator[Item]:
        for performer, line in list(self._lines.items()):
            if line.held:
                yield from self._release(performer)

    def _log(self, performer: str, note: str) -> None:
        if self._logged < _MOST_LOGGED:
            self._logged += 1
            _log.warning("%s: %s: %s", self.name, performer, note)


class BodySource:
    """Passes on a source without the joints that are no part of the body.

    Args:
        source: Source of the frames.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._joints: Newest[str, NDArray[np.intp]] = Newest(_NAMES)
        self.name, self.live = source.name, source.live

    def __getattr__(self, name: str) -> Any:
        return getattr(self._source, name)

    @property
    def in_order(self) -> bool:
        """Whether frames come in order of time, where the source offers that; see `abilities.Orders`."""
        return cast("Orders", self._source).in_order

    @in_order.setter
    def in_order(self, in_order: bool) -> None:
        cast("Orders", self._source).in_order = in_order

    def items(self) -> Iterator[Item]:
        """Yield the items, without those joints."""
        for item in self._source.items():
            if isinstance(item, Meta):
                self._joints[item.performer] = body_joints(item.skeleton, item.reference)
                yield body_meta(item)
            elif isinstance(item, Frames) and (joints := self._joints.get(item.performer)) is not None:
                yield of_joints(item, joints)
            else:
                yield item

    def close(self) -> None:
        """Close the source."""
        self._source.close()


def _named(meta: Meta, reference: tuple[str, ...]) -> Meta:
    return msgspec.structs.replace(meta, skeleton=body_root(meta.skeleton, reference), reference=reference)


def _as_large(frames: Frames, factor: float) -> Frames:
    return frames if factor == 1.0 else multiplied(frames, factor)
