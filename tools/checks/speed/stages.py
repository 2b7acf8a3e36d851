"""Stages: the cost of each step from positions to events.

Velocity and envelope run alone; the rest is the additional cost of the whole stream.
"""

import time
from collections.abc import Iterator

import numpy as np

from checks.speed.splitting import SIZE, runs_of_splitting
from mossar_stream import Settings
from mossar_stream.core.kernels import (
    ANALYSIS_DUE,
    HAPPENED,
    SPLITTING,
    VELOCITY_ALONE,
    Channel,
    Performer,
    Workspace,
    analyse_body,
    hand_out_events,
    step_body,
    step_events,
)
from mossar_stream.core.plan import Plan
from mossar_tools.bench.measurement import Measurement, Timing, duration, timed
from mossar_tools.bench.motion import Chunk, Motion
from mossar_tools.bench.work import Work

# Calls of some microseconds are timed by the processor's clock if its resolution is fine enough.
_FINE = time.get_clock_info("thread_time").resolution <= 1e-6
_ticks = time.thread_time if _FINE else time.perf_counter


class _Drive:
    """The stream's loop by hand, with a stopwatch at each part."""

    def __init__(self, motion: Motion) -> None:
        settings = Settings()
        room = settings.resolved().remerge_window  # rows grow in the loop only
        plan = Plan(motion.skeleton, settings, motion.fps, room=room)
        self._core = Performer(Workspace(), (Channel(plan, "p1", plan.new_row()),))
        self.remerging = 0.0  # s, remerge
        self.recording = 0.0  # s, making event records
        self.looking = 0.0  # s, analysing repetitions
        self.calls = 0
        self.events = 0

    def run(self, chunks: list[Chunk]) -> None:
        for positions, times in chunks:
            done = 0
            while done < len(times):
                stop, used = step_body(self._core, positions[done:], times[done:])
                done += used
                if stop == HAPPENED:
                    self._update()
                elif stop == ANALYSIS_DUE:
                    began = _ticks()
                    analyse_body(self._core, times[done])
                    self.looking += _ticks() - began

    def _update(self) -> None:
        began = _ticks()
        step_events(self._core)
        updated = _ticks()
        hand_out_events(self._core)
        self.events += len(self._core.pending)
        self._core.pending.clear()
        self.recording += _ticks() - updated
        self.remerging += updated - began
        self.calls += 1


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the stages, ns per frame, and the remerge for each call."""
    motion = work.single
    part = "stages"
    frames, travelling = runs_of_splitting(work, motion, VELOCITY_ALONE)
    _, splitting = runs_of_splitting(work, motion, SPLITTING)
    yield duration(part, "joints and velocity", "ns/frame", travelling, each=frames, note=motion.name)
    envelope = less(splitting, travelling)
    yield duration(part, "range, envelope, splitter", "ns/frame", envelope, each=frames)
    chunks = motion.chunks(frames, SIZE)
    _Drive(motion).run(chunks[:2])
    drives, whole = [], []
    for _ in range(work.repeats):
        drive = _Drive(motion)
        whole.append(timed(drive.run, chunks))
        drives.append(drive)
    remerging = [Timing(drive.remerging, drive.remerging) for drive in drives]
    recording = [Timing(drive.recording, drive.recording) for drive in drives]
    looking = [Timing(drive.looking, drive.looking) for drive in drives]
    rest = less(less(less(less(whole, splitting), remerging), recording), looking)
    note = "what joins the open segment, noise, tempo, poses kept"
    yield duration(part, "summaries", "ns/frame", rest, each=frames, note=note)
    yield duration(part, "remerge", "ns/frame", remerging, each=frames)
    yield duration(part, "event records", "ns/frame", recording, each=frames)
    yield duration(part, "looks at what is repeated", "ns/frame", looking, each=frames)
    calls, events = (
        max(1, int(np.median([getattr(drive, name) for drive in drives]))) for name in ("calls", "events")
    )
    note = f"{calls} calls, {events} events in {frames} frames"
    yield duration(part, "remerge, each call", "us", remerging, each=calls, note=note)


def less(runs: list[Timing], others: list[Timing]) -> list[Timing]:
    """Return the times of runs minus the median time of others, at least 0."""
    less = (
        float(np.median([other.wall for other in others])),
        float(np.median([other.cpu for other in others])),
    )
    return [Timing(max(0.0, run.wall - less[0]), max(0.0, run.cpu - less[1])) for run in runs]
