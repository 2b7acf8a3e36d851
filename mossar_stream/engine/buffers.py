"""Buffers: what compiled calls need besides the performers: scratch, and a buffer for events."""

import itertools

import numpy as np

from mossar_stream.engine.plan import Plan, new_scratch
from mossar_stream.engine.warm_up import warm_up
from mossar_stream.memory.event_buffer import Source, hand_out, new_event_buffer
from mossar_stream.repetitions.state import SCRATCH, new_room

IN_USE = "a segmenter, or the pool it belongs to, was used by two threads at once; use one for each thread, or a lock"
BATCH = 512  # events that there is room for besides those of one frame


class Guard:
    """Lets one thread in at a time, and knows whose the events are that it leaves in the buffer.

    Two threads would write into the same rows and the same event buffer; the second one gets an error at once. The one that
    is in leaves by `is_busy = False` as the last statement under `try`, and once more under `except BaseException`. Neither
    `finally` nor a context manager would do: Ctrl-C could come just before their last step, and all would be locked out.

    Attributes:
        is_busy: Whether a thread is in.
        sources: Of the rows that are in use, by the numbers that their events carry.
    """

    def __init__(self) -> None:
        self.is_busy = False
        self.sources: dict[int, Source] = {}
        self._numbers = itertools.count()

    def enlist(self, source: Source) -> int:
        """Return a number for the events of a source, which no other one gets."""
        number = next(self._numbers)
        self.sources[number] = source
        return number


class Buffers:
    """Scratch and an event buffer for performers of one plan, one after the other.

    Building them compiles the kernels for the plan's similarity measure, or loads them.

    Args:
        plan: Of the performers.
        guard: Of other buffers that the same thread works with.
    """

    def __init__(self, plan: Plan, guard: Guard | None = None) -> None:
        self.scratch = new_scratch(plan.shape)
        self.events = new_event_buffer(plan.most_events + BATCH)
        self.for_looks = new_room(plan.shape.padded_joints * plan.shape.repetitions), np.zeros(1, SCRATCH)
        self.for_run = self.scratch, self.events, plan.most_events
        self._view = memoryview(self.events)  # type: ignore[arg-type]
        self.guard = guard or Guard()
        warm_up(plan)

    def hand_out(self) -> None:
        """Add what lies in the event buffer to what waits at the performers, and empty it."""
        hand_out(self._view, self.guard.sources)
