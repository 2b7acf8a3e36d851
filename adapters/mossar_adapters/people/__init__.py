"""The same person keeps the same number: slots `p1` to `pN` that outlive the ids of a tracker."""

from mossar_adapters.people.given import People
from mossar_adapters.people.slot_table import REFUSED, REMEMBERED, Change
from mossar_adapters.people.slots import UNDECIDED, Slots
from mossar_adapters.people.source import PeopleSource

__all__ = ["REFUSED", "REMEMBERED", "UNDECIDED", "Change", "People", "PeopleSource", "Slots"]
