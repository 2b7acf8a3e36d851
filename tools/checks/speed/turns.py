"""Turns: the duration of pushes without and with a feature, in blocks by turns: other processes disturb both alike."""

import time
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Segmenter
from mossar_tools.bench.measurement import Measurement, Target
from mossar_tools.bench.motion import Motion
from mossar_tools.bench.push import WARM_UP, interruptions_of_thread, singles

BLOCK = 64  # pushes in turn
processor_time = getattr(time, "thread_time", time.process_time)


class Waits(NamedTuple):
    """Durations of pushes.

    Args:
        mean: Mean processor time of a push, s.
        wall: (n,) s, each push by the wall clock, in blocks without an interruption; all pushes if there is no such block.
    """

    mean: float
    wall: NDArray[np.float64]


def waits(motion: Motion, pair: Sequence[Segmenter], frames: int) -> tuple[Waits, Waits]:
    """Push frames one by one into each of two segmenters in turn, and return the durations.

    Args:
        motion: The motion to push.
        pair: The segmenter without a feature, and the one with it.
        frames: Number of measured frames; `WARM_UP` frames come before.
    """
    stream = singles(motion.chunks(WARM_UP + frames, 1 << 20))
    for positions, moment in (next(stream) for _ in range(WARM_UP)):
        for segmenter in pair:
            segmenter.push(positions, moment)
    spent, took, undisturbed = [0.0, 0.0], np.zeros((2, frames)), np.ones((2, frames), np.bool_)
    interruptions = interruptions_of_thread()
    for start in range(0, frames, BLOCK):
        block = [next(stream) for _ in range(min(BLOCK, frames - start))]
        here = slice(start, start + len(block))
        for which, segmenter in enumerate(pair):
            before, cpu = interruptions(), processor_time()
            took[which, here] = _timed(segmenter, block)
            spent[which] += processor_time() - cpu
            undisturbed[which, here] = interruptions() == before
    calm = [own[free] if free.any() else own for own, free in zip(took, undisturbed, strict=True)]
    return Waits(spent[0] / frames, calm[0]), Waits(spent[1] / frames, calm[1])


def added(
    part: str,
    what: str,
    runs: Sequence[tuple[Waits, Waits]],
    more: float | None = None,
    longest: float | None = None,
) -> Iterator[Measurement]:
    """Yield the mean time that a feature adds to a push, and the 99.9 % quantile of the pushes with it.

    Args:
        part: Part of the table.
        what: Name of the measured feature.
        runs: Durations without the feature and with it.
        more: Target of the added mean time, µs; None for no target.
        longest: Target of the quantile, µs; None for no target.
    """
    means = tuple((on.mean - off.mean) * 1e6 for off, on in runs)
    high = tuple(float(np.quantile(on.wall, 0.999)) * 1e6 for _, on in runs)
    note = f"without: {float(np.median([off.mean for off, _ in runs])) * 1e6:.2f} us"
    target = None if more is None else Target(more)
    yield Measurement(part, f"{what}: more on average", "us", means, means, target, note=note, clock="cpu")
    target = None if longest is None else Target(longest)
    yield Measurement(part, f"{what}: p99.9", "us", high, target=target, clock="wall")


def _timed(segmenter: Segmenter, block: list[tuple[NDArray[np.float32], float]]) -> list[float]:
    push, clock = segmenter.push, time.perf_counter
    found = []
    for positions, moment in block:
        began = clock()
        push(positions, moment)
        found.append(clock() - began)
    return found
