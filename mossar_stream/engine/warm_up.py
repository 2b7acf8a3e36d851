"""Kernels are compiled, or loaded from the disk, before frames come in."""

import functools

import numpy as np

from mossar_stream.engine.layout import HEAD_BYTES, TOOLS_BYTES
from mossar_stream.engine.plan import Plan, new_scratch
from mossar_stream.engine.run import ADVANCE, UPDATE, run
from mossar_stream.jit.cache import open_cache
from mossar_stream.jit.linked import publish
from mossar_stream.memory.event_buffer import EVENT_BYTES, events_size
from mossar_stream.readers import address_of_reader
from mossar_stream.repetitions.counting import analyse
from mossar_stream.settings import SimilarityName

# Measures whose kernels are there; looking them up takes as long as a thousand frames.
_ready: set[SimilarityName] = set()


def warm_up(plan: Plan) -> None:
    """Compile the kernels for a plan, or load them, if that has not been done in this process."""
    if plan.settings.similarity not in _ready:
        open_cache()
        warm_up_decisions(plan)
        warm_up_frames(plan)
        frames = np.zeros((0, plan.shape.joints, 3), np.float32)
        run(
            np.zeros(HEAD_BYTES, np.uint8),
            np.zeros(TOOLS_BYTES + EVENT_BYTES, np.uint8),
            plan.params,
            frames,
            np.zeros(0),
        )
        _ready.add(plan.settings.similarity)
    if plan.shape.repetitions:
        warm_up_analysis()


@functools.cache
def warm_up_analysis() -> None:
    """Compile what analyses repetitions, or load it."""
    address_of_reader(analyse)


def warm_up_decisions(plan: Plan) -> None:
    """Compile what decides, or load it."""
    scratch, events = new_scratch(plan.shape), np.zeros(events_size(plan.most_events), np.uint8)
    publish(UPDATE, plan.new_rows(1)[0], plan.params, scratch, events, 0)


def warm_up_frames(plan: Plan) -> None:
    """Compile what processes frames, or load it."""
    frames, times = np.zeros((2, plan.shape.joints, 3), np.float32), np.arange(2) / 100.0
    publish(ADVANCE, plan.new_rows(1)[0], plan.params, frames, times)
