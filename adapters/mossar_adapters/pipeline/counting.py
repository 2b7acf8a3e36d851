"""Counting: what a source may report about itself besides its frames."""

from collections.abc import Mapping

import msgspec

from mossar_adapters.abilities import Counts, Explains, offered
from mossar_adapters.source import Source


def explanation(source: Source) -> str:
    """Return what a source knows about why no frames come; empty if it cannot say."""
    explaining = offered(source, Explains)
    return "" if explaining is None else explaining.explain()


def counters_of(source: Source) -> Mapping[str, int]:
    """Return what a source has counted (`malformed`, `kernel_drops`), as far as it counts."""
    counting = offered(source, Counts)
    if counting is None:
        return {}
    found = msgspec.to_builtins(counting.counters)
    return {name: value for name, value in found.items() if isinstance(value, int)}
