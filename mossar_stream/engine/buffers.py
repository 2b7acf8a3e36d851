"""Buffers: what compiled calls need besides the performers: scratch, and a buffer for events."""

from collections.abc import Mapping
from typing import Self

from mossar_stream.algorithm.window_step import new_scratch
from mossar_stream.engine.plan import Plan
from mossar_stream.engine.warm_up import warm_up
from mossar_stream.events import Event
from mossar_stream.memory.event_buffer import new_event_buffer, take_events

IN_USE = "a segmenter, or the pool it belongs to, was used by two threads at once; use one for each thread, or a lock"
BATCH = 512  # events that there is room for besides those of one frame


class Buffers:
    """Scratch and an event buffer for performers of one plan, one after the other.

    They are used by one thread at a time (`with buffers:`); another one that comes meanwhile gets an error at once,
    since both would write into the same rows.

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
        self.is_busy = False
        warm_up(plan)

    def __enter__(self) -> Self:
        if self.is_busy:
            raise RuntimeError(IN_USE)
        self.is_busy = True
        return self

    def __exit__(self, *_: object) -> None:
        self.is_busy = False

    def take_events(self, performers: Mapping[int, str]) -> list[Event]:
        """Return what lies in the event buffer, and empty it; performers are named by row."""
        return take_events(self._view, performers, self._joints)
