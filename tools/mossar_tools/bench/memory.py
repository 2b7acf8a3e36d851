"""Memory: does a stream that goes on take more of it?"""

import gc
from collections.abc import Iterator

from mossar_stream import Segmenter, Settings
from mossar_tools.bench.measurement import Measurement, Target
from mossar_tools.bench.motion import Motion
from mossar_tools.bench.resident import resident_bytes
from mossar_tools.bench.work import Work

SETTLED = 10_000  # frames
SIZE = 1000  # frames of a chunk
LIMIT = 1.0  # MB


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the growth of the resident memory from the ten-thousandth frame on."""
    lengths = work.some(1, 0) * [1_000_000, 10_000_000] or [20_000]
    for frames, grown in zip(lengths, growth(work.single, lengths, work), strict=True):
        name = f"growth from {SETTLED:,} to {frames:,} frames"
        yield Measurement("memory", name, "MB", (grown,), target=Target(LIMIT, halved=False))


def growth(motion: Motion, lengths: list[int], work: Work) -> Iterator[float]:
    """Push one endless take and yield the growth, MB, at each of some lengths, in frames."""
    segmenter = Segmenter(motion.skeleton, Settings(), fps=motion.fps)
    turn = motion.chunks(len(motion.times), SIZE)
    period = float(motion.times[-1]) + 1.0 / motion.fps
    pushed, turns, begin = 0, 0, 0
    due = [SETTLED, *lengths]
    while due:
        for positions, times in turn:
            segmenter.push(positions, times + turns * period)
            pushed += len(times)
        turns += 1
        work.on_progress(f"memory: {pushed:,} frames")
        while due and pushed >= due[0]:
            gc.collect()
            if due.pop(0) == SETTLED and not begin:
                begin = resident_bytes()
            else:
                yield (resident_bytes() - begin) / 1e6
