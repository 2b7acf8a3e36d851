"""Splitting alone: joints, velocity, range, envelope and splitter (Algorithms 1 and 2), without summaries and remerge.

The kernel here is the beginning of `mossar_stream.algorithm.frame_step.advance`, from the same parts.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Settings
from mossar_stream.algorithm.joints import Joints, start_joints, step_joints
from mossar_stream.algorithm.normalisation import normalise
from mossar_stream.core.row import ROW, ROW_BYTES
from mossar_stream.algorithm.splitter import ACCEPTED, CROSSED, follow_curve, forget_candidate, start_curve
from mossar_stream.algorithm.velocity import travel
from mossar_stream.core.plan import Plan
from mossar_stream.jit.decorators import entry_point
from mossar_stream.memory.joint_pages import POINT
from mossar_tools.bench.measurement import Measurement, Timing, rate, timed
from mossar_tools.bench.motion import Chunk, Motion
from mossar_tools.bench.work import Work

VELOCITY, SPLITTING = 0, 1  # how far to go
TARGET = 10e6  # frames/s
SIZE = 1000  # frames of a chunk
SETTINGS = Settings(noise_margin=0.0, level="posture")  # equation 1; noise is no part of Algorithms 1 and 2


@entry_point(makes_arrays=False)
def split_frames(
    memory: NDArray[np.uint8],
    index: int,
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
    until: int,
) -> int:
    """Take frames of one performer in.

    Args:
        memory: (P, row) bytes.
        index: Row of the performer.
        positions: (n, J, 3) float32 m.
        times: (n,) s, increasing.
        until: VELOCITY or SPLITTING.

    Returns:
        Key frames confirmed.
    """
    row = memory[index]
    state = row[:ROW_BYTES].view(ROW)[0]
    plan, clock, curve, at = state.plan, state.clock, state.curve, state.at
    body = row[at.body : at.seen].view(np.float32)
    seen = row[at.seen : at.seen + 8 * plan.padded_joints].view(np.float64)
    tracked = row[at.tracked : at.tracked + 4 * plan.padded_joints].view(np.int32)
    joints = Joints(plan, state.joints, state.counters, seen, tracked, body)
    ring_time = row[at.ring_time : at.ring_time + 8 * plan.ring].view(np.float64)
    ring_step = row[at.ring_step : at.ring_step + 8 * plan.ring].view(np.int64)
    points = positions.reshape(-1).view(POINT)
    found = 0
    for i in range(len(times)):
        time = times[i]
        frame = points[i * plan.joints : (i + 1) * plan.joints]
        first = clock.open == 0
        dt, displacement = 0.0, 0.0
        if first:
            clock.open = 1
            start_joints(joints, frame, time)
        else:
            dt = min(time - clock.time, plan.max_gap)
            displacement = step_joints(joints, frame, clock.time, time)
        velocity = travel(state.velocity, ring_time, ring_step, time, displacement, plan.window)
        if until == SPLITTING:
            value, scale = normalise(state.range, plan, 0.0, velocity, dt)
            theta = plan.theta * scale
            if first:
                start_curve(curve, value, theta, scale, clock.next_frame, time)
            elif follow_curve(curve, value, theta, scale, clock.next_frame, time) & (CROSSED | ACCEPTED):
                forget_candidate(curve)
                found += 1
        clock.time = time
        clock.next_frame += 1
    return found


def run_splitting(motion: Motion, chunks: list[Chunk], until: int = SPLITTING) -> int:
    """Split a motion from its beginning and return the number of key frames."""
    memory = Plan(motion.skeleton, SETTINGS, motion.fps).new_rows(1)
    return sum(split_frames(memory, 0, positions, times, until) for positions, times in chunks)


def runs_of_splitting(work: Work, motion: Motion, until: int) -> tuple[int, list[Timing]]:
    """Return the frames of a run, and what the runs took."""
    frames = work.some(1_000_000, 2000)
    chunks = motion.chunks(frames, SIZE)
    run_splitting(motion, chunks[:2], until)
    return frames, [timed(run_splitting, motion, chunks, until) for _ in range(work.repeats)]


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the rate for each motion."""
    for motion in work.motions:
        frames, runs = runs_of_splitting(work, motion, SPLITTING)
        yield rate("splitting", f"{motion.name}, chunks of {SIZE}", frames, runs, TARGET)
