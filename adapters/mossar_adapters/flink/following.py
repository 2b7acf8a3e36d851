"""Following: the segmenters of the performers whose records come to one operator.

The engine keeps each performer's snapshot; here are the live segmenters, so that a snapshot is unpacked only after a
failure, a move to another machine, or a long absence. The process may lose them at any time.
"""

import math
from collections.abc import Callable

import msgspec

from mossar_adapters.flink.records import read_record
from mossar_adapters.joint_sets import by_count
from mossar_adapters.newest import Newest
from mossar_adapters.source import Meta
from mossar_stream import Event, FrameError, Moves, Segmenter, Settings, Skeleton

MOST = 4096  # live segmenters; the least recently used one is kept as a snapshot

Kept = Callable[[], bytes | None]  # reads the snapshot that the engine keeps, None if there is none


class Line(msgspec.Struct):
    """One performer.

    Args:
        segmenter: The segmenter of the performer.
        heard: When records last came, s on the caller's clock.
        due: When the caller will look after the performer, s.
    """

    segmenter: Segmenter
    heard: float
    due: float = math.inf

    def snapshot(self) -> bytes:
        """Return the state of the performer for the engine; the examples of moves are the job's."""
        return self.segmenter.snapshot(with_moves=False)


class Following:
    """Takes records in, each under its performer's name.

    Args:
        settings: Of all segmenters.
        most: Live segmenters.
        moves: That are recognised of all performers.
        follow: Names of those that are followed, or True for all.

    Example:
        >>> from mossar_adapters.demo import DemoSource
        >>> from mossar_adapters.flink.records import records_of
        >>> following, kept = Following(Settings()), {}
        >>> for item in DemoSource.from_url("demo:?seconds=1", speed="max").items():
        ...     for record in records_of(item):
        ...         line, events = following.take("p1", record, 0.0, lambda: kept.get("p1"))
        ...         kept["p1"] = line.snapshot()
        >>> Segmenter.restore(kept["p1"]).stats["frames"]
        60
    """

    def __init__(
        self,
        settings: Settings,
        most: int = MOST,
        moves: Moves | None = None,
        follow: tuple[str, ...] | bool = (),
    ) -> None:
        self._settings = settings
        self._moves = moves
        self._follow = follow
        self._lines: Newest[str, Line] = Newest(most)  # in the order in which they were last used

    def take(self, performer: str, record: bytes | str, now: float, kept: Kept) -> tuple[Line, list[Event]]:
        """Use a record.

        Args:
            performer: Its key.
            record: A record, see `records`.
            now: The caller's clock, s.
            kept: Reads the performer's snapshot.

        Returns:
            The performer as known now, and the events that the record causes.

        Raises:
            FrameError: If the record cannot be used; nothing is changed then.
            SnapshotError: If the snapshot cannot be read.
        """
        found = read_record(record)
        line = self.line(performer, now, kept)
        if isinstance(found, Meta):
            return self._announce(performer, line, found, now)
        if line is None:
            joints = found.positions.shape[1]
            plain = Skeleton(tuple(f"joint{i}" for i in range(joints)), root=-1)
            line = self._begin(performer, Meta(performer, by_count(joints) or plain), now)
        events = line.segmenter.push(found)
        line.heard = now
        return line, events

    def line(self, performer: str, now: float, kept: Kept) -> Line | None:
        """Return the state of a performer, heard `now` if that was lost; None for a stranger."""
        line = self._lines.get(performer)
        if line is None:
            blob = kept()
            if blob is None:
                return None
            return self._add(performer, Segmenter.restore(blob, self._moves, self._follow), now)
        self._lines.move_to_end(performer)
        return line

    def forget(self, performer: str) -> None:
        """Forget a performer."""
        self._lines.pop(performer, None)

    def _announce(
        self, performer: str, line: Line | None, meta: Meta, now: float
    ) -> tuple[Line, list[Event]]:
        """Note a skeleton; another one ends the take."""
        if line is not None and line.segmenter.skeleton == meta.skeleton:
            line.heard = now
            return line, []
        new = self._begin(performer, meta, now)
        if line is None:
            return new, []
        events = line.segmenter.end_take("another skeleton")
        new.segmenter.carry_on(line.segmenter.counts)
        return new, events

    def _begin(self, performer: str, meta: Meta, now: float) -> Line:
        try:
            segmenter = Segmenter(
                meta.skeleton, self._settings, performer, meta.fps, self._moves, self._follow
            )
        except ValueError as error:
            raise FrameError(str(error)) from None
        return self._add(performer, segmenter, now)

    def _add(self, performer: str, segmenter: Segmenter, now: float) -> Line:
        line = self._lines[performer] = Line(segmenter, now)
        return line
