"""Sizes: the cost of joints and of undecided key frames."""

from collections.abc import Iterator

from mossar_stream import Settings
from mossar_tools.bench.measurement import Measurement, Timing, rate, timed
from mossar_tools.bench.motion import Motion, to_and_fro, with_joints
from mossar_tools.bench.stream import run_stream
from mossar_tools.bench.work import Work

JOINTS = (10, 20, 31, 50, 75, 100)
WINDOWS = (2, 4, 8, 16, 32, 64)
SIZE = 1000  # frames of a chunk
LONG = 60.0  # s until a key frame is decided, so that the window fills


def measure_joints(work: Work) -> Iterator[Measurement]:
    """Yield the rate with other numbers of joints."""
    for joints in JOINTS[:: work.some(1, 5)]:
        one = work.single
        skeleton, positions = with_joints(one.skeleton, one.positions[: len(one.positions) // 2 + 1], joints)
        motion = to_and_fro(one.name, skeleton, one.fps, positions)
        yield rate("joints", f"{joints} joints", *_runs(work, motion, Settings()))


def measure_window(work: Work) -> Iterator[Measurement]:
    """Yield the rate with other numbers of undecided key frames."""
    note = f"remerge_seconds = {LONG:g}, so that it fills"
    for window in WINDOWS[:: work.some(1, 5)]:
        settings = Settings(remerge_window=window, remerge_seconds=LONG)
        frames, runs = _runs(work, work.single, settings)
        yield rate("window", f"remerge_window = {window}", frames, runs, note=note)


def _runs(work: Work, motion: Motion, settings: Settings) -> tuple[int, list[Timing]]:
    frames = work.some(300_000, 2000)
    chunks = motion.chunks(frames, SIZE)
    run_stream(motion, chunks[:2], settings)
    return frames, [timed(run_stream, motion, chunks, settings) for _ in range(work.some(3, 1))]
