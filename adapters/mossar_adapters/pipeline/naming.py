"""Naming: performers of several sources under names of their own, and the record of each."""

import logging
from collections import OrderedDict
from collections.abc import Iterable, Sequence

from mossar_adapters.pipeline.performer_record import PerformerRecord
from mossar_adapters.pipeline.snapshot import Position

_log = logging.getLogger("mossar.pipeline")


class Naming:
    """Gives each performer of each source a unique name, and a record.

    Args:
        sources: Names of the sources.

    Attributes:
        performers: The records by our names.
    """

    def __init__(self, sources: Sequence[str]) -> None:
        self.performers: dict[str, PerformerRecord] = {}
        self._sources = list(sources)
        # The records of each source by its own names, last used last.
        self._own: list[OrderedDict[str, PerformerRecord]] = [OrderedDict() for _ in sources]

    def performer(self, source: int, own: str) -> PerformerRecord:
        """Return the record of a performer of a source; the first source with a name keeps it."""
        records = self._own[source]
        if own in records:
            records.move_to_end(own)
            return records[own]
        record = self._add(self._free(own), source, own)
        if record.name != own:
            _log.info("%s: performer %s is called %s here", self._sources[source], own, record.name)
        return record

    def known(self, source: int, own: str) -> PerformerRecord | None:
        """Return the record of a performer of a source, None if it was never named."""
        return self._own[source].get(own)

    def of_source(self, source: int) -> list[PerformerRecord]:
        """Return the records of the performers of a source."""
        return list(self._own[source].values())

    def forget(self, kept: Iterable[str], most: int) -> None:
        """Forget performers, but for those called `kept` and the `most` of each source that were named last."""
        keep = set(kept)
        for records in self._own:
            for record in [record for record in list(records.values())[:-most] if record.name not in keep]:
                del self.performers[record.name], records[record.own]

    def positions(self) -> tuple[Position, ...]:
        """Return the position in each source."""
        return tuple(
            Position(
                name,
                {record.own: record.received for record in records.values() if record.received},
                {record.own: record.name for record in records.values()},
            )
            for name, records in zip(self._sources, self._own, strict=True)
        )

    def resume(self, positions: Sequence[Position]) -> None:
        """Go on with the names and counts of a snapshot of the same sources."""
        for source, position in enumerate(positions):
            for own, name in position.names.items():
                self._add(name, source, own, position.frames.get(own, 0))

    def fits(self, positions: Sequence[Position]) -> bool:
        """Return whether positions are of these sources."""
        return [position.name for position in positions] == self._sources

    def _add(self, name: str, source: int, own: str, received: int = 0) -> PerformerRecord:
        record = self._own[source][own] = self.performers[name] = PerformerRecord(name, source, own, received)
        return record

    def _free(self, own: str) -> str:
        if own not in self.performers:
            return own
        number = 1
        while f"p{number}" in self.performers:
            number += 1
        return f"p{number}"
