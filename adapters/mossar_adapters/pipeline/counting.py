"""Counting: what a source may tell about itself besides its frames."""

from collections.abc import Mapping

import msgspec

from mossar_adapters.source import Source


def explanation(source: Source) -> str:
    """Return what a source knows about why no frames come; empty if it cannot say."""
    explain = getattr(source, "explain", None)
    return str(explain()) if callable(explain) else ""


def counters_of(source: Source) -> Mapping[str, int]:
    """Return what a source has counted (`malformed`, `kernel_drops`), as far as it counts."""
    counters = getattr(source, "counters", None)
    if counters is None:
        return {}
    found = msgspec.to_builtins(counters)
    return {name: value for name, value in found.items() if isinstance(value, int)}
