"""Stream: from positions to events through the public `Segmenter`, in chunks."""

from collections.abc import Iterator

from mossar_stream.segmenter import Segmenter
from mossar_stream.settings import Settings
from mossar_tools.bench.measurement import Measurement, rate, timed
from mossar_tools.bench.motion import Chunk, Motion
from mossar_tools.bench.work import Work

SIZES = {1000: 4e6, 10: None}  # frames of a chunk: target, frames/s


def run_stream(motion: Motion, chunks: list[Chunk], settings: Settings) -> int:
    """Push chunks, end the take, and return the number of events."""
    segmenter = Segmenter(motion.skeleton, settings, fps=motion.fps)
    events = sum(len(segmenter.push(positions, times)) for positions, times in chunks)
    return events + len(segmenter.end_take())


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the rates, events delivered, for each motion and length of chunks."""
    for motion in work.motions:
        for size, target in SIZES.items():
            frames = work.some(1_000_000, 2000)
            chunks = motion.chunks(frames, size)
            run_stream(motion, chunks[: work.some(200, 20)], Settings())
            runs = [timed(run_stream, motion, chunks, Settings()) for _ in range(work.repeats)]
            yield rate("stream", f"{motion.name}, chunks of {size}", frames, runs, target)
