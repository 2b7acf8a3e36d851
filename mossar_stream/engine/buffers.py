"""Buffers: what compiled calls need besides the performers: scratch, and a buffer for events."""

from collections.abc import Mapping

import numpy as np

from mossar_stream.engine.plan import Plan, new_scratch
from mossar_stream.engine.warm_up import warm_up
from mossar_stream.events import Event
from mossar_stream.memory.event_buffer import Source, new_event_buffer, take_events
from mossar_stream.repetitions.state import SCRATCH, new_room

IN_USE = "a segmenter, or the pool it belongs to, was used by two threads at once; use one for each thread, or a lock"
BATCH = 512  # events that there is room for besides those of one frame


class Guard:
    """Lets one thread in at a time; another one that comes meanwhile gets an error at once.

    Two threads would write into the same rows and the same event buffer. Whoever is in leaves by `is_busy = False` under
    `finally`: with a call, as `with` makes one, Ctrl-C could come just before it, and nobody would get in any more.
    """

    def __init__(self) -> None:
        self.is_busy = False

    def enter(self) -> None:
        """Come in.

        Raises:
            RuntimeError: If a thread is in.
        """
        if self.is_busy:
            raise RuntimeError(IN_USE)
        self.is_busy = True


class Buffers:
    """Scratch and an event buffer for performers of one plan, one after the other.

    Building them compiles the kernels for the plan's similarity measure, or loads them.

    Args:
        plan: Of the performers.
    """

    def __init__(self, plan: Plan) -> None:
        self.scratch = new_scratch(plan.shape)
        self.events = new_event_buffer(plan.most_events + BATCH)
        self.for_looks = new_room(plan.shape.padded_joints * plan.shape.repetitions), np.zeros(1, SCRATCH)
        self.for_run = self.scratch, self.events, plan.most_events
        self._view = memoryview(self.events)  # type: ignore[arg-type]
        self.guard = Guard()
        warm_up(plan)

    def take_events(self, sources: Mapping[int, Source]) -> list[Event]:
        """Return what lies in the event buffer, and empty it; sources are given by row."""
        return take_events(self._view, sources)
