"""Stream: from positions to events through the public `Segmenter`, in chunks."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

from mossar_stream import Segmenter, Settings
from mossar_tools.bench.measurement import Measurement, rate, timed
from mossar_tools.bench.motion import Chunk, Motion
from mossar_tools.bench.work import Work

SIZES = {1000: 4e6, 10: None}  # frames of a chunk: target, frames/s
SOURCES = 2  # at once, each in a thread of its own


def run_stream(motion: Motion, chunks: list[Chunk], settings: Settings) -> int:
    """Push chunks, end the take, and return the number of events."""
    segmenter = Segmenter(motion.skeleton, settings, fps=motion.fps)
    events = sum(len(segmenter.push(positions, times)) for positions, times in chunks)
    return events + len(segmenter.end_take())


def run_sources(motion: Motion, chunks: list[Chunk], settings: Settings) -> int:
    """Do the same for several sources at once, and return the number of all events."""
    with ThreadPoolExecutor(SOURCES) as threads:
        runs = [threads.submit(run_stream, motion, chunks, settings) for _ in range(SOURCES)]
        return sum(run.result() for run in runs)


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the rates, events delivered, for each motion and length of chunks, and of several sources together."""
    frames = work.some(1_000_000, 2000)
    for motion in work.motions:
        for size, target in SIZES.items():
            chunks = motion.chunks(frames, size)
            run_stream(motion, chunks[: work.some(200, 20)], Settings())
            runs = [timed(run_stream, motion, chunks, Settings()) for _ in range(work.repeats)]
            yield rate("stream", f"{motion.name}, chunks of {size}", frames, runs, target)
    motion, size = work.motions[0], max(SIZES)
    chunks = motion.chunks(frames, size)
    runs = [timed(run_sources, motion, chunks, Settings()) for _ in range(work.repeats)]
    name = f"{motion.name}, chunks of {size}, {SOURCES} sources in threads"
    yield rate("stream", name, SOURCES * frames, runs)
