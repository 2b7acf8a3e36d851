"""Measures: what there is to measure, in the order of the table."""

from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from typing import Final, NamedTuple

from mossar_tools.bench.measurement import Measurement
from mossar_tools.bench.work import Work
from mossar_tools.errors import UsageError


class Measure(NamedTuple):
    """One part of the table."""

    title: str
    place: str  # module in this package, and function


MEASURES: Final[dict[str, Measure]] = {
    "splitting": Measure(
        "splitting alone: joints, velocity, range, envelope, Algorithms 1 and 2", "splitting.measure"
    ),
    "stream": Measure("end to end: positions to events, default remerge", "stream.measure"),
    "push": Measure("one frame: how long Segmenter.push takes, remerge on", "push.measure"),
    "stages": Measure("stages: where the time goes", "stages.measure"),
    "performers": Measure(
        "many performers in one process, default remerge, events delivered", "crowd.measure"
    ),
    "memory": Measure("memory of a stream", "memory.measure"),
    "start": Measure("start, in processes of their own", "start.measure"),
    "paths": Measure("path kernel: one pair of neighbouring segments, medians over pairs", "paths.measure"),
    "hierarchy": Measure(
        "whole Algorithm 3, positions to strengths, paper's kernel and settings", "hierarchy.measure"
    ),
    "joints": Measure("joints: end to end in chunks of 1000", "sizes.measure_joints"),
    "window": Measure("window: end to end in chunks of 1000", "sizes.measure_window"),
    "latency": Measure(
        "latency: from sending a frame to receiving its event, 60 frames/s", "latency.measure"
    ),
}


def chosen(names: Sequence[str]) -> list[str]:
    """Return the parts to measure; all of them if none is named.

    Raises:
        UsageError: If there is no such part.
    """
    unknown = [name for name in names if name not in MEASURES]
    if unknown:
        raise UsageError(f"--only: nothing is called {unknown[0][:40]!r}; there are {', '.join(MEASURES)}")
    return list(names or MEASURES)


def measure(name: str, work: Work) -> Iterator[Measurement]:
    """Yield the measurements of one part."""
    module, function = MEASURES[name].place.split(".")
    run: Callable[[Work], Iterator[Measurement]] = getattr(
        import_module(f"mossar_tools.bench.{module}"), function
    )
    yield from run(work)
