"""Crowd: many performers in one process on one core, each at 30 Hz."""

import gc
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Frames, Performers
from mossar_tools.bench.measurement import Measurement, Target, Timing, rate, timed
from mossar_tools.bench.motion import CROWD_FPS, Motion
from mossar_tools.bench.resident import resident_bytes
from mossar_tools.bench.work import Work

PERFORMERS = 4000  # far more than any cache holds
SIZE = 10  # frames of a chunk
BATCHES = 30  # chunks of each performer in a run
SINGLES = 60  # frames of each performer in a run frame by frame
TARGET = 900_000.0  # frames/s: 30,000 performers at 30 Hz
MOST_KB = 50.0
_STRIDE = 37  # frames that performers are apart, so that they do not move in step

Batch = tuple[NDArray[np.float32], NDArray[np.float64]]


class _Way(NamedTuple):
    """A way to push a batch."""

    name: str
    size: int
    batches: int
    push: Callable[["Crowd", Batch], int]
    target: float | None


class Crowd:
    """Performers with the same motion, each at another place of it.

    Args:
        motion: At `CROWD_FPS`.
        count: How many performers.
    """

    def __init__(self, motion: Motion, count: int) -> None:
        gc.collect()
        self._before = resident_bytes()
        self.names = [f"p{k}" for k in range(count)]
        self.pool = Performers(most=count)
        for name in self.names:
            self.pool.announce(name, motion.skeleton, motion.fps)
        self._motion = motion
        self._starts = np.arange(count) * _STRIDE % len(motion.times)
        self._frame = 0
        self.push_many(self.batch(SIZE))
        self.push_many(self.batch(SIZE))

    def kilobytes(self) -> float:
        """Return the memory that each performer takes."""
        gc.collect()
        return (resident_bytes() - self._before) / len(self.names) / 1e3

    def batch(self, size: int) -> Batch:
        """Return the next frames of all performers: (P, size, J, 3) m and (size,) s."""
        moments = np.arange(self._frame, self._frame + size)
        self._frame += size
        places = (self._starts[:, None] + moments) % len(self._motion.times)
        return self._motion.positions[places], moments / self._motion.fps

    def push_many(self, batch: Batch) -> int:
        """Push the frames of all performers at once, and return the number of events."""
        return len(self.pool.push_many(self.names, *batch))

    def push_each(self, batch: Batch) -> int:
        """Push one performer's frames after the other's, and return the number of events."""
        positions, times = batch
        return sum(
            len(self.pool.push(Frames(own, times, None, name)))
            for name, own in zip(self.names, positions, strict=True)
        )


_WAYS = (
    _Way(f"all at once, chunks of {SIZE}", SIZE, BATCHES, Crowd.push_many, TARGET),
    _Way("all at once, frame by frame", 1, SINGLES, Crowd.push_many, None),
    _Way(f"one after the other, chunks of {SIZE}", SIZE, BATCHES, Crowd.push_each, None),
)


def measure(work: Work) -> Iterator[Measurement]:
    """Yield rates, the number of performers that they allow, and the memory of each."""
    count = work.some(PERFORMERS, 40)
    motion = work.single.slowed(CROWD_FPS)
    Crowd(motion, 2)  # shared memory is not counted as memory of performers
    crowd = Crowd(motion, count)
    early = crowd.kilobytes()
    for way in _WAYS:
        batches = work.some(way.batches, 3)
        frames = count * way.size * batches
        runs = []
        for _ in range(work.some(3, 1)):
            took = [_timed(crowd, way) for _ in range(batches)]
            runs.append(Timing(sum(one.wall for one in took), sum(one.cpu for one in took)))
        own = rate("performers", f"{count} performers, {way.name}", frames, runs, way.target)
        yield own
        note = f"at {CROWD_FPS:g} Hz on one core, {way.name}"
        target = Target(way.target / CROWD_FPS, at_least=True) if way.target else None
        by_wall, by_cpu = (tuple(value / CROWD_FPS for value in values) for values in (own.wall, own.cpu))
        yield Measurement("performers", note, "performers", by_wall, by_cpu, target, clock=own.clock)
    target = None if work.quick else Target(MOST_KB, halved=False)
    yield Measurement("performers", f"memory of each after {2 * SIZE} frames", "kB", (early,))
    note = "memory of each when all of it is in use"
    yield Measurement("performers", note, "kB", (crowd.kilobytes(),), target=target)


def _timed(crowd: Crowd, way: _Way) -> Timing:
    batch = crowd.batch(way.size)
    return timed(way.push, crowd, batch)
