"""Kernels are compiled, or loaded from the disk, before frames come in."""

import functools
import math

import numpy as np
from numpy.typing import NDArray

from mossar_stream.engine.plan import Plan, new_scratch
from mossar_stream.engine.run import ADVANCE, UPDATE, run
from mossar_stream.jit.cache import open_cache
from mossar_stream.jit.linked import publish
from mossar_stream.memory.event_buffer import new_event_buffer
from mossar_stream.repetitions.counting import look
from mossar_stream.repetitions.state import HEADER, SCRATCH, adopt_counted, length, new_room
from mossar_stream.settings import SimilarityName

# Measures whose kernels are there; looking them up takes as long as a thousand frames.
_ready: set[SimilarityName] = set()


def warm_up(plan: Plan) -> None:
    """Compile the kernels for a plan, or load them, if that has not been done in this process."""
    if plan.settings.similarity not in _ready:
        _warm_up_steps(plan)
        _ready.add(plan.settings.similarity)
    if plan.shape.repetitions:
        warm_up_looks()


@functools.cache
def warm_up_looks() -> None:
    """Compile what looks at repetitions, and what lets limbs know of them, or load it."""
    look(np.zeros(1, HEADER), np.zeros(length(1), np.float32), new_room(1), np.zeros(1, SCRATCH), math.inf)
    adopt_counted(np.zeros(1, HEADER), np.zeros(1, HEADER))


def _warm_up_steps(plan: Plan) -> None:
    """Compile what takes frames in and what decides, or load it."""
    open_cache()
    scratch, events = warm_up_decisions(plan)
    frames, times = warm_up_frames(plan)
    nobody = np.zeros(0, np.int64)
    batch = nobody, nobody, nobody, np.zeros(2, np.int64)
    run(plan.new_rows(1), plan.params, (scratch, events, plan.most_events), batch, frames, times)


def warm_up_decisions(plan: Plan) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Compile what decides, or load it; return the scratch and the buffer of events that it was given."""
    scratch, events = new_scratch(plan.shape), new_event_buffer(plan.most_events)
    publish(UPDATE, plan.new_rows(1), 0, plan.params, scratch, events, 0)
    return scratch, events


def warm_up_frames(plan: Plan) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Compile what processes frames, or load it; return the frames and times that it was given."""
    frames, times = np.zeros((2, plan.shape.joints, 3), np.float32), np.arange(2) / 100.0
    publish(ADVANCE, plan.new_rows(1), 0, plan.params, frames, times)
    return frames, times
