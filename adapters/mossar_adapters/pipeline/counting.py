"""Counting: reports of a source beside its frames."""

from collections.abc import Mapping

import msgspec

from mossar_adapters.abilities import Counts, Explains, offered
from mossar_adapters.source import Source


def explanation(source: Source) -> str:
    """Return a source's explanation of why no frames come; empty if it has none."""
    explaining = offered(source, Explains)
    return "" if explaining is None else explaining.explain()


def counters_of(source: Source) -> Mapping[str, int]:
    """Return the counters of a source (`malformed`, `kernel_drops`), as far as it has any."""
    counting = offered(source, Counts)
    if counting is None:
        return {}
    found = msgspec.to_builtins(counting.counters)
    return {name: value for name, value in found.items() if isinstance(value, int)}
