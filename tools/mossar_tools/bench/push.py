"""Push: the time that a caller waits for `Segmenter.push` of one frame.

A push that the operating system interrupts to run another program is no measure of this one. Where the system counts
interruptions, the pushes in blocks without any are shown as well.
"""

import itertools
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Segmenter, Settings
from mossar_tools.bench.measurement import Measurement, Target
from mossar_tools.bench.motion import Chunk, Motion
from mossar_tools.bench.work import Work

BLOCK = 64  # pushes between two looks at the interruptions
WARM_UP = 5000  # frames
QUANTILES = {"p50": (0.5, 2.0), "p99": (0.99, 5.0), "p99.99": (0.9999, 100.0)}  # share, target in µs

Form = Callable[[NDArray[np.float32], float], tuple[Any, Any]]


def measure(work: Work) -> Iterator[Measurement]:
    """Yield quantiles over a million frames, remerge on, events delivered."""
    frames = work.some(1_000_000, 2000)
    for motion in work.motions:
        runs = [waits(motion, frames) for _ in range(work.some(3, 1))]
        every = [took for took, _ in runs]
        calm = [took[undisturbed] for took, undisturbed in runs]
        share = float(np.mean([undisturbed.mean() for _, undisturbed in runs]))
        yield from _quantiles(f"{motion.name}", every, targets=share > 0.99)
        if share <= 0.99:
            name = f"{motion.name}, uninterrupted"
            yield from _quantiles(name, calm, targets=True, note=f"{share:.1%} of the pushes")


def _quantiles(
    name: str, runs: Sequence[NDArray[np.float64]], *, targets: bool, note: str = ""
) -> Iterator[Measurement]:
    if not all(len(took) for took in runs):
        return
    for label, (share, limit) in QUANTILES.items():
        values = tuple(float(np.quantile(took, share)) * 1e6 for took in runs)
        target = Target(limit) if targets else None
        yield Measurement("push", f"{name}: {label}", "us", values, target=target, note=note, clock="wall")
    values = tuple(float(took.max()) * 1e6 for took in runs)
    yield Measurement("push", f"{name}: longest", "us", values, note=note, clock="wall")


def waits(
    motion: Motion, frames: int, form: Form | None = None
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Push frames one by one.

    Args:
        motion: The frames to push.
        frames: How many, after the warm-up.
        form: Converts a frame, float32 and contiguous, and its time to the pushed form.

    Returns:
        (frames,) s, duration of each push, and whether it was in a block without an interruption.
    """
    segmenter = Segmenter(motion.skeleton, Settings(), fps=motion.fps)
    stream = singles(motion.chunks(WARM_UP + frames, 1 << 20))
    took = np.zeros(frames)
    undisturbed = np.ones(frames, np.bool_)
    interruptions = interruptions_of_thread()
    for positions, moment in (next(stream) for _ in range(WARM_UP)):
        segmenter.push(positions, moment)
    push, clock = segmenter.push, time.perf_counter
    for start in range(0, frames, BLOCK):
        block: list[tuple[Any, Any]] = list(itertools.islice(stream, min(BLOCK, frames - start)))
        if form is not None:
            block = [form(positions, moment) for positions, moment in block]
        before = interruptions()
        for k, (positions, moment) in enumerate(block, start):
            began = clock()
            push(positions, moment)
            took[k] = clock() - began
        undisturbed[start : start + len(block)] = interruptions() == before
    return took, undisturbed


def singles(chunks: list[Chunk]) -> Iterator[tuple[NDArray[np.float32], float]]:
    """Yield the frames of chunks one by one, with their times."""
    for positions, times in chunks:
        yield from zip(positions, times.tolist(), strict=True)


def interruptions_of_thread() -> Callable[[], int]:
    """Return a function that counts preemptions of this thread; always 0 where the system does not report them."""
    try:
        import resource
    except ImportError:  # Windows
        return lambda: 0
    who = getattr(resource, "RUSAGE_THREAD", resource.RUSAGE_SELF)
    return lambda: resource.getrusage(who).ru_nivcsw
