"""Naming: performers of several sources under names of their own, and how far each source was read."""

import logging
from collections import OrderedDict
from collections.abc import Iterable, Sequence

from mossar_adapters.pipeline.snapshot import Position
from mossar_stream import Frames

_log = logging.getLogger("mossar.pipeline")


class Naming:
    """Gives each performer of each source a unique name.

    Args:
        sources: Names of the sources.
    """

    def __init__(self, sources: Sequence[str]) -> None:
        self._sources = list(sources)
        # From the source's name to ours, last used last.
        self._names: list[OrderedDict[str, str]] = [OrderedDict() for _ in sources]
        self._owners: dict[str, int] = {}  # from our name to the source
        self._frames: list[dict[str, int]] = [{} for _ in sources]  # taken so far, by the source's name

    def __len__(self) -> int:
        return len(self._owners)

    def name(self, source: int, performer: str) -> str:
        """Return our name for a performer of a source; the first source with a name keeps it."""
        names = self._names[source]
        if performer in names:
            names.move_to_end(performer)  # at once: a dashboard reads in another thread
        else:
            names[performer] = self._free(performer)
            self._owners[names[performer]] = source
            if names[performer] != performer:
                _log.info(
                    "%s: performer %s is called %s here", self._sources[source], performer, names[performer]
                )
        return names[performer]

    @property
    def names(self) -> set[str]:
        """Our names for all performers."""
        return set(self._owners)

    def known(self, source: int, performer: str) -> str | None:
        """Return our name for a performer of a source, None if it was never named."""
        return self._names[source].get(performer)

    def of_source(self, source: int) -> list[str]:
        """Return our names for the performers of a source."""
        return list(self._names[source].values())

    def source_of(self, name: str) -> int:
        """Return the source of the performer that we call `name`."""
        return self._owners[name]

    def count(self, source: int, frames: Frames) -> None:
        """Count frames, under the source's name for the performer."""
        counts = self._frames[source]
        counts[frames.performer] = counts.get(frames.performer, 0) + len(frames)

    def forget(self, kept: Iterable[str], most: int) -> None:
        """Forget performers, but for those called `kept` and the `most` of each source that were named last."""
        keep = set(kept)
        for names, frames in zip(self._names, self._frames, strict=True):
            for performer in [own for own, name in list(names.items())[:-most] if name not in keep]:
                del self._owners[names.pop(performer)]
                frames.pop(performer, None)

    def positions(self) -> tuple[Position, ...]:
        """Return how far each source was read."""
        return tuple(
            Position(name, dict(frames), dict(names))
            for name, frames, names in zip(self._sources, self._frames, self._names, strict=True)
        )

    def resume(self, positions: Sequence[Position]) -> None:
        """Go on with the names and counts of a snapshot of the same sources."""
        self._names = [OrderedDict(position.names) for position in positions]
        self._frames = [dict(position.frames) for position in positions]
        self._owners = {name: i for i, names in enumerate(self._names) for name in names.values()}

    def fits(self, positions: Sequence[Position]) -> bool:
        """Return whether positions are of these sources."""
        return [position.name for position in positions] == self._sources

    def _free(self, performer: str) -> str:
        if performer not in self._owners:
            return performer
        number = 1
        while f"p{number}" in self._owners:
            number += 1
        return f"p{number}"
