"""Measures: what `mossar bench` measures, in the order of the table."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import import_module
from typing import Final, NamedTuple

from mossar_tools.bench.measurement import Measurement
from mossar_tools.bench.work import Work
from mossar_tools.errors import UsageError


class Measure(NamedTuple):
    """One part of the table."""

    title: str
    place: str  # module:function, which takes the work and yields measurements


Measures = Mapping[str, Measure]

MEASURES: Final[Measures] = {
    "stream": Measure(
        "rate: positions to events, end to end, default remerge", "mossar_tools.bench.stream:measure"
    ),
    "push": Measure(
        "one frame: how long Segmenter.push takes, remerge on", "mossar_tools.bench.push:measure"
    ),
    "performers": Measure(
        "many performers in one process, default remerge, events delivered",
        "mossar_tools.bench.crowd:measure",
    ),
    "memory": Measure("memory of a stream", "mossar_tools.bench.memory:measure"),
}

# Parts of `python -m checks.speed` that were parts of this.
ELSEWHERE = (
    "moves",
    "limbs",
    "repetitions",
    "start",
)


def chosen(names: Sequence[str], measures: Measures = MEASURES) -> list[str]:
    """Return the parts to measure; all of them if none is named.

    Raises:
        UsageError: If there is no such part.
    """
    unknown = [name for name in names if name not in measures]
    if unknown and unknown[0] in ELSEWHERE and measures is MEASURES:
        raise UsageError(
            f"--only {unknown[0]}: measured by python -m checks.speed --only {unknown[0]}, from a checkout"
        )
    if unknown:
        raise UsageError(f"--only: nothing is called {unknown[0][:40]!r}; there are {', '.join(measures)}")
    return list(names or measures)


def measure(part: Measure, work: Work) -> Iterator[Measurement]:
    """Yield the measurements of one part."""
    module, function = part.place.split(":")
    run: Callable[[Work], Iterator[Measurement]] = getattr(import_module(module), function)
    yield from run(work)
