"""Slots of a run: those of all its sources, under the performers' names in its events."""

from collections.abc import Sequence
from typing import Any

from mossar_adapters.abilities import HasSlots, offered
from mossar_adapters.pipeline.run import Run
from mossar_stream import SettingsError


def sources_with_slots(run: Run) -> dict[int, Any]:
    """Return the `PeopleSource` of each source that has slots, by the source's number."""
    found = {i: offered(feed.source, HasSlots) for i, feed in enumerate(run.feeds)}
    return {i: source.people for i, source in found.items() if source is not None}


def slots_by_source(run: Run) -> dict[str, list[dict[str, object]]]:
    """Return the people in the slots of each source; see `Slots.table`."""
    return {
        source.name: [
            {**row, "slot": performer.name}
            for row in source.table()
            if (performer := run.naming.known(i, str(row["slot"]))) is not None
        ]
        for i, source in sources_with_slots(run).items()
    }


def exchange(run: Run, one: str, other: str) -> None:
    """Let two people have each other's slots.

    Raises:
        SettingsError: If there are no two such slots in one source.
    """
    if one == other:
        raise SettingsError(f"{one[:40]} cannot be exchanged with itself")
    source, slots = _found(run, (one, other))
    source.exchange(*slots)


def pin(run: Run, slot: str, *, pinned: bool) -> None:
    """Keep a slot for its person, or no longer.

    Raises:
        SettingsError: If there is no such slot, or no person was in it.
    """
    source, slots = _found(run, (slot,))
    source.pin(slots[0], pinned=pinned)


def _found(run: Run, names: Sequence[str]) -> tuple[Any, list[str]]:
    """Return the source that has slots of these names, and its own names of them."""
    everywhere = {
        name: [(i, slot) for i in sources_with_slots(run) if (slot := _slot(run, i, name)) is not None]
        for name in names
    }
    for name, places in everywhere.items():
        if not places:
            raise SettingsError(f"there is no slot {repr(name)[:40]}; there are {', '.join(_names(run))}")
    for i, source in sources_with_slots(run).items():
        slots = [slot for places in everywhere.values() for j, slot in places if j == i]
        if len(slots) == len(everywhere):
            return source, slots
    raise SettingsError(f"{' and '.join(names)} are people of different sources")


def _slot(run: Run, number: int, name: str) -> str | None:
    """Return a source's name of the slot that events call `name`; an unused one has its own name."""
    for slot in sources_with_slots(run)[number].performers:
        known = run.naming.known(number, slot)
        if known.name == name if known else slot == name and name not in run.naming.performers:
            return str(slot)
    return None


def _names(run: Run) -> list[str]:
    """Return the names that `_slot` knows."""
    places = [(i, slot) for i, source in sources_with_slots(run).items() for slot in source.performers]
    names = {known.name if (known := run.naming.known(i, slot)) else slot for i, slot in places}
    found = {name for name in names if any(_slot(run, i, name) is not None for i, _ in places)}
    return sorted(found, key=lambda name: (len(name), name))
