"""Measurement: a number from repeated runs, by both clocks, and its target."""

import time
from collections.abc import Callable, Sequence
from typing import Literal

import msgspec
import numpy as np

Unit = Literal["frames/s", "ns/frame", "ns", "us", "ms", "s", "MB", "kB", "performers", ""]
OWN = 0.9  # least share of the time with the processor for which the wall clock is meaningful
HALF = 2.0  # factor by which a target may be missed while neighbours load the machine


class Target(msgspec.Struct, frozen=True):
    """The target of a number.

    Args:
        limit: In the measurement's unit.
        at_least: Whether larger is better.
        halved: Whether half of it is acceptable while neighbours load the machine.
    """

    limit: float
    at_least: bool = False
    halved: bool = True

    def verdict(self, value: float, *, busy: bool) -> str:
        """Return `met`, `half (busy)` or `missed`."""
        if self._met(value, self.limit):
            return "met"
        eased = self.limit / HALF if self.at_least else self.limit * HALF
        return "half (busy)" if busy and self.halved and self._met(value, eased) else "missed"

    def _met(self, value: float, limit: float) -> bool:
        return value >= limit if self.at_least else value <= limit


class Measurement(msgspec.Struct, frozen=True):
    """One row of the table.

    Args:
        part: Which of the measures it belongs to.
        name: The measured quantity.
        unit: Of the values.
        wall: One value for each run, by the wall clock, or without a clock.
        cpu: The same by processor time; empty where that is meaningless.
        target: Its target.
        note: For people to read.
    """

    part: str
    name: str
    unit: Unit
    wall: tuple[float, ...]
    cpu: tuple[float, ...] = ()
    target: Target | None = None
    note: str = ""
    clock: Literal["wall", "cpu", ""] = ""

    @property
    def values(self) -> tuple[float, ...]:
        """The values to show, by the meaningful clock."""
        return self.cpu if self.clock == "cpu" else self.wall

    @property
    def value(self) -> float:
        """The median over the runs."""
        return float(np.median(self.values))


class Timing(msgspec.Struct, frozen=True):
    """The time of one run.

    Args:
        wall: s.
        cpu: s of processor time of this process.
    """

    wall: float
    cpu: float


def timed(run: Callable[..., object], *arguments: object) -> Timing:
    """Return the time of a call."""
    cpu, wall = time.process_time(), time.perf_counter()
    run(*arguments)
    return Timing(time.perf_counter() - wall, time.process_time() - cpu)


def rate(
    part: str, name: str, frames: int, runs: Sequence[Timing], target: float | None = None, note: str = ""
) -> Measurement:
    """Return frames per second; each run processed `frames`."""
    by_wall, by_cpu = _by_clocks(runs, lambda seconds: frames / seconds)
    limit = None if target is None else Target(target, at_least=True)
    return Measurement(part, name, "frames/s", by_wall, by_cpu, limit, note, _clock(runs))


def duration(
    part: str,
    name: str,
    unit: Unit,
    runs: Sequence[Timing],
    target: float | None = None,
    note: str = "",
    *,
    each: float = 1.0,
) -> Measurement:
    """Return the duration of a run, in a unit of time, divided by `each`."""
    scale = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9, "ns/frame": 1e9}[unit] / each
    by_wall, by_cpu = _by_clocks(runs, lambda seconds: seconds * scale)
    limit = None if target is None else Target(target)
    return Measurement(part, name, unit, by_wall, by_cpu, limit, note, _clock(runs))


def _by_clocks(
    runs: Sequence[Timing], made: Callable[[float], float]
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    floor = 1e-9  # a clock that does not tick between two looks
    return tuple(made(max(run.wall, floor)) for run in runs), tuple(made(max(run.cpu, floor)) for run in runs)


def _clock(runs: Sequence[Timing]) -> Literal["wall", "cpu"]:
    share = float(np.median([run.cpu / max(run.wall, 1e-9) for run in runs]))
    return "wall" if share >= OWN else "cpu"
