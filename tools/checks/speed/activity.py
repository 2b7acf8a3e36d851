"""Activity: its cost per frame, and its memory.

`follow_speeds_alone` of the core is that part of its frame step, on speeds that were computed before; its time includes
the loop around it. The cost of its events is measured with whole streams, in turn with the usual `rest_seconds` and with
one so long that the performer begins to move once and never rests.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from checks.speed.stages import less
from mossar_stream import ActivityEvent, Segmenter, Settings
from mossar_stream.core.kernels import BOUTS, RECORDS, SPEED_WINDOW, follow_speeds_alone
from mossar_tools.bench.measurement import Measurement, Target, Timing, duration, timed
from mossar_tools.bench.motion import Chunk, Motion
from mossar_tools.bench.work import Work

PER_FRAME = 100.0  # ns
BYTES = 200  # of a channel
SIZE = 1000  # frames of a chunk
LONGEST = 60.0  # s of rest_seconds
STATE, BOUT = RECORDS["Row"]["activity"], RECORDS["Bout"]
TURNS = 8  # runs of each kind for one timing of the events


def speeds_of(motion: Motion, chunks: list[Chunk]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rms speeds over the last `SPEED_WINDOW`, (n,) m/s, and their times, (n,) s."""
    positions = np.concatenate([positions for positions, _ in chunks]).astype(np.float64)
    times = np.concatenate([times for _, times in chunks])
    local = positions - positions[:, [motion.skeleton.root]]
    lag = max(1, round(SPEED_WINDOW * motion.fps))
    moved = (local[lag:] - local[:-lag]) / (times[lag:] - times[:-lag])[:, None, None]
    return np.sqrt(np.mean((moved**2).sum(-1), axis=1)), times[lag:]


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the bytes of a channel, and the cost of a frame, ns."""
    part, motion = "activity", work.single
    taken = STATE.itemsize + BOUTS * BOUT.itemsize
    note = f"state {STATE.itemsize}, {BOUTS} bouts of {BOUT.itemsize}"
    yield Measurement(part, "bytes of a channel", "", (float(taken),), target=Target(BYTES), note=note)
    chunks = motion.chunks(work.some(120_000, 4000), SIZE)
    speeds, times = speeds_of(motion, chunks)
    segmenter = Segmenter(motion.skeleton, Settings(), fps=motion.fps)
    for chunk in chunks[:10]:  # enough to estimate the noise
        segmenter.push(*chunk)
    row, bouts = segmenter.row.memory, np.zeros(BOUTS, BOUT)
    changes = follow_speeds_alone(row, bouts, speeds, times)
    stepping = [timed(_step_often, row, bouts, speeds, times) for _ in range(work.repeats)]
    note = f"{changes} changes in {len(times)} frames of {motion.name}"
    yield duration(
        part, "the step of a frame", "ns/frame", stepping, PER_FRAME, note, each=TURNS * len(times)
    )
    yield _reporting(work, motion, chunks)


def _step_often(
    row: NDArray[np.uint8],
    bouts: NDArray[np.void],
    speeds: NDArray[np.float64],
    times: NDArray[np.float64],
) -> None:
    for _ in range(TURNS):
        follow_speeds_alone(row, bouts, speeds, times)


def _reporting(work: Work, motion: Motion, chunks: list[Chunk]) -> Measurement:
    """Return the cost of the events of activity per frame."""
    frames = sum(len(times) for _, times in chunks)
    events = _streamed(motion, chunks, 0.25)
    with_events, without = [], []
    for _ in range(work.repeats):
        runs = [
            (timed(_streamed, motion, chunks, 0.25), timed(_streamed, motion, chunks, LONGEST))
            for _ in range(TURNS)
        ]
        with_events.append(_sum([run[0] for run in runs]))
        without.append(_sum([run[1] for run in runs]))
    note = f"{events} events in {frames} frames"
    more = less(with_events, without)
    return duration("activity", "what its events add", "ns/frame", more, PER_FRAME, note, each=TURNS * frames)


def _streamed(motion: Motion, chunks: list[Chunk], rest_seconds: float) -> int:
    """Stream a motion and return the number of events of activity."""
    segmenter = Segmenter(motion.skeleton, Settings(rest_seconds=rest_seconds), fps=motion.fps)
    found = 0
    for positions, times in chunks:
        found += sum(isinstance(event, ActivityEvent) for event in segmenter.push(positions, times))
    return found


def _sum(runs: list[Timing]) -> Timing:
    return Timing(sum(run.wall for run in runs), sum(run.cpu for run in runs))
