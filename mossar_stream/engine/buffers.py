"""Buffers: what compiled calls need besides the performers: scratch, and a buffer for events."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.window_step import new_scratch
from mossar_stream.engine.plan import Plan
from mossar_stream.engine.run import ADVANCE, UPDATE
from mossar_stream.events import Event
from mossar_stream.jit.decorators import CACHE_FOLDER
from mossar_stream.jit.linked import publish
from mossar_stream.jit.precompile import beside
from mossar_stream.memory.event_buffer import new_event_buffer, take_events
from mossar_stream.settings import Settings, SimilarityName
from mossar_stream.skeleton import Skeleton

BATCH = 512  # events that there is room for besides those of one frame


class Buffers:
    """Scratch and an event buffer for performers of one plan, one after the other.

    Building them compiles the kernels for the plan's similarity measure, or loads them.

    Args:
        plan: Of the performers.
    """

    def __init__(self, plan: Plan) -> None:
        self.scratch = new_scratch(plan.shape)
        self.events = new_event_buffer(plan.most_events + BATCH)
        self.for_run = self.scratch, self.events, plan.most_events
        self._joints = plan.skeleton.names
        self._view = memoryview(self.events)  # type: ignore[arg-type]
        _warm_up(plan, self)

    def take_events(self, performers: Mapping[int, str]) -> list[Event]:
        """Return what lies in the event buffer, and empty it; performers are named by row."""
        return take_events(self._view, performers, self._joints)


# Measures whose kernels are there; looking them up takes as long as a thousand frames.
_ready: set[SimilarityName] = set()


def _warm_up(plan: Plan, buffers: Buffers) -> None:
    """Compile the kernels, or load them; on two cores if there are two."""
    similarity = plan.given.similarity
    if similarity in _ready:
        return
    memory = plan.new_rows(1)
    with beside(__name__, similarity):
        publish(UPDATE, memory, 0, plan.params, buffers.scratch, buffers.events, 0)
    _publish_advance(plan, memory)
    _ready.add(similarity)


def _publish_advance(plan: Plan, memory: NDArray[np.uint8]) -> None:
    frames, times = np.zeros((2, plan.shape.joints, 3), np.float32), np.arange(2) / 100.0
    publish(ADVANCE, memory, 0, plan.params, frames, times)


def compile_beside(folder: str, similarity: SimilarityName) -> None:
    """Compile what `_warm_up` leaves to another process, if this one has the same cache.

    Args:
        folder: Of the cache.
        similarity: Measure to compile for.
    """
    if folder == str(CACHE_FOLDER):
        plan = Plan(Skeleton(("a", "b"), (-1, 0)), Settings(similarity=similarity), None)
        _publish_advance(plan, plan.new_rows(1))
