"""Kernels are compiled, or loaded from the disk, before frames come in."""

import functools
import math
from typing import cast

import numpy as np
from numpy.typing import NDArray

from mossar_stream.engine.plan import Plan, new_scratch
from mossar_stream.engine.run import ADVANCE, UPDATE, run
from mossar_stream.jit.cache import open_cache
from mossar_stream.jit.linked import publish
from mossar_stream.jit.precompile import other_processes
from mossar_stream.memory.event_buffer import new_event_buffer
from mossar_stream.repetitions.counting import look
from mossar_stream.repetitions.state import HEADER, SCRATCH, length, new_room
from mossar_stream.settings import Settings, SimilarityName
from mossar_stream.skeleton import Skeleton

LOOKS = "looks at repetitions"  # a part of what is compiled
# Measures whose kernels are there; looking them up takes as long as a thousand frames.
_ready: set[SimilarityName] = set()


def precompile(settings: Settings | None = None) -> None:
    """Compile the kernels that segmenters with these settings need, on two cores where there are two.

    They are left in a cache on disk, for this process and those to come; where they lie there already this takes a
    fraction of a second. A segmenter that is built without it compiles them itself, on one core. Other Python
    processes are started only if something must be compiled, and have ended when this returns.

    Args:
        settings: Defaults to `Settings()`; only the similarity measure, and whether repetitions are counted, matter here.

    Raises:
        MossarError: If there is nowhere to write compiled kernels to.

    Example:
        >>> precompile(Settings(similarity="likelihood"))
    """
    resolved = (settings or Settings()).resolved()
    similarity = resolved.similarity
    if similarity not in _ready:
        plan = _any_plan(similarity)
        parts = (similarity, LOOKS) if plan.shape.repetitions else (similarity,)
        with other_processes(__name__, parts):
            _publish_window_step(plan, plan.new_rows(1))
        warm_up(plan)
    if resolved.repetitions:
        _warm_up_looks()


def warm_up(plan: Plan) -> None:
    """Compile the kernels for a plan, or load them, if that has not been done in this process."""
    if plan.settings.similarity not in _ready:
        _warm_up_steps(plan)
        _ready.add(plan.settings.similarity)
    if plan.shape.repetitions:
        _warm_up_looks()


@functools.cache
def _warm_up_looks() -> None:
    """Compile what looks at repetitions, or load it."""
    look(np.zeros(1, HEADER), np.zeros(length(1), np.float32), new_room(1), np.zeros(1, SCRATCH), math.inf)


def _warm_up_steps(plan: Plan) -> None:
    """Compile what takes frames in and what decides, or load it."""
    open_cache()
    memory = plan.new_rows(1)
    scratch, events = _publish_window_step(plan, memory)
    frames, times = _publish_frame_step(plan, memory)
    nobody = np.zeros(0, np.int64)
    batch = nobody, nobody, nobody, np.zeros(2, np.int64)
    run(memory, plan.params, (scratch, events, plan.most_events), batch, frames, times)


def compile_part(folder: str, part: str) -> None:
    """Compile what `precompile` leaves to another process, if this one has the same cache.

    Args:
        folder: Of the cache.
        part: `LOOKS`, or the similarity measure for which frames are taken in.
    """
    if folder != str(open_cache().folder):
        return
    if part == LOOKS:
        _warm_up_looks()
    else:
        plan = _any_plan(cast("SimilarityName", part))
        _publish_frame_step(plan, plan.new_rows(1))


def _any_plan(similarity: SimilarityName) -> Plan:
    return Plan(Skeleton(("a", "b"), (-1, 0)), Settings(similarity=similarity), None)


def _publish_window_step(
    plan: Plan, memory: NDArray[np.uint8]
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    scratch, events = new_scratch(plan.shape), new_event_buffer(plan.most_events)
    publish(UPDATE, memory, 0, plan.params, scratch, events, 0)
    return scratch, events


def _publish_frame_step(
    plan: Plan, memory: NDArray[np.uint8]
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    frames, times = np.zeros((2, plan.shape.joints, 3), np.float32), np.arange(2) / 100.0
    publish(ADVANCE, memory, 0, plan.params, frames, times)
    return frames, times
