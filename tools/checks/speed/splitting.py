"""Splitting alone: joints, velocity, range, envelope and splitter (Algorithms 1 and 2), without summaries and remerge.

`split_frames` of the core is the beginning of its frame step, from the same parts.
"""

from collections.abc import Iterator

from mossar_stream import Settings
from mossar_stream.core.kernels import SPLITTING, split_frames
from mossar_stream.core.plan import Plan
from mossar_tools.bench.measurement import Measurement, Timing, rate, timed
from mossar_tools.bench.motion import Chunk, Motion
from mossar_tools.bench.work import Work

TARGET = 10e6  # frames/s
SIZE = 1000  # frames of a chunk
SETTINGS = Settings(noise_margin=0.0, level="posture")  # equation 1; noise is no part of Algorithms 1 and 2


def run_splitting(motion: Motion, chunks: list[Chunk], until: int = SPLITTING) -> int:
    """Split a motion from its start and return the number of key frames; until is SPLITTING or VELOCITY_ALONE."""
    row = Plan(motion.skeleton, SETTINGS, motion.fps).new_row()
    return sum(split_frames(row, positions, times, until) for positions, times in chunks)


def runs_of_splitting(work: Work, motion: Motion, until: int) -> tuple[int, list[Timing]]:
    """Return the number of frames in a run, and the timings of the runs."""
    frames = work.some(1_000_000, 2000)
    chunks = motion.chunks(frames, SIZE)
    run_splitting(motion, chunks[:2], until)
    return frames, [timed(run_splitting, motion, chunks, until) for _ in range(work.repeats)]


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the rate for each motion."""
    for motion in work.motions:
        frames, runs = runs_of_splitting(work, motion, SPLITTING)
        yield rate("splitting", f"{motion.name}, chunks of {SIZE}", frames, runs, TARGET)
