"""Standard input: JSON lines frames, one meta or frame map per line."""

import os
import sys
import time
from collections.abc import Iterator

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.jsonl import decode_line
from mossar_adapters.frame_maps import FrameMap, MetaMap, confidence_of_map, meta_of_map, positions_of_map
from mossar_adapters.joint_sets import by_count
from mossar_adapters.source import Meta
from mossar_stream.errors import FrameError, MossarError
from mossar_stream.frames import Frames, performer_name
from mossar_stream.skeleton import Skeleton

MAX_LINE = 1 << 20  # bytes; 1024 joints take about 70 thousand

_READ = 1 << 16  # bytes


class JsonLinesSource:
    """Reads frames from a file descriptor; implements `Source`.

    A frame without `t` has the time that its number gives at the rate, and without a rate the time of its arrival.
    Lines that hold no usable frame are counted and passed over.

    Args:
        descriptor: What to read; None is standard input.
        fps: Rate in Hz, for frames without `t`.
        performer: Another name for the only performer.
    """

    name = "standard input"
    live = False  # the sender waits for us; nothing is lost

    def __init__(
        self, descriptor: int | None = None, *, fps: float | None = None, performer: str | None = None
    ) -> None:
        self.counters = {"received": 0, "malformed": 0}  # lines
        self.frames = 0
        self._descriptor = sys.stdin.fileno() if descriptor is None else descriptor
        self._fps = fps
        self._performer = performer
        self._closed = False
        self._metas: dict[str, Meta] = {}
        self._counts: dict[str, int] = {}  # frames so far of each performer
        self._problem = ""  # what was wrong with the first malformed line
        self._line = 0

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield metas and frames until the input ends.

        Raises:
            MossarError: At the end, if no line held a usable frame.
        """
        rest = b""
        # Not through sys.stdin: a thread blocked in it would hold its lock when the interpreter ends.
        while not self._closed and (data := os.read(self._descriptor, _READ)):
            *lines, rest = (rest + data).split(b"\n")
            if len(rest) > MAX_LINE:
                self._refuse(f"longer than {MAX_LINE} bytes")
                rest = b""
            yield from self._chunks(lines)
        yield from self._chunks([rest])
        if not self.frames and not self._closed:
            raise MossarError(f"standard input: there is no frame in it{self._problem}")

    def close(self) -> None:
        """End `items` after the next line."""
        self._closed = True

    def explain(self) -> str:
        """Return why no frames come."""
        return (
            f"standard input: {self._line} lines came, {self.counters['malformed']} of them without a usable frame"
            f"{self._problem}; a line is a frame or meta map in JSON"
        )

    def _chunks(self, lines: list[bytes]) -> Iterator[Meta | Frames]:
        """Yield what lines hold, consecutive frames of a performer as one chunk."""
        waiting: list[Frames] = []
        for line in lines:
            self._line += 1
            self.counters["received"] += 1
            if not line.strip():
                continue
            try:
                items = self._items(decode_line(line))
            except (FrameError, ValueError) as error:
                self._refuse(str(error))
                continue
            for item in items:
                if waiting and not _continues(waiting[-1], item):
                    yield _joined(waiting)
                    waiting = []
                if isinstance(item, Meta):
                    yield item
                else:
                    waiting.append(item)
        if waiting:
            yield _joined(waiting)

    def _items(self, found: FrameMap | MetaMap | None) -> list[Meta | Frames]:
        if found is None:
            return []
        if isinstance(found, MetaMap):
            meta = meta_of_map(found)
            meta = msgspec.structs.replace(
                meta, performer=self._name(meta.performer), fps=self._fps or meta.fps
            )
            if self._metas.get(meta.performer) == meta:
                return []
            self._metas[meta.performer] = meta
            return [meta]
        positions = positions_of_map(found)
        name = self._name(performer_name(found.performer))
        meta, news = self._meta(name, len(positions))
        confidence = confidence_of_map(found, len(positions))
        count = self._counts.get(name, 0)
        self._counts[name] = count + 1
        self.frames += 1
        times = np.array([self._time(found, meta, count)])
        return [*news, Frames(positions[None], times, _one(confidence), name)]

    def _meta(self, performer: str, joints: int) -> tuple[Meta, list[Meta | Frames]]:
        """Return the meta of a performer, and what to announce first: senders may leave the meta out."""
        known = self._metas.get(performer)
        if known is not None:
            if len(known.skeleton) != joints:
                raise FrameError(f"{joints} joints where the meta of {performer} has {len(known.skeleton)}")
            return known, []
        unnamed = Skeleton(tuple(f"joint{i}" for i in range(joints)), root=-1)
        meta = Meta(performer, by_count(joints) or unnamed, self._fps)
        self._metas[performer] = meta
        return meta, [meta]

    def _time(self, found: FrameMap, meta: Meta, count: int) -> float:
        if found.t is not None and self._fps is None:
            if not abs(found.t) < 1e15:
                raise FrameError(f"t = {found.t} is no time")
            return found.t
        return count / meta.fps if meta.fps else time.monotonic()

    def _name(self, name: str) -> str:
        return performer_name(self._performer) if self._performer is not None else name

    def _refuse(self, why: str) -> None:
        self.counters["malformed"] += 1
        self._problem = self._problem or f" (line {self._line}: {why})"


def _one(confidence: NDArray[np.float32] | None) -> NDArray[np.float32] | None:
    return None if confidence is None else confidence[None]


def _continues(before: Frames, item: Meta | Frames) -> bool:
    return (
        isinstance(item, Frames)
        and item.performer == before.performer
        and (item.confidence is None) == (before.confidence is None)
    )


def _joined(parts: list[Frames]) -> Frames:
    if len(parts) == 1:
        return parts[0]
    confidence = [part.confidence for part in parts if part.confidence is not None]
    return Frames(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.times for part in parts]),
        np.concatenate(confidence) if confidence else None,
        parts[0].performer,
    )
