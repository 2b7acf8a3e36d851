"""The same person keeps the same number: slots `p1` to `pN` that outlive the ids of a tracker."""

from mossar_adapters.people.slots import REFUSED, UNDECIDED, Change, Slots
from mossar_adapters.people.source import PeopleSource

__all__ = ["REFUSED", "UNDECIDED", "Change", "PeopleSource", "Slots"]
